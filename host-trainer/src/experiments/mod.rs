//! Measurements that make a page and pictures for the documents.

pub mod link;
