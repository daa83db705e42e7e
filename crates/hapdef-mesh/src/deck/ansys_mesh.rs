//! Nodes, elements, components, element types and materials of an ANSYS deck.

use nalgebra::Point3;

use super::ansys::{Command, ElementType, Reader, SurfaceElement, UNKNOWN};
use super::ansys_blocks::{Format, Lines, block, component, label};
use super::inp_keyword::quoted;
use super::{DeckFault, DeckMaterial};

/// Material properties that act only with temperature, time, friction, damping, electricity,
/// magnetism, sound or flow, and names (ANSYS Mechanical APDL command reference, MP).
const HARMLESS_PROPERTIES: [&str; 44] = [
    "alpx", "alpy", "alpz", "ctex", "ctey", "ctez", "thsx", "thsy", "thsz", "kxx", "kyy", "kzz",
    "c", "enth", "reft", "mu", "damp", "dmpr", "dmps", "alpd", "betd", "rsvx", "rsvy", "rsvz",
    "murx", "mury", "murz", "mgxx", "mgyy", "mgzz", "perx", "pery", "perz", "lsst", "sbkx", "sbky",
    "sbkz", "emis", "hf", "qrat", "visc", "sonc", "uvid", "umid",
];

/// Element types that are no solids: links, beams, shells, masses, springs, contacts, surfaces
/// (ANSYS Mechanical APDL element reference).
const NO_SOLIDS: [u32; 44] = [
    3, 4, 8, 10, 14, 21, 28, 33, 34, 37, 39, 40, 41, 43, 57, 63, 68, 91, 93, 99, 131, 132, 151,
    152, 153, 154, 155, 156, 169, 170, 171, 172, 173, 174, 175, 177, 178, 179, 180, 181, 184, 188,
    189, 281,
];

/// One element of an eblock.
struct Row {
    line: usize,
    label: u32,
    kind: u32,
    material: u32,
    axes: i64,
    nodes: Vec<u32>,
}

impl Reader {
    pub(super) fn nodes(
        &mut self,
        command: &Command<'_>,
        lines: &mut Lines<'_>,
    ) -> Result<(), DeckFault> {
        let format = Format::read(lines)?;
        if format.reals.len() < 3 {
            return Err(unexpected(lines.line(), "a format with three or six reals", "fewer"));
        }
        let count = announced(command)?;
        let data = block(lines, "nodes", count)?;
        self.check_count(lines, "nodes", count, data.len())?;
        for (line, text) in data {
            let integers = format.integers(line, text)?;
            let reals = format.reals(line, text)?;
            let node = *integers.first().ok_or_else(|| unexpected(line, "a node number", text))?;
            if reals[3..].iter().any(|angle| *angle != 0.0) {
                let command = format!("nblock, rotated node {node}");
                let why = "nodal coordinate systems must be global";
                return Err(DeckFault::Unsupported { line, command, why });
            }
            self.deck.add_node(
                line,
                label(line, node)?,
                Point3::new(reals[0], reals[1], reals[2]),
            )?;
        }
        Ok(())
    }

    pub(super) fn elements(
        &mut self,
        command: &Command<'_>,
        lines: &mut Lines<'_>,
    ) -> Result<(), DeckFault> {
        let format = Format::read(lines)?;
        let count = announced(command)?;
        let data = block(lines, "elements", count)?;
        let rows = match command.field(2).to_lowercase().as_str() {
            "solid" => solid_rows(&format, &data)?,
            _ => data
                .iter()
                .map(|(line, text)| plain_row(&format, *line, text))
                .collect::<Result<_, _>>()?,
        };
        self.check_count(lines, "elements", count, rows.len())?;
        rows.into_iter().try_for_each(|row| self.element(row))
    }

    fn element(&mut self, row: Row) -> Result<(), DeckFault> {
        let line = row.line;
        let number = self.types.get(&row.kind).map(|kind| kind.number);
        if self.element_types.insert(row.label, row.kind).is_some() {
            return Err(DeckFault::Duplicate {
                line,
                kind: "element",
                name: row.label.to_string(),
            });
        }
        match number {
            Some(187) => {
                let nodes: [u32; 10] = row.nodes.as_slice().try_into().map_err(|_| {
                    unexpected(line, "ten nodes", &format!("{} nodes", row.nodes.len()))
                })?;
                self.materials_used.insert(row.material);
                self.deck.add_element(line, row.label, nodes)
            }
            Some(154) if self.deck.is_whole() => self.surface_element(&row),
            Some(other) if NO_SOLIDS.contains(&other) && !self.deck.is_whole() => {
                self.deck.skip_element(&format!("of type {other}"), row.label, Vec::new());
                Ok(())
            }
            Some(other) => Err(DeckFault::Unsupported {
                line,
                command: format!("element type {other}"),
                why: "only SOLID187 and, for loads, SURF154 are supported",
            }),
            None => {
                Err(DeckFault::Undefined { line, kind: "element type", name: row.kind.to_string() })
            }
        }
    }

