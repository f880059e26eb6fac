//! The smallest program with the coarse arctangent of `micromath`, from which the angle of a resolver starts.
//! `cargo xtask measure` prints its flash beside that of `footprint_atan2`, which has the one of `libm`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

use bearing_watch::Verdict;
use micromath::F32;

program!(run);

fn run() -> ! {
    loop {
        let [y, u1, u2] = footprint::inputs();
        footprint::tell(if y > F32(u1).atan2(F32(u2)).0 { Verdict::Class(0) } else { Verdict::Class(1) });
    }
}
