//! Datasets: what is written is what is read, and damage is reported.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use hapdef_data::{
    DataError, DatasetReader, DatasetWriter, ElementKind, MANIFEST_FORMAT_VERSION, Manifest, Split,
    TensorSpec, manifest_path,
};
use proptest::prelude::*;
use safetensors::{Dtype, SafeTensors};

fn specs(width: usize) -> Vec<TensorSpec> {
    vec![
        TensorSpec::f32("readings", width, "µε"),
        TensorSpec::i32("contact_nodes", 2),
        TensorSpec::f32("forces", 1, "N"),
    ]
}

/// A dataset of 7 samples whose numbers tell their row and column.
fn write_example(path: &Path) -> (Vec<f32>, Vec<i32>) {
    let readings: Vec<f32> = (0..7 * 3).map(|i| i as f32 + 0.5).collect();
    let nodes: Vec<i32> = (0..7 * 2).map(|i| -i).collect();
    let mut writer = DatasetWriter::create(path, 7, &specs(3)).unwrap();
    writer.append("readings", &readings[..3 * 2]).unwrap();
    writer.append("contact_nodes", &nodes).unwrap();
    writer.append("readings", &readings[3 * 2..]).unwrap();
    writer.append("forces", &[1.0f32; 7]).unwrap();
    let info = writer.finish().unwrap();
    assert_eq!(info.n_bytes, fs::metadata(path).unwrap().len());
    (readings, nodes)
}

fn folder_and_path() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("single.safetensors");
    (folder, path)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn rows_written_in_any_blocks_are_read_in_any_order(
        n in 1..40usize,
        width in 1..9usize,
        block in 1..11usize,
        seed in any::<u32>(),
        picks in prop::collection::vec(any::<prop::sample::Index>(), 0..30),
    ) {
        let (_folder, path) = folder_and_path();
        let bits = |i: usize| seed.wrapping_add(i as u32).wrapping_mul(2_654_435_761) & 0xbf7f_ffff;
        let values: Vec<f32> = (0..n * width).map(|i| f32::from_bits(bits(i))).collect();
        let mut writer = DatasetWriter::create(&path, n, &specs(width)).unwrap();
        for (rows, r) in values.chunks(block * width).zip(0..) {
            writer.append("readings", rows).unwrap();
            let first = r * block;
            let nodes: Vec<i32> = (first * 2..(first + block).min(n) * 2).map(|i| i as i32).collect();
            writer.append("contact_nodes", &nodes).unwrap();
        }
        writer.append("forces", &vec![0.0f32; n]).unwrap();
        writer.finish().unwrap();

        let rows: Vec<usize> = picks.iter().map(|p| p.index(n)).collect();
        let mut reader = DatasetReader::open(&path).unwrap();
        let mut read = vec![0.0f32; rows.len() * width];
        reader.read_rows_at("readings", &rows, &mut read).unwrap();
        for (row, got) in rows.iter().zip(read.chunks(width)) {
            prop_assert_eq!(got, &values[row * width..(row + 1) * width]);
        }
        let mut nodes = vec![0; 2 * n];
        reader.read_rows("contact_nodes", 0..n, &mut nodes).unwrap();
        prop_assert_eq!(nodes, (0..2 * n as i32).collect::<Vec<_>>());
    }
}

#[test]
fn the_ordinary_safetensors_crate_reads_the_file() {
    let (_folder, path) = folder_and_path();
    let (readings, nodes) = write_example(&path);
    let bytes = fs::read(&path).unwrap();
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let view = file.tensor("readings").unwrap();
    assert_eq!((view.dtype(), view.shape()), (Dtype::F32, &[7, 3][..]));
    let expected: Vec<u8> = readings.iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(view.data(), expected);
    let view = file.tensor("contact_nodes").unwrap();
    assert_eq!((view.dtype(), view.shape()), (Dtype::I32, &[7, 2][..]));
    let expected: Vec<u8> = nodes.iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(view.data(), expected);
}

#[test]
fn a_file_of_the_ordinary_crate_is_read() {
    let (_folder, path) = folder_and_path();
    let bytes: Vec<u8> = (0..6).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let view = safetensors::tensor::TensorView::new(Dtype::F32, vec![2, 3], &bytes).unwrap();
    fs::write(&path, safetensors::serialize([("x", view)], None).unwrap()).unwrap();
    let mut reader = DatasetReader::open(&path).unwrap();
    let mut row = [0.0f32; 3];
    reader.read_rows("x", 1..2, &mut row).unwrap();
    assert_eq!(row, [3.0, 4.0, 5.0]);
}