    fn surface_element(&mut self, row: &Row) -> Result<(), DeckFault> {
        let &[i, j, k, l, ..] = row.nodes.as_slice() else {
            return Err(unexpected(row.line, "at least four nodes", &row.nodes.len().to_string()));
        };
        if k != l {
            return Err(DeckFault::Unsupported {
                line: row.line,
                command: format!("SURF154 element {} with four corners", row.label),
                why: "the faces of tetrahedra are triangles: its third and fourth node must be the same",
            });
        }
        let axes = u32::try_from(row.axes).unwrap_or(0);
        let element = SurfaceElement { line: row.line, kind: row.kind, corners: [i, j, k], axes };
        self.surface_elements.insert(row.label, element);
        Ok(())
    }

    pub(super) fn component(
        &mut self,
        command: &Command<'_>,
        lines: &mut Lines<'_>,
    ) -> Result<(), DeckFault> {
        let name = command.field(1).to_uppercase();
        let members = component(lines, command.whole(3)?)?;
        match command.field(2).to_lowercase().as_str() {
            "node" => {
                for node in &members {
                    self.deck.require_node(lines.line(), *node)?;
                }
                self.deck.node_sets.insert(name, members.into_iter().collect());
            }
            kind if kind.starts_with("elem") => {
                self.element_components.insert(name, members.into_iter().collect());
            }
            _ => return Err(command.unexpected(2, "NODE or ELEM")),
        }
        Ok(())
    }

    /// The rows of an etblock up to -1: number, kind, options from the first on.
    pub(super) fn element_types(&mut self, lines: &mut Lines<'_>) -> Result<(), DeckFault> {
        let format = Format::read(lines)?;
        for (line, text) in block(lines, "element types", None)? {
            let row = format.integers(line, text)?;
            let [number, kind, options @ ..] = row.as_slice() else {
                return Err(unexpected(line, "a type's number and its kind", text));
            };
            let number = label(line, *number)?;
            let options = (1..).zip(options).filter(|(_, value)| **value != 0);
            let options = options.map(|(option, value)| (option, value.to_string())).collect();
            self.types.insert(number, ElementType { line, number: label(line, *kind)?, options });
        }
        Ok(())
    }

    pub(super) fn element_type(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let name = command.field(2).to_lowercase();
        let digits = name.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let number = digits.parse().map_err(|_| command.unexpected(2, "an element type"))?;
        let mut kind = ElementType { line: command.line, number, options: Default::default() };
        for (i, value) in command.fields.iter().skip(3).take(6).enumerate() {
            set_option(&mut kind, i as u32 + 1, value);
        }
        self.types.insert(command.whole(1)?, kind);
        Ok(())
    }

    pub(super) fn element_option(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let number: u32 = command.whole(1)?;
        let option = command.whole(2)?;
        let kind = self.types.get_mut(&number).ok_or_else(|| DeckFault::Undefined {
            line: command.line,
            kind: "element type",
            name: number.to_string(),
        })?;
        kind.line = command.line;
        set_option(kind, option, command.field(3));
        Ok(())
    }

    /// `MP,label,material,value`, `MPDATA,R5.0,n,label,material,start,value`, `MPTEMP,…`.
    pub(super) fn property(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let why = "only properties that are constant over temperature are supported";
        let (first, value) = match command.name.as_str() {
            "mpte" => return Ok(()),
            "mp" => (1, 3),
            _ => (3, 6),
        };
        let label = match command.field(first).to_lowercase().as_str() {
            "ex" => "ex",
            "dens" => "dens",
            // the same number in an isotropic material
            "nuxy" | "prxy" => "nuxy",
            other if HARMLESS_PROPERTIES.contains(&other) => return Ok(()),
            _ => return Err(command.unsupported(UNKNOWN)),
        };
        command.nothing_from(value + 1, why)?;
        if command.name == "mpda" && command.field(5) != "1" {
            return Err(command.unsupported(why));
        }
        self.properties.insert((command.whole(first + 1)?, label), command.real(value)?);
        Ok(())
    }

