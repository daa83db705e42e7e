//! Pictures whose pixels are known.

use super::*;

/// A sphere about the origin by latitude and longitude; the value is the x coordinate.
fn sphere(radius_m: f64, n: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>, Vec<f64>) {
    let mut positions = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let (theta, phi) = (
                std::f64::consts::PI * i as f64 / n as f64,
                2.0 * std::f64::consts::PI * j as f64 / n as f64,
            );
            let ring = radius_m * theta.sin();
            positions.push([ring * phi.cos(), radius_m * theta.cos(), ring * phi.sin()]);
        }
    }
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let triangles = (0..n * n)
        .flat_map(|k| {
            let (i, j) = (k / n, k % n);
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)]]
        })
        .collect();
    let values = positions.iter().map(|p| p[0]).collect();
    (positions, triangles, values)
}

fn draw(mesh: &(Vec<[f64; 3]>, Vec<[u32; 3]>, Vec<f64>), params: &RenderParams) -> Pixmap {
    let picture = LimbPicture { positions: &mesh.0, triangles: &mesh.1, values: &mesh.2, ..EMPTY };
    drawn(&picture, params)
}

const EMPTY: LimbPicture<'_> = LimbPicture {
    title: "a <limb>",
    value_label: "µm per N",
    positions: &[],
    triangles: &[],
    values: &[],
    markers: &[],
};

fn drawn(picture: &LimbPicture<'_>, params: &RenderParams) -> Pixmap {
    let scale = colour_range(params.range, picture.values).unwrap();
    render(picture, params, &View::new(picture, params), scale).unwrap()
}

fn rgb(pixmap: &Pixmap, x: u32, y: u32) -> [u8; 3] {
    let p = pixmap.pixel(x, y).unwrap();
    [p.red(), p.green(), p.blue()]
}

/// The disc fills π/4 of its 376 px square; on y-up at azimuth 0 (from z) x points right, so
/// the left is viridis' violet and the right its yellow.
#[test]
fn a_sphere_lights_its_disc() {
    let params = RenderParams {
        azimuth_rad: 0.0,
        elevation_rad: 0.0,
        width_px: 400 + BAR_PX,
        height_px: 400,
        ..RenderParams::default()
    };
    let pixmap = draw(&sphere(0.05, 60), &params);
    let mut lit = 0.0;
    for y in 0..400 {
        for x in 0..400 {
            lit += f64::from(u8::from(rgb(&pixmap, x, y) != [255; 3]));
        }
    }
    let expected = std::f64::consts::PI * 188.0 * 188.0;
    assert!((lit / expected - 1.0).abs() < 0.02, "{lit} px lit, {expected} expected");
    assert_eq!(rgb(&pixmap, 15, 15), [255; 3], "the corner stays white");
    let (left, right) = (rgb(&pixmap, 30, 200), rgb(&pixmap, 370, 200));
    assert!(left[2] > left[1], "violet at the left: {left:?}");
    assert!(right[1] > right[2] && right[0] > right[2], "yellow at the right: {right:?}");
}

/// Two parallel squares: the one nearer to the viewer is seen, from either side; a NaN is grey.
#[test]
fn the_nearer_surface_hides_the_other() {
    let square = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
    let positions = [square(0.0), square(1.0)].concat();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let front = RenderParams {
        azimuth_rad: 0.0,
        elevation_rad: 0.0,
        width_px: 128 + BAR_PX,
        height_px: 128,
        range: Some([0.0, 1.0]),
        ..RenderParams::default()
    };
    let back = RenderParams { azimuth_rad: std::f64::consts::PI, ..front };
    let values = [[0.0; 4], [1.0; 4]].concat();
    let mesh = (positions.clone(), triangles.clone(), values);
    let (seen_front, seen_back) =
        (rgb(&draw(&mesh, &front), 64, 64), rgb(&draw(&mesh, &back), 64, 64));
    assert!(seen_front[1] > 150, "yellow from +z: {seen_front:?}");
    assert!(seen_back[1] < 20, "violet from −z: {seen_back:?}");
    let grey = rgb(&draw(&(positions, triangles, vec![f64::NAN; 8]), &front), 64, 64);
    assert!(grey[0] == grey[1] && grey[1] == grey[2] && grey[0] < 250, "{grey:?}");
}

