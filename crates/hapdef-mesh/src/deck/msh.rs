//! Volume meshes of gmsh (`.msh`), formats 2.2 and 4.1, in words or in bytes: tetrahedra of order 1
//! and 2, and physical groups as node sets.
//!
//! Sections as in the gmsh 4.13 reference manual, chapters "MSH file format" and "MSH file format
//! version 2 (Legacy)".

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;

use super::DeckFault;
use super::builder::DeckBuilder;
use super::msh_source::Source;

/// What gmsh's element types are: number, name, dimension, nodes.
const KINDS: [(i64, &str, usize, usize); 24] = [
    (1, "lines", 1, 2),
    (2, "triangles", 2, 3),
    (3, "quadrangles", 2, 4),
    (4, "four-node tetrahedra", 3, 4),
    (5, "hexahedra", 3, 8),
    (6, "prisms", 3, 6),
    (7, "pyramids", 3, 5),
    (8, "lines", 1, 3),
    (9, "triangles", 2, 6),
    (10, "quadrangles", 2, 9),
    (11, "ten-node tetrahedra", 3, 10),
    (12, "hexahedra", 3, 27),
    (13, "prisms", 3, 18),
    (14, "pyramids", 3, 14),
    (15, "points", 0, 1),
    (16, "quadrangles", 2, 8),
    (17, "hexahedra", 3, 20),
    (18, "prisms", 3, 15),
    (19, "pyramids", 3, 13),
    (20, "triangles of order 3", 2, 9),
    (21, "triangles of order 3", 2, 10),
    (26, "lines of order 3", 1, 4),
    (29, "tetrahedra of order 3", 3, 20),
    (36, "quadrangles of order 3", 2, 16),
];

/// An element's group: its dimension and the number of its physical group.
type Group = (usize, i64);

