//! NAFEMS LE2, LE5 and LE6: stresses in shells; and LE5 against the same section in ten-node
//! tetrahedra, a reference that does not rest on thin-walled beams.

use nalgebra::{Point3, Vector3};

use super::prelude::*;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let bending = Case {
        name: "le2.bending",
        title: "NAFEMS LE2, cylindrical shell patch, edge moment",
        quantity: "hoop stress outside at the middle of a patch of 30° × 0.5 m, radius 1 m, thickness 0.01 m, under \
            1 kN along the edge",
        unit: "MPa",
        reference: Reference::Published(60.0),
        source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE2, as quoted by Abaqus \
            and Altair OptiStruct OS-V:0020 (radius, arc and width from memory); statics alone gives \
            6 M / t² and p R / t, both 60",
        meshes: &[[16, 4, 1], [32, 8, 1], [64, 16, 1]],
        solve: Solve::of(PATCH),
        ..Case::default()
    };
    let membrane = Case {
        name: "le2.membrane",
        title: "NAFEMS LE2, cylindrical shell patch, pressure",
        quantity: "hoop stress outside at the middle of a patch of 30° × 0.5 m, radius 1 m, thickness 0.01 m, under \
            0.6 MPa inside and 60 MPa on the edge",
        solve: Solve::of(Model { load: PATCH_PRESSURE, ..PATCH }),
        ..bending.clone()
    };
    let le5 = Case {
        name: "le5",
        title: "NAFEMS LE5, Z-section cantilever",
        quantity: "axial stress in the mid-surface at a flange's free side at x = 2.5 m, length 10 m, web 2 m, \
            flanges 1 m, thickness 0.1 m, torque 1.2 MN m by shear on the flanges",
        unit: "MPa",
        reference: Reference::Published(-108.0),
        source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE5, as quoted by Abaqus (section \
            from memory), whose four-node shell gives −110.4 and eight-node shell −109.8; NAFEMS' target \
            is the thin-walled beam's",
        target: Target::within(0.02),
        meshes: &[[40, 16, 1], [80, 32, 1], [160, 64, 1]],
        solve: Solve::of(Z_SECTION),
        ..Case::default()
    };
    let le6 = Case {
        name: "le6",
        title: "NAFEMS LE6, skew plate under pressure",
        quantity: "largest principal stress below at the centre, rhombus of side 1 m and 30°, thickness 0.01 m, \
            0.7 kPa, E = 210 GPa, ν = 0.3, deflection held on all sides",
        unit: "MPa",
        reference: Reference::Published(0.802),
        source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE6 (from memory); Morley, Skew \
            Plates and Structures, 1963",
        meshes: &[[16, 16, 1], [32, 32, 1], [64, 64, 1]],
        solve: Solve::of(SKEW_PLATE),
        ..Case::default()
    };
    let le5_solid = Case {
        name: "le5_solid",
        title: "NAFEMS LE5 against the same Z-section in TET10",
        quantity: "difference of the axial stress at a flange's free side at x = 2.5 m, relative to the solid's; \
            the shell on 160 × 64 cells",
        source: "TET10, one cell through the wall, square outer corners, the shear uniform over a flange's \
            end face; two cells through the wall give 0.2 % more on the finest mesh",
        meshes: &[[2, 1, 1], [4, 1, 1], [8, 1, 1]],
        solve: Solve::by(against_solid),
        ..Case::default()
    };
    let le5 = le5.both_missed(
        [Some(0.0205), Some(0.0339)],
        "the target is a thin-walled beam's; the same section in TET10 (the rows against the solid) gives \
            −108.7, −109.1 and −109.3 MPa, −109.5 extrapolated, and shells of other programs end at −109.7 \
            to −110.4 MPa",
    );
    let le6 = le6.both_missed(
        [None, Some(0.0189)],
        "only the deflection is held, and the stress still grows with refinement; the target is a plate's \
            without transverse shear",
    );
    let le5_solid = le5_solid.both_missed(
        [None, Some(0.0213)],
        "the thin shell agrees with the solid; the thick one's walls seem to twist at the folds as at free edges, \
            which takes 4.7 % from the torsion constant, 0.63 t⁴ / 3 a wall (Roark), against 1.6 % in one \
            piece, and adds 1.1 % to the stress by the thin-walled beam's formula, half of the difference",
    );
    [bending.both(), membrane.both(), le5, le6, le5_solid].concat()
}

const ARC: f64 = std::f64::consts::FRAC_PI_6;

/// Hoop direction along u, from the clamped side; z along v; 1 kN m per metre about z at the edge.
const PATCH: Model = Model {
    mesh: Mesh::Grid(0.01, Pattern::ALL, |p| {
        let (sin, cos) = (p.x * ARC).sin_cos();
        Point3::new(cos, sin, 0.5 * p.y)
    }),
    material: [210e9, 0.3],
    supports: &[(All, Y(0.0)), (Mirror(2), Z(0.0)), (Mirror(2), Z(0.5))],
    load: Load::Total(Y(0.5), 5, 1000.0 * 0.5),
    probe: Probe::Value(|s| {
        let hoop = |p: &Point3<f64>| Vector3::new(-p.y, p.x, 0.0);
        Ok(s.shell_stress(Place::Grid(0.5, 0.5), 0.005, hoop)?.x / 1e6)
    }),
};

