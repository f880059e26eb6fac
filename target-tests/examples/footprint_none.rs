//! The smallest program without a detector: `cargo xtask measure` takes its flash off that of the other examples
//! `footprint_…`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

use bearing_watch::Verdict;

program!(run);

fn run() -> ! {
    loop {
        let [y, u1, u2] = footprint::inputs();
        footprint::tell(if y > u1 + u2 { Verdict::Class(0) } else { Verdict::Class(1) });
    }
}
