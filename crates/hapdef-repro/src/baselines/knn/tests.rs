//! Against hand-worked weights and all distances.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;

fn uniform(rng: &mut ChaCha8Rng) -> f32 {
    (rng.next_u32() >> 8) as f32 / (1 << 24) as f32
}

/// Distances 1, 2 and 4: weights 4/7, 2/7, 1/7.
#[test]
fn weights_by_hand() {
    let knn = Knn::new(&[1.0, -2.0, 4.0, 100.0], 1).unwrap();
    let params = KnnParams { k: 3, own_row: OwnRow::None };
    let found = knn.neighbours(&[0.0], &params).unwrap();
    assert_eq!(found.rows(0), [0, 1, 2]);
    let expected = [4.0 / 7.0, 2.0 / 7.0, 1.0 / 7.0];
    let worst = found.weights(0).iter().zip(expected).map(|(a, b)| (a - b).abs());
    assert!(worst.fold(0.0, f64::max) < 1e-14, "{:?}", found.weights(0));
    let mut out = [0.0];
    found.predict(0, &[7.0, 14.0, 28.0, 1e9], &mut out);
    assert!((out[0] - 12.0).abs() < 1e-5, "{out:?}");
}

#[test]
fn an_exact_match_takes_all_the_weight_and_may_be_excluded() {
    let x = [1.0, 5.0, 5.0, 9.0];
    let knn = Knn::new(&x, 1).unwrap();
    let params = KnnParams { k: 3, own_row: OwnRow::None };
    let found = knn.neighbours(&x, &params).unwrap();
    assert_eq!((found.rows(1), found.weights(1)), (&[1, 2, 0][..], &[0.5, 0.5, 0.0][..]));
    assert_eq!((found.rows(3)[0], found.weights(3)), (3, &[1.0, 0.0, 0.0][..]));
    let params = KnnParams { k: 2, own_row: OwnRow::Exclude { first: 2 } };
    let found = knn.neighbours(&x[2..], &params).unwrap();
    assert_eq!((found.rows(0), found.weights(0)), (&[1, 0][..], &[1.0, 0.0][..]));
    assert_eq!(found.rows(1), [1, 2]);
}

/// Against all distances, on clustered data far from the origin where cancellation bites.
#[test]
fn matches_brute_force() {
    let (n, m, d, k) = (2 * ROW_BLOCK + 500, 90, 12, 6);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut rows = |n: usize| -> Vec<f32> {
        (0..n * d)
            .map(|i| {
                let cluster = ((i / d) % 3) as f32 * 1e3;
                1e4 + cluster + (16.0 * uniform(&mut rng)).floor() * 1e-3
            })
            .collect()
    };
    let (x, queries) = (rows(n), rows(m));
    let found = Knn::new(&x, d).unwrap().neighbours(&queries, &KnnParams::default()).unwrap();
    for i in 0..m {
        let mut all: Vec<(f64, u32)> = (0..n)
            .map(|j| {
                let d_sq: f64 = (0..d)
                    .map(|l| f64::from(x[j * d + l]) - f64::from(queries[i * d + l]))
                    .map(|e| e * e)
                    .sum();
                (d_sq.sqrt(), j as u32)
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (distances, rows): (Vec<f64>, Vec<u32>) = all[..k].iter().copied().unzip();
        assert_eq!((found.distances(i), found.rows(i)), (&distances[..], &rows[..]));
        let sum: f64 = found.weights(i).iter().sum();
        assert!((sum - 1.0).abs() < 1e-12, "query {i}: weights sum to {sum}");
    }
}

#[test]
fn one_and_two_threads_agree_to_the_bit() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let x: Vec<f32> = (0..400 * 8).map(|_| uniform(&mut rng)).collect();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let params = KnnParams { own_row: OwnRow::Exclude { first: 0 }, k: 6 };
        pool.install(|| Knn::new(&x, 8).unwrap().neighbours(&x, &params).unwrap())
    };
    assert!(run(1) == run(2), "neighbours differ between one and two threads");
}

#[test]
fn bad_arguments_are_refused() {
    assert!(matches!(Knn::new(&[], 3), Err(ReproError::TooFewSamples { .. })));
    assert!(matches!(Knn::new(&[1.0, 2.0], 3), Err(ReproError::NotWholeRows { .. })));
    let knn = Knn::new(&[1.0, 2.0], 1).unwrap();
    let too_many = KnnParams { k: 3, own_row: OwnRow::None };
    let error = knn.neighbours(&[0.0], &too_many).unwrap_err();
    assert!(matches!(error, ReproError::TooFewSamples { needed: 3, found: 2, .. }), "{error}");
    let own = KnnParams { k: 1, own_row: OwnRow::Exclude { first: 2 } };
    let error = knn.neighbours(&[0.0], &own).unwrap_err();
    assert!(
        matches!(error, ReproError::Argument(ArgumentError::Index { index: 2, len: 2, .. })),
        "{error}"
    );
}
