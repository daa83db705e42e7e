//! Runs a target on mutated inputs and watches it: panics, time.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::mutate::mutated;
use super::targets::Target;

/// Longest time for one input; the program ends with the input saved when one takes longer.
const PATIENCE: Duration = Duration::from_secs(20);

/// What came of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Inputs.
    pub n_executions: u64,
    /// Inputs that panicked.
    pub n_panics: u64,
    /// Longest time for one.
    pub slowest: Duration,
}

/// The corpus of a target, by name: at least one seed.
pub fn corpus(folder: &Path) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let seeds: Vec<_> = paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
    assert!(!seeds.is_empty(), "{}: no seeds", folder.display());
    seeds
}

/// Runs the seeds themselves and mutations of them until `is_over` of the inputs so far and the time
/// since the start; inputs that panic are written to `failures`.
pub fn fuzz(
    target: Target,
    seeds: &[Vec<u8>],
    seed: u64,
    is_over: impl Fn(u64, Duration) -> bool,
    failures: &Path,
) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let folder = scratch(target.name);
    let watchdog = Watchdog::start(target.name, failures);
    let start = Instant::now();
    let mut outcome = Outcome::default();
    while !is_over(outcome.n_executions, start.elapsed()) {
        let input = match seeds.get(outcome.n_executions as usize) {
            Some(seed) => seed.clone(),
            None => mutated(seeds, &mut rng),
        };
        watchdog.begin(&input);
        let before = Instant::now();
        let run = catch_unwind(AssertUnwindSafe(|| (target.run)(&input, folder.path())));
        outcome.slowest = outcome.slowest.max(before.elapsed());
        watchdog.end();
        outcome.n_executions += 1;
        if run.is_err() {
            outcome.n_panics += 1;
            save(failures, target.name, &input);
        }
    }
    outcome
}

/// A folder for files, in memory where the system has such a one.
fn scratch(name: &str) -> tempfile::TempDir {
    let shm = Path::new("/dev/shm");
    let mut builder = tempfile::Builder::new();
    builder.prefix(name);
    let made = match shm.is_dir() {
        true => builder.tempdir_in(shm).or_else(|_| tempfile::tempdir()),
        false => builder.tempdir(),
    };
    made.unwrap()
}

fn save(failures: &Path, name: &str, input: &[u8]) {
    let hash = input.iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let path = failures.join(format!("{name}-{hash:016x}"));
    let written = std::fs::create_dir_all(failures).and_then(|()| std::fs::write(&path, input));
    match written {
        Ok(()) => eprintln!("{name}: the input is in {}", path.display()),
        Err(error) => eprintln!("{name}: {}: {error}", path.display()),
    }
}

/// Ends the program when an input takes too long; nothing else stops a loop without end.
struct Watchdog {
    shared: Arc<Watched>,
}

struct Watched {
    start: Instant,
    /// When the present input began, ms after the start; 0 between inputs.
    began_ms: AtomicU64,
    is_over: AtomicU64,
    input: Mutex<Vec<u8>>,
}

impl Watchdog {
    fn start(name: &'static str, failures: &Path) -> Self {
        let shared = Arc::new(Watched {
            start: Instant::now(),
            began_ms: AtomicU64::new(0),
            is_over: AtomicU64::new(0),
            input: Mutex::new(Vec::new()),
        });
        let (theirs, failures) = (Arc::clone(&shared), failures.to_owned());
        std::thread::spawn(move || {
            while theirs.is_over.load(Ordering::Relaxed) == 0 {
                std::thread::sleep(Duration::from_millis(200));
                let began = theirs.began_ms.load(Ordering::Relaxed);
                let now = theirs.start.elapsed().as_millis() as u64;
                if began > 0 && now.saturating_sub(began) > PATIENCE.as_millis() as u64 {
                    save(&failures, name, &theirs.input.lock().unwrap());
                    eprintln!("{name}: an input takes more than {PATIENCE:?}");
                    std::process::exit(1);
                }
            }
        });
        Self { shared }
    }

    fn begin(&self, input: &[u8]) {
        self.shared.input.lock().unwrap().clone_from(&input.to_vec());
        let now = self.shared.start.elapsed().as_millis() as u64;
        self.shared.began_ms.store(now.max(1), Ordering::Relaxed);
    }

    fn end(&self) {
        self.shared.began_ms.store(0, Ordering::Relaxed);
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.shared.is_over.store(1, Ordering::Relaxed);
    }
}
