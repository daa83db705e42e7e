//! What a message says, its fields in their order.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};

/// A message, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Part {
    /// A number; what is null is none.
    Number(f64),
    Text(String),
    Flag(bool),
    List(Vec<Part>),
    Object(Vec<(String, Part)>),
}

impl Part {
    /// A field of an object.
    pub(super) fn field(&self, name: &str) -> Option<&Self> {
        self.fields().find(|(field, _)| *field == name).map(|(_, part)| part)
    }

    /// The fields of an object; none of anything else.
    pub(super) fn fields(&self) -> impl Iterator<Item = (&str, &Self)> {
        let fields = match self {
            Self::Object(fields) => fields.as_slice(),
            _ => &[],
        };
        fields.iter().map(|(name, part)| (name.as_str(), part))
    }

    /// The time in a header of ROS, ns since 1970 UTC; none without a header, or where it was left at 0.
    pub(super) fn stamp_ns(&self) -> Option<u64> {
        let stamp = self.field("header")?.field("stamp")?;
        let whole = |name| Some(stamp.field(name)?.number()? as u64);
        let ns = whole("sec")?.saturating_mul(1_000_000_000).saturating_add(whole("nanosec")?);
        (ns > 0).then_some(ns)
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// A list of numbers that has some.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::List(parts) if !parts.is_empty() => parts.iter().map(Self::number).collect(),
            _ => None,
        }
    }

    /// A list of texts.
    pub(super) fn texts(&self) -> Option<Vec<String>> {
        let text = |part: &Self| match part {
            Self::Text(text) => Some(text.clone()),
            _ => None,
        };
        match self {
            Self::List(parts) => parts.iter().map(text).collect(),
            _ => None,
        }
    }
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PartVisitor)
    }
}

struct PartVisitor;

impl<'de> Visitor<'de> for PartVisitor {
    type Value = Part;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_f64<E>(self, number: f64) -> Result<Part, E> {
        Ok(Part::Number(number))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Part, E> {
        Ok(Part::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Part, E> {
        Ok(Part::Number(number as f64))
    }

    fn visit_unit<E>(self) -> Result<Part, E> {
        Ok(Part::Number(f64::NAN))
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Part, E> {
        Ok(Part::Flag(flag))
    }

    fn visit_str<E>(self, text: &str) -> Result<Part, E> {
        Ok(Part::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Part, A::Error> {
        let mut parts = Vec::new();
        while let Some(part) = list.next_element()? {
            parts.push(part);
        }
        Ok(Part::List(parts))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Part, A::Error> {
        let mut fields = Vec::new();
        while let Some(field) = map.next_entry()? {
            fields.push(field);
        }
        Ok(Part::Object(fields))
    }
}
