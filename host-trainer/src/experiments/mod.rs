//! Measurements that make a page for the documents.

pub mod link;
pub mod paper;
