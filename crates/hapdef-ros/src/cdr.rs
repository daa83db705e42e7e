//! CDR as rosbag2 and DDS have it: four bytes that say little-endian, then plain CDR.
//!
//! OMG DDSI-RTPS 2.3, 10.2: representation identifier CDR_LE is 0x0001, options are 0.

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::RosError;

const CDR_LE: [u8; 4] = [0, 1, 0, 0];

/// A message's bytes.
///
/// # Errors
/// A value that CDR can't hold; the types of [`crate::msg`] have none.
pub fn to_cdr<T: Serialize>(value: &T) -> Result<Vec<u8>, RosError> {
    let mut out = CDR_LE.to_vec();
    cdr_encoding::to_writer::<T, LittleEndian, _>(&mut out, value).map_err(fault::<T>)?;
    Ok(out)
}

/// A message from its bytes.
///
/// # Errors
/// Bytes that are no little-endian CDR of the type.
pub fn from_cdr<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, RosError> {
    let content = bytes.strip_prefix(&CDR_LE).ok_or_else(|| RosError::Encapsulation {
        found: bytes.iter().copied().take(CDR_LE.len()).collect(),
    })?;
    let (value, _) = cdr_encoding::from_bytes::<T, LittleEndian>(content).map_err(fault::<T>)?;
    Ok(value)
}

fn fault<T>(error: cdr_encoding::Error) -> RosError {
    RosError::Cdr { type_name: std::any::type_name::<T>(), message: error.to_string() }
}
