//! The programs: libFuzzer where `cargo attack fuzz` builds them; without coverage they replay inputs, as those that a
//! run has found to fail.

use std::process::ExitCode;

use crate::Door;

/// The program of these doors.
#[macro_export]
macro_rules! program {
    ($doors:expr) => {
        #[global_allocator]
        static MEMORY: $crate::memory::Guarded = $crate::memory::Guarded;

        #[cfg(attack_coverage)]
        mod guided {
            static DOOR: std::sync::LazyLock<&$crate::Door> = std::sync::LazyLock::new(|| $crate::chosen(&$doors));

            libfuzzer_sys::fuzz_target!(init: $crate::replay::name_unless_chosen(&$doors), |bytes: &[u8]| {
                (DOOR.attack)(bytes);
            });
        }

        #[cfg(not(attack_coverage))]
        fn main() -> std::process::ExitCode {
            $crate::replay::main(&$doors)
        }
    };
}

/// Prints the doors and ends, unless the environment variable `ATTACK_DOOR` names one.
pub fn name_unless_chosen(doors: &[Door]) {
    if std::env::var_os("ATTACK_DOOR").is_none() {
        doors.iter().for_each(|door| println!("{}", door.name));
        std::process::exit(0);
    }
}

/// Prints the doors, or attacks the door of the first argument with the files that follow.
#[must_use]
pub fn main(doors: &[Door]) -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let Some(name) = arguments.next() else {
        doors.iter().for_each(|door| println!("{}", door.name));
        return ExitCode::SUCCESS;
    };
    let Some(door) = doors.iter().find(|door| *door.name == *name) else {
        eprintln!("no door {}", name.display());
        return ExitCode::from(2);
    };
    for file in arguments {
        match std::fs::read(&file) {
            Ok(bytes) => (door.attack)(&bytes),
            Err(error) => {
                eprintln!("{}: {error}", file.display());
                return ExitCode::from(2);
            }
        }
    }
    ExitCode::SUCCESS
}
