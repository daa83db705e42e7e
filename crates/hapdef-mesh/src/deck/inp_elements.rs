//! Elements of Abaqus and CalculiX decks: tetrahedra are read, what is no solid is passed over.

use super::DeckFault;
use super::inp::Reader;
use super::inp_keyword::{Card, DataLine};
use super::inp_sets::integers;

/// What a deck's element kind is to a limb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A tetrahedron of four or ten nodes.
    Tetrahedron(usize),
    /// A face or a line with this many nodes.
    Lower {
        n_nodes: usize,
        is_face: bool,
    },
    /// A mass, spring or other element without a shape.
    Point,
    Unknown,
}

/// Names of faces and lines up to the digit that counts their nodes (Abaqus 2016 and CalculiX 2.20
/// manuals): a T3D3 has three, an S8R5 eight.
const FACES: [&str; 11] =
    ["CPS", "CPE", "CAX", "M3D", "SFM3D", "R3D", "STRI", "DS", "DC2D", "AC2D", "S"];
const LINES: [&str; 5] = ["T2D", "T3D", "DC1D", "R2D", "FRAME"];
/// Beams, whose second digit is the order: two nodes, or three of a B22 or B32.
const BEAMS: [&str; 2] = ["B2", "B3"];
const POINTS: [&str; 8] =
    ["MASS", "ROTARYI", "SPRING", "DASHPOT", "CONN", "GAP", "DCOUP", "HEATCAP"];

impl Kind {
    fn of(name: &str) -> Self {
        let digit = |prefix: &&str| {
            let digit = name.strip_prefix(*prefix)?.chars().next()?.to_digit(10)?;
            usize::try_from(digit).ok().filter(|n| *n > 1)
        };
        if let Some(suffix) = name.strip_prefix("C3D10").or_else(|| name.strip_prefix("C3D4")) {
            let n_nodes = if name.starts_with("C3D10") { 10 } else { 4 };
            let letters = suffix.chars().all(|c| c.is_ascii_alphabetic());
            return if letters { Self::Tetrahedron(n_nodes) } else { Self::Unknown };
        }
        if let Some(n_nodes) = FACES.iter().find_map(digit) {
            Self::Lower { n_nodes, is_face: true }
        } else if let Some(n_nodes) = LINES.iter().find_map(digit) {
            Self::Lower { n_nodes, is_face: false }
        } else if BEAMS.iter().any(|beam| name.starts_with(beam)) {
            let n_nodes = if name[2..].starts_with('2') { 3 } else { 2 };
            Self::Lower { n_nodes, is_face: false }
        } else if POINTS.iter().any(|point| name.starts_with(point)) {
            Self::Point
        } else {
            Self::Unknown
        }
    }
}

impl Reader {
    pub(super) fn elements(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["TYPE", "ELSET"], "only TYPE= and ELSET= are read here")?;
        let name = card.required("TYPE")?;
        let whole = self.deck.is_whole();
        let refused = |why| Err(card.unsupported(format!("*ELEMENT, TYPE={name}"), why));
        let labels = match Kind::of(name) {
            Kind::Tetrahedron(n_nodes) if name == "C3D10" || !whole => {
                if name != "C3D10" && n_nodes == 10 {
                    self.deck.notes.push(format!("{name} is read as C3D10, for its geometry"));
                }
                self.tetrahedra(card, n_nodes)?
            }
            Kind::Tetrahedron(_) => {
                return refused(
                    "only ten-node tetrahedra of the plain formulation (C3D10) are solved; a \
                     scene takes the geometry of this one",
                );
            }
            Kind::Lower { n_nodes, is_face } => {
                let mut labels = Vec::new();
                rows(card, n_nodes, |first, numbers| {
                    let nodes = if is_face { numbers[1..].to_vec() } else { Vec::new() };
                    nodes.iter().try_for_each(|node| self.deck.require_node(first.0, *node))?;
                    self.deck.skip_element(name, numbers[0], nodes);
                    labels.push(numbers[0]);
                    Ok(())
                })?;
                labels
            }
            Kind::Point if !whole => {
                self.deck.pass_over(&format!("*ELEMENT, TYPE={name}"));
                let labels = card.data.iter().filter_map(|data| data.1.first()?.parse().ok());
                let labels: Vec<u32> = labels.collect();
                self.deck.faces.extend(labels.iter().map(|label| (*label, Vec::new())));
                labels
            }
            _ => return refused("only ten-node tetrahedra (C3D10) are supported"),
        };
        if let Some(name) = card.parameter("ELSET") {
            self.element_sets.entry(name.to_owned()).or_default().extend(labels);
        }
        Ok(())
    }

    fn tetrahedra(&mut self, card: &Card<'_>, n_nodes: usize) -> Result<Vec<u32>, DeckFault> {
        let mut labels = Vec::new();
        rows(card, n_nodes, |first, numbers| {
            match *numbers {
                [label, a, b, c, d] => self.deck.add_linear(first.0, label, [a, b, c, d])?,
                [label, ref nodes @ ..] => {
                    let nodes = std::array::from_fn(|i| nodes[i]);
                    self.deck.add_element(first.0, label, nodes)?;
                }
                [] => {}
            }
            labels.push(numbers[0]);
            Ok(())
        })?;
        Ok(labels)
    }
}

/// Hands `take` each element's number and `n_nodes` nodes, which may go over several lines, and its
/// first line.
fn rows(
    card: &Card<'_>,
    n_nodes: usize,
    mut take: impl FnMut(&DataLine<'_>, &[u32]) -> Result<(), DeckFault>,
) -> Result<(), DeckFault> {
    let expected = || match n_nodes {
        10 => "an element number and ten nodes".to_owned(),
        _ => format!("an element number and {n_nodes} nodes"),
    };
    let mut lines = card.data.iter();
    while let Some(first) = lines.next() {
        let mut numbers = integers(first)?;
        let mut last = first;
        while numbers.len() < 1 + n_nodes {
            last = lines.next().ok_or_else(|| DeckFault::Truncated {
                line: last.0,
                expected: expected(),
                found: format!("{} numbers", numbers.len()),
            })?;
            numbers.extend(integers(last)?);
        }
        if numbers.len() > 1 + n_nodes {
            return Err(DeckFault::Unexpected {
                line: last.0,
                expected: expected(),
                found: format!("{} numbers", numbers.len()),
            });
        }
        take(first, &numbers)?;
    }
    Ok(())
}
