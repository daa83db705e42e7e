//! The lines of the paper's authors' sketch: integers of 12 bits with commas between, at 115200
//! baud.
//!
//! A line has no number, time or checksum: a lost line can't be counted and a damaged digit can't be
//! seen. Flash the HDP1 sketch for more than a first look.

/// Longest line that is read, bytes.
const MAX_LINE_LEN: usize = 1024;
/// Largest value of a converter with 12 bits.
const MAX_VALUE: i32 = 4095;

/// What the lines came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CsvCounts {
    /// Lines read.
    pub n_lines: u64,
    /// Lines refused: other than the expected number of integers from 0 to 4095.
    pub n_refused: u64,
}

/// Decodes lines in pieces of any size, in bounded memory.
#[derive(Clone, Debug)]
pub struct CsvDecoder {
    n_channels: usize,
    line: Vec<u8>,
    overlong: bool,
    is_joining: bool,
    values: Vec<i32>,
    /// Integers of the last line that had another number of them.
    n_other: Option<usize>,
    counts: CsvCounts,
}

impl CsvDecoder {
    /// A decoder for lines of that many integers; the sketch prints 10.
    #[must_use]
    pub fn new(n_channels: usize) -> Self {
        Self {
            n_channels,
            line: Vec::with_capacity(MAX_LINE_LEN),
            overlong: false,
            is_joining: true,
            values: Vec::with_capacity(n_channels),
            n_other: None,
            counts: CsvCounts::default(),
        }
    }

    /// Takes bytes and hands out the values of each line, with the counts up to and with it. The first
    /// line after opening is left out: its beginning may be missing without a trace.
    pub fn push(&mut self, mut bytes: &[u8], sink: &mut impl FnMut(CsvCounts, &[i32])) {
        while let Some(end) = bytes.iter().position(|b| *b == b'\n') {
            self.append(&bytes[..end]);
            self.end_of_line(sink);
            bytes = &bytes[end + 1..];
        }
        self.append(bytes);
    }

    /// Forgets a line that has begun, because the link was closed.
    pub fn link_closed(&mut self) {
        self.line.clear();
        self.overlong = false;
        self.is_joining = true;
    }

    /// Lines read and refused.
    #[must_use]
    pub fn counts(&self) -> CsvCounts {
        self.counts
    }

    /// Integers that a line has to have, and that the last one had which was refused for nothing else.
    pub(crate) fn other_channels(&self) -> Option<(usize, usize)> {
        self.n_other.map(|found| (self.n_channels, found))
    }

    fn append(&mut self, bytes: &[u8]) {
        let room = MAX_LINE_LEN - self.line.len();
        self.overlong |= bytes.len() > room;
        self.line.extend(&bytes[..bytes.len().min(room)]);
    }

    fn end_of_line(&mut self, sink: &mut impl FnMut(CsvCounts, &[i32])) {
        let was_joining = std::mem::replace(&mut self.is_joining, false);
        let is_blank = !self.overlong && self.line.trim_ascii().is_empty();
        if !was_joining && !is_blank {
            if !self.overlong && self.parse() {
                self.counts.n_lines += 1;
                sink(self.counts, &self.values);
            } else {
                self.counts.n_refused += 1;
            }
        }
        self.line.clear();
        self.overlong = false;
    }

    fn parse(&mut self) -> bool {
        self.values.clear();
        let Ok(text) = std::str::from_utf8(&self.line) else {
            return false;
        };
        for word in text.split(',') {
            match word.trim_ascii().parse() {
                Ok(value) if (0..=MAX_VALUE).contains(&value) => self.values.push(value),
                _ => return false,
            }
        }
        let found = self.values.len();
        self.n_other = (found != self.n_channels).then_some(found);
        self.n_other.is_none()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(decoder: &mut CsvDecoder, text: &[u8]) -> Vec<Vec<i32>> {
        let mut lines = Vec::new();
        decoder.push(text, &mut |_, values| lines.push(values.to_vec()));
        lines
    }

    #[test]
    fn the_sketchs_lines_are_read() {
        let mut decoder = CsvDecoder::new(10);
        let text = b"12,13\r\n0,1,2,3,4,5,6,7,8,4095\r\n 1, 2,3,4,5,6,7,8,9,10\n";
        let lines = read(&mut decoder, text);
        assert_eq!(lines[0], [0, 1, 2, 3, 4, 5, 6, 7, 8, 4095]);
        assert_eq!(lines[1], [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
        assert_eq!((lines.len(), decoder.counts().n_refused), (2, 0));
    }

    #[test]
    fn what_is_no_line_of_the_sketch_is_refused() {
        let mut decoder = CsvDecoder::new(3);
        let text = "x\n1,2\n1,2,3,4\n1,2,4096\n1,-2,3\n1,,3\n1,2,\u{b5}\n\n1,2,3\n";
        assert_eq!(read(&mut decoder, text.as_bytes()), [[1, 2, 3]]);
        assert_eq!(decoder.counts().n_refused, 6);
        read(&mut decoder, &[b'1'; 5000]);
        assert!(read(&mut decoder, b",2,3\n").is_empty());
        assert_eq!(decoder.counts().n_refused, 7);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_bytes_in_pieces_of_any_size(bytes in prop::collection::vec(any::<u8>(), 0..3000), piece in 1usize..50) {
            let (mut whole, mut parts) = (CsvDecoder::new(2), CsvDecoder::new(2));
            let all = read(&mut whole, &bytes);
            let pieces: Vec<_> = bytes.chunks(piece).flat_map(|b| read(&mut parts, b)).collect();
            prop_assert_eq!(all, pieces);
        }
    }
}
