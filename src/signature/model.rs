//! The signature of a model.

use ed25519_compact as ed25519;

use super::block::{HEAD, Kind, SEAL_HEAD, SIGNATURE};
use super::error::SignatureError;
use super::key::{PublicKey, key_id};
use crate::model::stored_len;

/// Whose models are accepted, and from which counter on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trust<'k> {
    /// Keys that may sign; of keys with equal ids the first.
    pub keys: &'k [PublicKey],
    /// The least counter that is accepted: that of the newest model that has run, kept where it cannot be written back.
    pub least_counter: u32,
}

/// A model that an accepted key has signed. It refers to the bytes that were checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Signed<'b> {
    /// The model, for [`Model::from_bytes`](crate::Model::from_bytes).
    pub model: &'b [u8],
    /// Its counter.
    pub counter: u32,
    /// Number of bytes of model and signature.
    pub length: usize,
}

impl Trust<'_> {
    /// Checks the model that these bytes start with and the signature behind it; what follows is ignored (the erased
    /// tail of a flash sector). Nothing of the model but its lengths is read before. Cost: one verification, a fixed
    /// time, and a hash over the bytes.
    ///
    /// No bytes and keys are known with which it panics, but the linker does not prove it: the crate that verifies
    /// indexes arrays within bounds that the compiler does not see. [`Trust::verify_with`] is proven.
    ///
    /// # Errors
    /// A [`SignatureError`]: no model, not signed, by another key, changed, or older than accepted.
    pub fn verify<'b>(&self, bytes: &'b [u8]) -> Result<Signed<'b>, SignatureError> {
        self.verify_with(bytes, |key, message, signature| {
            ed25519::PublicKey::new(*key).verify(message, &ed25519::Signature::new(*signature)).is_ok()
        })
    }

    /// The same with a verification of the caller: that of the boot loader or of the chip. `is_signed` is given a key
    /// of `keys`, a message and a signature, and says whether this is an Ed25519 signature of the message by the key.
    ///
    /// # Errors
    /// As [`Trust::verify`].
    pub fn verify_with<'b>(
        &self,
        bytes: &'b [u8],
        is_signed: impl FnOnce(&PublicKey, &[u8], &[u8; SIGNATURE]) -> bool,
    ) -> Result<Signed<'b>, SignatureError> {
        let record = stored_len(bytes).map_err(SignatureError::Model)?;
        let (model, block) = bytes.split_at_checked(record).ok_or(SignatureError::Truncated)?;
        let start = block.first_chunk::<SEAL_HEAD>().ok_or(SignatureError::Unsigned)?;
        let counter = Kind::Model.read(start, record)?;
        let (head, rest) = block.split_first_chunk::<HEAD>().ok_or(SignatureError::Truncated)?;
        let signature = rest.first_chunk::<SIGNATURE>().ok_or(SignatureError::Truncated)?;
        let id = head.last_chunk::<8>().ok_or(SignatureError::Truncated)?;
        let key = self.keys.iter().find(|key| key_id(key) == *id).ok_or(SignatureError::UnknownKey)?;
        let message = bytes.get(..record.saturating_add(HEAD)).ok_or(SignatureError::Truncated)?;
        if !is_signed(key, message, signature) {
            return Err(SignatureError::Mismatch);
        }
        // After the signature: what is said of the counter is then true.
        if counter < self.least_counter {
            return Err(SignatureError::Older { given: counter, least: self.least_counter });
        }
        Ok(Signed { model, counter, length: message.len().saturating_add(SIGNATURE) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ModelError;
    use crate::signature::{BLOCK, head};
    use std::vec::Vec;

    static RECORD: &[u8] = include_bytes!("../../examples/support/standard_rig/model.bwm");

    fn pair(seed: u8) -> ed25519::KeyPair {
        ed25519::KeyPair::from_seed(ed25519::Seed::new([seed; 32]))
    }

    /// The record and its block.
    fn signed(seed: u8, counter: u32) -> (PublicKey, Vec<u8>) {
        let pair = pair(seed);
        let head = head(u32::try_from(RECORD.len()).unwrap(), &pair.pk, counter);
        let mut bytes: Vec<u8> = RECORD.iter().copied().chain(head).collect();
        bytes.extend(*pair.sk.sign(&bytes, None));
        (*pair.pk, bytes)
    }

    #[test]
    fn the_signature_is_that_of_rfc_8032() {
        let bytes = |text: &str| -> Vec<u8> {
            (0..text.len() / 2).map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).unwrap()).collect()
        };
        let seed = bytes("4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb");
        let public = bytes("3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c");
        let signature = bytes(
            "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da\
             085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00",
        );
        let pair = ed25519::KeyPair::from_seed(ed25519::Seed::from_slice(&seed).unwrap());
        assert_eq!((&pair.pk[..], &pair.sk.sign([0x72], None)[..]), (&public[..], &signature[..]));
    }

    #[test]
    fn a_signed_model_is_accepted_from_a_sector_too() {
        let (key, mut bytes) = signed(1, 5);
        let trust = Trust { keys: &[[9; 32], key], least_counter: 5 };
        let expected = Signed { model: RECORD, counter: 5, length: bytes.len() };
        assert_eq!(trust.verify(&bytes), Ok(expected));
        bytes.extend([0xFF; 300]);
        assert_eq!(trust.verify(&bytes), Ok(expected));
        assert_eq!(expected.length, RECORD.len() + BLOCK);
    }

    #[test]
    fn a_verification_of_the_caller_decides_on_what_was_signed() {
        let (key, bytes) = signed(1, 5);
        let trust = Trust { keys: &[[9; 32], key], least_counter: 5 };
        let mut asked = Vec::new();
        let verified = trust.verify_with(&bytes, |key, message, signature| {
            asked.push((*key, message.to_vec(), signature.to_vec()));
            true
        });
        assert_eq!(verified, trust.verify(&bytes));
        // The message is all before the signature, the block's head included.
        let (message, signature) = bytes.split_at(bytes.len() - 64);
        assert_eq!(asked, [(key, message.to_vec(), signature.to_vec())]);
        assert_eq!(trust.verify_with(&bytes, |_, _, _| false), Err(SignatureError::Mismatch));
        let newer = Trust { least_counter: 6, ..trust };
        let older = newer.verify_with(&bytes, |_, _, _| true);
        assert_eq!(older, Err(SignatureError::Older { given: 5, least: 6 }), "a good signature is not enough");
        let untrusted = Trust { keys: &[[9; 32]], least_counter: 0 };
        let mut asked = false;
        let unknown = untrusted.verify_with(&bytes, |_, _, _| {
            asked = true;
            true
        });
        assert_eq!((unknown, asked), (Err(SignatureError::UnknownKey), false));
    }

    #[test]
    fn every_changed_bit_is_refused() {
        let (key, good) = signed(1, 5);
        let trust = Trust { keys: &[key], least_counter: 0 };
        for bit in 0..8 * good.len() {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(trust.verify(&bytes).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn older_counters_other_keys_and_short_bytes_are_refused() {
        let (key, good) = signed(1, 5);
        let (other, _) = signed(2, 5);
        let accepts = |keys: &[PublicKey], least_counter| Trust { keys, least_counter }.verify(&good).err();
        assert_eq!(accepts(&[key], 6), Some(SignatureError::Older { given: 5, least: 6 }));
        assert_eq!(accepts(&[other], 0), Some(SignatureError::UnknownKey));
        assert_eq!(accepts(&[], 0), Some(SignatureError::UnknownKey));
        let mut namesake = other;
        namesake[..8].copy_from_slice(&key[..8]);
        assert_eq!(accepts(&[namesake], 0), Some(SignatureError::Mismatch), "the id is not the key");
        let trust = Trust { keys: &[key], least_counter: 0 };
        for length in 0..good.len() {
            assert!(trust.verify(&good[..length]).is_err(), "{length} bytes");
        }
        assert_eq!(trust.verify(RECORD), Err(SignatureError::Unsigned));
        assert_eq!(trust.verify(&good[..good.len() - 1]), Err(SignatureError::Truncated));
        assert_eq!(trust.verify(b"nothing"), Err(SignatureError::Model(ModelError::NotAModel)));
    }

    #[test]
    fn a_block_of_another_model_or_version_is_refused() {
        let (key, good) = signed(1, 5);
        let trust = Trust { keys: &[key], least_counter: 0 };
        let at = |index: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[RECORD.len() + index] = byte;
            trust.verify(&bytes).err()
        };
        assert_eq!(at(4, 2), Some(SignatureError::Version { given: 2, supported: 1 }));
        assert_eq!(at(5, 2), Some(SignatureError::Version { given: 1, supported: 1 }), "another algorithm");
        assert_eq!([at(6, 1), at(12, 0)], [Some(SignatureError::Format); 2], "reserved bytes, another length");
    }

    #[test]
    fn a_weak_public_key_signs_nothing() {
        // The neutral element: by its equation every signature with R = S·B would hold.
        let mut weak = [0; 32];
        weak[0] = 1;
        let mut bytes: Vec<u8> = RECORD.to_vec();
        bytes.extend(head(u32::try_from(RECORD.len()).unwrap(), &weak, 5));
        bytes.extend(weak);
        bytes.extend([0; 32]);
        assert_eq!(Trust { keys: &[weak], least_counter: 0 }.verify(&bytes), Err(SignatureError::Mismatch));
    }
}
