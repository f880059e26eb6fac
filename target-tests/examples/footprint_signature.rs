//! The smallest program that verifies a signed model: `cargo xtask measure` prints its flash beside that of
//! `footprint_seal`, which opens a sealed state.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

use core::hint::black_box;

use bearing_watch::Verdict;
use bearing_watch::signature::Trust;

program!(run);

fn run() -> ! {
    loop {
        let [y, ..] = footprint::inputs();
        let [byte, ..] = y.to_le_bytes();
        let (keys, bytes) = (black_box([[byte; 32]]), black_box([0; 300]));
        let verified = Trust { keys: &keys, least_counter: 1 }.verify(&bytes);
        footprint::tell(if verified.is_ok() { Verdict::Class(0) } else { Verdict::Class(1) });
    }
}
