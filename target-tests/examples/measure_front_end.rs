//! Counts the instructions of the front end, a sample at a time, as lines of JSON.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use support::count::Counter;
use support::front_end;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask firmware measure_front_end");
        return;
    };
    front_end::measure(&mut counter, |name, factor, instructions, bytes| {
        say!(r#"{{"name":"front end, {name}","n":{factor},"instructions":{instructions},"bytes":{bytes}}}"#);
    });
}
