//! The model's file.

use hapdef_wasm::{PageError, PageModel, Session};

use crate::support;

#[test]
fn a_model_comes_back_as_it_was() {
    let model = support::model();
    let bytes = model.to_bytes().unwrap();
    let again = PageModel::from_bytes(&bytes).unwrap();
    assert_eq!(again.to_bytes().unwrap(), bytes);
    assert_eq!(again.rig(), model.rig());
    assert_eq!(again.picture().triangles, model.picture().triangles);
    assert!(Session::new(&again).is_ok());
}

#[test]
fn what_is_no_model_is_refused_with_a_reason() {
    let bytes = support::model().to_bytes().unwrap();
    let refused = |bytes: &[u8]| PageModel::from_bytes(bytes).unwrap_err();
    assert!(matches!(refused(b""), PageError::NotAModel { .. }));
    assert!(matches!(refused(b"not gzip"), PageError::NotAModel { .. }));
    assert!(matches!(refused(&bytes[..bytes.len() / 2]), PageError::NotAModel { .. }));
    let bundle = support::model().bundle().to_bytes().unwrap();
    let error = refused(&packed(&bundle));
    assert!(error.to_string().contains("it has no header"), "{error}");
}

#[test]
fn a_damaged_part_is_named() {
    let mut bytes = unpacked(&support::model().to_bytes().unwrap());
    // JSON within JSON
    let version = br#"version\":1"#;
    let at = bytes.windows(version.len()).position(|word| word == version).unwrap();
    bytes[at + version.len() - 1] = b'7';
    let error = PageModel::from_bytes(&packed(&bytes)).unwrap_err();
    assert!(matches!(error, PageError::Version { expected: 1, found: 7 }), "{error}");
    let mut bytes = unpacked(&support::model().to_bytes().unwrap());
    let at = bytes.len() - 1000;
    bytes[at] ^= 1;
    let error = PageModel::from_bytes(&packed(&bytes)).unwrap_err();
    assert!(matches!(error, PageError::Live(_)), "{error}");
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

fn unpacked(bytes: &[u8]) -> Vec<u8> {
    use std::io::Read;
    let mut out = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut out).unwrap();
    out
}
