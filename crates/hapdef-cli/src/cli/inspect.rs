//! `hapdef inspect`: what a geometry file holds and what is wrong with it.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use hapdef_cli::{print_json, shown};
use hapdef_contact::printable;
use hapdef_mesh::{
    DeckParams, DeckReading, GltfParams, MeshError, QualityReport, SolidDeck, WeldInfo, read_deck,
    read_deck_with, read_surface,
};

use super::unit::Unit;

/// What `hapdef inspect` is given.
#[derive(Args)]
pub(crate) struct InspectArgs {
    /// The file.
    file: PathBuf,
    /// Unit of a surface's coordinates; the report guesses one, say here which it is.
    #[arg(long, default_value = "m")]
    unit: Unit,
    /// Vertices of a surface no farther apart than this are joined before it is judged, m.
    #[arg(long, default_value_t = 1e-6)]
    weld_m: f64,
    /// Turn a surface's triangles over until neighbours agree on the outside, before it is judged.
    #[arg(long)]
    orient: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Reads a surface or a deck and prints its report.
pub(crate) fn inspect(args: &InspectArgs) -> Result<()> {
    let file = &args.file;
    let name = file.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    match name.rsplit('.').next().unwrap_or_default() {
        "glb" | "gltf" | "stl" | "obj" | "dae" => inspect_surface(args),
        "inp" | "dat" | "cdb" | "msh" => inspect_deck(file, args.json),
        other => bail!(
            "{}: expected .glb, .gltf, .stl, .obj, .dae, .inp, .dat, .cdb or .msh (the last four also with .gz), found \
             {other:?}; convert the file first",
            shown(file)
        ),
    }
}

fn inspect_surface(args: &InspectArgs) -> Result<()> {
    let unit = args.unit.into();
    let surface = read_surface(&args.file, &GltfParams { unit, ..GltfParams::default() })?;
    let (mesh, weld) = surface.mesh.weld(args.weld_m)?;
    let (mesh, n_turned) = if args.orient { mesh.oriented() } else { (mesh, 0) };
    let report = QualityReport::of(&mesh);
    if args.json {
        let json = surface_json(&report, &weld, surface.parts.len(), n_turned);
        return Ok(print_json(&json, false)?);
    }
    println!("{}\n{report}", shown(&args.file));
    println!(
        "welded at {:.1} µm: {} vertices joined, {} triangles collapsed, {} had a corner twice",
        args.weld_m * 1e6,
        weld.n_merged_vertices,
        weld.n_collapsed_triangles,
        weld.n_repeated_corner_triangles
    );
    if n_turned > 0 {
        println!("turned over: {n_turned} triangles");
    }
    Ok(())
}

fn surface_json(
    report: &QualityReport,
    weld: &WeldInfo,
    n_parts: usize,
    n_turned: usize,
) -> serde_json::Value {
    let size_m: [f64; 3] = report.bounding_box.size_m().into();
    let places = report.crossings.iter().map(|c| c.place.coords.into());
    let crossings_m: Vec<[f64; 3]> = places.collect();
    serde_json::json!({
        "n_parts": n_parts,
        "n_turned_triangles": n_turned,
        "n_merged_vertices": weld.n_merged_vertices,
        "n_collapsed_triangles": weld.n_collapsed_triangles,
        "n_vertices": report.n_vertices,
        "n_triangles": report.n_triangles,
        "n_bodies": report.n_bodies,
        "n_open_edges": report.n_open_edges,
        "n_non_manifold_edges": report.n_non_manifold_edges,
        "n_misoriented_edges": report.n_misoriented_edges,
        "n_doubled_triangles": report.n_doubled_triangles,
        "n_degenerate_triangles": report.n_degenerate_triangles,
        "n_sliver_triangles": report.n_sliver_triangles,
        "n_crossing_pairs": report.crossings.len(),
        "crossings_m": crossings_m,
        "area_m2": report.area_m2,
        "volume_m3": report.is_closed().then_some(report.signed_volume_m3),
        "size_m": size_m,
        "unit_guess": report.unit_guess.to_string(),
    })
}

/// The whole deck, or what a scene reads of it where it can't be solved as it is.
fn deck_or_mesh(file: &Path) -> Result<SolidDeck, MeshError> {
    read_deck(file).or_else(|refused| {
        let params = DeckParams { reading: DeckReading::Mesh, ..DeckParams::default() };
        let mut deck = read_deck_with(file, &params)?;
        deck.notes.push(format!("read for a scene; `hapdef deck` refuses it: {refused}"));
        Ok(deck)
    })
}

fn inspect_deck(file: &Path, json: bool) -> Result<()> {
    let deck = deck_or_mesh(file)?;
    let boundary = deck.mesh.boundary();
    let bodies = deck.mesh.bodies();
    let sets: Vec<&str> = deck.node_sets.keys().map(String::as_str).collect();
    let material = deck.material.as_ref().map(|m| (m.youngs_modulus_pa, m.poissons_ratio));
    if json {
        let json = serde_json::json!({
            "n_fe_nodes": deck.mesh.nodes().len(),
            "n_elements": deck.mesh.elements().len(),
            "n_bodies": bodies.len(),
            "n_boundary_faces": boundary.faces.len(),
            "n_fixed_nodes": deck.fixed_nodes.len(),
            "node_sets": sets,
            "notes": deck.notes,
        });
        return Ok(print_json(&json, false)?);
    }
    println!("{}", shown(file));
    println!("FE nodes        {}", deck.mesh.nodes().len());
    println!("elements        {} ten-node tetrahedra", deck.mesh.elements().len());
    println!("bodies          {}", bodies.len());
    if bodies.len() > 1 {
        for body in &bodies {
            let (n, unit_box) = (body.elements.len(), &body.bounding_box);
            let [x, y, z] = unit_box.centre().into();
            let [a, b, c] = unit_box.size_m().into();
            println!("    {n} elements around ({x:.4}, {y:.4}, {z:.4}), {a:.4} x {b:.4} x {c:.4}");
        }
    }
    println!("boundary faces  {}", boundary.faces.len());
    println!("fixed nodes     {}", deck.fixed_nodes.len());
    println!("nodal forces    {}", deck.nodal_forces.len());
    println!("loaded faces    {}", deck.face_tractions.len());
    println!("node sets       {}", printable(&sets.join(", ")));
    match material {
        Some((e, nu)) => println!("material        E = {e:.4e}, ν = {nu}"),
        None => println!("material        none: the scene must name one"),
    }
    deck.notes.iter().for_each(|note| println!("note: {}", printable(note)));
    Ok(())
}