/// Reads a file's bytes.
pub(super) fn read(bytes: &[u8], deck: DeckBuilder) -> Result<DeckBuilder, DeckFault> {
    let mut source = Source::new(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut reader = Reader { deck, ..Reader::default() };
    while let Some(line) = source.line() {
        let Some(section) = line.strip_prefix('$') else { continue };
        match (section, reader.is_legacy) {
            ("MeshFormat", _) => reader.format(&mut source)?,
            ("PhysicalNames", _) => reader.names(&mut source)?,
            ("Entities", false) => reader.entities(&mut source)?,
            ("Nodes", true) => reader.legacy_nodes(&mut source)?,
            ("Nodes", false) => reader.nodes(&mut source)?,
            ("Elements", true) => reader.legacy_elements(&mut source)?,
            ("Elements", false) => reader.elements(&mut source)?,
            _ => {}
        }
        source.leave(section)?;
    }
    reader.finish(&source)
}

#[derive(Default)]
struct Reader {
    deck: DeckBuilder,
    /// Is it format 2.2?
    is_legacy: bool,
    has_format: bool,
    names: BTreeMap<Group, String>,
    /// Physical groups of a geometric entity, by dimension and tag.
    groups: BTreeMap<(usize, i64), Vec<i64>>,
    members: BTreeMap<Group, BTreeSet<u32>>,
}

impl Reader {
    fn format(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        let line = source.line().ok_or_else(|| source.cut_short("a format"))?;
        let words: Vec<&str> = line.split_whitespace().collect();
        self.is_legacy = match words.as_slice() {
            ["2" | "2.1" | "2.2", _, "8"] => true,
            ["4.1", _, "8"] => false,
            _ => return Err(source.unexpected("format 2.2 or 4.1 with numbers of 8 bytes", &line)),
        };
        self.has_format = true;
        source.is_binary = words[1] == "1";
        if source.is_binary {
            let one = source.int()?;
            if one != 1 {
                return Err(
                    source.unexpected("1 as four bytes, the lowest first", &one.to_string())
                );
            }
        }
        Ok(())
    }

    /// Names are words in a binary file, too.
    fn names(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        let count = source.line().and_then(|line| line.parse().ok()).unwrap_or(0);
        for _ in 0..count {
            let line = source.line().ok_or_else(|| source.cut_short("a physical group"))?;
            let mut words = line.splitn(3, char::is_whitespace);
            let group = words.next().zip(words.next()).zip(words.next());
            let parsed = group.and_then(|((dimension, tag), name)| {
                let name = name.trim().trim_matches('"').to_uppercase();
                Some(((dimension.parse().ok()?, tag.parse().ok()?), name))
            });
            let expected = "dimension, number and \"name\" of a physical group";
            let (group, name) = parsed.ok_or_else(|| source.unexpected(expected, &line))?;
            self.names.insert(group, name);
        }
        Ok(())
    }

    fn entities(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        let counts = [source.size()?, source.size()?, source.size()?, source.size()?];
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let tag = source.int()?;
                // a point's place, or a box around the entity
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    source.real()?;
                }
                for _ in 0..source.size()? {
                    let group = source.int()?;
                    self.groups.entry((dimension, tag)).or_default().push(group);
                }
                // the entities that bound it
                let n_bounds = if dimension == 0 { 0 } else { source.size()? };
                for _ in 0..n_bounds {
                    source.int()?;
                }
            }
        }
        Ok(())
    }

    fn node(&mut self, source: &mut Source<'_>, tag: u64) -> Result<(), DeckFault> {
        let place = Point3::new(source.real()?, source.real()?, source.real()?);
        let (tag, line) = (source.tag(tag)?, 0);
        self.deck.add_node(line, tag, place).map_err(|fault| at_line(fault, source))
    }

    fn legacy_nodes(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        for _ in 0..counted(source)? {
            let tag = source.int()?;
            self.node(source, u64::try_from(tag).unwrap_or(0))?;
        }
        Ok(())
    }

    fn nodes(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        let [n_blocks, _, _, _] = [source.size()?, source.size()?, source.size()?, source.size()?];
        for _ in 0..n_blocks {
            let [dimension, _, has_parameters] = [source.int()?, source.int()?, source.int()?];
            let mut tags = Vec::new();
            for _ in 0..source.size()? {
                tags.push(source.size()?);
            }
            for tag in tags {
                self.node(source, tag)?;
                for _ in 0..if has_parameters == 1 { dimension } else { 0 } {
                    source.real()?;
                }
            }
        }
        Ok(())
    }

    /// In words an element has its type; in bytes elements of a type are told together.
    fn legacy_elements(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        let mut left = counted(source)?;
        while left > 0 {
            let (mut tag, kind, n_alike, n_tags);
            if source.is_binary {
                [kind, n_alike, n_tags] = [source.int()?, source.int()?, source.int()?];
                tag = 0;
            } else {
                [tag, kind, n_tags] = [source.int()?, source.int()?, source.int()?];
                n_alike = 1;
            }
            for _ in 0..n_alike.clamp(1, i64::try_from(left).unwrap_or(i64::MAX)) {
                if source.is_binary {
                    tag = source.int()?;
                }
                let mut physical = Vec::new();
                for i in 0..n_tags {
                    let value = source.int()?;
                    physical.extend((i == 0 && value != 0).then_some(value));
                }
                self.element(source, tag.unsigned_abs(), kind, &physical, |source| {
                    Ok(source.int()?.unsigned_abs())
                })?;
                left -= 1;
            }
        }
        Ok(())
    }

    fn elements(&mut self, source: &mut Source<'_>) -> Result<(), DeckFault> {
        let [n_blocks, _, _, _] = [source.size()?, source.size()?, source.size()?, source.size()?];
        for _ in 0..n_blocks {
            let [dimension, entity, kind] = [source.int()?, source.int()?, source.int()?];
            let of = (usize::try_from(dimension).unwrap_or(0), entity);
            let physical = self.groups.get(&of).cloned().unwrap_or_default();
            for _ in 0..source.size()? {
                let tag = source.size()?;
                self.element(source, tag, kind, &physical, |source| source.size())?;
            }
        }
        Ok(())
    }

    fn element(
        &mut self,
        source: &mut Source<'_>,
        tag: u64,
        kind: i64,
        physical: &[i64],
        mut number: impl FnMut(&mut Source<'_>) -> Result<u64, DeckFault>,
    ) -> Result<(), DeckFault> {
        let known = KINDS.iter().find(|known| known.0 == kind);
        let expected = "an element type of gmsh up to order 3";
        let &(_, name, dimension, n_nodes) =
            known.ok_or_else(|| source.unexpected(expected, &kind.to_string()))?;
        let mut nodes = Vec::with_capacity(n_nodes);
        for _ in 0..n_nodes {
            let value = number(source)?;
            nodes.push(source.tag(value)?);
        }
        let tag = source.tag(tag)?;
        let added = match *nodes.as_slice() {
            [a, b, c, d] if dimension == 3 => self.deck.add_linear(0, tag, [a, b, c, d]),
            // gmsh's last two mid-side nodes are the other way round
            [a, b, c, d, e, f, g, h, i, j] if dimension == 3 => {
                self.deck.add_element(0, tag, [a, b, c, d, e, f, g, h, j, i])
            }
            _ if dimension == 3 => Err(DeckFault::Unsupported {
                line: 0,
                command: format!("element {tag}: {name}"),
                why: "only tetrahedra of order 1 and 2 are supported",
            }),
            _ => {
                let known = nodes.iter().try_for_each(|node| self.deck.require_node(0, *node));
                self.deck.skip_element(name, tag, Vec::new());
                known
            }
        };
        added.map_err(|fault| at_line(fault, source))?;
        for &group in physical {
            self.members.entry((dimension, group)).or_default().extend(&nodes);
        }
        Ok(())
    }

    /// Physical groups become node sets: by their names, else by their numbers.
    fn finish(mut self, source: &Source<'_>) -> Result<DeckBuilder, DeckFault> {
        if !self.has_format {
            return Err(source.unexpected("$MeshFormat in a .msh file of gmsh", "none"));
        }
        for ((dimension, number), nodes) in self.members {
            let unnamed = || format!("PHYSICAL_{dimension}_{number}");
            let name = self.names.remove(&(dimension, number)).unwrap_or_else(unnamed);
            self.deck.node_sets.entry(name).or_default().extend(nodes);
        }
        Ok(self.deck)
    }
}

/// How many nodes or elements of format 2.2 follow: a line of words in any file.
fn counted(source: &mut Source<'_>) -> Result<u64, DeckFault> {
    let line = source.line().unwrap_or_default();
    line.parse().map_err(|_| source.unexpected("how many follow", &line))
}

/// The fault in the line that was reached.
fn at_line(fault: DeckFault, source: &Source<'_>) -> DeckFault {
    let line = source.line_number();
    match fault {
        DeckFault::Undefined { kind, name, .. } => DeckFault::Undefined { line, kind, name },
        DeckFault::Duplicate { kind, name, .. } => DeckFault::Duplicate { line, kind, name },
        DeckFault::Unsupported { command, why, .. } => {
            DeckFault::Unsupported { line, command, why }
        }
        other => other,
    }
}
