//! Sinks that come along: the terminal, JSON lines to files and clients, tables.

mod csv;
mod json;
mod server;
mod text;

pub use csv::CsvSink;
pub use json::{JsonSink, json_line};
pub use server::JsonServer;
pub use text::TextSink;
