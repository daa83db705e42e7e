//! What can go wrong.

use hapdef_live::LiveError;
use hapdef_rig::RigError;
use hapdef_view::ViewError;

/// Why a limb can't be shown.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum PageError {
    #[error(
        "not a whole model of a page: {what}; copy it again, or make it anew: hapdef page SCENE -o FOLDER"
    )]
    NotAModel { what: String },
    #[error(
        "a model of version {found}, this program reads version {expected}: make it anew with hapdef page"
    )]
    Version { expected: u32, found: u32 },
    #[error(
        "the model's part {part}: expected {expected}, found {found}; make it anew: hapdef page SCENE -o FOLDER"
    )]
    Part { part: &'static str, expected: String, found: String },
    #[error(
        "a limb with loads on the whole of it, or that the device measures, can't be shown without a program: leave \
         out loads in the scene"
    )]
    Loads,
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(transparent)]
    Rig(#[from] RigError),
    #[error(transparent)]
    View(#[from] ViewError),
}
