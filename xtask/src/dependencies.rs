//! Licences, sources, doubled versions and advisories of all dependencies, by cargo-deny, which is installed if it is
//! missing; the rules are in `deny.toml`.

use std::process::Command;

use anyhow::Result;

use crate::child;
use crate::tally::Tally;
use crate::target::brief;
use crate::tools::DENY;

/// The workspaces whose programs a user may run.
const MANIFESTS: [&str; 2] = ["Cargo.toml", "frameworks/Cargo.toml"];

/// What cargo-deny prints where it cannot have the database of advisories.
const NO_DATABASE: &str = "failed to fetch advisory database";

/// The outcome of a check.
#[derive(Debug, PartialEq, Eq)]
enum Outcome {
    Passed,
    /// There is no way to the database of advisories.
    NoDatabase,
    Failed(String),
}

/// Both workspaces, all crates and features.
pub fn checks(tally: &mut Tally) {
    if let Err(reason) = DENY.command(&[]) {
        return tally.missing("cargo deny", &format!("{reason:#}"));
    }
    for manifest in MANIFESTS {
        for checks in [&["bans", "licenses", "sources"] as &[&str], &["advisories"]] {
            let what = format!("{} of {manifest}", checks.join(", "));
            match brief(run(manifest, checks)) {
                Ok(Outcome::Passed) => tally.check::<_, &str>(&what, Ok("")),
                Ok(Outcome::NoDatabase) => tally.skip(&what, "no access to the database of advisories"),
                Ok(Outcome::Failed(reason)) | Err(reason) => tally.check::<&str, _>(&what, Err(reason)),
            }
        }
    }
}

fn run(manifest: &str, checks: &[&str]) -> Result<Outcome> {
    let mut deny = DENY.command(&["--workspace", "--locked", "--all-features", "--config", "deny.toml"])?;
    deny.args(["--manifest-path", manifest, "check", "--hide-inclusion-graph"]);
    // Each workspace uses only some of the exceptions, and doubled versions are no fault.
    deny.args(["--allow", "license-exception-not-encountered", "--allow", "duplicate"]).args(checks);
    outcome(&mut deny)
}

fn outcome(deny: &mut Command) -> Result<Outcome> {
    // A network that swallows packets must not stop the test.
    deny.env("GIT_HTTP_LOW_SPEED_LIMIT", "1000").env("GIT_HTTP_LOW_SPEED_TIME", "30").env("GIT_TERMINAL_PROMPT", "0");
    let output = child::captured(deny)?;
    let text = String::from_utf8_lossy(&output.stderr);
    Ok(classify(output.status.success(), &text))
}

fn classify(success: bool, text: &str) -> Outcome {
    if success {
        Outcome::Passed
    } else if text.contains(NO_DATABASE) {
        Outcome::NoDatabase
    } else {
        Outcome::Failed(text.trim_end().to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_database_is_no_failure_and_all_else_is() {
        let missing = "[ERROR] failed to fetch advisory database https://host with cli: failed to clone";
        assert_eq!(classify(false, missing), Outcome::NoDatabase);
        assert_eq!(classify(true, ""), Outcome::Passed);
        assert_eq!(classify(false, "error[vulnerability]\n"), Outcome::Failed("error[vulnerability]".to_owned()));
    }
}