/// The edge is pulled along the hoop, at 30°.
const PATCH_PRESSURE: Load = Load::All(&[
    Load::Pressure(-0.6e6),
    Load::Total(Y(0.5), 0, -0.5 * EDGE_PULL),
    Load::Total(Y(0.5), 1, 0.866_025_403_784_438_6 * EDGE_PULL),
]);
const EDGE_PULL: f64 = 60e6 * 0.01 * 0.5;

/// The section is unrolled along v: flange, web (twice as wide), flange.
const Z_SECTION: Model = Model {
    // moved nodes would leave the folds
    mesh: Mesh::Grid(0.1, &[Pattern::Up, Pattern::Down], |p| {
        let (y, z) = match 4.0 * p.y {
            s if s < 1.0 => (s - 1.0, 1.0),
            s if s > 3.0 => (s - 3.0, -1.0),
            s => (0.0, 2.0 - s),
        };
        Point3::new(10.0 * p.x, y, z)
    }),
    material: [210e9, 0.3],
    supports: &[(All, X(0.0))],
    load: Load::All(&[
        Load::Total(Where(|p| same(p.x, 10.0) && p.z > 0.95 - 1e-9), 1, -0.6e6),
        Load::Total(Where(|p| same(p.x, 10.0) && p.z < -0.95 + 1e-9), 1, 0.6e6),
    ]),
    probe: Probe::Value(|s| {
        Ok(s.shell_stress(Place::Grid(0.25, 0.0), 0.0, |_| Vector3::x())?.x / 1e6)
    }),
};

const Z_SOLID: Model =
    Model { mesh: Mesh::Other(z_body), probe: Probe::Stress([2.5, -1.0, 1.0], 0, 0), ..Z_SECTION };

/// One fine shell beside a solid of `n[0]` cells along a flange.
fn against_solid(element: Element, n: [usize; 3]) -> Result<Measured, VerifyError> {
    let shell = Z_SECTION.measure(element, [160, 64, 1], Pattern::Up)?;
    let solid = Z_SOLID.measure(Element::Tet10, n, Pattern::Up)?;
    // the shell's own error does not shrink: no order is to be seen
    let value = shell.value / solid.value - 1.0;
    Ok(Measured { value, mesh: solid.mesh, h: 1.0, ..shell })
}

/// Flange, corner, web, corner, flange, 0.1 m thick, 10 m along x.
fn z_body([n, ..]: [usize; 3]) -> Result<Body, VerifyError> {
    let boxes = [
        ([-1.0, -0.05], [0.95, 1.05], [n, 1]),
        ([-0.05, 0.05], [0.95, 1.05], [1, 1]),
        ([-0.05, 0.05], [-0.95, 0.95], [1, 2 * n]),
        ([-0.05, 0.05], [-1.05, -0.95], [1, 1]),
        ([0.05, 1.0], [-1.05, -0.95], [n, 1]),
    ];
    let within = |[a, b]: [f64; 2], t: f64| a + (b - a) * t;
    let mut blocks = Blocks::default();
    for (y, z, [ny, nz]) in boxes {
        blocks = blocks
            .block([10 * n, ny, nz], |p| Point3::new(10.0 * p.x, within(y, p.y), within(z, p.z)));
    }
    let words = format!("solid of {} × {} cells", 10 * n, 4 * n + 2);
    Ok(Body::solid(blocks.finish()?, [10 * n, 1, 1]).named(words))
}

const SKEW_PLATE: Model = Model {
    mesh: Mesh::Grid(0.01, Pattern::ALL, |p| {
        let (sin, cos) = ARC.sin_cos();
        Point3::new(p.x + p.y * cos, p.y * sin, 0.0)
    }),
    material: [210e9, 0.3],
    supports: &[
        (
            Only(&[2]),
            Where(|p| {
                let (sin, cos) = ARC.sin_cos();
                let along = p.x - p.y / sin * cos;
                [p.y, p.y - sin, along, along - 1.0].iter().any(|&off| same(off, 0.0))
            }),
        ),
        (Only(&[0, 1]), X(0.0)),
        (Only(&[1]), Where(|p| same(p.x, 1.0) && same(p.y, 0.0))),
    ],
    load: Load::Pressure(700.0),
    probe: Probe::Value(|s| Ok(principal(s, Place::Grid(0.5, 0.5), -0.005)? / 1e6)),
};

/// The larger principal stress.
fn principal(s: &Solution, place: Place, z: f64) -> Result<f64, VerifyError> {
    let stress = s.shell_stress(place, z, |_| Vector3::x())?;
    let (mean, half) = (0.5 * (stress.x + stress.y), 0.5 * (stress.x - stress.y));
    Ok(mean + half.hypot(stress.z))
}
