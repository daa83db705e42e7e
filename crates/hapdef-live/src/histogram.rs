//! Times by their size, without heap and with bounded error.

/// Buckets of an octave: 3 % wide.
const PER_OCTAVE: u64 = 32;
/// Octaves above the first 32 ns; the last ends at 137 s.
const N_OCTAVES: usize = 32;

/// Counts durations in buckets 3 % wide, up to two minutes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Histogram {
    counts: Vec<u64>,
    n: u64,
    max_ns: u64,
}

/// Durations since the last look, or since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latency {
    /// How many were measured.
    pub n: u64,
    /// Median, µs, to 3 %.
    pub p50_us: f64,
    /// 99th percentile, µs, to 3 %.
    pub p99_us: f64,
    /// Longest, µs.
    pub max_us: f64,
}

impl Histogram {
    pub(crate) fn new() -> Self {
        Self { counts: vec![0; (N_OCTAVES + 1) * PER_OCTAVE as usize], n: 0, max_ns: 0 }
    }

    pub(crate) fn add(&mut self, ns: u64) {
        let last = self.counts.len() - 1;
        self.counts[bucket(ns).min(last)] += 1;
        self.n += 1;
        self.max_ns = self.max_ns.max(ns);
    }

    /// Adds what `other` has counted.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (to, from) in self.counts.iter_mut().zip(&other.counts) {
            *to += from;
        }
        self.n += other.n;
        self.max_ns = self.max_ns.max(other.max_ns);
    }

    pub(crate) fn clear(&mut self) {
        self.counts.fill(0);
        (self.n, self.max_ns) = (0, 0);
    }

    pub(crate) fn latency(&self) -> Latency {
        Latency {
            n: self.n,
            p50_us: self.quantile_ns(0.5) * 1e-3,
            p99_us: self.quantile_ns(0.99) * 1e-3,
            max_us: self.max_ns as f64 * 1e-3,
        }
    }

    /// The value that a share `q` is not above: its bucket's middle.
    fn quantile_ns(&self, q: f64) -> f64 {
        let wanted = ((q * self.n as f64).ceil() as u64).max(1);
        let mut seen = 0;
        for (bucket, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                let [low, high] = [bucket, bucket + 1].map(|b| lower_edge_ns(b) as f64);
                return (0.5 * (low + high - 1.0)).min(self.max_ns as f64);
            }
        }
        0.0
    }
}

/// Linear up to 32 ns, then 32 buckets an octave.
fn bucket(ns: u64) -> usize {
    if ns < PER_OCTAVE {
        return ns as usize;
    }
    let octave = u64::from(ns.ilog2() - PER_OCTAVE.ilog2());
    (octave * PER_OCTAVE + (ns >> octave)) as usize
}

fn lower_edge_ns(bucket: usize) -> u64 {
    let bucket = bucket as u64;
    if bucket < PER_OCTAVE {
        return bucket;
    }
    let octave = bucket / PER_OCTAVE - 1;
    (bucket % PER_OCTAVE + PER_OCTAVE) << octave
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_lies_in_its_bucket() {
        for ns in (0..2000).chain((11..37).flat_map(|e| [(1 << e) - 1, 1 << e, (1 << e) + 1])) {
            let b = bucket(ns);
            assert!(lower_edge_ns(b) <= ns && ns < lower_edge_ns(b + 1), "{ns}");
        }
    }

    #[test]
    fn quantiles_are_right_to_three_percent() {
        let mut histogram = Histogram::new();
        for ns in 1..=100_000 {
            histogram.add(ns * 10);
        }
        let found = histogram.latency();
        assert!((found.p50_us / 500.0 - 1.0).abs() < 0.03, "{found:?}");
        assert!((found.p99_us / 990.0 - 1.0).abs() < 0.03, "{found:?}");
        assert_eq!((found.n, found.max_us), (100_000, 1000.0));
        let mut sum = Histogram::new();
        sum.merge(&histogram);
        assert_eq!(sum, histogram);
        sum.clear();
        assert_eq!(sum, Histogram::new());
    }
}