#[test]
fn markers_show_where_they_lie_and_fade_when_hidden() {
    let mesh = sphere(1.0, 24);
    let params = RenderParams { azimuth_rad: 0.0, elevation_rad: 0.0, ..RenderParams::default() };
    let ring_colour = |z: f64| {
        let markers = [LimbMarker { position: [0.0, 0.0, z], mark: Mark::True }];
        let (positions, triangles, values) = (&mesh.0, &mesh.1, &mesh.2);
        let picture = LimbPicture { positions, triangles, values, markers: &markers, ..EMPTY };
        let pixmap = drawn(&picture, &params);
        rgb(&pixmap, (params.width_px - BAR_PX) / 2 + 10, params.height_px / 2)
    };
    let (seen, hidden) = (ring_colour(1.0), ring_colour(-1.0));
    assert!(seen[0] > 200 && seen[1] < 60, "{seen:?}");
    assert!(hidden[1] > 80, "{hidden:?}");
}

#[test]
fn bad_pictures_are_refused() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let good =
        LimbPicture { positions: &positions, triangles: &[[0, 1, 2]], values: &[0.0; 3], ..EMPTY };
    let params = RenderParams::default();
    let draw = |picture, params| limb_row_svg(&[(picture, params)]);
    assert!(draw(good, params).is_ok());
    let short = LimbPicture { values: &[0.0; 2], ..good };
    assert!(matches!(draw(short, params), Err(ReportError::Argument(ArgumentError::Shape { .. }))));
    let index = LimbPicture { triangles: &[[0, 1, 3]], ..good };
    let error = draw(index, params).unwrap_err();
    assert!(
        matches!(
            error,
            ReportError::Argument(ArgumentError::Index { index: 3, position: 2, len: 3, .. })
        ),
        "{error}"
    );
    let empty = LimbPicture { triangles: &[], ..good };
    assert!(matches!(draw(empty, params), Err(ReportError::TooFew { .. })));
    let huge = RenderParams { width_px: 100_000, ..params };
    assert!(matches!(
        draw(good, huge),
        Err(ReportError::Argument(ArgumentError::Parameter { .. }))
    ));
    assert!(matches!(limb_row_svg(&[]), Err(ReportError::TooFew { .. })));
}

/// Two panels: titles, units, five numbers on each colour bar, and a length bar as long as it says.
#[test]
fn a_row_says_what_it_shows_and_how_large_it_is() {
    let (positions, triangles, values) = sphere(0.05, 12);
    let picture =
        LimbPicture { positions: &positions, triangles: &triangles, values: &values, ..EMPTY };
    let params = RenderParams {
        width_px: 400 + BAR_PX,
        height_px: 400,
        range: Some([0.0, 8.0]),
        ..RenderParams::default()
    };
    let plain = LimbPicture { value_label: "", ..picture };
    let svg = limb_row_svg(&[(picture, params), (plain, params)]).unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let all = |name: &'static str| {
        let nodes = document.descendants();
        nodes.filter(move |node| node.tag_name().name() == name)
    };
    let texts: Vec<_> = all("text").filter_map(|node| node.text()).collect();
    let bar = ["a <limb>", "µm per N", "8", "6", "4", "2", "0", "50 mm"];
    assert_eq!(texts, [&bar[..], &["a <limb>", "50 mm"]].concat());
    assert_eq!(all("image").count(), 2);
    let path = all("path").next().and_then(|node| node.attribute("d"));
    let end = path.unwrap().split(['H', 'V']).nth(2).unwrap();
    // A sphere of 100 mm fills 376 px.
    let length: f64 = end.parse::<f64>().unwrap() - 12.0;
    assert!((length - 188.0).abs() < 2.0, "{length} px for 50 mm");
}
