//! ANSYS decks (`.dat` of Workbench, `.cdb`): SOLID187 tetrahedra, one material, fixed nodes,
//! nodal forces, and surface loads through SURF154 elements; one linear static load step.
//!
//! Commands follow the ANSYS Mechanical APDL command reference and count by their first four
//! letters.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Matrix3;

use super::ansys_blocks::Lines;
use super::ansys_parameters::Parameters;
use super::ansys_state::{PendingLoad, Selection};
use super::builder::DeckBuilder;
use super::inp_keyword::quoted;
use super::{DeckFault, DeckReading};
use crate::LengthUnit;

/// Commands that don't change a linear static model: output, display, solver choice, bookkeeping,
/// a reference temperature without temperature loads, active coordinate systems (blocks are always
/// global Cartesian), and default attributes for elements made later (blocks state their own).
const HARMLESS: [&str; 50] = [
    "/bat", "/con", "/nop", "/gop", "/nol", "/gol", "/wb", "/com", "/tit", "/gst", "/go", "/out",
    "/xml", "/vie", "/sho", "/del", "/sys", "/fil", "/sta", "/ner", "/sol", "/pre", "shpp", "etco",
    "csys", "toff", "tref", "eqsl", "cntr", "dmpo", "nldi", "resc", "nsub", "auto", "kbc", "delt",
    "outr", "outp", "cewr", "save", "fini", "xmlo", "*msg", "*sta", "*end", "type", "mat", "real",
    "esys", "secn",
];

/// Why an unknown command is refused.
pub(super) const UNKNOWN: &str =
    "it may change the model, so it can't be skipped; remove it or restate the model without it";

/// Commands that make, move or drop nodes and elements one by one or read them from elsewhere: no
/// mesh can be read without them.
const MESH_MAKING: [&str; 24] = [
    "n", "e", "en", "ngen", "egen", "nsca", "nmod", "numm", "numc", "nume", "numo", "nele", "edel",
    "ndel", "fill", "vmes", "ames", "vswe", "esiz", "/inp", "cdre", "nrea", "erea", "*do",
];

/// Reads a deck's text.
pub(super) fn read(text: &str, deck: DeckBuilder) -> Result<DeckBuilder, DeckFault> {
    let mut lines = Lines::new(text);
    let mut reader = Reader { deck, time: 1.0, ..Reader::default() };
    while let Some((line, text)) = lines.next() {
        reader.line(line, text, &mut lines)?;
    }
    if reader.open_file {
        return Err(DeckFault::Truncated {
            line: lines.line(),
            expected: "/wb,file,end".into(),
            found: "the end of the file".into(),
        });
    }
    reader.finish()
}

/// An element type and its options.
#[derive(Debug)]
pub(super) struct ElementType {
    /// Where it was set last.
    pub(super) line: usize,
    /// ANSYS's number: 187, 154.
    pub(super) number: u32,
    /// Options set to something else than 0 or nothing, by their number.
    pub(super) options: BTreeMap<u32, String>,
}

/// A SURF154 element on a triangular face.
#[derive(Debug)]
pub(super) struct SurfaceElement {
    pub(super) line: usize,
    pub(super) kind: u32,
    pub(super) corners: [u32; 3],
    /// Number of the coordinate system its loads act in.
    pub(super) axes: u32,
}

