//! The list of numbers in a message, wherever it is.

use super::part::Part;

/// Numbers with the names of those that have some.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) names: Option<Vec<String>>,
    pub(super) values: Vec<f64>,
}

/// The one list of numbers in `message`, or at its field `path` of names with points between; where there is
/// no list, the numbers that are fields of it. A list beside it of as many texts names them.
pub(super) fn numbers(message: &Part, path: Option<&str>) -> Result<Found, String> {
    let (mut parent, mut part) = (message, message);
    for name in path.into_iter().flat_map(|path| path.split('.')) {
        let inner = part.field(name);
        let inner = inner.ok_or_else(|| format!("no field {name:?}: it has {}", names_in(part)))?;
        (parent, part) = (part, inner);
    }
    let mut lists = Vec::new();
    search(part, parent, path.unwrap_or_default(), &mut lists);
    match lists.as_slice() {
        [] => single_numbers(part),
        [(_, found)] => Ok(found.clone()),
        [(one, _), (other, _), ..] => {
            Err(format!("several lists of numbers, {one:?} and {other:?}: name one as TOPIC.{one}"))
        }
    }
}

/// All lists of numbers in `part`, a field of `parent`, with their paths.
fn search(part: &Part, parent: &Part, path: &str, lists: &mut Vec<(String, Found)>) {
    if let Some(values) = part.numbers() {
        let mut texts = parent.fields().filter_map(|(_, beside)| beside.texts());
        let names = texts.find(|texts| texts.len() == values.len());
        lists.push((path.to_owned(), Found { names, values }));
    }
    for (name, inner) in part.fields() {
        let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        search(inner, part, &path, lists);
    }
}

fn single_numbers(part: &Part) -> Result<Found, String> {
    if let Some(value) = part.number() {
        return Ok(Found { names: None, values: vec![value] });
    }
    let numbers = part.fields().filter_map(|(name, part)| Some((name.to_owned(), part.number()?)));
    let (names, values): (Vec<String>, Vec<f64>) = numbers.unzip();
    if values.is_empty() {
        return Err(format!("no numbers: it has {}", names_in(part)));
    }
    Ok(Found { names: Some(names), values })
}

fn names_in(part: &Part) -> String {
    let names: Vec<&str> = part.fields().map(|(name, _)| name).collect();
    if names.is_empty() { "no fields".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(json: &str, path: Option<&str>) -> Result<Found, String> {
        numbers(&serde_json::from_str(json).unwrap(), path)
    }

    #[track_caller]
    fn check(json: &str, path: Option<&str>, names: Option<&[&str]>, values: &[f64]) {
        let names = names.map(|names| names.iter().map(|name| (*name).to_owned()).collect());
        assert_eq!(found(json, path).unwrap(), Found { names, values: values.to_vec() }, "{json}");
    }

    #[test]
    fn the_numbers_of_messages() {
        check("[1, 2.5]", None, None, &[1.0, 2.5]);
        check(r#"{"t": 3, "data": [1, -2], "dim": []}"#, None, None, &[1.0, -2.0]);
        check(r#"{"layout": {"offset": 1}, "a": {"b": [7]}}"#, None, None, &[7.0]);
        // fields keep their order
        check(r#"{"t": 3, "g0": 1.5, "u": "ue"}"#, None, Some(&["t", "g0"]), &[3.0, 1.5]);
        check("4", None, None, &[4.0]);
        let joints =
            r#"{"name": ["a", "b"], "position": [1, 2], "velocity": [], "effort": [3, 4]}"#;
        check(joints, Some("effort"), Some(&["a", "b"]), &[3.0, 4.0]);
        let inner = format!(r#"{{"s": {joints}}}"#);
        check(&inner, Some("s.position"), Some(&["a", "b"]), &[1.0, 2.0]);
        check(r#"{"names": ["a"], "values": [1]}"#, None, Some(&["a"]), &[1.0]);
        assert!(found("[1, null]", None).unwrap().values[1].is_nan());
    }

    #[test]
    fn messages_without_or_with_too_many_numbers_are_refused() {
        #[track_caller]
        fn refused(json: &str, path: Option<&str>, expected: &str) {
            let error = found(json, path).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        refused(
            r#"{"position": [1], "effort": [3]}"#,
            None,
            r#""position" and "effort": name one as TOPIC.position"#,
        );
        refused(r#"{"a": "b", "c": []}"#, None, "no numbers: it has a, c");
        refused(r#"{"a": 1}"#, Some("b"), r#"no field "b": it has a"#);
        refused(r#""text""#, None, "no numbers: it has no fields");
    }
}
