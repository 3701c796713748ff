//! Measurements at length, each of which writes a page with figures for the documents.

pub mod paper;
pub mod radio;
