//! Abaqus and CalculiX decks (`.inp`) with C3D10 elements: one part and its instance, one linear
//! static step.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use super::builder::{DeckBuilder, SurfaceLoad};
use super::include::Includes;
use super::inp_keyword::{Card, DataLine, cards, number, real, real_or_zero};
use super::inp_sets::{held_range, named, one_row, set_members, unexpected};
use super::{DeckFault, DeckMaterial, DeckReading};

/// Keywords that don't change a linear static model: titles, output requests, step frames,
/// properties that act only with temperature, time or damping, and surface definitions, which
/// act only through loads and constraints that are refused.
const HARMLESS: [&str; 29] = [
    "HEADING",
    "PREPRINT",
    "RESTART",
    "STATIC",
    "END STEP",
    "NODE PRINT",
    "NODE FILE",
    "NODE OUTPUT",
    "EL PRINT",
    "EL FILE",
    "ELEMENT OUTPUT",
    "ENERGY OUTPUT",
    "ENERGY PRINT",
    "ENERGY FILE",
    "CONTACT OUTPUT",
    "OUTPUT",
    "PRINT",
    "MONITOR",
    "FILE FORMAT",
    "SURFACE",
    "CONDUCTIVITY",
    "SPECIFIC HEAT",
    "EXPANSION",
    "DAMPING",
    "NO ANALYSIS",
    "SECTION PRINT",
    "SECTION FILE",
    "NODE RESPONSE",
    "PHYSICAL CONSTANTS",
];

/// Keywords that make or move nodes and elements: no mesh can be read without them.
const MESH_MAKING: [&str; 12] = [
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SYSTEM",
    "IMPORT",
    "PARAMETER",
    "ADAPTIVE MESH",
    "SUBSTRUCTURE GENERATE",
    "MAP SOLUTION",
];

/// Why a keyword is refused.
const UNKNOWN: &str =
    "it may change the model, so it can't be skipped; remove it or restate the model without it";

/// Reads a deck's text and the files it includes.
pub(super) fn read(
    text: &str,
    deck: DeckBuilder,
    includes: &mut Includes,
) -> Result<DeckBuilder, DeckFault> {
    let mut reader = Reader { deck, ..Reader::default() };
    reader.text(text, includes)?;
    reader.finish(text.lines().count())
}

#[derive(Default)]
pub(super) struct Reader {
    pub(super) deck: DeckBuilder,
    pub(super) element_sets: BTreeMap<String, BTreeSet<u32>>,
    materials: BTreeMap<String, DeckMaterial>,
    open_material: Option<String>,
    used_materials: BTreeSet<String>,
    /// Is the material none that could be used?
    no_material: bool,
    forces_given: BTreeSet<(u32, usize)>,
    steps_open: usize,
    steps: usize,
    parts: usize,
    instances: usize,
    /// Within *ASSEMBLY and no *INSTANCE: nodes there are reference points, numbered on their own.
    in_assembly: bool,
}

impl Reader {
    fn text(&mut self, text: &str, includes: &mut Includes) -> Result<(), DeckFault> {
        for card in cards(text)? {
            if card.name != "INCLUDE" {
                self.card(&card)?;
                continue;
            }
            let file = card.required("INPUT")?;
            includes.open(file, |includes, text| match text {
                Ok(text) => self.text(text, includes).map_err(|fault| DeckFault::Included {
                    file: file.to_owned(),
                    fault: Box::new(fault),
                }),
                Err(why) => Err(card.unsupported(format!("*INCLUDE, INPUT={file}"), why)),
            })?;
        }
        Ok(())
    }

