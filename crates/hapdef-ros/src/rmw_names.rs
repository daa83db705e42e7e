//! Names and attachments by which rmw_zenoh knows publishers and messages.
//!
//! Source: rmw_zenoh, docs/design.md of ROS 2 Jazzy, sections "Graph Cache" and "Publishers".

use crate::schema::{dds_name, type_hash};

/// Reliable, volatile, the last 10, no deadline: empty where it is rmw_zenoh's default.
const QOS: &str = "::,10:,:,:,,";
/// Bytes of a publisher's identity.
pub(crate) const GID_LEN: usize = 16;

/// Who publishes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Node<'a> {
    /// ROS_DOMAIN_ID.
    pub(crate) domain_id: u32,
    /// Identity of the zenoh session, hexadecimal.
    pub(crate) session: &'a str,
    /// Name of the node.
    pub(crate) name: &'a str,
}

/// Key of a topic's messages: `0/chatter/std_msgs::msg::dds_::String_/RIHS01_…`.
pub(crate) fn topic_key(domain_id: u32, topic: &str, message: &str) -> String {
    let topic = topic.trim_matches('/');
    let (name, hash) = type_name(message);
    format!("{domain_id}/{topic}/{name}/{hash}")
}

/// Liveliness token of a node; its number within the session is 0.
pub(crate) fn node_token(node: &Node<'_>) -> String {
    token(node, 0, "NN")
}

/// Liveliness token of a publisher, number `entity` within the session.
pub(crate) fn publisher_token(
    node: &Node<'_>,
    entity: usize,
    topic: &str,
    message: &str,
) -> String {
    let (name, hash) = type_name(message);
    let topic = topic.replace('/', "%");
    format!("{}/{topic}/{name}/{hash}/{QOS}", token(node, entity, "MP"))
}

/// What goes with each message: its number, its time, the publisher's identity with its length.
pub(crate) fn attachment(number: i64, stamp_ns: u64, gid: &[u8; GID_LEN]) -> Vec<u8> {
    let mut bytes = number.to_le_bytes().to_vec();
    bytes.extend(stamp_ns.cast_signed().to_le_bytes());
    bytes.push(GID_LEN as u8);
    bytes.extend(gid);
    bytes
}

fn token(node: &Node<'_>, entity: usize, kind: &str) -> String {
    let Node { domain_id, session, name } = node;
    // No enclave and the root as namespace are both %.
    format!("@ros2_lv/{domain_id}/{session}/0/{entity}/{kind}/%/%/{name}")
}

fn type_name(message: &str) -> (String, &'static str) {
    (dds_name(message), type_hash(message).unwrap_or("*"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODE: Node<'_> =
        Node { domain_id: 0, session: "8b20917502ee955ac4476e0266340d5c", name: "talker" };

    /// The tokens of design.md, with a message that has a hash here.
    #[test]
    fn tokens_are_those_of_the_design() {
        assert_eq!(
            node_token(&NODE),
            "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/0/NN/%/%/talker"
        );
        let hash = type_hash("tf2_msgs/TFMessage").unwrap();
        let name = "tf2_msgs::msg::dds_::TFMessage_";
        assert_eq!(
            publisher_token(&NODE, 10, "/tf", "tf2_msgs/TFMessage"),
            format!(
                "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%tf/{name}/{hash}/::,10:,:,:,,"
            )
        );
        let key = topic_key(3, "/hapdef/contact_0/wrench", "tf2_msgs/TFMessage");
        assert_eq!(key, format!("3/hapdef/contact_0/wrench/{name}/{hash}"));
    }

    #[test]
    fn an_attachment_has_33_bytes() {
        let bytes = attachment(2, 3, &[7; GID_LEN]);
        assert_eq!(bytes.len(), 33);
        assert_eq!(bytes[..18], [2, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 16, 7]);
    }
}
