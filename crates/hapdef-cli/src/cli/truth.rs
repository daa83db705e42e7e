//! Ground truth of a simulated rig: from itself, or as it writes it, a JSON line for each frame.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

use anyhow::{Context, Result, bail, ensure};
use hapdef_cli::shown;
use hapdef_live::Touch;
use hapdef_rig::live::{TrueContact, TruthFrame};

/// Frames that wait for their line at most; the rig writes a moment later than it sends.
const MAX_WAITING: usize = 1 << 16;

/// Longest line, bytes; one of a rig has a few hundred.
const MAX_LINE_LEN: usize = 1 << 16;

/// What a simulated rig is pressed by, found for each frame by its number.
pub(super) struct Truth {
    lines: Lines,
    /// A line that is ahead of the frames.
    next: Option<TruthFrame>,
    /// Frames without their line: number and time.
    waiting: VecDeque<(u32, u64)>,
    boot_id: Option<u32>,
}

/// Where lines come from.
enum Lines {
    /// A file that may still grow.
    File {
        path: PathBuf,
        lines: BufReader<File>,
        /// A line that is not whole yet.
        partial: String,
    },
    /// A rig within the program.
    Rig(Receiver<TruthFrame>),
}

/// Takes the truth of a frame: its time, ns, its number, what touches.
type Put<'a> = dyn FnMut(u64, u32, &Touch) -> Result<()> + 'a;

impl Truth {
    /// In a file, as a rig writes it; its name ends in `.partial` until the rig ends.
    pub(super) fn in_file(path: &Path) -> Result<Self> {
        let mut partial = path.as_os_str().to_owned();
        partial.push(".partial");
        let file = File::open(path).or_else(|error| match error.kind() {
            ErrorKind::NotFound => File::open(partial),
            _ => Err(error),
        });
        let file = file.with_context(|| format!("{}: reading", shown(path)))?;
        Ok(Self::new(Lines::File {
            path: path.to_owned(),
            lines: BufReader::with_capacity(1 << 16, file),
            partial: String::new(),
        }))
    }

    /// From a rig within the program.
    pub(super) fn of_rig(frames: Receiver<TruthFrame>) -> Self {
        Self::new(Lines::Rig(frames))
    }

    fn new(lines: Lines) -> Self {
        Self { lines, next: None, waiting: VecDeque::new(), boot_id: None }
    }

    /// Takes a frame's number and time, and hands out the truth of all frames that have it by now.
    pub(super) fn frame(&mut self, seq: u32, stamp_ns: u64, put: &mut Put<'_>) -> Result<()> {
        if self.waiting.len() == MAX_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back((seq, stamp_ns));
        self.look(put)
    }

    /// Hands out what has come by now.
    pub(super) fn look(&mut self, put: &mut Put<'_>) -> Result<()> {
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
                let contacts = line.contacts.iter().map(TrueContact::contact).collect();
                put(stamp_ns, seq, &Touch { contacts, ..Touch::default() })?;
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

    fn line(&mut self) -> Result<Option<TruthFrame>> {
        if let Some(line) = self.next.take() {
            return Ok(Some(line));
        }
        let line = self.lines.next()?;
        if let Some(line) = &line {
            self.boot_id = Some(line.boot_id);
        }
        Ok(line)
    }
}

impl Lines {
    fn next(&mut self) -> Result<Option<TruthFrame>> {
        let (path, lines, partial) = match self {
            Self::Rig(frames) => return Ok(frames.try_recv().ok()),
            Self::File { path, lines, partial } => (path, lines, partial),
        };
        let room = MAX_LINE_LEN.saturating_sub(partial.len()) as u64;
        lines
            .by_ref()
            .take(room)
            .read_line(partial)
            .with_context(|| format!("{}: reading", shown(&*path)))?;
        if !partial.ends_with('\n') {
            ensure!(
                partial.len() < MAX_LINE_LEN,
                "{}: expected lines of a rig's ground truth, found {MAX_LINE_LEN} bytes without an end \
                 of a line: name the file that hapdef rig --truth writes",
                shown(&*path)
            );
            return Ok(None);
        }
        let Ok(line) = TruthFrame::from_json_line(partial) else {
            bail!(
                "{}: expected a line of a rig's ground truth with boot_id, seq and contacts, found \
                 {:.60}",
                shown(&*path),
                partial.trim_end()
            );
        };
        partial.clear();
        Ok(Some(line))
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
        let mut truth = Truth::in_file(&path).unwrap();
        let mut found = Vec::new();
        let mut put = |stamp_ns, seq, touch: &Touch| {
            found.push((seq, stamp_ns, touch.contacts[0].force_n));
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
    fn a_rig_within_the_program_tells_it() {
        let (rig, frames) = std::sync::mpsc::sync_channel(8);
        let mut truth = Truth::of_rig(frames);
        let tell = |seq| {
            let frame = TruthFrame { boot_id: 1, seq, ..TruthFrame::default() };
            rig.try_send(frame).unwrap();
        };
        let mut found = Vec::new();
        let mut put = |stamp_ns, seq, _: &Touch| {
            found.push((seq, stamp_ns));
            Ok(())
        };
        // 7 is lost on the link, 8 comes before the rig tells of it.
        (5..8).for_each(tell);
        truth.frame(6, 60, &mut put).unwrap();
        truth.frame(8, 80, &mut put).unwrap();
        tell(8);
        truth.look(&mut put).unwrap();
        assert_eq!(found, [(6, 60), (8, 80)]);
    }

    #[test]
    fn what_is_no_truth_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.jsonl");
        std::fs::write(&path, "hello\n").unwrap();
        let mut truth = Truth::in_file(&path).unwrap();
        let error = truth.frame(0, 0, &mut |_, _, _| Ok(())).unwrap_err();
        assert!(error.to_string().contains("boot_id"), "{error}");

        std::fs::write(&path, vec![b'1'; 10 * MAX_LINE_LEN]).unwrap();
        let mut truth = Truth::in_file(&path).unwrap();
        let error = truth.frame(0, 0, &mut |_, _, _| Ok(())).unwrap_err();
        assert!(error.to_string().contains("without an end"), "{error}");
    }

    #[test]
    fn a_file_is_read_that_still_has_its_first_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.jsonl");
        let nowhere = Truth::in_file(&path).map(|_| ()).unwrap_err();
        assert!(nowhere.to_string().contains("truth.jsonl: reading"));
        std::fs::write(folder.path().join("truth.jsonl.partial"), line(7)).unwrap();
        let mut truth = Truth::in_file(&path).unwrap();
        let mut n = 0;
        let mut put = |_, _, _: &Touch| {
            n += 1;
            Ok(())
        };
        truth.frame(7, 70, &mut put).unwrap();
        assert_eq!(n, 1);
    }
}