    /// Reads a card. For a scene, what is refused in other cards than those of mesh and supports is
    /// passed over.
    fn card(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        let done = self.known(card);
        let needed = match card.name.as_str() {
            "NODE" | "ELEMENT" | "PART" | "INSTANCE" => true,
            "BOUNDARY" => self.deck.reading != DeckReading::Mesh,
            name => MESH_MAKING.contains(&name),
        };
        match done {
            Err(DeckFault::Unsupported { .. }) if !self.deck.is_whole() && !needed => {
                let material = ["ELASTIC", "DENSITY", "SOLID SECTION", "MATERIAL"];
                self.no_material |= material.contains(&card.name.as_str());
                self.deck.pass_over(&format!("*{}", card.name));
                Ok(())
            }
            Err(DeckFault::Undefined { .. }) if card.name == "BOUNDARY" && !needed => {
                self.deck.pass_over("*BOUNDARY");
                Ok(())
            }
            done => done,
        }
    }

    fn known(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        match card.name.as_str() {
            "NODE" | "ELEMENT" | "NSET" | "ELSET"
                if self.in_assembly && card.parameter("INSTANCE").is_none() =>
            {
                if self.deck.is_whole() {
                    return Err(card.unsupported(
                        format!("*{} of the assembly", card.name),
                        "only the nodes and sets of one part and its instance are read",
                    ));
                }
                self.deck.pass_over(&format!("*{} of the assembly", card.name));
                Ok(())
            }
            "NODE" => self.nodes(card),
            "ELEMENT" => self.elements(card),
            "NSET" => self.node_set(card),
            "ELSET" => self.element_set(card),
            "PART" => one_only(card, &mut self.parts),
            "INSTANCE" => self.instance(card),
            "ASSEMBLY" | "END INSTANCE" => {
                self.in_assembly = true;
                Ok(())
            }
            "END ASSEMBLY" => {
                self.in_assembly = false;
                Ok(())
            }
            "END PART" => Ok(()),
            "MATERIAL" => self.material(card),
            "ELASTIC" => self.elastic(card),
            "DENSITY" => self.density(card),
            "SOLID SECTION" => self.section(card),
            "BOUNDARY" => self.boundary(card),
            "STEP" => self.step(card),
            "CLOAD" | "DLOAD" if !self.deck.is_whole() => {
                self.deck.pass_over(&format!("*{}", card.name));
                Ok(())
            }
            "CLOAD" => self.point_forces(card),
            "DLOAD" => self.pressures(card),
            name if HARMLESS.contains(&name) => {
                self.steps_open -= usize::from(name == "END STEP" && self.steps_open > 0);
                Ok(())
            }
            name => Err(card.unsupported(format!("*{name}"), UNKNOWN)),
        }
    }

