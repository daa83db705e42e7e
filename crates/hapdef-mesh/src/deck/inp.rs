//! Abaqus and CalculiX decks (`.inp`) with C3D10 elements: one part, one linear static step.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;

use super::builder::{DeckBuilder, SurfaceLoad};
use super::inp_keyword::{Card, DataLine, cards, number, real, real_or_zero};
use super::inp_sets::{held_range, integers, named, one_row, set_members, unexpected};
use super::{DeckFault, DeckMaterial};

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

/// Reads a deck's text.
pub(super) fn read(text: &str) -> Result<DeckBuilder, DeckFault> {
    let mut reader = Reader::default();
    for card in cards(text)? {
        reader.card(&card)?;
    }
    reader.finish(text.lines().count())
}

#[derive(Default)]
struct Reader {
    deck: DeckBuilder,
    element_sets: BTreeMap<String, BTreeSet<u32>>,
    materials: BTreeMap<String, DeckMaterial>,
    open_material: Option<String>,
    used_materials: BTreeSet<String>,
    forces_given: BTreeSet<(u32, usize)>,
    steps_open: usize,
    steps: usize,
}

impl Reader {
    fn card(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        match card.name.as_str() {
            "NODE" => self.nodes(card),
            "ELEMENT" => self.elements(card),
            "NSET" => self.node_set(card),
            "ELSET" => self.element_set(card),
            "MATERIAL" => self.material(card),
            "ELASTIC" => self.elastic(card),
            "DENSITY" => self.density(card),
            "SOLID SECTION" => self.section(card),
            "BOUNDARY" => self.boundary(card),
            "CLOAD" => self.point_forces(card),
            "DLOAD" => self.pressures(card),
            "STEP" => self.step(card),
            "INCLUDE" => Err(card.unsupported(
                "*INCLUDE".into(),
                "a deck must be one file; put the included text in its place",
            )),
            name if HARMLESS.contains(&name) => {
                self.steps_open -= usize::from(name == "END STEP" && self.steps_open > 0);
                Ok(())
            }
            name => Err(card.unsupported(
                format!("*{name}"),
                "it may change the model, so it can't be skipped; remove it or restate the model without it",
            )),
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

    fn elements(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["TYPE", "ELSET"], "only TYPE= and ELSET= are read here")?;
        let kind = card.required("TYPE")?;
        if kind != "C3D10" {
            return Err(card.unsupported(
                format!("*ELEMENT, TYPE={kind}"),
                "only ten-node tetrahedra (C3D10) are supported",
            ));
        }
        let mut labels = Vec::new();
        let mut lines = card.data.iter();
        while let Some(first) = lines.next() {
            let mut numbers = integers(first)?;
            let mut last = first;
            while numbers.len() < 11 {
                last = lines.next().ok_or_else(|| DeckFault::Truncated {
                    line: last.0,
                    expected: "an element number and ten nodes".into(),
                    found: format!("{} numbers", numbers.len()),
                })?;
                numbers.extend(integers(last)?);
            }
            let nodes: [u32; 10] = numbers[1..].try_into().map_err(|_| DeckFault::Unexpected {
                line: last.0,
                expected: "an element number and ten nodes".into(),
                found: format!("{} numbers", numbers.len()),
            })?;
            self.deck.add_element(first.0, numbers[0], nodes)?;
            labels.push(numbers[0]);
        }
        if let Some(name) = card.parameter("ELSET") {
            self.element_sets.entry(name.to_owned()).or_default().extend(labels);
        }
        Ok(())
    }

    fn node_set(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        card.only(&["NSET", "GENERATE"], "only NSET= and GENERATE are read here")?;
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
        card.only(&["ELSET", "GENERATE", "INTERNAL"], "only ELSET= and GENERATE are read here")?;
        let name = card.required("ELSET")?.to_owned();
        let labels = set_members(card, &self.element_sets, "element set", |line, label| {
            self.deck.require_element(line, label)
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
                let load = SurfaceLoad::Pressure { element, face, pressure_pa };
                self.deck.surface_loads.push(load);
            }
        }
        Ok(())
    }

    fn step(&mut self, card: &Card<'_>) -> Result<(), DeckFault> {
        self.steps += 1;
        self.steps_open += 1;
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
        if self.used_materials.len() > 1 {
            return Err(DeckFault::SeveralMaterials { found: self.used_materials.len() });
        }
        let used = match self.used_materials.pop_first() {
            Some(name) => {
                let found = self.materials.get(&name).copied();
                let undefined = DeckFault::Undefined { line: n_lines, kind: "material", name };
                Some(found.ok_or(undefined)?)
            }
            None if self.materials.len() > 1 => {
                return Err(DeckFault::SeveralMaterials { found: self.materials.len() });
            }
            None => self.materials.into_values().next(),
        };
        self.deck.material = used.filter(|material| material.youngs_modulus_pa.is_finite());
        Ok(self.deck)
    }
}
