//! Signed models: whether bytes come from who has the private key, and are not older than firmware accepts.
//!
//! A feature, off by default. The items name it, too: what makes the header reads this file alone.

use bearing_watch::signature::{SignatureError, Trust};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{check, elements, put};

/// Bytes of a public key.
#[cfg(feature = "signature")]
pub const BW_KEY_SIZE: usize = 32;

/// A model that an accepted key has signed.
#[cfg(feature = "signature")]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BwSigned {
    /// Bytes of the model, for `bw_init`.
    pub model_length: usize,
    /// Bytes of model and signature.
    pub length: usize,
    /// Counter of the model. Once the model has started, keep it as the least one that is accepted.
    pub counter: u32,
}

/// Checks the model that these bytes start with and the signature of `bearing-watch sign` behind it, before `bw_init`;
/// what follows both, such as the erased rest of a flash sector, is ignored. `keys` are the public keys that may sign,
/// as `bearing-watch keys` prints them; without one everything is refused. `least_counter` is the counter of the newest
/// model that has run: keep it where an attacker cannot write it back. The bytes must not change until `bw_init` has
/// read them. A library that was built without the feature `signature` does not have this function; define
/// `BEARING_WATCH_SIGNATURE` before the header to declare it.
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
            // Format, and what a later version of the core adds.
            _ => Self::SignatureFormat,
        }
    }
}
