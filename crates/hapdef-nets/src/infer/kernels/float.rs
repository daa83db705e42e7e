//! The kernels with f32 sums, written once for every instruction set.
//!
//! The sums of a panel stay in the first cache while the rows of the active inputs pass, four at a
//! time, the next four being fetched meanwhile. A row of a panel fills a page, so that what the processor
//! fetches ahead on its own is seldom of a row that is passed over.

/// Kernels over the vector operations of the module that calls it: `Vector` (16 lanes), `splat`,
/// `fma`, `f32_line`, `int8_quarter`, `store`, `prefetch`.
macro_rules! float_kernels {
    ($(#[$feature:meta])*) => {
        float_kernel! {
            /// `out = Wᵀ x`, weights in f32.
            $(#[$feature])* f32(F32Line), 1: f32_line
        }
        float_kernel! {
            /// `out = Wᵀ x`, weights in bytes: four lines of results a unit.
            $(#[$feature])* int8(Int8Line), 4: int8_quarter::<0>, int8_quarter::<1>,
            int8_quarter::<2>, int8_quarter::<3>
        }
    };
}

/// One kernel: `$part`s are the vectors of a line of weights, `$n` of them.
macro_rules! float_kernel {
    ($(#[$meta:meta])* $name:ident($line:ty), $n:literal: $($part:expr),*) => {
        $(#[$meta])*
        pub(super) fn $name(w: &Panels<$line>, x: &[Active], out: &mut [F32Line]) {
            for (unit, width, lines) in w.iter() {
                let out = &mut out[$n * unit..$n * (unit + width)];
                let row = |active: &Active| &lines[active.row as usize * width..][..width];
                out.fill(Line([0.0; 16]));
                let (fours, rest) = x.as_chunks::<4>();
                for (i, [a, b, c, d]) in fours.iter().enumerate() {
                    let [e, f, g, h] = fours.get(i + 1).unwrap_or(&fours[i]);
                    let (rows, ahead) = ([row(a), row(b), row(c), row(d)], [row(e), row(f), row(g), row(h)]);
                    let values = [splat(a.value), splat(b.value), splat(c.value), splat(d.value)];
                    for (u, out) in out.as_chunks_mut::<$n>().0.iter_mut().enumerate() {
                        for k in 0..4 {
                            prefetch(&ahead[k][u]);
                        }
                        let mut lines = out.iter_mut();
                        $(if let Some(out) = lines.next() {
                            let mut sum = f32_line(out);
                            for k in 0..4 {
                                sum = fma(values[k], $part(&rows[k][u]), sum);
                            }
                            store(sum, out);
                        })*
                    }
                }
                for active in rest {
                    let (row, value) = (row(active), splat(active.value));
                    for (u, out) in out.as_chunks_mut::<$n>().0.iter_mut().enumerate() {
                        let mut lines = out.iter_mut();
                        $(if let Some(out) = lines.next() {
                            let sum = fma(value, $part(&row[u]), f32_line(out));
                            store(sum, out);
                        })*
                    }
                }
            }
        }
    };
}
