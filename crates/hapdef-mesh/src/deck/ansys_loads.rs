//! Selections, supports and loads of an ANSYS deck.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::ansys::{Command, Reader, SurfaceElement};
use super::ansys_state::{LoadKind, PendingLoad, Selection};
use super::builder::{DeckBuilder, HELD_ALL, SurfaceLoad};
use super::{DeckFault, DeckReading};

/// Options of SURF154 that matter here: loads in the element's coordinate system (2 = 1) on the
/// real, not the projected, area (11 = 2), with mid-side nodes (4 = 0). Option 7 acts only in large
/// deformation.
const SURFACE_OPTIONS: [(u32, &str); 2] = [(2, "1"), (11, "2")];

impl Reader {
    pub(super) fn select(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let what = command.field(1).to_lowercase();
        match (command.name.as_str(), what.as_str()) {
            ("alls", _) => {
                self.selected_nodes = Selection::All;
                self.selected_elements = Selection::All;
            }
            ("nsel", "all") => self.selected_nodes = Selection::All,
            ("esel", "all") => self.selected_elements = Selection::All,
            ("esel", "s") if command.field(2).eq_ignore_ascii_case("type") => {
                let kind: u32 = command.whole(4)?;
                let of_kind = self.element_types.iter().filter(|(_, k)| **k == kind);
                self.selected_elements =
                    Selection::Some(of_kind.map(|(label, _)| *label).collect());
            }
            ("cmse", "s") => self.select_component(command)?,
            ("nsel" | "nsle", _) => self.selected_nodes = Selection::Unknown,
            ("esel" | "esln", _) => self.selected_elements = Selection::Unknown,
            ("cm", _) => self.define_component(command)?,
            _ => return Err(command.unsupported("this selection is not followed")),
        }
        Ok(())
    }

    fn select_component(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let name = command.field(2).to_uppercase();
        if let Some(nodes) = self.deck.node_sets.get(&name) {
            self.selected_nodes = Selection::Some(nodes.clone());
        } else if let Some(elements) = self.element_components.get(&name) {
            self.selected_elements = Selection::Some(elements.clone());
        } else {
            return Err(DeckFault::Undefined { line: command.line, kind: "component", name });
        }
        Ok(())
    }

    fn define_component(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let name = command.field(1).to_uppercase();
        if command.field(2).to_lowercase().starts_with("elem") {
            let elements = self.selected_elements(command)?;
            self.element_components.insert(name, elements.into_iter().collect());
        } else if command.field(2).eq_ignore_ascii_case("node") {
            let nodes = self.nodes_of("all", command)?;
            self.deck.node_sets.insert(name, nodes.into_iter().collect());
        } else {
            return Err(command.unexpected(2, "NODE or ELEM"));
        }
        Ok(())
    }

    /// `LOCAL,number,kind,x,y,z,angles` and CDWRITE's `LOCAL,R5.0,ANG,number,kind,angles`, the
    /// Cartesian ones; loads in another are refused where one uses it.
    pub(super) fn local_axes(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let (number, kind, angles) = match command.field(2).to_lowercase().as_str() {
            "loc" | "prm" => return Ok(()),
            "ang" => (3, 4, 5),
            _ => (1, 2, 6),
        };
        if !matches!(command.field(kind).to_lowercase().as_str(), "" | "0" | "cart") {
            self.axes.remove(&command.whole(number)?);
            return Ok(());
        }
        let angle = |i| {
            if command.field(i).is_empty() { Ok(0.0) } else { command.real(i) }
        };
        let axes = axes([angle(angles)?, angle(angles + 1)?, angle(angles + 2)?]);
        self.axes.insert(command.whole(number)?, axes);
        Ok(())
    }

