//! Counts the instructions of decimation, a sample at a time, as lines of JSON.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use support::count::Counter;
use support::decimation;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask firmware measure_decimate");
        return;
    };
    decimation::measure(&mut counter, |name, factor, instructions, bytes| {
        say!(r#"{{"name":"{name}","n":{factor},"instructions":{instructions},"bytes":{bytes}}}"#);
    });
}
