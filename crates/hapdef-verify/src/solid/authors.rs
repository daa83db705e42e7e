//! The paper authors' limb against ANSYS's printout and CalculiX's displacements.

use std::cell::OnceCell;
use std::path::PathBuf;
use std::rc::Rc;

use crate::{
    Case, DeckResults, Measured, Reference, Target, VerifyError, read_displacements, shared,
};

/// What the two decks give, solved once for all rows.
#[derive(Default)]
struct Decks {
    skin: OnceCell<(DeckResults, usize)>,
    weight: OnceCell<(DeckResults, usize)>,
}

const ANSYS: &str =
    "ANSYS 18.2's printout of the authors' run (2019), as recorded for this project";
const CALCULIX: &str = "CalculiX 2.20 on the same deck, as recorded for this project";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let decks = Rc::new(Decks::default());
    let skin =
        |id, title, quantity, unit, reference, source, rel_err, value: fn(&DeckResults) -> f64| {
            let decks = Rc::clone(&decks);
            Case {
                id,
                title,
                element: "TET10",
                quantity,
                unit,
                reference: Reference::Published(reference),
                source,
                target: Target::within(rel_err),
                n_levels: 1,
                known_miss: None,
                run: Box::new(move |_| decks.skin()?.measured(value)),
            }
        };
    let mut cases = vec![
        skin(
            "solid.limb.ke_max",
            "Authors' limb, largest element stiffness",
            "skin deck",
            "N/m",
            3.856521697e9,
            ANSYS,
            1e-9,
            |f| f.ke_max_n_m,
        ),
        skin(
            "solid.limb.ke_min",
            "Authors' limb, smallest element stiffness",
            "skin deck",
            "N/m",
            149_749.234,
            ANSYS,
            1e-8,
            |f| f.ke_min_n_m,
        ),
        skin(
            "solid.limb.mass",
            "Authors' limb, mass",
            "skin deck",
            "kg",
            0.0261236,
            ANSYS,
            2e-6,
            |f| f.mass_kg.unwrap_or(f64::NAN),
        ),
        skin(
            "solid.limb.energy",
            "Authors' limb, strain energy under (10, 0, −15) N",
            "skin deck",
            "J",
            1.071613e-2,
            CALCULIX,
            1e-6,
            |f| f.energy_j,
        ),
        skin(
            "solid.limb.u",
            "Authors' limb, largest displacement under (10, 0, −15) N",
            "skin deck",
            "m",
            1.224494e-3,
            CALCULIX,
            1e-6,
            |f| f.largest_u_m,
        ),
    ];
    cases.push(every_node(Rc::clone(&decks)));
    cases.push(weight(
        "solid.limb.weight_u",
        "Authors' limb, largest displacement under the 360 N weight",
        "m",
        6.046101e-3,
        Rc::clone(&decks),
        |f| f.largest_u_m,
    ));
    cases.push(weight(
        "solid.limb.weight_energy",
        "Authors' limb, strain energy under the 360 N weight",
        "J",
        0.2653024,
        decks,
        |f| f.energy_j,
    ));
    cases
}

fn every_node(decks: Rc<Decks>) -> Case {
    Case {
        id: "solid.limb.every_node",
        title: "Authors' limb, displacement at every node",
        element: "TET10",
        quantity: "largest difference / largest displacement, skin deck",
        unit: "1",
        reference: Reference::Zero,
        source: CALCULIX,
        target: Target::within(1e-5),
        n_levels: 1,
        known_miss: None,
        run: Box::new(move |_| {
            let reference = read_displacements(&input("ccx_shin_node2984.dat.gz")?)?;
            let solved = decks.skin()?;
            let difference = solved.0.difference(&reference)?;
            solved.measured(|_| difference)
        }),
    }
}

fn weight(
    id: &'static str,
    title: &'static str,
    unit: &'static str,
    reference: f64,
    decks: Rc<Decks>,
    value: fn(&DeckResults) -> f64,
) -> Case {
    Case {
        id,
        title,
        element: "TET10",
        quantity: "weight deck, tractions on curved faces",
        unit,
        reference: Reference::Published(reference),
        source: CALCULIX,
        target: Target::within(1e-5),
        n_levels: 1,
        known_miss: None,
        run: Box::new(move |_| decks.weight()?.measured(value)),
    }
}

/// A solved deck and its number of nodes.
struct Solved<'a>(&'a DeckResults, usize);

impl Solved<'_> {
    fn measured(&self, value: impl Fn(&DeckResults) -> f64) -> Result<Measured, VerifyError> {
        Ok(Measured {
            value: value(self.0),
            mesh: "the authors' own mesh".to_owned(),
            n_nodes: self.1,
            n_equations: self.0.n_equations,
            h: 1.0,
        })
    }
}

impl Decks {
    fn skin(&self) -> Result<Solved<'_>, VerifyError> {
        solved(&self.skin, "02_skin_ds.dat.gz")
    }

    fn weight(&self) -> Result<Solved<'_>, VerifyError> {
        solved(&self.weight, "01_weight_ds.dat.gz")
    }
}

fn solved<'a>(
    cell: &'a OnceCell<(DeckResults, usize)>,
    file: &str,
) -> Result<Solved<'a>, VerifyError> {
    let path = input(file)?;
    if cell.get().is_none() {
        let (deck, figures) = DeckResults::of(&path)?;
        let _ = cell.set((figures, deck.mesh.nodes().len()));
    }
    let kept = cell.get();
    let (figures, n_nodes) = kept.ok_or_else(|| VerifyError::not_run("the deck was not solved"))?;
    Ok(Solved(figures, *n_nodes))
}

fn input(file: &str) -> Result<PathBuf, VerifyError> {
    shared(&format!("hapdef-shin/{file}"))
}