    /// `D,node,label,value,…,label2,…`
    pub(super) fn hold(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let targets = self.nodes_of(command.field(1), command)?;
        no_range(command)?;
        let mut directions = 0;
        for label in [2].into_iter().chain(7..command.fields.len()) {
            directions |= match command.field(label).to_lowercase().as_str() {
                "all" => HELD_ALL,
                "ux" => 0b001,
                "uy" => 0b010,
                "uz" => 0b100,
                "" if label > 2 => 0,
                _ => return Err(command.unexpected(label, "ALL, UX, UY or UZ")),
            };
        }
        self.push(command, targets, 3, LoadKind::Hold(directions));
        Ok(())
    }

    /// `F,node,label,value`
    pub(super) fn force(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        let targets = self.nodes_of(command.field(1), command)?;
        no_range(command)?;
        let axis = match command.field(2).to_lowercase().as_str() {
            "fx" => 0,
            "fy" => 1,
            "fz" => 2,
            _ => return Err(command.unexpected(2, "FX, FY or FZ")),
        };
        self.push(command, targets, 3, LoadKind::Force(axis));
        Ok(())
    }

    /// `SFE,element,face,PRES,1,value`
    pub(super) fn surface_load(&mut self, command: &Command<'_>) -> Result<(), DeckFault> {
        if !command.field(3).eq_ignore_ascii_case("pres")
            || !matches!(command.field(4), "" | "0" | "1")
        {
            return Err(command.unsupported("only real PRES loads are supported"));
        }
        command.nothing_from(6, "only loads that are constant over an element are supported")?;
        let face: usize = command.whole(2)?;
        if !(1..=3).contains(&face) {
            return Err(command.unsupported("only faces 1 to 3 (x, y, z) of SURF154 are supported"));
        }
        let targets = match command.field(1).to_lowercase().as_str() {
            "all" => self.selected_elements(command)?,
            _ => vec![command.whole(1)?],
        };
        self.push(command, targets, 5, LoadKind::Surface(face - 1));
        Ok(())
    }

    fn push(&mut self, command: &Command<'_>, targets: Vec<u32>, value: usize, kind: LoadKind) {
        let value = match command.field(value) {
            "" => "0".to_owned(),
            value => value.to_owned(),
        };
        self.pending.push(PendingLoad { line: command.line, targets, value, kind });
    }

    /// The nodes that ALL, a number or a component's name means.
    fn nodes_of(&self, field: &str, command: &Command<'_>) -> Result<Vec<u32>, DeckFault> {
        if field.eq_ignore_ascii_case("all") {
            return match &self.selected_nodes {
                Selection::All => Ok(self.deck.node_labels().collect()),
                Selection::Some(nodes) => Ok(nodes.iter().copied().collect()),
                Selection::Unknown => Err(command
                    .unsupported("ALL follows a selection that is not followed; name the nodes")),
            };
        }
        if let Ok(node) = field.parse() {
            self.deck.require_node(command.line, node)?;
            return Ok(vec![node]);
        }
        let name = field.to_uppercase();
        match self.deck.node_sets.get(&name) {
            Some(nodes) => Ok(nodes.iter().copied().collect()),
            None => Err(DeckFault::Undefined { line: command.line, kind: "node component", name }),
        }
    }

    fn selected_elements(&self, command: &Command<'_>) -> Result<Vec<u32>, DeckFault> {
        match &self.selected_elements {
            Selection::All => Ok(self.element_types.keys().copied().collect()),
            Selection::Some(elements) => Ok(elements.iter().copied().collect()),
            Selection::Unknown => {
                Err(command
                    .unsupported("ALL follows a selection that is not followed; select by type"))
            }
        }
    }

