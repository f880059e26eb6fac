//! Versions of installed programs.

use std::process::Command;

use crate::child;

/// Whether the command runs and the version that it prints is not below this one.
pub fn is_at_least(command: &mut Command, minimum: &[u32]) -> bool {
    child::output(command).is_some_and(|text| found(&text) >= minimum.to_vec())
}

/// The first version in what a program prints.
fn found(text: &str) -> Vec<u32> {
    let words = text.split(|own: char| own.is_whitespace() || "(),".contains(own));
    words.map(numbers).find(|numbers| !numbers.is_empty()).unwrap_or_default()
}

/// Numbers of a version, up to what is no number; none if it does not start with one.
pub fn numbers(version: &str) -> Vec<u32> {
    version.split('.').map_while(|part| part.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_found_and_compare_by_numbers() {
        assert_eq!(found("QEMU emulator version 7.2.22 (Debian 1:7.2+dfsg-7+deb12u18)\nCopyright 2003"), [7, 2, 22]);
        assert_eq!(found("rustc 1.96.0 (ac68faa20 2026-05-25) (built from a source tarball)"), [1, 96, 0]);
        assert_eq!(found("12.2.1"), [12, 2, 1]);
        assert_eq!(found("no version"), Vec::<u32>::new());
        assert!(found("version 10.0") >= vec![6, 0] && found("cmake 3.9") < vec![3, 22] && found("") < vec![0]);
    }

    #[test]
    fn a_program_that_is_missing_or_too_old_does_not_serve() {
        assert!(!is_at_least(&mut Command::new("no-such-program"), &[]));
        let prints = |version: &str, minimum: &[u32]| is_at_least(Command::new("echo").arg(version), minimum);
        assert!(prints("1.2", &[1, 2]) && !prints("1.2", &[1, 3]));
    }
}
