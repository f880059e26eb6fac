//! Attacks a door of `readers`: with libFuzzer, guided by coverage, where `cargo xtask fuzz` builds it; else replays files.
#![cfg_attr(attack_coverage, no_main)]

use attack::readers::DOORS;

#[global_allocator]
static MEMORY: attack::memory::Guarded = attack::memory::Guarded;

#[cfg(attack_coverage)]
mod guided {
    use std::sync::LazyLock;

    static DOOR: LazyLock<&attack::Door> = LazyLock::new(|| attack::chosen(&super::DOORS));

    libfuzzer_sys::fuzz_target!(init: attack::replay::name_unless_chosen(&super::DOORS), |bytes: &[u8]| {
        (DOOR.attack)(bytes);
    });
}

#[cfg(not(attack_coverage))]
fn main() -> std::process::ExitCode {
    attack::replay::main(&DOORS)
}
