//! The system's list of installed packages, as the resolver of a private unpacking has to see it.

use std::collections::BTreeSet;

/// Fields that say which packages are there. Without the others no installed package hinders another one, and none
/// misses what it needs: nothing is installed or removed.
const KEPT: [&str; 6] = ["Package: ", "Status: ", "Architecture: ", "Multi-Arch: ", "Version: ", "Provides: "];

/// The list in the format of dpkg, without the packages that are to be unpacked and those of the same source, which
/// belong together and look for each other beside them.
pub fn reduced(status: &str, wanted: &[&str], sources: &BTreeSet<String>) -> String {
    let stays = |stanza: &&str| {
        let name = field(stanza, "Package: ").unwrap_or_default();
        !wanted.contains(&name) && !sources.contains(source(stanza))
    };
    status.split("\n\n").filter(stays).map(|stanza| facts(stanza) + "\n").collect()
}

fn facts(stanza: &str) -> String {
    let kept = stanza.lines().filter(|line| KEPT.iter().any(|start| line.starts_with(start)));
    kept.map(|line| format!("{line}\n")).collect()
}

/// The sources of the packages that `apt-cache show` describes.
pub fn sources(shown: &str) -> BTreeSet<String> {
    let stanzas = shown.split("\n\n").filter(|stanza| stanza.contains("Package: "));
    stanzas.map(|stanza| source(stanza).to_owned()).collect()
}

/// The source package: it has a field if its name or version is another one.
fn source(stanza: &str) -> &str {
    let name = field(stanza, "Source: ").or_else(|| field(stanza, "Package: ")).unwrap_or_default();
    name.split(" (").next().unwrap_or(name)
}

fn field<'a>(stanza: &'a str, start: &str) -> Option<&'a str> {
    stanza.lines().find_map(|line| line.strip_prefix(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS: &str = "\
Package: qemu-utils
Status: install ok installed
Source: qemu (1:10.0)
Version: 1:10.0
Depends: libc6

Package: libc6
Status: install ok installed
Architecture: amd64
Version: 2.36
Breaks: hurd
Description: a
 Version: of a kind

Package: make
Status: install ok installed
Version: 4.3
";

    #[test]
    fn what_belongs_to_the_wanted_packages_is_left_out_and_relations_too() {
        let sources = sources("Package: qemu-system-arm\nSource: qemu\nVersion: 1:7.2\n\nPackage: make\n");
        assert_eq!(sources.iter().collect::<Vec<_>>(), ["make", "qemu"]);
        let qemu = BTreeSet::from(["qemu".to_owned()]);
        let left = reduced(STATUS, &["make"], &qemu);
        assert_eq!(left, "Package: libc6\nStatus: install ok installed\nArchitecture: amd64\nVersion: 2.36\n\n",);
        assert!(reduced(STATUS, &[], &qemu).contains("Package: make\n"));
    }
}
