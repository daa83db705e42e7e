//! Messages of ROS 2, read by the definition that is in the file.
//!
//! The definition is that of a `ros2msg` schema: the fields of the message, then behind a line of `=`
//! those of each type it names. The bytes are CDR (OMG DDSI-RTPS 2.3, 10.2), as rosbag2 keeps them.

use std::collections::BTreeMap;

use super::part::Part;

/// Deepest nesting of types: definitions of ROS are no circles, damaged ones may be.
const MAX_DEPTH: usize = 16;

/// The fields of a message and of the types in it.
#[derive(Debug)]
pub(super) struct Ros2Type {
    fields: Vec<Field>,
    types: BTreeMap<String, Vec<Field>>,
}

#[derive(Debug)]
struct Field {
    name: String,
    /// A primitive, or `package/Type`.
    type_name: String,
    many: Many,
}

#[derive(Clone, Copy, Debug)]
enum Many {
    One,
    Fixed(usize),
    Counted,
}

impl Ros2Type {
    /// A message's type, by the name and the text of its schema.
    pub(super) fn parse(name: &str, schema: &str) -> Result<Self, String> {
        let package = package(name);
        let mut parts = schema.split("\n===");
        let fields = fields(parts.next().unwrap_or_default(), package)?;
        let mut types = BTreeMap::new();
        for part in parts {
            let (_, part) = part.split_once('\n').unwrap_or_default();
            let Some((name, text)) = part.trim_start().split_once('\n') else {
                // a type without fields
                types.insert(full_name(part.trim().trim_start_matches("MSG:").trim(), ""), vec![]);
                continue;
            };
            let name = name.trim_start_matches("MSG:").trim();
            types.insert(full_name(name, ""), self::fields(text, self::package(name))?);
        }
        Ok(Self { fields, types })
    }

    /// A message.
    pub(super) fn read(&self, bytes: &[u8]) -> Result<Part, String> {
        let is_little = match bytes {
            [0, 1, _, _, ..] => true,
            [0, 0, _, _, ..] => false,
            _ => return Err("no plain CDR".to_owned()),
        };
        let mut cdr = Cdr { bytes: &bytes[4..], at: 0, is_little, types: &self.types };
        cdr.object(&self.fields, 0)
    }
}

fn package(name: &str) -> &str {
    name.split('/').next().unwrap_or_default()
}

/// `package/Type` of a type as it is named in `package`.
fn full_name(name: &str, package: &str) -> String {
    let name = name.replace("/msg/", "/");
    if name == "Header" {
        "std_msgs/Header".to_owned()
    } else if name.contains('/') || package.is_empty() {
        name
    } else {
        format!("{package}/{name}")
    }
}

fn fields(text: &str, package: &str) -> Result<Vec<Field>, String> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let mut all = Vec::new();
    for line in lines.filter(|line| !line.is_empty()) {
        let mut words = line.split_whitespace();
        let (Some(type_name), Some(name)) = (words.next(), words.next()) else {
            return Err(format!("a definition has the line {line:?}"));
        };
        // constants are in no message
        let is_constant = name.contains('=') || words.next().is_some_and(|w| w.starts_with('='));
        if !is_constant {
            all.push(field(type_name, name, package)?);
        }
    }
    Ok(all)
}

fn field(type_name: &str, name: &str, package: &str) -> Result<Field, String> {
    let (type_name, many) = match type_name.strip_suffix(']').and_then(|t| t.rsplit_once('[')) {
        None => (type_name, Many::One),
        Some((type_name, n)) if n.is_empty() || n.starts_with("<=") => (type_name, Many::Counted),
        Some((type_name, n)) => {
            // a value has a byte at least, or lists of nothing in lists would never end
            let known = n.parse().ok().filter(|n| *n > 0);
            let known = known.ok_or_else(|| format!("a definition has a list of {n:?}"))?;
            (type_name, Many::Fixed(known))
        }
    };
    let bare = type_name.split("<=").next().unwrap_or_default();
    let type_name = match size(bare).is_some() || bare == "string" {
        true => bare.to_owned(),
        false => full_name(bare, package),
    };
    Ok(Field { name: name.to_owned(), type_name, many })
}

/// Bytes of a primitive that is a number.
fn size(type_name: &str) -> Option<usize> {
    Some(match type_name {
        "bool" | "byte" | "char" | "int8" | "uint8" => 1,
        "int16" | "uint16" => 2,
        "int32" | "uint32" | "float32" => 4,
        "int64" | "uint64" | "float64" => 8,
        _ => return None,
    })
}

/// A message that is being read.
struct Cdr<'a> {
    /// Behind the four bytes that say how it is written; what is aligned counts from here.
    bytes: &'a [u8],
    at: usize,
    is_little: bool,
    types: &'a BTreeMap<String, Vec<Field>>,
}

