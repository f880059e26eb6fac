//! The public interface of the core beside that of a release: what breaks programs of users needs another version.

use std::process::Command;

use anyhow::Result;

use crate::tally::Tally;
use crate::target::brief;
use crate::tools::SEMVER_CHECKS;
use crate::{child, workspace};

/// The crates whose interface is promised. The library of the workbench serves its command line and the Python package.
const PROMISED: [&str; 1] = ["bearing-watch"];

/// Compares with a revision, or with the newest tag of a release.
pub fn checks(tally: &mut Tally, baseline: Option<&str>) {
    let Some(revision) = baseline.map(ToOwned::to_owned).or_else(last_release) else {
        return tally.skip("public interface", "there is no release yet (no tag v…): nothing to compare with");
    };
    for name in PROMISED {
        tally.check(&format!("public interface of {name} beside {revision}"), brief(compare(name, &revision)));
    }
}

/// The newest tag `v1.2.3` that this revision contains.
fn last_release() -> Option<String> {
    let arguments = ["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"];
    child::output(Command::new("git").args(arguments).current_dir(workspace::root()))
}

fn compare(name: &str, revision: &str) -> Result<&'static str> {
    let mut tool = SEMVER_CHECKS.command(&["semver-checks", "--package", name, "--baseline-rev", revision])?;
    // Features without a promise are left out.
    child::succeed(tool.args(["--only-explicit-features", "--features", PROMISED_FEATURES]))?;
    Ok("compatible with its version")
}

/// All features of the core.
const PROMISED_FEATURES: &str = "alloc,bounded,defmt,embedded-hal,embedded-storage,signature,telemetry,watch";

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn all_features_are_promised() -> Result<()> {
        let manifest = fs::read_to_string(workspace::root().join("Cargo.toml"))?;
        let section = manifest.split("\n[features]\n").nth(1).and_then(|rest| rest.split("\n[").next());
        let names = section.unwrap_or_default().lines().filter(|line| !line.starts_with('#'));
        let mut names: Vec<_> =
            names.filter_map(|line| line.split(" = ").next()).filter(|name| !name.is_empty()).collect();
        names.retain(|name| *name != "default");
        names.sort_unstable();
        assert_eq!(names.join(","), PROMISED_FEATURES);
        Ok(())
    }
}
