//! Public keys and their ids.

/// A public key of Ed25519.
pub type PublicKey = [u8; 32];

/// The id of a key in a signature.
#[must_use]
pub fn key_id(key: &PublicKey) -> [u8; 8] {
    let [id @ .., _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _] = *key;
    id
}
