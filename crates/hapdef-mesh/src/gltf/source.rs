//! A parsed file with its buffers, and the objects that its indices refer to.

use std::borrow::Cow;

use gltf::json::Root;

use super::GltfFault;
use super::params::GltfParams;

/// A parsed file with the bytes of its buffers.
pub(super) struct Source<'a> {
    pub root: &'a Root,
    pub buffers: &'a [Cow<'a, [u8]>],
    pub params: &'a GltfParams,
}

/// The object a property refers to.
pub(super) fn found<'a, T>(
    list: &'a [T],
    index: usize,
    place: &str,
    what: &'static str,
) -> Result<&'a T, GltfFault> {
    let fault = || GltfFault::Dangling { place: place.to_owned(), what, index, count: list.len() };
    list.get(index).ok_or_else(fault)
}
