//! What goes wrong with the virtual rig, as asked for in words.

use std::str::FromStr;

use hapdef_daq::faults::{Fault, Injector};

use super::electronics::LiveElectronicsParams;
use crate::error::RigError;

/// One thing that goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigFault {
    /// Damage on the wire: `bitflips=1e-6`, `drops=1e-4`, `dups=1e-4`, `bursts=1e-4x16`,
    /// `holes=2e-6x4096` (chance per bit or byte, bytes).
    Wire(Fault),
    /// The plug is pulled: `unplug=5+2` at 5 s for 2 s.
    Unplug {
        /// When, s.
        at_s: f64,
        /// For how long, s.
        for_s: f64,
    },
    /// The device starts anew: `reset=8` at 8 s.
    Reset {
        /// When, s.
        at_s: f64,
    },
    /// The device's clock runs fast: `drift=40` parts per million.
    Drift {
        /// Parts per million.
        ppm: f64,
    },
    /// A channel reads 0: `dead=3`.
    Dead {
        /// The channel.
        channel: usize,
    },
    /// Two gauges' wires are swapped: `swap=1,4`.
    Swapped {
        /// The one.
        first: usize,
        /// The other.
        second: usize,
    },
}

/// Form of a fault in words.
const EXPECTED: &str = "bitflips=RATE, drops=RATE, dups=RATE, bursts=RATExBYTES, holes=RATExBYTES, \
                        unplug=AT_S+FOR_S, reset=AT_S, drift=PPM, dead=CHANNEL or swap=A,B";

impl RigFault {
    /// Sets what of it concerns the electronics.
    pub fn apply(&self, params: &mut LiveElectronicsParams) {
        match *self {
            Self::Dead { channel } => params.dead.push(channel),
            Self::Swapped { first, second } => params.swapped.push((first, second)),
            _ => {}
        }
    }
}

impl FromStr for RigFault {
    type Err = RigError;

    fn from_str(text: &str) -> Result<Self, RigError> {
        let refused = || RigError::Fault { found: text.to_owned(), expected: EXPECTED };
        parse(text).ok_or_else(refused)
    }
}

fn parse(text: &str) -> Option<RigFault> {
    let (kind, value) = text.split_once('=')?;
    let rate = |text: &str| text.parse().ok().filter(|r| (0.0..1.0).contains(r));
    let run = || -> Option<(f64, usize)> {
        let (r, len) = value.split_once('x')?;
        Some((rate(r)?, len.parse().ok().filter(|len| *len > 0)?))
    };
    let seconds = |text: &str| {
        let s: f64 = text.parse().ok()?;
        (s.is_finite() && s >= 0.0).then_some(s)
    };
    Some(match kind {
        "bitflips" => RigFault::Wire(Fault::BitFlips { rate: rate(value)? }),
        "drops" => RigFault::Wire(Fault::DroppedBytes { rate: rate(value)? }),
        "dups" => RigFault::Wire(Fault::DuplicatedBytes { rate: rate(value)? }),
        "bursts" => run().map(|(rate, len)| RigFault::Wire(Fault::Bursts { rate, len }))?,
        "holes" => run().map(|(rate, len)| RigFault::Wire(Fault::Holes { rate, len }))?,
        "unplug" => {
            let (at, long) = value.split_once('+')?;
            RigFault::Unplug { at_s: seconds(at)?, for_s: seconds(long)? }
        }
        "reset" => RigFault::Reset { at_s: seconds(value)? },
        "drift" => RigFault::Drift { ppm: value.parse().ok().filter(|ppm: &f64| ppm.abs() < 1e4)? },
        "dead" => RigFault::Dead { channel: value.parse().ok()? },
        "swap" => {
            let (first, second) = value.split_once(',')?;
            RigFault::Swapped { first: first.parse().ok()?, second: second.parse().ok()? }
        }
        _ => return None,
    })
}

/// Wires one behind the other, each with its kind of damage.
#[derive(Clone, Debug, Default)]
pub(super) struct Wires {
    injectors: Vec<Injector>,
    before: Vec<u8>,
    after: Vec<u8>,
    n_hit: u64,
}

impl Wires {
    pub(super) fn new(faults: &[RigFault], seed: u64) -> Self {
        let wire = |(i, fault): (u64, &RigFault)| match fault {
            RigFault::Wire(fault) => Some(Injector::new(*fault, seed.wrapping_add(i))),
            _ => None,
        };
        Self { injectors: (0..).zip(faults).filter_map(wire).collect(), ..Self::default() }
    }

    /// Passes packets on to `out`; `bytes` is empty afterwards.
    pub(super) fn pass(&mut self, bytes: &mut Vec<u8>, out: &mut Vec<u8>) {
        std::mem::swap(&mut self.before, bytes);
        let mut is_hit = false;
        for injector in &mut self.injectors {
            self.after.clear();
            is_hit |= injector.pass(&self.before, &mut self.after);
            std::mem::swap(&mut self.before, &mut self.after);
        }
        out.extend_from_slice(&self.before);
        self.before.clear();
        std::mem::swap(&mut self.before, bytes);
        self.n_hit += u64::from(is_hit);
    }

    /// Times that anything passed on was damaged.
    pub(super) fn n_hit(&self) -> u64 {
        self.n_hit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read() {
        let read = |text: &str| text.parse::<RigFault>().unwrap();
        let rate = 1e-5;
        assert_eq!(read("bitflips=1e-5"), RigFault::Wire(Fault::BitFlips { rate }));
        let len = 16;
        assert_eq!(read("bursts=1e-5x16"), RigFault::Wire(Fault::Bursts { rate, len }));
        let (at_s, for_s) = (5.0, 1.5);
        assert_eq!(read("unplug=5+1.5"), RigFault::Unplug { at_s, for_s });
        assert_eq!(read("reset=5"), RigFault::Reset { at_s });
        let (first, second) = (1, 4);
        assert_eq!(read("swap=1,4"), RigFault::Swapped { first, second });
    }

    #[test]
    fn other_words_are_refused_with_what_is_expected() {
        for text in ["", "bitflips", "bitflips=2", "bursts=1e-4", "unplug=-1+2", "swap=1", "dead=x"]
        {
            let error = text.parse::<RigFault>().unwrap_err().to_string();
            assert!(error.contains("unplug=AT_S+FOR_S"), "{text}: {error}");
        }
    }
}
