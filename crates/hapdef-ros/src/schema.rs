//! Definitions of the messages, as MCAP's `ros2msg` has them, and their names and hashes.

use std::collections::BTreeSet;

/// Line between the definitions of a schema.
const SEPARATOR: &str =
    "================================================================================";

macro_rules! definitions {
    ($($package:literal / $name:literal),* $(,)?) => {
        &[$((
            concat!($package, "/", $name),
            include_str!(concat!("../msg/", $package, "/", $name, ".msg")),
        )),*]
    };
}

/// Every definition, by package and name.
const DEFINITIONS: &[(&str, &str)] = definitions![
    "builtin_interfaces" / "Duration",
    "builtin_interfaces" / "Time",
    "diagnostic_msgs" / "DiagnosticArray",
    "diagnostic_msgs" / "DiagnosticStatus",
    "diagnostic_msgs" / "KeyValue",
    "geometry_msgs" / "Point",
    "geometry_msgs" / "Pose",
    "geometry_msgs" / "Quaternion",
    "geometry_msgs" / "Transform",
    "geometry_msgs" / "TransformStamped",
    "geometry_msgs" / "Vector3",
    "geometry_msgs" / "Wrench",
    "geometry_msgs" / "WrenchStamped",
    "hapdef_msgs" / "Alternative",
    "hapdef_msgs" / "Contact",
    "hapdef_msgs" / "Contacts",
    "hapdef_msgs" / "Gauges",
    "hapdef_msgs" / "RobotContacts",
    "hapdef_msgs" / "Status",
    "sensor_msgs" / "CompressedImage",
    "sensor_msgs" / "JointState",
    "std_msgs" / "ColorRGBA",
    "std_msgs" / "Float32MultiArray",
    "std_msgs" / "Float64MultiArray",
    "std_msgs" / "Header",
    "std_msgs" / "Int16MultiArray",
    "std_msgs" / "Int32MultiArray",
    "std_msgs" / "MultiArrayDimension",
    "std_msgs" / "MultiArrayLayout",
    "std_msgs" / "UInt16MultiArray",
    "std_msgs" / "UInt32MultiArray",
    "tf2_msgs" / "TFMessage",
    "visualization_msgs" / "Marker",
    "visualization_msgs" / "MarkerArray",
    "visualization_msgs" / "MeshFile",
    "visualization_msgs" / "UVCoordinate",
];