impl Cdr<'_> {
    fn object(&mut self, fields: &[Field], depth: usize) -> Result<Part, String> {
        if depth > MAX_DEPTH {
            return Err("its definition goes in circles".to_owned());
        }
        if fields.is_empty() {
            // CDR has a byte for what has no members
            self.take(1)?;
        }
        let part = |field: &Field| Ok((field.name.clone(), self.field(field, depth)?));
        Ok(Part::Object(fields.iter().map(part).collect::<Result<_, String>>()?))
    }

    fn field(&mut self, field: &Field, depth: usize) -> Result<Part, String> {
        let n = match field.many {
            Many::One => return self.value(&field.type_name, depth),
            Many::Fixed(n) => n,
            Many::Counted => self.count()?,
        };
        if n > self.bytes.len() {
            return Err(format!("{} of {n} values in {} bytes", field.name, self.bytes.len()));
        }
        let values = (0..n).map(|_| self.value(&field.type_name, depth));
        Ok(Part::List(values.collect::<Result<_, _>>()?))
    }

    fn value(&mut self, type_name: &str, depth: usize) -> Result<Part, String> {
        if let Some(n) = size(type_name) {
            let bits = self.bits(n)?;
            return Ok(number(type_name, bits, n));
        }
        if type_name == "string" {
            let n = self.count()?;
            let text = self.take(n)?;
            let text = text.strip_suffix(&[0]).unwrap_or(text);
            return Ok(Part::Text(String::from_utf8_lossy(text).into_owned()));
        }
        let fields = self.types.get(type_name);
        let fields = fields.ok_or_else(|| format!("its definition has no type {type_name:?}"))?;
        self.object(fields, depth + 1)
    }

    /// The next `n` bytes, in this machine's order.
    fn bits(&mut self, n: usize) -> Result<u64, String> {
        self.at = self.at.next_multiple_of(n);
        let is_little = self.is_little;
        let mut bytes = [0; 8];
        for (i, byte) in self.take(n)?.iter().enumerate() {
            bytes[if is_little { i } else { n - 1 - i }] = *byte;
        }
        Ok(u64::from_le_bytes(bytes))
    }

    fn count(&mut self) -> Result<usize, String> {
        Ok(self.bits(4)? as usize)
    }

    fn take(&mut self, n: usize) -> Result<&[u8], String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..n).ok_or("it is shorter than its definition says")?;
        self.at += n;
        Ok(taken)
    }
}

/// A primitive of `n` bytes.
fn number(type_name: &str, bits: u64, n: usize) -> Part {
    let unused = 64 - 8 * n as u32;
    Part::Number(match type_name {
        "bool" => return Part::Flag(bits != 0),
        "float32" => f64::from(f32::from_bits(bits as u32)),
        "float64" => f64::from_bits(bits),
        _ if type_name.starts_with("int") => ((bits << unused).cast_signed() >> unused) as f64,
        _ => bits as f64,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// As JSON, what is no number as null.
    #[track_caller]
    fn check(found: &Part, expected: &str) {
        let expected: Part = serde_json::from_str(expected).unwrap();
        assert_eq!(format!("{found:?}"), format!("{expected:?}"));
    }

    const ARRAY: &str = "\
# of numbers
MultiArrayLayout  layout        # specification of data layout
float64[]         data
================================================================================
MSG: std_msgs/MultiArrayLayout
MultiArrayDimension[] dim
uint32 data_offset
================================================================================
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
";

    #[test]
    fn lists_in_types_in_types() {
        let array = Ros2Type::parse("std_msgs/msg/Float64MultiArray", ARRAY).unwrap();
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend([1, 0, 0, 0, 2, 0, 0, 0, b'g', 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0]);
        bytes.extend([2, 0, 0, 0, 0, 0, 0, 0]);
        bytes.extend(1.5f64.to_le_bytes());
        bytes.extend(f64::NAN.to_le_bytes());
        let expected = r#"{"layout": {"dim": [{"label": "g", "size": 2, "stride": 3}],
            "data_offset": 0}, "data": [1.5, null]}"#;
        check(&array.read(&bytes).unwrap(), expected);
        for n in 0..bytes.len() {
            array.read(&bytes[..n]).unwrap_err();
        }
    }

    #[test]
    fn constants_defaults_bounds_and_the_other_order_of_bytes() {
        let text = "int8 ON=1\nint8 OFF = 0\nint16 a -7\nstring<=3[<=2] names\nbool[2] on\n";
        let of = Ros2Type::parse("x/msg/X", text).unwrap();
        let bytes = [0, 0, 0, 0, 0xff, 0xfe, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, b'b', 0, 1, 0];
        let expected = r#"{"a": -2, "names": ["b"], "on": [true, false]}"#;
        check(&of.read(&bytes).unwrap(), expected);
    }

    #[test]
    fn what_a_definition_lacks_is_said() {
        let found = |schema: &str| {
            let of = Ros2Type::parse("x/msg/X", schema)?;
            of.read(&[0, 1, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0])
        };
        assert!(found("float64[\n").unwrap_err().contains("line \"float64[\""));
        assert!(found("float64[n] a\n").unwrap_err().contains("list of \"n\""));
        assert!(found("float64[0] a\n").unwrap_err().contains("list of \"0\""));
        assert!(found("Other a\n").unwrap_err().contains("no type \"x/Other\""));
        assert!(found("float64[] a\n").unwrap_err().contains("4294967295 values"));
        assert!(found("X a\n===\nMSG: x/X\nX a\n").unwrap_err().contains("circles"));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn any_definition_and_any_bytes_are_no_panic(
            words in prop::collection::vec(
                prop::sample::select(vec![
                    "float64", "uint8[]", "string", "x/X", "X[2]", "bool[<=3]", "a", "=", "1", " ",
                    "\n", "\n===\n", "MSG: x/X\n", "#", "[", "]",
                ]),
                0..40,
            ),
            bytes in prop::collection::vec(any::<u8>(), 0..80),
        ) {
            let schema = words.concat();
            let message = [&[0, 1, 0, 0], &bytes[..]].concat();
            if let Ok(of) = Ros2Type::parse("x/msg/X", &schema) {
                // what is read of damaged bytes is of no use, but small
                if let Ok(part) = of.read(&message) {
                    let words = format!("{part:?}");
                    prop_assert!(words.len() < 100_000);
                }
            }
        }
    }
}
