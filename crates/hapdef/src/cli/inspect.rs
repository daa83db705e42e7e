//! `hapdef inspect`: what a geometry file holds and what is wrong with it.

use std::path::Path;

use anyhow::{Result, bail};
use hapdef_mesh::{GltfParams, QualityReport, read_deck, read_gltf};

/// Reads a surface or a deck and prints its report.
pub(crate) fn inspect(file: &Path, json: bool) -> Result<()> {
    let name = file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    match name.rsplit('.').next().unwrap_or_default() {
        "glb" | "gltf" => inspect_surface(file, json),
        "inp" | "dat" | "cdb" => inspect_deck(file, json),
        other => bail!(
            "{}: expected .glb, .gltf, .inp, .dat or .cdb (the last three also with .gz), found \
             {other:?}; convert the file first",
            file.display()
        ),
    }
}

fn inspect_surface(file: &Path, json: bool) -> Result<()> {
    let surface = read_gltf(file, &GltfParams::default())?;
    let report = QualityReport::of(&surface.mesh);
    if json {
        println!(
            "{}",
            serde_json::json!({
                "n_vertices": report.n_vertices,
                "n_triangles": report.n_triangles,
                "n_bodies": report.n_bodies,
                "n_open_edges": report.n_open_edges,
                "n_non_manifold_edges": report.n_non_manifold_edges,
                "n_parts": surface.parts.len(),
            })
        );
    } else {
        println!("{}\n{report}", file.display());
    }
    Ok(())
}

fn inspect_deck(file: &Path, json: bool) -> Result<()> {
    let deck = read_deck(file)?;
    let boundary = deck.mesh.boundary();
    let sets: Vec<&str> = deck.node_sets.keys().map(String::as_str).collect();
    let material = deck
        .material
        .as_ref()
        .map(|m| (m.youngs_modulus_pa, m.poissons_ratio));
    if json {
        println!(
            "{}",
            serde_json::json!({
                "n_fe_nodes": deck.mesh.nodes().len(),
                "n_elements": deck.mesh.elements().len(),
                "n_boundary_faces": boundary.faces.len(),
                "n_fixed_nodes": deck.fixed_nodes.len(),
                "node_sets": sets,
            })
        );
        return Ok(());
    }
    println!("{}", file.display());
    println!("FE nodes        {}", deck.mesh.nodes().len());
    println!(
        "elements        {} ten-node tetrahedra",
        deck.mesh.elements().len()
    );
    println!("boundary faces  {}", boundary.faces.len());
    println!("fixed nodes     {}", deck.fixed_nodes.len());
    println!("nodal forces    {}", deck.nodal_forces.len());
    println!("loaded faces    {}", deck.face_tractions.len());
    println!("node sets       {}", sets.join(", "));
    match material {
        Some((e, nu)) => println!("material        E = {e:.4e}, ν = {nu}"),
        None => println!("material        none: the scene must name one"),
    }
    Ok(())
}