/// Type hashes of the messages that have topics and of those that are read as readings, by REP-2016: SHA-256 over the type's description.
/// `scripts/read_back.py --hashes` computes them with rosbags.
const HASHES: &[(&str, &str)] = &[
    (
        "diagnostic_msgs/DiagnosticArray",
        "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    ),
    (
        "geometry_msgs/WrenchStamped",
        "RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77",
    ),
    (
        "hapdef_msgs/Contacts",
        "RIHS01_bda1d410f3c48b73d311976ac41ab5fa8d2e9c823704791b91f041ea37cff598",
    ),
    (
        "hapdef_msgs/Gauges",
        "RIHS01_93d2b568749a3032576ca46b0266a6e9466d44602210b71590766590695bd031",
    ),
    (
        "hapdef_msgs/RobotContacts",
        "RIHS01_558a606f4306ca2756b5bba05caef64a646cbc2e881ccc30264a45c4bf9a7919",
    ),
    (
        "hapdef_msgs/Status",
        "RIHS01_83fe54b65cd00d9734055bd81dcfc060a619707b7705d1418f47a07ee7a42038",
    ),
    (
        "sensor_msgs/JointState",
        "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    ),
    (
        "std_msgs/Float32MultiArray",
        "RIHS01_0599f6f85b4bfca379873a0b4375a0aca022156bd2d7021275d116ed1fa8bfe0",
    ),
    (
        "std_msgs/Float64MultiArray",
        "RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f",
    ),
    (
        "std_msgs/Int16MultiArray",
        "RIHS01_b58810e8e5b90fb19a5062469eb8409f5ab11a446d60de7157a1457e52a076ce",
    ),
    (
        "std_msgs/Int32MultiArray",
        "RIHS01_84a7346323525d1b4dfca899df3820f245e54009dac5a6b69217d14fdefd1701",
    ),
    (
        "std_msgs/UInt16MultiArray",
        "RIHS01_94fe73428ec63baecc774f8fb82406123e9291cf728f1b7c91caf5335129492b",
    ),
    (
        "std_msgs/UInt32MultiArray",
        "RIHS01_6c2577c7ad3cbdcc2164a41c12f1d5ad314ea320f3fb1ee47e78019fe16bb5b0",
    ),
    (
        "tf2_msgs/TFMessage",
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    ),
    (
        "visualization_msgs/MarkerArray",
        "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    ),
];

/// Messages whose numbers can be readings, as they are named where another one comes.
#[cfg(feature = "zenoh")]
pub(crate) const READABLE: [&str; 8] = [
    "std_msgs/Float64MultiArray",
    "std_msgs/Float32MultiArray",
    "std_msgs/Int32MultiArray",
    "std_msgs/Int16MultiArray",
    "std_msgs/UInt32MultiArray",
    "std_msgs/UInt16MultiArray",
    "sensor_msgs/JointState",
    "hapdef_msgs/Gauges",
];

/// The definition of a message, by package and name (`geometry_msgs/WrenchStamped`), with those of
/// everything in it behind; none for a message that is not spoken here.
#[must_use]
pub fn definition(name: &str) -> Option<String> {
    let mut text = String::new();
    let mut seen = BTreeSet::from([name.to_owned()]);
    let mut wanted = vec![name.to_owned()];
    let mut next = 0;
    while let Some(name) = wanted.get(next).cloned() {
        let fields = fields(&name)?;
        if next > 0 {
            text += &format!("{SEPARATOR}\nMSG: {name}\n");
        }
        text += fields;
        for inner in inner_types(&name, fields) {
            if seen.insert(inner.clone()) {
                wanted.push(inner);
            }
        }
        next += 1;
    }
    Some(text)
}

/// The message's name in DDS, which is its name for rmw_zenoh, too:
/// `geometry_msgs::msg::dds_::WrenchStamped_`.
#[must_use]
pub fn dds_name(name: &str) -> String {
    let (package, name) = name.split_once('/').unwrap_or(("", name));
    format!("{package}::msg::dds_::{name}_")
}

/// The message of a name in DDS; a name of another form as it is.
#[cfg(any(test, feature = "zenoh"))]
pub(crate) fn message_name(dds_name: &str) -> String {
    let inner = dds_name.strip_suffix('_').and_then(|name| name.split_once("::msg::dds_::"));
    inner.map_or(dds_name.to_owned(), |(package, name)| format!("{package}/{name}"))
}

/// The message's type hash; none for one that has no topic and is not read.
#[must_use]
pub fn type_hash(name: &str) -> Option<&'static str> {
    lookup(HASHES, name)
}

fn fields(name: &str) -> Option<&'static str> {
    lookup(DEFINITIONS, name)
}

fn lookup(table: &'static [(&str, &str)], name: &str) -> Option<&'static str> {
    let found = table.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text)
}

/// The messages that a definition's fields are made of, in order.
fn inner_types<'a>(name: &'a str, fields: &'a str) -> impl Iterator<Item = String> + 'a {
    let package = name.split_once('/').map_or("", |(package, _)| package);
    fields.lines().filter_map(move |line| {
        let mut words = line.split('#').next()?.split_whitespace();
        let (kind, field) = (words.next()?, words.next()?);
        let kind = kind.split('[').next()?;
        let is_plain = kind.starts_with(|c: char| c.is_ascii_lowercase()) && !kind.contains('/');
        if is_plain || field.contains('=') {
            return None;
        }
        Some(match kind.contains('/') {
            true => kind.to_owned(),
            false => format!("{package}/{kind}"),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_brings_what_is_in_it_once() {
        let text = definition("geometry_msgs/WrenchStamped").unwrap();
        let parts: Vec<&str> = text.split(SEPARATOR).collect();
        let heads: Vec<_> =
            parts[1..].iter().map(|part| part.trim_start().lines().next().unwrap()).collect();
        assert_eq!(
            heads,
            [
                "MSG: std_msgs/Header",
                "MSG: geometry_msgs/Wrench",
                "MSG: builtin_interfaces/Time",
                "MSG: geometry_msgs/Vector3",
            ]
        );
        assert!(parts[0].starts_with("std_msgs/Header header\n"));
    }

    #[test]
    fn every_message_is_defined_with_all_that_is_in_it() {
        for (name, _) in DEFINITIONS {
            assert!(definition(name).is_some(), "{name}");
        }
        assert_eq!(definition("std_msgs/Nothing"), None);
    }

    #[test]
    fn names_in_dds_are_those_of_ros() {
        let name = dds_name("geometry_msgs/WrenchStamped");
        assert_eq!(name, "geometry_msgs::msg::dds_::WrenchStamped_");
        assert_eq!(message_name(&name), "geometry_msgs/WrenchStamped");
        assert_eq!(message_name("x_"), "x_");
        assert_eq!(type_hash("geometry_msgs/Wrench"), None);
    }
}
