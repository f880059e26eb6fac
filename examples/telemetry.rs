//! Frames of a monitor as hexadecimal digits, a frame a line: the same on the chip, in QEMU and on the host. As bytes
//! for the workbench:
//!
//! ```text
//! cargo run --features telemetry --example telemetry | xxd -r -p | bearing-watch listen - --out traces
//! ```
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/sender.rs"]
mod sender;
#[path = "support/standard_rig/mod.rs"]
mod standard_rig;

use core::fmt;

main!(run);

struct Hexadecimal<'a>(&'a [u8]);

impl fmt::Display for Hexadecimal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

fn run() {
    if let Err(error) = sender::run(|frame| say!("{}", Hexadecimal(frame))) {
        say!("{error}");
    }
}
