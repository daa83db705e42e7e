//! The kernels with f32 sums, written once for every instruction set.

/// Kernels over the vector operations of the module that calls it: `Vector` (16 lanes), `zero`,
/// `splat`, `fma`, `f32_line`, `bf16_low`, `bf16_high`, `int8_quarter`, `store`, `prefetch`.
/// `$most` is the number of vectors whose sums stay in registers.
macro_rules! float_kernels {
    ($most:literal, $(#[$feature:meta])*) => {
        /// `out = Wᵀ x`, weights in f32.
        $(#[$feature])*
        pub(super) fn f32(w: &Panels<F32Line>, x: &[Active], out: &mut [F32Line]) {
            for (unit, width, lines) in w.iter() {
                let out = &mut out[unit..unit + width];
                let mut first = 0;
                while first < width {
                    first += match width - first {
                        rest if rest >= $most => f32_units::<{ $most }>(lines, width, first, x, out),
                        rest if rest >= 8 && 8 < $most => f32_units::<8>(lines, width, first, x, out),
                        rest if rest >= 4 && 4 < $most => f32_units::<4>(lines, width, first, x, out),
                        rest if rest >= 2 && 2 < $most => f32_units::<2>(lines, width, first, x, out),
                        _ => f32_units::<1>(lines, width, first, x, out),
                    };
                }
            }
        }

        /// Units from `first`, as many as it returns.
        $(#[$feature])*
        #[inline]
        fn f32_units<const U: usize>(
            lines: &[F32Line],
            width: usize,
            first: usize,
            x: &[Active],
            out: &mut [F32Line],
        ) -> usize {
            let mut sums = [zero(); U];
            for (i, active) in x.iter().enumerate() {
                let start = active.row as usize * width + first;
                let row = &lines[start..start + U];
                if let Some(ahead) = x.get(i + AHEAD) {
                    let start = ahead.row as usize * width + first;
                    for line in &lines[start..start + U] {
                        prefetch(line);
                    }
                }
                let value = splat(active.value);
                for u in 0..U {
                    sums[u] = fma(value, f32_line(&row[u]), sums[u]);
                }
            }
            for u in 0..U {
                store(sums[u], &mut out[first + u]);
            }
            U
        }

        /// `out = Wᵀ x`, weights in bf16: two lines of results a unit.
        $(#[$feature])*
        pub(super) fn bf16(w: &Panels<Bf16Line>, x: &[Active], out: &mut [F32Line]) {
            for (unit, width, lines) in w.iter() {
                let out = &mut out[2 * unit..2 * (unit + width)];
                let mut first = 0;
                while first < width {
                    first += match width - first {
                        rest if rest >= ($most / 2) => bf16_units::<{ ($most / 2) }>(lines, width, first, x, out),
                        rest if rest >= 8 && 8 < ($most / 2) => bf16_units::<8>(lines, width, first, x, out),
                        rest if rest >= 4 && 4 < ($most / 2) => bf16_units::<4>(lines, width, first, x, out),
                        rest if rest >= 2 && 2 < ($most / 2) => bf16_units::<2>(lines, width, first, x, out),
                        _ => bf16_units::<1>(lines, width, first, x, out),
                    };
                }
            }
        }

        /// Units from `first`, as many as it returns.
        $(#[$feature])*
        #[inline]
        fn bf16_units<const U: usize>(
            lines: &[Bf16Line],
            width: usize,
            first: usize,
            x: &[Active],
            out: &mut [F32Line],
        ) -> usize {
            let mut sums = [[zero(); 2]; U];
            for (i, active) in x.iter().enumerate() {
                let start = active.row as usize * width + first;
                let row = &lines[start..start + U];
                if let Some(ahead) = x.get(i + AHEAD) {
                    let start = ahead.row as usize * width + first;
                    for line in &lines[start..start + U] {
                        prefetch(line);
                    }
                }
                let value = splat(active.value);
                for u in 0..U {
                    sums[u][0] = fma(value, bf16_low(&row[u]), sums[u][0]);
                    sums[u][1] = fma(value, bf16_high(&row[u]), sums[u][1]);
                }
            }
            for u in 0..U {
                store(sums[u][0], &mut out[2 * (first + u)]);
                store(sums[u][1], &mut out[2 * (first + u) + 1]);
            }
            U
        }

        /// `out = Wᵀ x`, weights in bytes: four lines of results a unit.
        $(#[$feature])*
        pub(super) fn int8(w: &Panels<Int8Line>, x: &[Active], out: &mut [F32Line]) {
            for (unit, width, lines) in w.iter() {
                let out = &mut out[4 * unit..4 * (unit + width)];
                let mut first = 0;
                while first < width {
                    first += match width - first {
                        rest if rest >= ($most / 4) => int8_units::<{ ($most / 4) }>(lines, width, first, x, out),
                        rest if rest >= 8 && 8 < ($most / 4) => int8_units::<8>(lines, width, first, x, out),
                        rest if rest >= 4 && 4 < ($most / 4) => int8_units::<4>(lines, width, first, x, out),
                        rest if rest >= 2 && 2 < ($most / 4) => int8_units::<2>(lines, width, first, x, out),
                        _ => int8_units::<1>(lines, width, first, x, out),
                    };
                }
            }
        }

        /// Units from `first`, as many as it returns.
        $(#[$feature])*
        #[inline]
        fn int8_units<const U: usize>(
            lines: &[Int8Line],
            width: usize,
            first: usize,
            x: &[Active],
            out: &mut [F32Line],
        ) -> usize {
            let mut sums = [[zero(); 4]; U];
            for (i, active) in x.iter().enumerate() {
                let start = active.row as usize * width + first;
                let row = &lines[start..start + U];
                if let Some(ahead) = x.get(i + AHEAD) {
                    let start = ahead.row as usize * width + first;
                    for line in &lines[start..start + U] {
                        prefetch(line);
                    }
                }
                let value = splat(active.value);
                for u in 0..U {
                    sums[u][0] = fma(value, int8_quarter::<0>(&row[u]), sums[u][0]);
                    sums[u][1] = fma(value, int8_quarter::<1>(&row[u]), sums[u][1]);
                    sums[u][2] = fma(value, int8_quarter::<2>(&row[u]), sums[u][2]);
                    sums[u][3] = fma(value, int8_quarter::<3>(&row[u]), sums[u][3]);
                }
            }
            for u in 0..U {
                for quarter in 0..4 {
                    store(sums[u][quarter], &mut out[4 * (first + u) + quarter]);
                }
            }
            U
        }

        /// `z ← σ(z + bias)`.
        $(#[$feature])*
        pub(super) fn activate(activation: Activation, z: &mut [f32], bias: &[f32]) {
            activation.apply(z, bias);
        }
    };
}