    /// The deck with its loads at the end of the step.
    pub(super) fn finish(mut self) -> Result<DeckBuilder, DeckFault> {
        self.deck.material = self.material()?;
        if self.deck.is_whole() {
            self.check_solid_options()?;
        }
        let mut tractions: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
        for load in std::mem::take(&mut self.pending) {
            let value = match self.parameters.value(load.line, &load.value, self.time) {
                Err(_) if self.deck.reading == DeckReading::Mesh => f64::NAN,
                value => value?,
            };
            for target in load.targets {
                match load.kind {
                    LoadKind::Hold(directions) if value == 0.0 => {
                        self.deck.hold(target, directions);
                    }
                    LoadKind::Hold(_) if self.deck.reading == DeckReading::Mesh => {
                        self.deck.pass_over("D with a displacement");
                    }
                    LoadKind::Hold(_) => {
                        return Err(DeckFault::Unsupported {
                            line: load.line,
                            command: format!("d, node {target}, displacement {value}"),
                            why: "only a displacement of zero is supported",
                        });
                    }
                    LoadKind::Force(axis) => self.deck.set_force(load.line, target, axis, value),
                    LoadKind::Surface(axis) => {
                        self.loadable(load.line, target)?;
                        tractions.entry(target).or_insert_with(Vector3::zeros)[axis] = value;
                    }
                }
            }
        }
        self.add_tractions(&tractions);
        Ok(self.deck)
    }

    /// The surface element `target`, if a load on it means what this reader takes it to mean.
    fn loadable(&self, line: usize, target: u32) -> Result<&SurfaceElement, DeckFault> {
        let refuse = |why| {
            Err(DeckFault::Unsupported { line, command: format!("sfe on element {target}"), why })
        };
        let Some(element) = self.surface_elements.get(&target) else {
            return refuse("surface loads are supported on SURF154 elements only");
        };
        let options = &self.types[&element.kind].options;
        if !SURFACE_OPTIONS
            .iter()
            .all(|(option, value)| options.get(option).is_some_and(|v| v == value))
            || options.keys().any(|option| ![2, 7, 11].contains(option))
        {
            return refuse(
                "SURF154 is supported with keyopt(2) = 1 (loads in its coordinate system), keyopt(11) = 2 (real area) and the other options at 0",
            );
        }
        if element.axes != 0 && !self.axes.contains_key(&element.axes) {
            return refuse("its coordinate system is not defined by LOCAL");
        }
        Ok(element)
    }

    fn add_tractions(&mut self, tractions: &BTreeMap<u32, Vector3<f64>>) {
        for (label, in_axes) in tractions {
            let Some(element) = self.surface_elements.get(label) else {
                continue;
            };
            let global_from_local =
                self.axes.get(&element.axes).copied().unwrap_or_else(Matrix3::identity);
            let traction_pa = global_from_local * in_axes;
            if traction_pa.iter().any(|component| *component != 0.0) {
                let (line, corners) = (element.line, element.corners);
                let load = SurfaceLoad::Traction { line, corners, traction_pa };
                self.deck.surface_loads.push(load);
            }
        }
    }

    /// SOLID187 is plain displacement-based only with keyopt(6) = 0.
    fn check_solid_options(&self) -> Result<(), DeckFault> {
        match self.types.values().find(|kind| kind.number == 187 && kind.options.contains_key(&6)) {
            Some(kind) => Err(DeckFault::Unsupported {
                line: kind.line,
                command: format!("keyopt(6) = {} of SOLID187", kind.options[&6]),
                why: "the mixed formulation is not supported",
            }),
            None => Ok(()),
        }
    }
}

/// `NEND` and `NINC` ask for a pattern of nodes.
fn no_range(command: &Command<'_>) -> Result<(), DeckFault> {
    let blank = |i| matches!(command.field(i), "" | "0" | "0.");
    match blank(5) && blank(6) {
        true => Ok(()),
        false => {
            Err(command
                .unsupported("ranges of nodes (NEND, NINC) are not supported; use a component"))
        }
    }
}

/// The axes of a coordinate system as columns: turned by the first angle about z, then by the
/// second about the new x, then by the third about the new y (degrees; LOCAL).
fn axes(degrees: [f64; 3]) -> Matrix3<f64> {
    let [xy, yz, zx] = degrees.map(f64::to_radians);
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), xy)
        * Rotation3::from_axis_angle(&Vector3::x_axis(), yz)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), zx);
    turned.into_inner()
}
