//! The integration tests of hapdef-daq: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod clock_laws;
mod converters;
mod examples;
mod firmware;
mod hdp1;
mod hdp1_faults;
mod hdp1_laws;
mod host_c;
mod numbers;
mod other_device;
mod player;
mod python_mcap;
mod realtime;
mod receivers;
mod record;
mod record_names;
mod record_survival;
mod refusals;
mod serial_pty;
mod sources;
mod support;
mod tokio_ports;
mod topic_reader;
