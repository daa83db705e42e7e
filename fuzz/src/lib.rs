//! The targets for cargo-fuzz.

mod targets;

/// Runs a target by its name.
///
/// # Panics
/// That is what is looked for; and for a name that is none.
pub fn run(name: &str, bytes: &[u8]) {
    let target = targets::TARGETS.iter().find(|target| target.name == name);
    let folder = tempfile::tempdir().expect("a folder for files");
    (target.expect("a target's name").run)(bytes, folder.path());
}