    fn nodes(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["NSET", "SYSTEM"], "only NSET= is read here")?;
        if card.parameter("SYSTEM").is_some_and(|system| system != "R") {
            return Err(card.unsupported("*NODE, SYSTEM".into(), "coordinates must be rectangular"));
        }
        let mut labels = Vec::with_capacity(card.data.len());
        for data in &card.data {
            let label = number(data, 0, "a node number")?;
            let [x, y, z] =
                [real_or_zero(data, 1)?, real_or_zero(data, 2)?, real_or_zero(data, 3)?];
            self.deck.add_node(data.0, label, Point3::new(x, y, z))?;
            labels.push(label);
        }
        self.extend_node_set(card.parameter("NSET"), labels);
        Ok(())
    }

    /// The part's one instance, with its mesh moved and turned to where the instance is: a line with
    /// a translation, a line with two points of an axis and an angle in degrees.
    fn instance(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        one_only(card, &mut self.instances)?;
        self.in_assembly = false;
        let row = |i: usize, n: usize| -> Result<Vec<f64>, DeckFault> {
            let Some(data) = card.data.get(i) else { return Ok(vec![0.0; n]) };
            (0..n).map(|i| real_or_zero(data, i)).collect()
        };
        let (shift, turn) = (row(0, 3)?, row(1, 7)?);
        let (a, b) = (Point3::from_slice(&turn[..3]), Point3::from_slice(&turn[3..6]));
        let axis = Unit::try_new(b - a, 0.0).unwrap_or(Vector3::z_axis());
        let turn = Rotation3::from_axis_angle(&axis, turn[6].to_radians());
        let shift = Vector3::from_column_slice(&shift);
        self.deck.move_nodes(|position| a + turn * (position + shift - a));
        Ok(())
    }

    fn node_set(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(
            &["NSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"],
            "only NSET= and GENERATE are read here",
        )?;
        let name = card.required("NSET")?.to_owned();
        let labels = set_members(card, &self.deck.node_sets, "node set", |line, label| {
            self.deck.require_node(line, label)
        })?;
        self.extend_node_set(Some(&name), labels);
        Ok(())
    }

    fn extend_node_set(&mut self, name: Option<&str>, labels: Vec<u32>) {
        if let Some(name) = name {
            self.deck.node_sets.entry(name.to_owned()).or_default().extend(labels);
        }
    }

    fn element_set(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(
            &["ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"],
            "only ELSET= and GENERATE are read here",
        )?;
        let name = card.required("ELSET")?.to_owned();
        let labels =
            set_members(card, &self.element_sets, "element set", |line, label| {
                match self.deck.faces.contains_key(&label) {
                    true => Ok(()),
                    false => self.deck.require_element(line, label),
                }
            })?;
        self.element_sets.entry(name).or_default().extend(labels);
        Ok(())
    }

    fn material(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        self.open_material = Some(card.required("NAME")?.to_owned());
        Ok(())
    }

    fn open_material(&mut self, card: &Card<'_>) -> Result<&mut DeckMaterial, DeckFault> {
        let name = self.open_material.clone().ok_or_else(|| DeckFault::Unexpected {
            line: card.line,
            expected: format!("*MATERIAL before *{}", card.name),
            found: "none".into(),
        })?;
        Ok(self.materials.entry(name).or_insert(DeckMaterial {
            youngs_modulus_pa: f64::NAN,
            poissons_ratio: f64::NAN,
            density_kg_m3: None,
        }))
    }

    fn elastic(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["TYPE"], "only isotropic elasticity is supported")?;
        if card.parameter("TYPE").is_some_and(|kind| !kind.starts_with("ISO")) {
            return Err(
                card.unsupported("*ELASTIC, TYPE".into(), "only isotropic elasticity is supported")
            );
        }
        let data = one_row(card, "E and ν")?;
        let (youngs_modulus_pa, poissons_ratio) = (real(data, 0)?, real(data, 1)?);
        let material = self.open_material(card)?;
        *material = DeckMaterial { youngs_modulus_pa, poissons_ratio, ..*material };
        Ok(())
    }

    fn density(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        let density = real(one_row(card, "the density")?, 0)?;
        self.open_material(card)?.density_kg_m3 = Some(density);
        Ok(())
    }

    fn section(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["ELSET", "MATERIAL", "CONTROLS"], "only ELSET= and MATERIAL= are read here")?;
        let material = card.required("MATERIAL")?.to_owned();
        let members = card.parameter("ELSET").and_then(|name| self.element_sets.get(name));
        if members.is_some_and(|m| m.iter().any(|label| self.deck.faces.contains_key(label))) {
            if self.deck.is_whole() {
                let command = "*SOLID SECTION of elements that are no solids".into();
                return Err(card.unsupported(command, "only ten-node tetrahedra may bear load"));
            }
            return Ok(());
        }
        self.used_materials.insert(material);
        Ok(())
    }

    fn boundary(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["OP"], "only supports that hold still are supported")?;
        for data in &card.data {
            let (first, last) = held_range(data)?;
            if real_or_zero(data, 3)? != 0.0 {
                return Err(card.unsupported(
                    format!("*BOUNDARY, displacement {}", data.1[3]),
                    "only a displacement of zero is supported",
                ));
            }
            let directions =
                (first..=last).filter(|d| *d <= 3).fold(0, |bits, d| bits | 1 << (d - 1));
            for label in self.named_nodes(data)? {
                self.deck.hold(label, directions);
            }
        }
        Ok(())
    }

    fn point_forces(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["OP"], "only constant forces in global directions are supported")?;
        for data in &card.data {
            let direction: usize = number(data, 1, "a direction 1, 2 or 3")?;
            let force_n = real(data, 2)?;
            if !(1..=3).contains(&direction) {
                return Err(unexpected(data.0, "a direction 1, 2 or 3", data.1[1]));
            }
            for label in self.named_nodes(data)? {
                // programs differ in whether a second force adds or replaces
                if !self.forces_given.insert((label, direction)) {
                    let name = format!("{label}, direction {direction}");
                    return Err(DeckFault::Duplicate { line: data.0, kind: "force on node", name });
                }
                self.deck.set_force(data.0, label, direction - 1, force_n);
            }
        }
        Ok(())
    }

    fn pressures(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["OP"], "only constant pressures are supported")?;
        for data in &card.data {
            let kind = data.1.get(1).map(|kind| kind.to_uppercase()).unwrap_or_default();
            let face = match kind.as_str() {
                "P1" => 0,
                "P2" => 1,
                "P3" => 2,
                "P4" => 3,
                _ => {
                    let command = format!("*DLOAD, {kind}");
                    return Err(
                        card.unsupported(command, "only face pressures P1 to P4 are supported")
                    );
                }
            };
            let pressure_pa = real(data, 2)?;
            for element in self.named_elements(data)? {
                self.deck.require_element(data.0, element)?;
                let load = SurfaceLoad::Pressure { element, face, pressure_pa };
                self.deck.surface_loads.push(load);
            }
        }
        Ok(())
    }

    fn step(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        self.steps += 1;
        self.steps_open += 1;
        if !self.deck.is_whole() {
            return Ok(());
        }
        if self.steps > 1 {
            return Err(
                card.unsupported("a second *STEP".into(), "one load case a deck is supported")
            );
        }
        match card.parameter("NLGEOM") {
            None | Some("NO") => Ok(()),
            Some(_) => {
                Err(card
                    .unsupported("*STEP, NLGEOM".into(), "only small displacements are supported"))
            }
        }
    }

    fn named_nodes(&self, data: &DataLine<'_>) -> Result<Vec<u32>, DeckFault> {
        named(data, &self.deck.node_sets, "node set", |line, label| {
            self.deck.require_node(line, label)
        })
    }

    fn named_elements(&self, data: &DataLine<'_>) -> Result<Vec<u32>, DeckFault> {
        named(data, &self.element_sets, "element set", |line, label| {
            self.deck.require_element(line, label)
        })
    }

    fn finish(mut self, n_lines: usize) -> Result<DeckBuilder, DeckFault> {
        if self.steps_open > 0 {
            return Err(DeckFault::Truncated {
                line: n_lines,
                expected: "*END STEP".into(),
                found: "the end of the file".into(),
            });
        }
        for (name, members) in std::mem::take(&mut self.element_sets) {
            if let Some(nodes) = self.deck.face_nodes(&members) {
                self.deck.node_sets.entry(name).or_insert(nodes);
            }
        }
        self.deck.material = match self.used_material(n_lines) {
            Err(_) if !self.deck.is_whole() => None,
            used => used?.filter(|m| m.youngs_modulus_pa.is_finite() && !self.no_material),
        };
        Ok(self.deck)
    }

    fn used_material(&mut self, line: usize) -> Result<Option<DeckMaterial>, DeckFault> {
        let found = self.used_materials.len().max(1);
        match self.used_materials.pop_first() {
            Some(_) if found > 1 => Err(DeckFault::SeveralMaterials { found }),
            Some(name) => {
                let used = self.materials.get(&name).copied();
                used.map(Some).ok_or(DeckFault::Undefined { line, kind: "material", name })
            }
            None if self.materials.len() > 1 => {
                Err(DeckFault::SeveralMaterials { found: self.materials.len() })
            }
            None => Ok(self.materials.values().next().copied()),
        }
    }
}

/// Refuses a second card of this name.
fn one_only(card: &Card<'_>, count: &mut usize) -> Result<(), DeckFault> {
    *count += 1;
    match *count {
        1 => Ok(()),
        _ => Err(card.unsupported(
            format!("a second *{}", card.name),
            "one part and one instance of it are read; export them merged to one part",
        )),
    }
}
