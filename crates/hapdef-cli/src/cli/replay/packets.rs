//! Recorded messages to packets of HDP1, with their own numbers and times.

use std::sync::Arc;

use hapdef_daq::hdp1::{Encoder, Hello, Pong};
use hapdef_daq::{Frame, Message};

/// Makes packets of messages; frames of one packet are collected until it is whole.
pub(super) struct Packets {
    encoder: Encoder,
    hello: Option<Arc<Hello>>,
    scans: Vec<Frame>,
    samples: Vec<i32>,
    t_us: u64,
    rate_mhz: u32,
    n_incomplete: u64,
}

impl Packets {
    /// `rate_mhz` stands in for the rate of a device that names none.
    pub(super) fn new(rate_mhz: u32) -> Self {
        Self {
            encoder: Encoder::new(),
            hello: None,
            scans: Vec::new(),
            samples: Vec::new(),
            t_us: 0,
            rate_mhz,
            n_incomplete: 0,
        }
    }

    /// Packets of a message, if it completes one.
    pub(super) fn take(&mut self, message: Message, out: &mut Vec<u8>) -> anyhow::Result<()> {
        match message {
            Message::Frame(frame) => self.frame(frame, out)?,
            Message::Hello(hello) => {
                let mut hello = hello;
                if hello.rate_mhz == 0 {
                    let own = Arc::make_mut(&mut hello);
                    own.rate_mhz = self.rate_mhz;
                    own.seal();
                }
                self.hello = Some(hello);
                self.say_hello(out)?;
            }
            Message::Status(status) => self.encoder.status(status, self.t_us, out),
            Message::Log(text) => self.encoder.log(&text, self.t_us, out),
            Message::Restarted | Message::RoundTrip(_) | Message::Link(_) => {}
        }
        Ok(())
    }

    /// HELLO, if the recording had one by now.
    pub(super) fn say_hello(&mut self, out: &mut Vec<u8>) -> anyhow::Result<()> {
        if let Some(hello) = &self.hello {
            out.push(0);
            self.encoder.hello(hello, self.t_us, out)?;
        }
        Ok(())
    }

    /// The answer to a PING.
    pub(super) fn pong(&mut self, host_ns: u64, out: &mut Vec<u8>) {
        let (t_rx_us, t_us) = (self.t_us, self.t_us);
        let pong = Pong { host_ns, t_rx_us, t_us };
        self.encoder.pong(pong, out);
    }

    /// Packets of which the recording lacks scans; they are left out, so that the host counts them
    /// as lost.
    pub(super) fn n_incomplete(&self) -> u64 {
        self.n_incomplete
    }

    fn frame(&mut self, frame: Frame, out: &mut Vec<u8>) -> anyhow::Result<()> {
        let Some(hello) = self.hello.clone() else {
            self.n_incomplete += 1;
            return Ok(());
        };
        let is_next = usize::from(frame.scan) == self.scans.len()
            && self.scans.iter().all(|scan| scan.seq == frame.seq);
        if !is_next {
            self.n_incomplete += u64::from(!self.scans.is_empty());
            self.scans.clear();
            if frame.scan > 0 {
                return Ok(());
            }
        }
        self.scans.push(frame);
        if self.scans.len() < usize::from(hello.n_scans) {
            return Ok(());
        }
        self.samples.clear();
        let scans = self.scans.iter();
        self.samples.extend(scans.flat_map(|scan| scan.bits()));
        let first = self.scans[0];
        self.scans.clear();
        self.t_us = first.t_device_us;
        self.encoder.set_seq(first.seq);
        self.encoder.data(&hello, first.t_device_us, first.flags, &self.samples, out)?;
        Ok(())
    }
}