    /// Refuses a block that is shorter or longer than announced. Of nodes there may be fewer for a
    /// scene, as Workbench counts some that it does not write; one that is missing is found by its
    /// elements.
    fn check_count(
        &mut self,
        lines: &Lines<'_>,
        what: &str,
        expected: Option<usize>,
        found: usize,
    ) -> Result<(), DeckFault> {
        let line = lines.line();
        match expected {
            Some(expected) if expected > found && what == "nodes" && !self.deck.is_whole() => {
                let note = format!(
                    "the block of {what} that ends in line {line} announces {expected} and has {found}"
                );
                self.deck.notes.push(note);
                Ok(())
            }
            Some(expected) if expected != found => Err(DeckFault::Unexpected {
                line,
                expected: format!("{expected} {what}, as the block announces"),
                found: found.to_string(),
            }),
            _ => Ok(()),
        }
    }

    /// The one material that the elements use.
    pub(super) fn material(&self) -> Result<Option<DeckMaterial>, DeckFault> {
        if self.materials_used.len() > 1 {
            let several = DeckFault::SeveralMaterials { found: self.materials_used.len() };
            return if self.deck.is_whole() { Err(several) } else { Ok(None) };
        }
        let Some(&number) = self.materials_used.first() else {
            return Ok(None);
        };
        let property = |label| self.properties.get(&(number, label)).copied();
        let (Some(youngs_modulus_pa), Some(poissons_ratio)) = (property("ex"), property("nuxy"))
        else {
            return Ok(None);
        };
        Ok(Some(DeckMaterial {
            youngs_modulus_pa,
            poissons_ratio,
            density_kg_m3: property("dens"),
        }))
    }
}

fn set_option(kind: &mut ElementType, option: u32, value: &str) {
    match value {
        "" | "0" => kind.options.remove(&option),
        _ => kind.options.insert(option, value.to_owned()),
    };
}

/// The count that the block's fourth argument announces.
fn announced(command: &Command<'_>) -> Result<Option<usize>, DeckFault> {
    match command.field(4) {
        "" => Ok(None),
        _ => command.whole(4).map(Some),
    }
}

/// Elements of a block with the key `solid`: eleven attributes and up to eight nodes, then lines
/// with the other nodes.
fn solid_rows(format: &Format, data: &[(usize, &str)]) -> Result<Vec<Row>, DeckFault> {
    let mut rows = Vec::new();
    let mut data = data.iter();
    while let Some(&(line, text)) = data.next() {
        let head = format.integers(line, text)?;
        if head.len() < 12 {
            return Err(unexpected(line, "eleven attributes and nodes", text));
        }
        let n_nodes = usize::try_from(head[8]).unwrap_or(0);
        let mut nodes = head[11..].to_vec();
        while nodes.len() < n_nodes {
            let &(line, text) = data.next().ok_or_else(|| {
                unexpected(line, &format!("{n_nodes} nodes"), &format!("{} nodes", nodes.len()))
            })?;
            nodes.extend(format.integers(line, text)?);
        }
        rows.push(row(line, [head[10], head[1], head[0], head[4]], &nodes, n_nodes)?);
    }
    Ok(rows)
}

/// An element of a block without the key: number, type, real constants, material, coordinate
/// system, nodes.
fn plain_row(format: &Format, line: usize, text: &str) -> Result<Row, DeckFault> {
    let all = format.integers(line, text)?;
    if all.len() < 6 {
        return Err(unexpected(line, "five attributes and nodes", text));
    }
    row(line, [all[0], all[1], all[3], all[4]], &all[5..], all.len() - 5)
}

fn row(
    line: usize,
    [element, kind, material, axes]: [i64; 4],
    nodes: &[i64],
    n_nodes: usize,
) -> Result<Row, DeckFault> {
    if nodes.len() != n_nodes {
        let (expected, found) = (format!("{n_nodes} nodes"), format!("{} nodes", nodes.len()));
        return Err(unexpected(line, &expected, &found));
    }
    Ok(Row {
        line,
        label: label(line, element)?,
        kind: label(line, kind)?,
        material: label(line, material)?,
        axes,
        nodes: nodes.iter().map(|node| label(line, *node)).collect::<Result<_, _>>()?,
    })
}

fn unexpected(line: usize, expected: &str, found: &str) -> DeckFault {
    DeckFault::Unexpected { line, expected: expected.into(), found: quoted(found) }
}
