//! Where readings come from.

/// What the page shows of the device that readings come from; a page opened later receives it, too.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceState {
    /// Whether the readings are simulated.
    pub is_simulated: bool,
    /// Why no readings come, in words; `None` where they come.
    pub fault: Option<String>,
}
