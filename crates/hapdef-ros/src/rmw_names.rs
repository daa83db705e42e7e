//! Names and attachments by which rmw_zenoh knows publishers and messages.
//!
//! Source: rmw_zenoh, docs/design.md of ROS 2 Jazzy, sections "Graph Cache" and "Publishers".

use hapdef_daq::record::Numbered;

use crate::schema::{dds_name, message_name, type_hash};

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

/// A publisher in the graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Publisher {
    /// Its topic, `/strain`.
    pub(crate) topic: String,
    /// What it publishes, `std_msgs/Float64MultiArray`.
    pub(crate) message: String,
    /// Hash of that message's definition.
    pub(crate) hash: String,
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

/// Number, time and publisher of a message, as [`attachment`] writes them; none of other bytes. Before its releases
/// of April 2025 (0.2.4 of Jazzy) rmw_zenoh wrote a name before each.
pub(crate) fn read_attachment(bytes: &[u8]) -> Option<Numbered> {
    let (number, rest) = unnamed(bytes, "sequence_number").split_first_chunk()?;
    let (sent_ns, rest) = unnamed(rest, "source_timestamp").split_first_chunk()?;
    let (&len, gid) = unnamed(rest, "source_gid").split_first()?;
    let publisher = gid.try_into().ok().filter(|_| usize::from(len) == GID_LEN)?;
    let (number, sent_ns) = (i64::from_le_bytes(*number), i64::from_le_bytes(*sent_ns));
    Some(Numbered { publisher, number, sent_ns: u64::try_from(sent_ns).unwrap_or(0) })
}

/// Key of the messages of a topic, whatever they are.
pub(crate) fn messages_key(domain_id: u32, topic: &str) -> String {
    format!("{domain_id}/{}/*/*", topic.trim_matches('/'))
}

/// What messages of a key are, `std_msgs/Float64MultiArray`, and the hash of their definition.
pub(crate) fn type_of_key(key: &str) -> (String, &str) {
    let mut chunks = key.rsplit('/');
    let (hash, name) = (chunks.next().unwrap_or_default(), chunks.next().unwrap_or_default());
    (message_name(name), hash)
}

/// Key of the liveliness tokens of all publishers.
pub(crate) fn publishers_key(domain_id: u32) -> String {
    format!("@ros2_lv/{domain_id}/*/*/*/MP/**")
}

impl Publisher {
    /// Of its liveliness token; none of another token.
    pub(crate) fn of_token(token: &str) -> Option<Self> {
        let chunks: Vec<&str> = token.split('/').collect();
        match chunks[..] {
            ["@ros2_lv", _, _, _, _, "MP", _, _, _, topic, name, hash, _] => Some(Self {
                topic: topic.replace('%', "/"),
                message: message_name(name),
                hash: hash.to_owned(),
            }),
            _ => None,
        }
    }
}

/// What follows a value's name, a text with its length, where there is one.
fn unnamed<'a>(bytes: &'a [u8], name: &str) -> &'a [u8] {
    let named = bytes.strip_prefix(&[name.len() as u8]);
    named.and_then(|rest| rest.strip_prefix(name.as_bytes())).unwrap_or(bytes)
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
        let read = read_attachment(&bytes).unwrap();
        assert_eq!(read, Numbered { publisher: [7; GID_LEN], number: 2, sent_ns: 3 });
        for n in 0..33 {
            assert_eq!(read_attachment(&bytes[..n]), None);
        }
        let older = [
            b"\x0fsequence_number",
            &bytes[..8],
            b"\x10source_timestamp",
            &bytes[8..16],
            b"\x0asource_gid",
            &bytes[16..],
        ];
        assert_eq!(read_attachment(&older.concat()), Some(read));
    }

    #[test]
    fn a_token_says_what_is_published() {
        let token = publisher_token(&NODE, 10, "/left/tf", "tf2_msgs/TFMessage");
        let hash = type_hash("tf2_msgs/TFMessage").unwrap();
        let found = Publisher::of_token(&token).unwrap();
        assert_eq!(
            (found.topic.as_str(), found.message.as_str(), found.hash.as_str()),
            ("/left/tf", "tf2_msgs/TFMessage", hash)
        );
        assert_eq!(Publisher::of_token(&node_token(&NODE)), None);
        assert_eq!(publishers_key(3), "@ros2_lv/3/*/*/*/MP/**");
        let key = topic_key(3, "/left/tf", "tf2_msgs/TFMessage");
        assert_eq!(type_of_key(&key), ("tf2_msgs/TFMessage".to_owned(), hash));
        assert_eq!(messages_key(3, "/left/tf"), "3/left/tf/*/*");
    }
}
