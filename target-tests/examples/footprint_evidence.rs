//! The smallest program with the evidence of runs in five directions, the reason of its alarm, and the growth:
//! `cargo xtask measure` prints by how much its flash exceeds that of `footprint_decided`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "support/directed.rs"]
mod directed;
#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

use bearing_watch::{Evidence, Verdict};

program!(run);

fn run() -> ! {
    let mut evidence = Evidence::new(&directed::MODEL);
    loop {
        let [a, b, c] = footprint::inputs();
        let Some(decision) = directed::decision([a, b, c, a + b, b + c]) else { continue };
        footprint::tell(directed::MODEL.constants().classifier.verdict(&decision));
        let mut alarm = evidence.observe(Some(&decision));
        if c > 0.0 {
            alarm = evidence.end_run();
        }
        let (Some(_), Some(main)) = (alarm, evidence.main_contribution()) else { continue };
        let grows = evidence.growth(main.direction).is_some_and(|growth| growth.is_growing());
        footprint::tell(if grows { Verdict::Class(main.direction) } else { Verdict::Novel });
    }
}
