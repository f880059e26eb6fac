//! Attacks on every door of bearing-watch: a door takes any bytes, makes inputs and calls of them, and panics if a
//! property does not hold.
//!
//! ```text
//! core      model bytes, samples and calls, front end, converter, telemetry, flash, C interface
//! readers   files of the workbench: tables, labels, TOML, models; requests to its pages, its line
//! ```
//!
//! Tests replay the kept corpora and some thousand changes of them. `cargo attack fuzz --minutes 10` attacks with
//! libFuzzer, guided by coverage, on stable Rust: the compiler's pass that counts branches is an option of LLVM.
//! `docs/trust.md` has the properties.

pub mod checksum;
pub mod core;
pub mod finite;
pub mod input;
pub mod memory;
pub mod models;
#[cfg(feature = "readers")]
pub mod readers;
pub mod replay;
#[cfg(feature = "readers")]
pub mod served;
pub mod session;

/// Something that takes bytes from outside.
#[derive(Clone, Copy, Debug)]
pub struct Door {
    /// Its name, that of its corpus.
    pub name: &'static str,
    /// What the bytes stand for.
    pub about: &'static str,
    /// Attacks with these bytes; panics if a property does not hold.
    pub attack: fn(&[u8]),
}

impl Door {
    /// A door.
    #[must_use]
    pub const fn new(name: &'static str, about: &'static str, attack: fn(&[u8])) -> Self {
        Self { name, about, attack }
    }
}

/// The door that the environment variable `ATTACK_DOOR` names.
///
/// # Panics
/// If there is no such door: the panic lists those that there are.
#[must_use]
pub fn chosen(doors: &'static [Door]) -> &'static Door {
    let name = std::env::var("ATTACK_DOOR").unwrap_or_default();
    let names: Vec<&str> = doors.iter().map(|door| door.name).collect();
    doors.iter().find(|door| door.name == name).unwrap_or_else(|| panic!("ATTACK_DOOR is one of {names:?}"))
}