/// What the commands so far have set.
#[derive(Debug, Default)]
pub(super) struct Reader {
    pub(super) deck: DeckBuilder,
    pub(super) parameters: Parameters,
    pub(super) types: BTreeMap<u32, ElementType>,
    pub(super) axes: BTreeMap<u32, Matrix3<f64>>,
    /// Type number of every element, surface elements included.
    pub(super) element_types: BTreeMap<u32, u32>,
    pub(super) surface_elements: BTreeMap<u32, SurfaceElement>,
    pub(super) element_components: BTreeMap<String, BTreeSet<u32>>,
    pub(super) materials_used: BTreeSet<u32>,
    pub(super) properties: BTreeMap<(u32, &'static str), f64>,
    pub(super) selected_nodes: Selection,
    pub(super) selected_elements: Selection,
    pub(super) pending: Vec<PendingLoad>,
    pub(super) time: f64,
    solved: bool,
    in_post: bool,
    open_file: bool,
}

impl Reader {
    fn line(&mut self, line: usize, text: &str, lines: &mut Lines<'_>) -> Result<(), DeckFault> {
        let content = text.split('!').next().unwrap_or("").trim();
        if content.is_empty() || content.to_lowercase().starts_with("c***") {
            return Ok(());
        }
        let word = content.split([',', ' ', '\t']).next().unwrap_or("").to_lowercase();
        let name: String = word.chars().take(4).collect();
        if self.solved && !self.deck.is_whole() && name != "/wb" {
            return Ok(()); // the mesh was complete
        }
        if self.in_post {
            self.in_post = !matches!(name.as_str(), "fini" | "/pre" | "/sol");
            return Ok(());
        }
        if let Some((left, right)) = assignment(content) {
            return self.parameters.assign(line, left, right);
        }
        let command = Command { line, name, fields: fields(content) };
        let known = self.command(&command, lines);
        if self.deck.is_whole() || command.is_needed(self.deck.reading) {
            return known;
        }
        match known {
            Err(
                DeckFault::Unsupported { .. }
                | DeckFault::Undefined { .. }
                | DeckFault::Unexpected { .. },
            ) => {
                // data lines of a block that a scene has no use for come without a command
                if content.starts_with(|c: char| c.is_ascii_alphabetic() || "/*".contains(c)) {
                    self.deck.pass_over(&command.name.to_uppercase());
                }
                Ok(())
            }
            known => known,
        }
    }

    fn command(&mut self, command: &Command<'_>, lines: &mut Lines<'_>) -> Result<(), DeckFault> {
        match command.name.as_str() {
            "/wb" => self.marker(command),
            "/pos" => self.in_post = true,
            "*get" => self.parameters.forget(command.field(1)),
            "*if" => return self.skip_condition(command, lines),
            "*els" => skip_to_end(lines)?,
            name if HARMLESS.contains(&name) => {}
            "n" | "en" if command.is_end_mark() => {}
            "solv" if !self.solved => self.solved = true,
            "f" | "sfe" if !self.deck.is_whole() => self.deck.pass_over(command.field(0)),
            _ if self.solved => {
                return Err(command.unsupported("only one load step, ended by SOLVE, is supported"));
            }
            "nblo" => return self.nodes(command, lines),
            "eblo" => return self.elements(command, lines),
            "cmbl" => return self.component(command, lines),
            "et" => return self.element_type(command),
            "etbl" => return self.element_types(lines),
            "keyo" => return self.element_option(command),
            "mp" | "mpda" | "mpte" => return self.property(command),
            "/uni" => self.deck.unit = units(command)?,
            "loca" => return self.local_axes(command),
            "cmse" | "nsel" | "esel" | "nsle" | "esln" | "alls" | "cm" => {
                return self.select(command);
            }
            "d" => return self.hold(command),
            "f" => return self.force(command),
            "sfe" => return self.surface_load(command),
            "time" => self.time = command.real(1)?,
            "*dim" => return self.parameters.dimension(command.line, &command.fields),
            "*set" => {
                return self.parameters.assign(command.line, command.field(1), command.field(2));
            }
            _ => return self.conditional(command),
        }
        Ok(())
    }

    /// Commands that are harmless with some arguments only.
    fn conditional(&self, command: &Command<'_>) -> Result<(), DeckFault> {
        let argument = command.field(1).to_lowercase();
        let harmless = match command.name.as_str() {
            "anty" => matches!(argument.as_str(), "" | "0" | "static" | "stat"),
            "nlge" | "stab" | "pstr" => matches!(argument.as_str(), "off" | "0"),
            "dof" => argument == "delete",
            "numo" => self.deck.node_labels().next().is_none(),
            _ => false,
        };
        if harmless { Ok(()) } else { Err(command.unsupported(UNKNOWN)) }
    }

    /// Workbench frames its decks, which shows whether one is whole.
    fn marker(&mut self, command: &Command<'_>) {
        match (command.field(1), command.field(2)) {
            ("file", "start") => self.open_file = true,
            ("file", "end") => self.open_file = false,
            _ => {}
        }
    }

