//! The same deck through the `ccx` program, when it is installed.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use hapdef_mesh::{DeckMaterial, FeNodeId, SolidDeck, Tet10Mesh, write_inp};
use hapdef_sim::NodalLoad;
use nalgebra::{Point3, Vector3};

use super::problem::{Problem, cells, same};
use crate::deck::largest;
use crate::meshes::{Blocks, faces_where};
use crate::{Case, Measured, Reference, Target, VerifyError, read_displacements};

const MESHES: [[usize; 3]; 2] = [[24, 4, 4], [48, 8, 6]];

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let case = |id, title, quantity, reference, target, pick: fn(Both) -> f64| Case {
        id,
        title,
        element: "C3D10",
        quantity,
        unit: "1",
        reference,
        source: "the program ccx on the deck that hapdef_mesh::write_inp writes",
        target,
        n_levels: MESHES.len(),
        known_miss: None,
        run: Box::new(move |level| run(level, pick)),
    };
    vec![
        // ccx prints seven digits
        case(
            "solid.ccx.displacement",
            "Side by side with ccx, a bent tube",
            "largest difference / largest displacement",
            Reference::Zero,
            Target::within(1e-5),
            |both| both.difference,
        ),
        case(
            "solid.ccx.time",
            "Side by side with ccx, time",
            "wall time of ccx / wall time of hapdef (assemble, factor, solve), two threads each",
            Reference::Reported,
            Target::within(0.0),
            |both| both.time_ratio,
        ),
    ]
}

/// What both programs gave.
struct Both {
    difference: f64,
    time_ratio: f64,
}

fn run(level: usize, pick: fn(Both) -> f64) -> Result<Measured, VerifyError> {
    if Command::new("ccx").arg("-v").output().is_err() {
        return Err(VerifyError::not_run("the program ccx is not installed"));
    }
    let n = MESHES[level];
    let problem = Problem::new(bent_tube(n)?, 2e9, 0.3)?.clamp(|p| same(p.z, 0.0));
    let tip = faces_where(&problem.mesh, |p| same(p.z, 0.2));
    let load = problem.traction(&tip, |_, _| Vector3::new(1e5, 2e5, 0.0));
    let started = Instant::now();
    let solution = problem.solve(&load)?;
    let own_s = started.elapsed().as_secs_f64();
    let (other, other_s) = ccx(&problem, &load)?;
    let apart = solution
        .u
        .iter()
        .enumerate()
        .map(|(node, u)| other.get(&(node as u32 + 1)).map_or(f64::NAN, |v| (u - v).norm()));
    // a missing node must not be lost in a maximum
    let worst =
        apart.fold(0.0, |m: f64, d| if d.is_nan() || m.is_nan() { f64::NAN } else { m.max(d) });
    let both = Both { difference: worst / largest(&solution.u), time_ratio: other_s / own_s };
    Ok(solution.measured(pick(both), cells(n), 1.0 / n[0] as f64))
}

/// Half a tube of radius 20 to 23 mm, 200 mm long, with a waist.
fn bent_tube(n: [usize; 3]) -> Result<Tet10Mesh, VerifyError> {
    Blocks::new(1e-7)
        .block([n[2] / 2, n[1] * 2, n[0]], |p| {
            let waist = 1.0 - 0.2 * (std::f64::consts::PI * p.z).sin();
            let (r, phi) = ((0.020 + 0.003 * p.x) * waist, std::f64::consts::PI * p.y);
            Point3::new(r * phi.cos(), r * phi.sin(), 0.2 * p.z)
        })
        .finish()
}

type Displacements = BTreeMap<u32, Vector3<f64>>;

/// Displacements by node label, and the seconds that ccx took.
fn ccx(problem: &Problem, load: &NodalLoad) -> Result<(Displacements, f64), VerifyError> {
    let folder =
        tempfile::tempdir().map_err(|cause| io("making a folder in", Path::new("."), cause))?;
    let path = folder.path().join("deck.inp");
    write_inp(&path, &deck(problem, load))?;
    // the deck asks for a binary field file; seven printed digits are easier to read
    let text = fs::read_to_string(&path).map_err(|cause| io("reading", &path, cause))?;
    let text = text.replace("*NODE FILE\nU\n", "*NODE PRINT, NSET=EVERY\nU\n");
    fs::write(&path, text).map_err(|cause| io("writing", &path, cause))?;
    let started = Instant::now();
    let output = Command::new("ccx")
        .arg("deck")
        .current_dir(folder.path())
        .env("OMP_NUM_THREADS", "2")
        .output()
        .map_err(|cause| io("starting", Path::new("ccx"), cause))?;
    let elapsed_s = started.elapsed().as_secs_f64();
    let result = folder.path().join("deck.dat");
    if !output.status.success() || !result.exists() {
        let said = String::from_utf8_lossy(&output.stdout);
        return Err(VerifyError::Setup {
            what: "ccx",
            expected: "a result".to_owned(),
            found: said.lines().rev().take(3).collect::<Vec<_>>().join(" / "),
        });
    }
    Ok((read_displacements(&result)?.into_iter().collect(), elapsed_s))
}

fn deck(problem: &Problem, load: &NodalLoad) -> SolidDeck {
    let mesh = problem.mesh.clone();
    let (n_nodes, n_elements) = (mesh.nodes().len() as u32, mesh.elements().len() as u32);
    let all: Vec<FeNodeId> = (0..n_nodes).map(FeNodeId).collect();
    let mut forces: BTreeMap<FeNodeId, Vector3<f64>> = BTreeMap::new();
    for (node, force) in &load.forces_n {
        *forces.entry(*node).or_insert_with(Vector3::zeros) += force;
    }
    SolidDeck {
        fixed_nodes: crate::meshes::nodes_where(&mesh, |p| same(p.z, 0.0)),
        mesh,
        node_labels: (1..=n_nodes).collect(),
        element_labels: (1..=n_elements).collect(),
        node_sets: BTreeMap::from([("EVERY".to_owned(), all)]),
        material: Some(DeckMaterial {
            youngs_modulus_pa: problem.material.youngs_modulus_pa(),
            poissons_ratio: problem.material.poissons_ratio(),
            density_kg_m3: None,
        }),
        nodal_forces: forces.into_iter().collect(),
        face_tractions: Vec::new(),
        unused_node_labels: Vec::new(),
    }
}

fn io(action: &'static str, path: &Path, cause: std::io::Error) -> VerifyError {
    VerifyError::Io { action, path: path.to_owned(), cause }
}
