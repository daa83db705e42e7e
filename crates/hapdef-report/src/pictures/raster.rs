//! A depth-buffered triangle rasteriser with supersampling.

/// Samples per pixel and direction.
const OVER: usize = 3;

/// A vertex on the screen: x to the right and y down in pixels, depth towards the viewer, and
/// the value it carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) depth: f64,
    pub(super) value: f64,
}

/// Colours and depths of `width` × `height` pixels, each of `OVER`² samples.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    colour: Vec<[u8; 3]>,
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize, background: [u8; 3]) -> Self {
        let n = width * height * OVER * OVER;
        Self { width, height, depth: vec![f32::NEG_INFINITY; n], colour: vec![background; n] }
    }

    /// Fills a triangle where it is nearer than what is there; `colour` maps a value to a colour.
    pub(super) fn fill(&mut self, corners: &[Vertex; 3], colour: impl Fn(f64) -> [u8; 3]) {
        let over = OVER as f64;
        let [a, b, c] = corners.map(|v| Vertex { x: v.x * over - 0.5, y: v.y * over - 0.5, ..v });
        let area = cross(&a, &b, &c);
        if area == 0.0 {
            return;
        }
        let (w, h) = (self.width * OVER, self.height * OVER);
        let (x0, x1) = span([a.x, b.x, c.x], w);
        let (y0, y1) = span([a.y, b.y, c.y], h);
        for y in y0..y1 {
            for x in x0..x1 {
                let p = Vertex { x: x as f64, y: y as f64, ..a };
                let weights = [cross(&b, &c, &p), cross(&c, &a, &p), cross(&a, &b, &p)];
                let weights = weights.map(|w| w / area);
                if weights.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let mix = |f: fn(&Vertex) -> f64| {
                    weights[0] * f(&a) + weights[1] * f(&b) + weights[2] * f(&c)
                };
                let depth = mix(|v| v.depth) as f32;
                let at = y * w + x;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.colour[at] = colour(mix(|v| v.value));
                }
            }
        }
    }

    /// The depth nearest to the viewer in the pixel at (x, y); −∞ outside and where empty.
    pub(super) fn depth_at(&self, x: f64, y: f64) -> f64 {
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64) {
            return f64::NEG_INFINITY;
        }
        let (column, row) = (x as usize * OVER, y as usize * OVER);
        let mut nearest = f32::NEG_INFINITY;
        for i in 0..OVER * OVER {
            let at = (row + i / OVER) * self.width * OVER + column + i % OVER;
            nearest = nearest.max(self.depth[at]);
        }
        f64::from(nearest)
    }

    /// Opaque RGBA bytes, `[height, width, 4]`: the mean colour of each pixel's samples.
    pub(super) fn to_rgba(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.width * self.height * 4);
        for pixel in 0..self.width * self.height {
            let (row, column) = (pixel / self.width * OVER, pixel % self.width * OVER);
            let mut sums = [0_usize; 3];
            for i in 0..OVER * OVER {
                let at = (row + i / OVER) * self.width * OVER + column + i % OVER;
                sums.iter_mut().zip(self.colour[at]).for_each(|(s, c)| *s += usize::from(c));
            }
            bytes.extend(sums.map(|s| ((s + OVER * OVER / 2) / (OVER * OVER)) as u8));
            bytes.push(255);
        }
        bytes
    }
}

/// Twice the signed area of the triangle abc.
fn cross(a: &Vertex, b: &Vertex, c: &Vertex) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Samples that may lie between the least and the largest coordinate, within `0..n`.
fn span(values: [f64; 3], n: usize) -> (usize, usize) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let clamp = |v: f64| v.clamp(0.0, n as f64) as usize;
    (clamp(low.floor()), clamp(high.ceil() + 1.0))
}
