//! Ranges of the scene's values.

use super::{
    ContactRegion, EstimatorSpec, Geometry, LoadsSpec, Mount, RigMesh, Scene, Shape, WallBox,
    WallThickness,
};

/// A value outside its range.
pub(super) struct Fault {
    pub(super) path: String,
    pub(super) expected: &'static str,
    pub(super) found: String,
}

type Checked = Result<(), Fault>;

/// Checks every value of the scene in the order of the file.
pub(super) fn check(scene: &Scene) -> Checked {
    check_name(&scene.name)?;
    check_geometry(&scene.geometry)?;
    check_mount("mount", &scene.mount)?;
    scene.loads.as_ref().map_or(Ok(()), check_loads)?;
    check_contact(scene)?;
    check_gauges(scene)?;
    check_rig(scene)?;
    check_estimator(&scene.estimator)
}

fn check_geometry(geometry: &Geometry) -> Checked {
    if let Some(axis) = &geometry.axis {
        direction("geometry.axis.direction", &axis.direction)?;
    }
    if let Shape::Skin(skin) = &geometry.shape {
        check_wall(&skin.wall)?;
    }
    let n = geometry.refinements;
    require(n <= 2, "geometry.refinements", "0, 1 or 2", n.to_string())
}

fn check_wall(wall: &WallThickness) -> Checked {
    match wall {
        WallThickness::Constant(wall_m) => positive("geometry.wall_m", *wall_m),
        WallThickness::File(_) => Ok(()),
        WallThickness::Regions(regions) => {
            positive("geometry.wall_m.elsewhere_m", regions.elsewhere_m)?;
            let check =
                |(i, region)| check_wall_box(&format!("geometry.wall_m.boxes[{i}]"), region);
            regions.boxes.iter().enumerate().try_for_each(check)
        }
    }
}

fn check_wall_box(path: &str, WallBox { min_m, max_m, wall_m }: &WallBox) -> Checked {
    positive(&format!("{path}.wall_m"), *wall_m)?;
    ordered(&format!("{path}.max_m"), "above min_m in x, y and z", min_m, max_m)
}

fn check_estimator(estimator: &EstimatorSpec) -> Checked {
    match estimator {
        EstimatorSpec::Hapdefx(spec) => {
            positive("estimator.kmax_radius_m", spec.kmax_radius_m)?;
            not_negative("estimator.floor_um", spec.floor_um)
        }
        EstimatorSpec::Superposition(spec) => {
            positive("estimator.noise_ue", spec.noise_ue)?;
            not_negative("estimator.map_error", spec.map_error)?;
            not_negative("estimator.friction", spec.friction)?;
            not_negative("estimator.widest_tip_m", spec.widest_tip_m)?;
            not_negative("estimator.palm_radius_m", spec.palm_radius_m)?;
            require(
                spec.map_refinements <= 2,
                "estimator.map_refinements",
                "0, 1 or 2",
                spec.map_refinements.to_string(),
            )?;
            let n = spec.n_sites;
            require((10..=20_000).contains(&n), "estimator.n_sites", "10 to 20000", n.to_string())
        }
    }
}

fn check_name(name: &str) -> Checked {
    let fine = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    require(
        !name.is_empty() && name.chars().all(fine),
        "name",
        "letters, digits, - and _, at least one",
        format!("{name:?}"),
    )
}

fn check_mount(path: &str, mount: &Mount) -> Checked {
    match mount {
        Mount::Deck {} | Mount::NodeSet { .. } => Ok(()),
        Mount::Box { min_m, max_m } => {
            ordered(&format!("{path}.max_m"), "above min_m in x, y and z", min_m, max_m)
        }
        Mount::Plane { point_m, normal } => {
            finite(&format!("{path}.point_m"), point_m)?;
            direction(&format!("{path}.normal"), normal)
        }
        Mount::End { length_m, .. } => positive(&format!("{path}.length_m"), *length_m),
    }
}

fn check_loads(loads: &LoadsSpec) -> Checked {
    if let Some(flange) = &loads.flange {
        check_mount("loads.flange.at", &flange.at)?;
        not_negative("loads.flange.force_sd_n", flange.force_sd_n)?;
        not_negative("loads.flange.moment_sd_nm", flange.moment_sd_nm)?;
    }
    not_negative("loads.specific_force_sd_m_s2", loads.specific_force_sd_m_s2)?;
    not_negative("loads.angular_acceleration_sd_rad_s2", loads.angular_acceleration_sd_rad_s2)?;
    not_negative("loads.angular_rate_sd_rad_s", loads.angular_rate_sd_rad_s)?;
    not_negative("loads.temperature_sd_k", loads.temperature_sd_k)?;
    not_negative("loads.expansion_per_k", loads.expansion_per_k)
}

