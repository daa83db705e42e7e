//! Where the bytes come from: data URIs and files, and nothing outside the file's own folder.

use crate::gltf_common;

use std::path::Path;

use base64::Engine;
use gltf_common::{fault, kind, read_as, tetrahedron};
use hapdef_mesh::{GltfParams, GltfSurface, MeshError, read_gltf};
use serde_json::json;
use tempfile::TempDir;

/// The tetrahedron as a .gltf whose one buffer is found at `uri`.
fn with_uri(uri: &str) -> Vec<u8> {
    let (mut json, _) = tetrahedron();
    json["buffers"][0]["uri"] = json!(uri);
    json.to_string().into_bytes()
}

#[test]
fn byte_limits_count_file_and_buffers() {
    let folder = TempDir::new().unwrap();
    let text = with_uri("a.bin");
    std::fs::write(folder.path().join("a.gltf"), &text).unwrap();
    std::fs::write(folder.path().join("a.bin"), tetrahedron().1).unwrap();
    let read = |max_bytes| {
        let params = GltfParams { max_bytes, ..GltfParams::default() };
        read_gltf(&folder.path().join("a.gltf"), &params)
    };
    let needed = text.len() as u64 + 72;
    assert!(read(needed).is_ok());
    assert_eq!(kind(&fault(read(needed - 1))), "Limit");
    assert_eq!(kind(&fault(read(10))), "Limit");
    assert_eq!(kind(&fault(read(0))), "Limit");
}

#[test]
fn data_uris() {
    let engine = base64::engine::general_purpose::STANDARD;
    let base64 = engine.encode(tetrahedron().1);
    let read = |uri: String| read_as("a.gltf", &with_uri(&uri));
    assert!(read(format!("data:application/octet-stream;base64,{base64}")).is_ok());
    assert!(read(format!("data:;base64,{}", base64.trim_end_matches('='))).is_ok());
    for uri in [
        format!("data:application/octet-stream,{base64}"),
        format!("data:application/octet-stream;base64{base64}"),
        format!("data:application/octet-stream;base64,!{base64}"),
    ] {
        assert_eq!(kind(&fault(read(uri))), "BufferUri");
    }
    let short = format!("data:;base64,{}", &base64[..40]);
    assert_eq!(kind(&fault(read(short))), "BufferShort");
}

/// A folder `in` with the .gltf file, beside a buffer that it must not reach.
fn read_beside(folder: &Path, uri: &str) -> Result<GltfSurface, MeshError> {
    let path = folder.join("in/a.gltf");
    std::fs::write(&path, with_uri(uri)).unwrap();
    read_gltf(&path, &GltfParams::default())
}

#[test]
fn buffers_outside_the_folder_are_never_opened() {
    let outer = TempDir::new().unwrap();
    let folder = outer.path();
    std::fs::create_dir_all(folder.join("in/sub")).unwrap();
    for name in ["secret.bin", "in/a b.bin", "in/sub/c.bin"] {
        std::fs::write(folder.join(name), tetrahedron().1).unwrap();
    }
    for uri in ["a%20b.bin", "a b.bin", "sub/c.bin", "./sub/c.bin"] {
        assert!(read_beside(folder, uri).is_ok(), "{uri}");
    }
    let absolute = folder.join("secret.bin").display().to_string();
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "sub/../../secret.bin",
        &absolute,
        &format!("file://{absolute}"),
        "https://example.org/secret.bin",
        "",
        "sub",
    ] {
        assert_eq!(kind(&fault(read_beside(folder, uri))), "BufferUri", "{uri}");
    }
    assert_eq!(kind(&fault(read_beside(folder, "none.bin"))), "BufferIo");
}

#[cfg(unix)]
#[test]
fn links_out_of_the_folder_are_refused() {
    let outer = TempDir::new().unwrap();
    let folder = outer.path();
    std::fs::create_dir_all(folder.join("in")).unwrap();
    std::fs::create_dir_all(folder.join("other")).unwrap();
    std::fs::write(folder.join("other/secret.bin"), tetrahedron().1).unwrap();
    std::fs::write(folder.join("in/own.bin"), tetrahedron().1).unwrap();
    let link = |to: &str, from: &str| {
        std::os::unix::fs::symlink(folder.join(to), folder.join("in").join(from)).unwrap();
    };
    link("other/secret.bin", "file_link.bin");
    link("other", "folder_link");
    link("in/own.bin", "inner_link.bin");
    assert_eq!(kind(&fault(read_beside(folder, "file_link.bin"))), "BufferUri");
    assert_eq!(kind(&fault(read_beside(folder, "folder_link/secret.bin"))), "BufferUri");
    assert!(read_beside(folder, "inner_link.bin").is_ok());
}

#[test]
fn files_that_cannot_be_files() {
    let folder = TempDir::new().unwrap();
    let missing = read_gltf(&folder.path().join("none.glb"), &GltfParams::default());
    assert!(matches!(missing, Err(MeshError::Io { action: "read", .. })), "{missing:?}");
    assert_eq!(kind(&fault(read_as("a.obj", b"v 0 0 0"))), "FileKind");
    assert_eq!(kind(&fault(read_as("a.gltf", b""))), "Json");
    let deep = "[".repeat(100_000);
    assert_eq!(kind(&fault(read_as("a.gltf", deep.as_bytes()))), "Json");
    let without_bin = read_as("a.gltf", tetrahedron().0.to_string().as_bytes());
    assert_eq!(kind(&fault(without_bin)), "BufferMissing");
}
