//! The smallest program that opens and seals a saved state: `cargo xtask measure` prints its flash beside that of
//! `footprint_signature`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

use core::hint::black_box;

use bearing_watch::Verdict;
use bearing_watch::signature::StateKey;

program!(run);

fn run() -> ! {
    let mut bytes = black_box([0; 300]);
    loop {
        let [y, ..] = footprint::inputs();
        let [byte, ..] = y.to_le_bytes();
        let key = StateKey::new(black_box([byte; 32]));
        let opened = key.open(&bytes, 1).is_ok();
        let sealed = key.seal(&mut bytes, 252, y.to_bits()).is_ok();
        footprint::tell(if opened && sealed { Verdict::Class(0) } else { Verdict::Class(1) });
    }
}
