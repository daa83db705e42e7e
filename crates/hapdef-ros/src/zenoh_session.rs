//! Sessions as rmw_zenoh's nodes have them.

use zenoh::Wait;

use crate::error::RosError;

/// Where rmw_zenoh's nodes look for the router.
pub(crate) const ROUTER: &str = "tcp/localhost:7447";

/// Opens a session that finds others by the router at `connect`, not by multicast. A router that is not there
/// is looked for until it is.
pub(crate) fn open(connect: &[String], listen: &[String]) -> Result<zenoh::Session, RosError> {
    zenoh::open(config(connect, listen)?).wait().map_err(fault)
}

pub(crate) fn fault(error: zenoh::Error) -> RosError {
    RosError::Zenoh { message: error.to_string() }
}

fn config(connect: &[String], listen: &[String]) -> Result<zenoh::Config, RosError> {
    let list = |addresses: &[String]| {
        let quoted: Vec<String> = addresses.iter().map(|a| format!("{a:?}")).collect();
        format!("[{}]", quoted.join(","))
    };
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"peer\"".to_owned()),
        ("scouting/multicast/enabled", "false".to_owned()),
        ("connect/endpoints", list(connect)),
        ("listen/endpoints", list(listen)),
    ] {
        config.insert_json5(key, &value).map_err(fault)?;
    }
    Ok(config)
}
