//! What the data lines of an Abaqus or CalculiX card name: numbers, sets, ranges, directions.

use std::collections::{BTreeMap, BTreeSet};

use super::DeckFault;
use super::inp_keyword::{Card, DataLine, number, quoted};

/// The members of an *NSET or *ELSET card: numbers, names of earlier sets, or generated ranges.
pub(super) fn set_members(
    card: &Card<'_>,
    sets: &BTreeMap<String, BTreeSet<u32>>,
    kind: &'static str,
    require: impl Fn(usize, u32) -> Result<(), DeckFault>,
) -> Result<Vec<u32>, DeckFault> {
    let mut members = Vec::new();
    for data in &card.data {
        if card.parameter("GENERATE").is_some() {
            let (first, last): (u32, u32) =
                (number(data, 0, "a first number")?, number(data, 1, "a last number")?);
            let step: u32 = if data.1.len() > 2 { number(data, 2, "an increment")? } else { 1 };
            if step == 0 || first > last {
                return Err(unexpected(
                    data.0,
                    "first, last, increment in rising order",
                    &data.1.join(", "),
                ));
            }
            for label in (first..=last).step_by(step as usize) {
                require(data.0, label)?;
                members.push(label);
            }
        } else {
            for field in &data.1 {
                let one = (data.0, vec![*field]);
                members.extend(named(&one, sets, kind, &require)?);
            }
        }
    }
    Ok(members)
}

/// What the first field of a data line names: one number or all members of a set.
pub(super) fn named(
    data: &DataLine<'_>,
    sets: &BTreeMap<String, BTreeSet<u32>>,
    kind: &'static str,
    require: impl Fn(usize, u32) -> Result<(), DeckFault>,
) -> Result<Vec<u32>, DeckFault> {
    let field = data.1.first().copied().unwrap_or("");
    if let Ok(label) = field.parse() {
        require(data.0, label)?;
        return Ok(vec![label]);
    }
    let name = field.trim_matches('"').to_uppercase();
    // `PART-1-1.BASE`: a set or a number of the only instance
    let (_, of_instance) = name.rsplit_once('.').unwrap_or(("", &name));
    if let (true, Ok(label)) = (of_instance.len() < name.len(), of_instance.parse()) {
        require(data.0, label)?;
        return Ok(vec![label]);
    }
    match sets.get(&name).or_else(|| sets.get(of_instance)) {
        Some(members) => Ok(members.iter().copied().collect()),
        None => Err(DeckFault::Undefined { line: data.0, kind, name }),
    }
}

/// The range of directions a *BOUNDARY line holds.
pub(super) fn held_range(data: &DataLine<'_>) -> Result<(u8, u8), DeckFault> {
    let word = data.1.get(1).map(|word| word.to_uppercase()).unwrap_or_default();
    if word == "ENCASTRE" || word == "PINNED" {
        return Ok((1, 3));
    }
    let first: u8 = number(data, 1, "a first direction 1 to 6")?;
    let last: u8 = match data.1.get(2) {
        None | Some(&"") => first,
        Some(_) => number(data, 2, "a last direction 1 to 6")?,
    };
    if 1 <= first && first <= last && last <= 6 {
        Ok((first, last))
    } else {
        Err(unexpected(data.0, "directions from 1 to 6 in rising order", &data.1.join(", ")))
    }
}

pub(super) fn one_row<'a, 'b>(
    card: &'a Card<'b>,
    what: &str,
) -> Result<&'a DataLine<'b>, DeckFault> {
    match card.data.as_slice() {
        [data] => Ok(data),
        rows => Err(DeckFault::Unexpected {
            line: card.line,
            expected: format!("one line with {what} (constant over temperature)"),
            found: format!("{} lines", rows.len()),
        }),
    }
}

pub(super) fn integers(data: &DataLine<'_>) -> Result<Vec<u32>, DeckFault> {
    (0..data.1.len()).map(|i| number(data, i, "a whole number")).collect()
}

pub(super) fn unexpected(line: usize, expected: &str, found: &str) -> DeckFault {
    DeckFault::Unexpected { line, expected: expected.into(), found: quoted(found) }
}
