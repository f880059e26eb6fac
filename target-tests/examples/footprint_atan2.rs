//! The smallest program with the arctangent of `libm`: what the start of a resolver's angle would take by it.
//! `cargo xtask measure` prints its flash beside that of `footprint_coarse`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

use bearing_watch::Verdict;

program!(run);

fn run() -> ! {
    loop {
        let [y, u1, u2] = footprint::inputs();
        footprint::tell(if y > libm::atan2f(u1, u2) { Verdict::Class(0) } else { Verdict::Class(1) });
    }
}