fn check_contact(scene: &Scene) -> Checked {
    let contact = &scene.contact;
    match &contact.region {
        ContactRegion::Radial { min_normal_dot_radial, min_radius_m, axial_range_m } => {
            let (path, cosine) = ("contact.region.min_normal_dot_radial", *min_normal_dot_radial);
            let is_cosine = (-1.0..1.0).contains(&cosine);
            require(is_cosine, path, "a cosine in [-1, 1)", cosine.to_string())?;
            not_negative("contact.region.min_radius_m", *min_radius_m)?;
            range("contact.region.axial_range_m", axial_range_m)?;
        }
        ContactRegion::FreeSkin { mount_gap_m } => {
            not_negative("contact.region.mount_gap_m", *mount_gap_m)?;
        }
        ContactRegion::OuterSkin {} => {}
    }
    not_negative("contact.tip_radius_m", contact.tip_radius_m)?;
    range("contact.force_range_n", &contact.force_range_n)?;
    not_negative("contact.force_range_n[0]", contact.force_range_n[0])?;
    not_negative("contact.min_spacing_m", contact.min_spacing_m)?;
    let n = contact.max_contacts;
    require((1..=4).contains(&n), "contact.max_contacts", "1 to 4", n.to_string())
}

fn check_gauges(scene: &Scene) -> Checked {
    let gauges = &scene.gauges;
    positive("gauges.length_m", gauges.length_m)?;
    positive("gauges.width_m", gauges.width_m)?;
    let lost = gauges.max_lost_share;
    require((0.0..1.0).contains(&lost), "gauges.max_lost_share", "in [0, 1)", lost.to_string())?;
    let n = gauges.patch_nodes;
    require(n >= 1, "gauges.patch_nodes", "at least 1", n.to_string())?;
    let n = gauges.sites.len();
    require(n >= 1, "gauges.sites", "at least one gauge", format!("{n} gauges"))?;
    for (i, site) in gauges.sites.iter().enumerate() {
        finite(&format!("gauges.sites[{i}].position_m"), &site.position_m)?;
        direction(&format!("gauges.sites[{i}].axis"), &site.axis)?;
    }
    Ok(())
}

fn check_rig(scene: &Scene) -> Checked {
    let rig = &scene.rig;
    check_rig_mesh(&rig.mesh)?;
    for (name, variation) in [("stiffness", rig.stiffness), ("thickness", rig.thickness)] {
        let path = format!("rig.{name}.fraction");
        let fraction = variation.fraction;
        require((0.0..0.5).contains(&fraction), &path, "in [0, 0.5)", fraction.to_string())?;
        let path = format!("rig.{name}.correlation_length_m");
        positive(&path, variation.correlation_length_m)?;
    }
    rig.max_wall_m.map_or(Ok(()), |wall_m| positive("rig.max_wall_m", wall_m))?;
    not_negative("rig.misplacement.shift_m", rig.misplacement.shift_m)?;
    let gain = rig.gain.fraction;
    require((0.0..1.0).contains(&gain), "rig.gain.fraction", "in [0, 1)", gain.to_string())?;
    not_negative("rig.electronics.noise_ue", rig.electronics.noise_ue)?;
    positive("rig.electronics.headroom", rig.electronics.headroom)?;
    let bits = rig.electronics.adc_bits;
    require((4..=32).contains(&bits), "rig.electronics.adc_bits", "4 to 32", bits.to_string())?;
    range("rig.presses.spacing_range_m", &rig.presses.spacing_range_m)?;
    not_negative("rig.presses.held_spread_n", rig.presses.held_spread_n)?;
    let least = rig.presses.held_force_n - rig.presses.held_spread_n;
    require(
        least >= 0.0,
        "rig.presses.held_force_n",
        "at least rig.presses.held_spread_n",
        rig.presses.held_force_n.to_string(),
    )
}

fn check_rig_mesh(mesh: &RigMesh) -> Checked {
    match mesh {
        RigMesh::Refined { times } => require(
            (1..=2).contains(times),
            "rig.mesh.times",
            "1 or 2: the rig needs a mesh other than the training side's",
            times.to_string(),
        ),
        RigMesh::Deck { refinements, .. } => {
            require(*refinements <= 2, "rig.mesh.refinements", "0, 1 or 2", refinements.to_string())
        }
    }
}

fn ordered(path: &str, expected: &'static str, min: &[f64; 3], max: &[f64; 3]) -> Checked {
    require((0..3).all(|i| min[i] < max[i]), path, expected, format!("{max:?}"))
}

fn positive(path: &str, value: f64) -> Checked {
    require(value > 0.0 && value.is_finite(), path, "a number above 0", value.to_string())
}

fn not_negative(path: &str, value: f64) -> Checked {
    require(value >= 0.0 && value.is_finite(), path, "a number of 0 or more", value.to_string())
}

fn range(path: &str, [low, high]: &[f64; 2]) -> Checked {
    require(low < high, path, "two numbers, the first below the second", format!("[{low}, {high}]"))
}

fn finite(path: &str, values: &[f64; 3]) -> Checked {
    require(values.iter().all(|v| v.is_finite()), path, "finite numbers", format!("{values:?}"))
}

fn direction(path: &str, values: &[f64; 3]) -> Checked {
    finite(path, values)?;
    let length = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    require(length > 1e-12, path, "a direction: a vector that is not 0", format!("{values:?}"))
}

fn require(holds: bool, path: &str, expected: &'static str, found: String) -> Checked {
    if holds { Ok(()) } else { Err(Fault { path: path.to_owned(), expected, found }) }
}
