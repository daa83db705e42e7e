//! Ground truth of a simulated rig, as it is written: a JSON line for each frame.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use hapdef_ros::{Contact, Contacts};
use serde::Deserialize;

/// Frames that wait for their line at most; the rig writes a moment later than it sends.
const MAX_WAITING: usize = 1 << 16;

/// Follows a file that may still grow and finds the line of each frame by its number.
pub(super) struct TruthFile {
    path: PathBuf,
    lines: BufReader<File>,
    /// A line that is not whole yet.
    partial: String,
    /// A line that is ahead of the frames.
    next: Option<Line>,
    /// Frames without their line: number and time.
    waiting: VecDeque<(u32, u64)>,
    boot_id: Option<u32>,
}

#[derive(Deserialize)]
struct Line {
    boot_id: u32,
    seq: u32,
    contacts: Vec<LineContact>,
}

#[derive(Deserialize)]
struct LineContact {
    id: u32,
    position_m: [f64; 3],
    normal: [f64; 3],
    force_n: f64,
}

impl TruthFile {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).with_context(|| format!("{}: reading", path.display()))?;
        Ok(Self {
            path: path.to_owned(),
            lines: BufReader::with_capacity(1 << 16, file),
            partial: String::new(),
            next: None,
            waiting: VecDeque::new(),
            boot_id: None,
        })
    }

    /// Takes a frame's number and time, and hands out the truth of all frames that have it by now.
    pub(super) fn frame(
        &mut self,
        seq: u32,
        stamp_ns: u64,
        put: &mut dyn FnMut(&Contacts) -> Result<()>,
    ) -> Result<()> {
        if self.waiting.len() == MAX_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back((seq, stamp_ns));
        self.look(put)
    }

    /// Hands out what has come by now.
    pub(super) fn look(&mut self, put: &mut dyn FnMut(&Contacts) -> Result<()>) -> Result<()> {
        while let Some(&(seq, stamp_ns)) = self.waiting.front() {
            let Some(line) = self.line()? else {
                return Ok(());
            };
            if line.seq > seq {
                // The frame is from before the file begins.
                self.waiting.pop_front();
                self.next = Some(line);
            } else if line.seq == seq {
                self.waiting.pop_front();
                put(&line.contacts(stamp_ns))?;
            }
        }
        Ok(())
    }

    /// The device started anew: its numbers begin again, and so do the file's.
    pub(super) fn restarted(&mut self) -> Result<()> {
        self.waiting.clear();
        let old = self.boot_id;
        while let Some(line) = self.line()? {
            if Some(line.boot_id) != old {
                self.next = Some(line);
                break;
            }
        }
        Ok(())
    }

    fn line(&mut self) -> Result<Option<Line>> {
        if let Some(line) = self.next.take() {
            return Ok(Some(line));
        }
        self.lines
            .read_line(&mut self.partial)
            .with_context(|| format!("{}: reading", self.path.display()))?;
        if !self.partial.ends_with('\n') {
            return Ok(None);
        }
        let parsed = serde_json::from_str::<Line>(&self.partial);
        let Ok(line) = parsed else {
            bail!(
                "{}: expected a line of a rig's ground truth with boot_id, seq and contacts, found \
                 {:.60}",
                self.path.display(),
                self.partial.trim_end()
            );
        };
        self.partial.clear();
        self.boot_id = Some(line.boot_id);
        Ok(Some(line))
    }
}

impl Line {
    fn contacts(&self, stamp_ns: u64) -> Contacts {
        let contact = |c: &LineContact| Contact {
            id: c.id,
            position_m: c.position_m,
            normal: c.normal,
            force_n: c.force_n,
            uncertainty: None,
        };
        Contacts {
            stamp_ns,
            seq: self.seq,
            quality: None,
            contacts: self.contacts.iter().map(contact).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn line(seq: u32) -> String {
        format!(
            "{{\"boot_id\":1,\"seq\":{seq},\"t_device_us\":0,\"t_s\":0,\"contacts\":[{{\"id\":2,\
             \"position_m\":[1,2,3],\"normal\":[0,0,1],\"force_n\":{seq},\"shear_n\":[0,0,0],\
             \"face\":0,\"bary\":[1,0,0]}}]}}\n"
        )
    }

    #[test]
    fn each_frame_gets_its_own_line_also_when_that_comes_later() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.jsonl");
        let mut file = File::create(&path).unwrap();
        let mut truth = TruthFile::open(&path).unwrap();
        let mut found = Vec::new();
        let mut put = |contacts: &Contacts| {
            found.push((
                contacts.seq,
                contacts.stamp_ns,
                contacts.contacts[0].force_n,
            ));
            Ok(())
        };
        // 3 and 4 are lost on the link, 5 comes in two pieces, 1 is from before the file.
        truth.frame(1, 10, &mut put).unwrap();
        truth.frame(2, 20, &mut put).unwrap();
        for seq in 2..5 {
            file.write_all(line(seq).as_bytes()).unwrap();
        }
        let (head, tail) = (&line(5)[..30], &line(5)[30..]);
        file.write_all(head.as_bytes()).unwrap();
        truth.frame(5, 50, &mut put).unwrap();
        file.write_all(tail.as_bytes()).unwrap();
        truth.look(&mut put).unwrap();
        assert_eq!(found, [(2, 20, 2.0), (5, 50, 5.0)]);
    }

    #[test]
    fn what_is_no_truth_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.jsonl");
        std::fs::write(&path, "hello\n").unwrap();
        let mut truth = TruthFile::open(&path).unwrap();
        let error = truth.frame(0, 0, &mut |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("boot_id"), "{error}");
    }
}
