//! The Scordelis–Lo roof on irregular meshes written by Abaqus/CAE.

use super::CaseResult;
use super::grid::Grid;
use super::problem::Problem;
use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// Nodes and three-node elements of a deck, nodes that coincide merged and unused ones dropped: the
/// decks tie coincident seams with beams.
fn read(text: &str) -> Grid {
    let mut section = "";
    let mut points = BTreeMap::new();
    let mut elements = Vec::new();
    for line in text.lines() {
        if line.starts_with('*') {
            let name = line.split(',').next().unwrap();
            if !line.starts_with("**") {
                section = name;
            }
            continue;
        }
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        let whole = |i: usize| fields[i].parse::<usize>().unwrap();
        match section {
            "*Node" => {
                points.insert(whole(0), Point3::new(number(1), number(2), number(3)));
            }
            "*Element" => elements.push([whole(1), whole(2), whole(3)]),
            _ => {}
        }
    }
    let mut nodes: Vec<Point3<f64>> = Vec::new();
    let mut place = |id: usize| {
        let p = points[&id];
        nodes
            .iter()
            .position(|q| (q - p).norm() < 1e-3)
            .unwrap_or_else(|| {
                nodes.push(p);
                nodes.len() - 1
            })
    };
    let triangles = elements.iter().map(|e| e.map(&mut place)).collect();
    Grid {
        nodes,
        triangles,
        nu: 0,
        nv: 0,
    }
}

/// The roof in inches: radius 300, length 600, thickness 3, E = 3e6, ν = 0, weight 0.20833 along −x;
/// deflection at the middle of the free edge, 12 · 0.3024.
pub fn scordelis_lo_of(deck: &str, kind: ShellKind) -> CaseResult {
    let grid = read(deck);
    let nodes = grid.nodes.clone();
    let find = |take: &dyn Fn(&Point3<f64>) -> bool| -> Vec<usize> {
        (0..nodes.len()).filter(|&i| take(&nodes[i])).collect()
    };
    let mut p = Problem::new(&grid, 3.0, 3e6, 0.0);
    p.mirror(&find(&|q| q.y.abs() < 1e-3), 1);
    p.mirror(&find(&|q| (q.z - 300.0).abs() < 1e-3), 2);
    p.fix(&find(&|q| q.z.abs() < 1e-3), &[0, 1]);
    p.area_force(Vector3::new(-0.20833 * 3.0, 0.0, 0.0));
    let free = 300.0 * 40.0_f64.to_radians().sin();
    let middle = find(&|q| (q.z - 300.0).abs() < 1e-3 && (q.y - free).abs() < 0.1);
    assert_eq!(middle.len(), 1, "one node at the middle of the free edge");
    let s = p.solve(kind);
    CaseResult {
        value: -s.displacement[middle[0]].x,
        reference: 12.0 * 0.3024,
        n_nodes: s.n_nodes,
    }
}
