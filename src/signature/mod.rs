//! Signed models, and saved states under a key of the drive.
//!
//! Enters: bytes of a model with a signature, or of a saved state with an authentication code, and keys. Leaves: the
//! bytes of the model or the state, if they come from who has the key and are not older than accepted; a checksum alone
//! ([`crate::model`], [`crate::storage`]) detects accidents, not intent.
//!
//! ```
//! # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/standard_rig/model.rs")); }
//! # use model::{Drive, MODEL};
//! use bearing_watch::{Evidence, Model};
//! use bearing_watch::signature::{SignatureError, StateKey, Trust};
//!
//! // `bearing-watch sign --key vendor.key --new` prints the public key. Keep the counter in memory that cannot be rewritten.
//! # let key = [7; 32];
//! # let file = [0; 8];
//! let trust = Trust { keys: &[key], least_counter: 3 };
//! let model = trust.verify(&file).ok().and_then(|signed| Model::<Drive>::from_bytes(signed.model).ok());
//! assert!(model.is_none(), "no model that somebody has signed");
//!
//! // The key of this drive, written at its production.
//! let key = StateKey::new([0x5A; 32]);
//! let (mut buffer, evidence) = ([0; 512], Evidence::new(&MODEL));
//! let length = evidence.save(&MODEL, &mut buffer)?;
//! let length = key.seal(&mut buffer, length, 41)?;
//! let sealed = key.open(&buffer[..length], 41)?;
//! assert_eq!((sealed.state.len(), sealed.sequence), (Evidence::saved_len(&MODEL), 41));
//! assert!(matches!(key.open(&buffer[..length], 42), Err(SignatureError::Older { .. })));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Format
//!
//! ```text
//! model   record of `model::bytes`, then the block
//! block   "BWSG"  version u8 = 1  algorithm u8 = 1  0 u16  counter u32  record length u32  key id [u8; 8]  [u8; 64]
//!         the last: Ed25519 (RFC 8032) over all bytes before it, record and block
//! state   record of `saved`, then the seal
//! seal    "BWSM"  version u8 = 1  algorithm u8 = 2  0 u16  sequence u32  state length u32  [u8; 32]
//!         the last: HMAC-SHA-256 (RFC 2104) over all bytes before it, state and seal
//! ```
//!
//! Little-endian. The key id is the first eight bytes of the public key. A program without this feature reads the model
//! as before ([`Model::from_sector`](crate::Model::from_sector) ignores what follows it).
//!
//! # Why two algorithms
//!
//! A model is made in one place and checked in many: with a public key a drive that is opened gives away nothing that
//! signs. A state is written and read by the same drive. A private key in it would be as easy to read as a symmetric
//! one, and a signature by it costs a hundred times an authentication code; so the code, with a key that each drive
//! has for itself. Who reads the key out of a drive forges states of that drive, and of no other one.
//!
//! # Cost
//!
//! A verification takes 1.9 million instructions and 27 kB of flash on a Cortex-M4F, a seal 15 500 and 13 kB
//! (`book/src/faults.md`, `cargo xtask measure`). All functions but [`Trust::verify`] link without a panic; the crate
//! that verifies indexes arrays within bounds that the compiler does not see. [`Trust::verify_with`] takes the
//! verification of the boot loader or the chip instead.
//!
//! # What it does not do
//!
//! It encrypts nothing. A drive cannot know that an old signed model is old unless `least_counter` is where an attacker
//! cannot write it back: one-time programmable cells, or flash behind a secure boot. Raise it after the new model has
//! started. The same holds for the sequence of states: use the record's counter plus one
//! ([`SlotPair::newest`](crate::storage::SlotPair::newest)) as the sequence, and require at a load that both are equal;
//! two whole old slots written back pass unless the least sequence is protected. The boot loader has to protect keys
//! and program.

mod block;
mod error;
mod key;
mod model;
mod state;

pub use block::{BLOCK, HEAD, head};
pub use error::SignatureError;
pub use key::{PublicKey, key_id};
pub use model::{Signed, Trust};
pub use state::{SEAL, Sealed, StateKey};
