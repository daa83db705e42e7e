//! Sinks that come along: the terminal, JSON lines to files and clients, tables, a controller's stop signal.

mod alert;
mod csv;
mod json;
mod server;
mod text;

pub use alert::AlertSink;
pub use csv::CsvSink;
pub use json::{JsonSink, json_line};
pub use server::JsonServer;
pub use text::TextSink;
