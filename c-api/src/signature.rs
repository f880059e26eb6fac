//! Signed models and sealed states: whether bytes come from who has the key, and are not older than firmware accepts.
//!
//! A feature, off by default. The items name it, too: what makes the header reads this file alone.

use bearing_watch::signature::{SignatureError, StateKey, Trust};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{check, elements, elements_mut, get, put};

/// Bytes of a public key.
#[cfg(feature = "signature")]
pub const BW_KEY_SIZE: usize = 32;

/// A model that an accepted key has signed.
#[cfg(feature = "signature")]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BwSigned {
    /// Bytes of the model, for `bw_start`.
    pub model_length: usize,
    /// Bytes of model and signature.
    pub length: usize,
    /// Counter of the model. Once the model has started, keep it as the least one that is accepted.
    pub counter: u32,
}

/// Checks the model that these bytes start with and the signature of `bearing-watch sign` behind it, before `bw_start`;
/// what follows both, such as the erased rest of a flash sector, is ignored. `keys` are the public keys that may sign,
/// as `bearing-watch sign --key FILE` prints them; without one everything is refused. `least_counter` is the counter of
/// the newest model that has run: keep it where an attacker cannot write it back. The bytes must not change until
/// `bw_start` has read them. A library that was built without the feature `signature` does not have this function;
/// define `BEARING_WATCH_SIGNATURE` before the header to declare it.
///
/// Takes about 2 million instructions and 6 kB of stack. It is the one function of which the linker does not prove that
/// it cannot panic: the indices of the arithmetic are within their bounds whatever the bytes, but no compiler sees it.
///
/// Returns `BW_CODE_OK`, what is wrong with the model, or a `BW_CODE_SIGNATURE_…`; `signed_model` is then unchanged.
///
/// # Safety
/// `bytes` is NULL or has `length` readable bytes. `keys` is NULL or has `key_count` readable keys. `signed_model` is
/// NULL or writable.
#[cfg(feature = "signature")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_verify_model(
    bytes: *const u8,
    length: usize,
    keys: *const [u8; BW_KEY_SIZE],
    key_count: usize,
    least_counter: u32,
    signed_model: *mut BwSigned,
) -> BwCode {
    // SAFETY: the same contract.
    let (bytes, keys) = unsafe { (elements(bytes, length), elements(keys, key_count)) };
    let verified = check(signed_model).and_then(|()| verify(bytes?, keys?, least_counter));
    // SAFETY: the same contract.
    code(verified.and_then(|signed| unsafe { put(signed_model, signed) }).map(|()| BwCode::Ok))
}

fn verify(bytes: &[u8], keys: &[[u8; BW_KEY_SIZE]], least_counter: u32) -> Outcome<BwSigned> {
    let signed = Trust { keys, least_counter }.verify(bytes)?;
    Ok(BwSigned { model_length: signed.model.len(), length: signed.length, counter: signed.counter })
}

/// Bytes of a drive's key.
#[cfg(feature = "signature")]
pub const BW_STATE_KEY_SIZE: usize = 32;

/// Bytes that `bw_seal` adds to a state.
#[cfg(feature = "signature")]
pub const BW_SEAL_SIZE: usize = 48;

/// A state that was sealed with the key of the drive.
#[cfg(feature = "signature")]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BwSealed {
    /// Bytes of the state, for `bw_restore`.
    pub state_length: usize,
    /// Its number.
    pub sequence: u32,
}

/// Adds an authentication code (HMAC-SHA-256) to the state that `bw_save` wrote into the first `length` of `capacity`
/// bytes; `sealed_length` is then `length + BW_SEAL_SIZE`. `key` has `BW_STATE_KEY_SIZE` random bytes, others in each
/// drive. `sequence` is the number of the record, or any that rises.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_BUFFER_TOO_SMALL` if the code does not fit; nothing is then written.
///
/// # Safety
/// `bytes` is NULL or has `capacity` writable bytes. `key` is NULL or readable. `sealed_length` is NULL or writable.
#[cfg(feature = "signature")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_seal(
    bytes: *mut u8,
    length: usize,
    capacity: usize,
    key: *const [u8; BW_STATE_KEY_SIZE],
    sequence: u32,
    sealed_length: *mut usize,
) -> BwCode {
    let sealed = check(sealed_length).and_then(|()| {
        // SAFETY: the same contract; no other reference to the bytes exists during this call.
        let (bytes, key) = unsafe { (elements_mut(bytes, capacity)?, get(key)?) };
        Ok(StateKey::new(key).seal(bytes, length, sequence)?)
    });
    // SAFETY: the same contract.
    code(sealed.and_then(|sealed| unsafe { put(sealed_length, sealed) }).map(|()| BwCode::Ok))
}

/// Checks a state and the code of `bw_seal` behind it, before `bw_restore`; the first `state_length` bytes are then the
/// state. `least_sequence` is the number of the newest state that was written, kept where an attacker cannot write it
/// back, or 0.
///
/// Returns `BW_CODE_OK` or a `BW_CODE_SIGNATURE_…`; `sealed` is then unchanged.
///
/// # Safety
/// `bytes` is NULL or has `length` readable bytes. `key` is NULL or readable. `sealed` is NULL or writable.
#[cfg(feature = "signature")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_open(
    bytes: *const u8,
    length: usize,
    key: *const [u8; BW_STATE_KEY_SIZE],
    least_sequence: u32,
    sealed: *mut BwSealed,
) -> BwCode {
    let opened = check(sealed).and_then(|()| {
        // SAFETY: the same contract.
        let (bytes, key) = unsafe { (elements(bytes, length)?, get(key)?) };
        let opened = StateKey::new(key).open(bytes, least_sequence)?;
        Ok(BwSealed { state_length: opened.state.len(), sequence: opened.sequence })
    });
    // SAFETY: the same contract.
    code(opened.and_then(|opened| unsafe { put(sealed, opened) }).map(|()| BwCode::Ok))
}

impl From<SignatureError> for BwCode {
    fn from(error: SignatureError) -> Self {
        match error {
            SignatureError::Model(error) => error.into(),
            SignatureError::Unsigned => Self::SignatureMissing,
            SignatureError::Version { .. } => Self::SignatureVersion,
            SignatureError::Truncated => Self::SignatureTruncated,
            SignatureError::UnknownKey => Self::SignatureKey,
            SignatureError::Mismatch => Self::SignatureMismatch,
            SignatureError::Older { .. } => Self::SignatureOlder,
            SignatureError::BufferTooSmall => Self::BufferTooSmall,
            // Format, and what a later version of the core adds.
            _ => Self::SignatureFormat,
        }
    }
}
