//! The smallest program that makes decisions on five coordinates, and no evidence of them: what `footprint_evidence`
//! is compared with.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "support/directed.rs"]
mod directed;
#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;

program!(run);

fn run() -> ! {
    loop {
        let [a, b, c] = footprint::inputs();
        if let Some(decision) = directed::decision([a, b, c, a + b, b + c]) {
            footprint::tell(directed::MODEL.constants().classifier.verdict(&decision));
        }
    }
}