    /// The two conditions that deck writers emit are false in a fresh batch run: an interactive
    /// session, and a solid model read before the mesh.
    fn skip_condition(
        &mut self,
        command: &Command<'_>,
        lines: &mut Lines<'_>,
    ) -> Result<(), DeckFault> {
        let condition = command.fields[1..].join(",").to_lowercase();
        match condition.as_str() {
            "ansinter_,ne,0,then" | "_cdrdoff,eq,1,then" => skip_to_end(lines),
            _ => {
                Err(command
                    .unsupported("conditions can't be evaluated; write the deck without them"))
            }
        }
    }
}

/// Skips to the `*endif` or `*else` that ends this branch, over conditions within it.
fn skip_to_end(lines: &mut Lines<'_>) -> Result<(), DeckFault> {
    let mut depth = 0_usize;
    loop {
        let (_, text) = lines.need("*endif", "an open *if")?;
        let word = text.trim().to_lowercase();
        if word.starts_with("*if") && word.contains("then") {
            depth += 1;
        } else if depth > 0 {
            depth -= usize::from(word.starts_with("*endif"));
        } else if word.starts_with("*endif") || word.starts_with("*else") {
            return Ok(());
        }
    }
}

/// The unit of length that `/units` names.
fn units(command: &Command<'_>) -> Result<Option<LengthUnit>, DeckFault> {
    match command.field(1).to_lowercase().as_str() {
        "mks" | "si" => Ok(Some(LengthUnit::Metre)),
        "mpa" => Ok(Some(LengthUnit::Millimetre)),
        _ => Err(command.unsupported(
            "only /units,MKS and /units,SI (metres) and /units,MPA (millimetres) are supported",
        )),
    }
}

/// `name = value` or `name(i,j,k) = value`.
fn assignment(content: &str) -> Option<(&str, &str)> {
    let (left, right) = content.split_once('=')?;
    let base = left.split('(').next().unwrap_or("").trim();
    let is_name = base.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && base.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    is_name.then_some((left, right))
}

fn fields(content: &str) -> Vec<&str> {
    content.split(',').map(str::trim).collect()
}

/// One command line.
#[derive(Debug)]
pub(super) struct Command<'a> {
    pub(super) line: usize,
    /// The first four letters in lower case.
    pub(super) name: String,
    /// The command word and its arguments, trimmed.
    pub(super) fields: Vec<&'a str>,
}

impl Command<'_> {
    /// Must `reading` have what the command says? Then it is refused where it can't be read.
    fn is_needed(&self, reading: DeckReading) -> bool {
        let name = self.name.as_str();
        let of_mesh = ["nblo", "eblo", "cmbl", "et", "etbl", "/uni", "*if", "*use"];
        of_mesh.contains(&name)
            || MESH_MAKING.contains(&name)
            || (reading == DeckReading::Supports && name == "d")
    }

    /// `N,R5.3,LOC,-1,` and `EN,R5.5,ATTR,-1,`: old end marks of blocks.
    fn is_end_mark(&self) -> bool {
        matches!(self.field(2).to_lowercase().as_str(), "loc" | "attr") && self.field(3) == "-1"
    }

    /// Argument `i`, counted from 1; empty if it is not there.
    pub(super) fn field(&self, i: usize) -> &str {
        self.fields.get(i).copied().unwrap_or("")
    }

    /// Argument `i` as a whole number.
    pub(super) fn whole<T: std::str::FromStr>(&self, i: usize) -> Result<T, DeckFault> {
        self.field(i).parse().map_err(|_| self.unexpected(i, "a whole number"))
    }

    /// Argument `i` as a finite number.
    pub(super) fn real(&self, i: usize) -> Result<f64, DeckFault> {
        let value = self.field(i).parse().ok().filter(|value: &f64| value.is_finite());
        value.ok_or_else(|| self.unexpected(i, "a finite number"))
    }

    /// Refuses arguments from `first` on that are neither empty nor 0.
    pub(super) fn nothing_from(&self, first: usize, why: &'static str) -> Result<(), DeckFault> {
        let blank = |field: &&str| field.is_empty() || field.parse::<f64>() == Ok(0.0);
        match self.fields.iter().skip(first).all(blank) {
            true => Ok(()),
            false => Err(self.unsupported(why)),
        }
    }

    pub(super) fn unexpected(&self, i: usize, expected: &str) -> DeckFault {
        DeckFault::Unexpected {
            line: self.line,
            expected: format!("{expected} as argument {i} of {}", self.field(0)),
            found: quoted(self.field(i)),
        }
    }

    pub(super) fn unsupported(&self, why: &'static str) -> DeckFault {
        DeckFault::Unsupported { line: self.line, command: self.fields.join(","), why }
    }
}