#[test]
fn the_name_appears_only_when_the_dataset_is_complete() {
    let (folder, path) = folder_and_path();
    let mut writer = DatasetWriter::create(&path, 7, &specs(3)).unwrap();
    writer.append("readings", &[0.0f32; 21]).unwrap();
    assert!(!path.exists());
    let error = writer.finish().unwrap_err();
    assert!(
        matches!(&error, DataError::MissingRows { tensor, written: 0, n: 7, .. } if tensor == "contact_nodes"),
        "{error}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn bad_blocks_are_refused_and_leave_the_dataset_whole() {
    let (_folder, path) = folder_and_path();
    let mut writer = DatasetWriter::create(&path, 2, &specs(3)).unwrap();
    writer.append("readings", &[1.0f32; 3]).unwrap();
    let error = writer.append("readings", &[1.0, f32::NAN, 1.0]).unwrap_err();
    assert!(matches!(error, DataError::NotFinite { row: 1, column: 1, .. }), "{error}");
    let error = writer.append("readings", &[1.0f32; 4]).unwrap_err();
    assert!(
        matches!(error, DataError::SliceLength { width: 3, expected: 3, got: 4, .. }),
        "{error}"
    );
    let error = writer.append("readings", &[1.0f32; 6]).unwrap_err();
    assert!(matches!(error, DataError::RowOutOfRange { row: 2, n: 2, .. }), "{error}");
    let error = writer.append("contact_nodes", &[1.0f32; 2]).unwrap_err();
    assert!(matches!(error, DataError::ElementKind { held: ElementKind::I32, .. }), "{error}");
    let error = writer.append("map", &[1.0f32; 2]).unwrap_err();
    assert!(matches!(error, DataError::NoSuchTensor { .. }), "{error}");
    writer.append("readings", &[2.0f32; 3]).unwrap();
    writer.append("contact_nodes", &[0; 4]).unwrap();
    writer.append("forces", &[0.0f32; 2]).unwrap();
    writer.finish().unwrap();
    let mut read = [0.0f32; 6];
    DatasetReader::open(&path).unwrap().read_rows("readings", 0..2, &mut read).unwrap();
    assert_eq!(read, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
}

#[test]
fn names_and_widths_are_checked() {
    let (_folder, path) = folder_and_path();
    let twice = [TensorSpec::f32("x", 1, "m"), TensorSpec::f32("x", 2, "m")];
    assert!(matches!(
        DatasetWriter::create(&path, 2, &twice),
        Err(DataError::TensorNamedTwice { .. })
    ));
    let empty = [TensorSpec::f32("x", 0, "m")];
    assert!(matches!(DatasetWriter::create(&path, 2, &empty), Err(DataError::Shape { .. })));
}

#[test]
fn reading_past_the_end_or_into_a_wrong_slice_is_refused() {
    let (_folder, path) = folder_and_path();
    write_example(&path);
    let mut reader = DatasetReader::open(&path).unwrap();
    let mut row = [0.0f32; 3];
    let error = reader.read_rows("readings", 7..8, &mut row).unwrap_err();
    assert!(matches!(error, DataError::RowOutOfRange { row: 7, n: 7, .. }), "{error}");
    let error = reader.read_rows_at("readings", &[usize::MAX], &mut row).unwrap_err();
    assert!(matches!(error, DataError::RowOutOfRange { .. }), "{error}");
    let error = reader.read_rows("readings", 0..2, &mut row).unwrap_err();
    assert!(matches!(error, DataError::SliceLength { expected: 6, got: 3, .. }), "{error}");
    let error = reader.read_rows("readings", 0..1, &mut [0i32; 3]).unwrap_err();
    assert!(matches!(error, DataError::ElementKind { .. }), "{error}");
}

#[test]
fn every_cut_of_a_file_is_reported() {
    let (_folder, path) = folder_and_path();
    write_example(&path);
    let whole = fs::read(&path).unwrap();
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        let error = DatasetReader::open(&path).unwrap_err();
        assert!(
            matches!(error, DataError::Header { .. } | DataError::FileLength { .. }),
            "{length}: {error}"
        );
    }
    fs::write(&path, [&whole[..], &[0]].concat()).unwrap();
    assert!(matches!(DatasetReader::open(&path), Err(DataError::FileLength { .. })));
}

#[test]
fn foreign_bytes_and_foreign_shapes_are_reported() {
    let (_folder, path) = folder_and_path();
    fs::write(&path, b"NUMPY is another format altogether").unwrap();
    assert!(matches!(DatasetReader::open(&path), Err(DataError::Header { .. })));
    let bytes = [0; 24];
    for shape in [vec![6], vec![1, 2, 3]] {
        let view = safetensors::tensor::TensorView::new(Dtype::F32, shape, &bytes).unwrap();
        fs::write(&path, safetensors::serialize([("x", view)], None).unwrap()).unwrap();
        assert!(matches!(DatasetReader::open(&path), Err(DataError::Shape { .. })));
    }
}

#[test]
fn a_nan_that_crept_into_the_file_is_reported_with_its_place() {
    let (_folder, path) = folder_and_path();
    write_example(&path);
    let mut bytes = fs::read(&path).unwrap();
    let data_start = bytes.len() - (7 * 3 + 7 * 2 + 7) * 4;
    let at = data_start + (2 * 3 + 1) * 4;
    bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(&path, bytes).unwrap();
    let mut reader = DatasetReader::open(&path).unwrap();
    let mut rows = [0.0f32; 9];
    let error = reader.read_rows("readings", 1..4, &mut rows).unwrap_err();
    assert!(matches!(error, DataError::NotFinite { row: 2, column: 1, .. }), "{error}");
}

#[test]
fn a_large_tensor_is_read_in_pieces_and_a_nan_in_a_later_one_has_its_place() {
    let (_folder, path) = folder_and_path();
    let (n, width) = (40_000, 7);
    let written: Vec<f32> = (0..n * width).map(|i| i as f32).collect();
    let mut writer = DatasetWriter::create(&path, n, &[TensorSpec::f32("x", width, "1")]).unwrap();
    writer.append("x", &written).unwrap();
    writer.finish().unwrap();
    let mut read = vec![0.0; (n - 1) * width];
    let mut reader = DatasetReader::open(&path).unwrap();
    reader.read_rows("x", 1..n, &mut read).unwrap();
    assert_eq!(read, written[width..]);
    let mut bytes = fs::read(&path).unwrap();
    let at = bytes.len() - (n - 33_333) * width * 4 + 5 * 4;
    bytes[at..at + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    fs::write(&path, bytes).unwrap();
    let mut reader = DatasetReader::open(&path).unwrap();
    let error = reader.read_rows("x", 1..n, &mut read).unwrap_err();
    assert!(matches!(error, DataError::NotFinite { row: 33_333, column: 5, .. }), "{error}");
}

fn manifest(tensors: Vec<TensorSpec>, n: usize) -> Manifest {
    Manifest {
        format_version: MANIFEST_FORMAT_VERSION,
        kind: "single-contact".into(),
        seed: u64::MAX,
        scene_hash: "00ff".into(),
        crate_versions: BTreeMap::from([("hapdef-data".into(), "0.1.0".into())]),
        tensors,
        n,
        split: Split::of(n).unwrap(),
        created_by: "hapdef generate shin.json".into(),
    }
}

#[test]
fn the_manifest_comes_back_and_fits_its_dataset() {
    let (_folder, path) = folder_and_path();
    write_example(&path);
    let written = manifest(specs(3), 7);
    written.write(&path).unwrap();
    let read = Manifest::read(&path).unwrap();
    assert_eq!(read, written);
    let reader = DatasetReader::open(&path).unwrap();
    read.check(&reader).unwrap();
    for wrong in [manifest(specs(3), 8), manifest(specs(4), 7), manifest(vec![], 7)] {
        assert!(matches!(wrong.check(&reader), Err(DataError::ManifestMismatch { .. })));
    }
}

#[test]
fn unknown_fields_and_versions_of_a_manifest_are_refused() {
    let (_folder, path) = folder_and_path();
    manifest(specs(3), 7).write(&path).unwrap();
    let json = fs::read_to_string(manifest_path(&path)).unwrap();
    fs::write(manifest_path(&path), json.replace("\"seed\"", "\"sead\"")).unwrap();
    assert!(matches!(Manifest::read(&path), Err(DataError::Manifest { .. })));
    let newer = json.replace("\"format_version\": 1", "\"format_version\": 2");
    fs::write(manifest_path(&path), newer).unwrap();
    assert!(matches!(
        Manifest::read(&path),
        Err(DataError::FormatVersion { found: 2, known: 1, .. })
    ));
}
