//! Which samples train, which validate, which test.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::error::DataError;

/// Three contiguous blocks of samples: the first 60 %, the next 20 %, the rest (Sun and Martius
/// 2019, section 3.4.3).
///
/// Contiguous blocks are a fair split only because datasets hold their samples in random order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// Samples that the weights are fitted to.
    pub train: Range<usize>,
    /// Samples that choose among trained weights and stop training.
    pub validation: Range<usize>,
    /// Samples that errors are reported on.
    pub test: Range<usize>,
}

impl Split {
    /// Splits `n` samples. Fails below 5, where a block would be empty.
    pub fn of(n: usize) -> Result<Self, DataError> {
        if n < 5 {
            return Err(DataError::TooFewSamples { n });
        }
        let n_train = n / 5 * 3 + n % 5 * 3 / 5;
        let n_validation = n / 5;
        Ok(Self {
            train: 0..n_train,
            validation: n_train..n_train + n_validation,
            test: n_train + n_validation..n,
        })
    }

    /// Number of samples in all three blocks.
    pub fn n(&self) -> usize {
        self.train.len() + self.validation.len() + self.test.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_each_other_and_hold_60_20_20() {
        for n in 5..500 {
            let split = Split::of(n).unwrap();
            assert_eq!(split.train.start, 0);
            assert_eq!(split.train.end, split.validation.start);
            assert_eq!(split.validation.end, split.test.start);
            assert_eq!((split.test.end, split.n()), (n, n));
            for (block, share) in
                [(&split.train, 0.6), (&split.validation, 0.2), (&split.test, 0.2)]
            {
                assert!(!block.is_empty());
                assert!((block.len() as f64 - share * n as f64).abs() < 2.0, "{n}: {split:?}");
            }
        }
    }

    #[test]
    fn the_paper_s_27000() {
        let split = Split::of(27_000).unwrap();
        assert_eq!(split.train.len(), 16_200);
        assert_eq!(split.validation.len(), 5_400);
        assert_eq!(split.test.len(), 5_400);
    }

    #[test]
    fn too_few_are_refused() {
        assert!(matches!(Split::of(4), Err(DataError::TooFewSamples { n: 4 })));
    }
}
