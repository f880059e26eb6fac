//! Licences, sources, doubled versions and advisories of all dependencies, by cargo-deny, which is installed if it is
//! missing; the rules are in `deny.toml`.

use anyhow::{Result, bail};

use crate::child;
use crate::python::tool;
use crate::report::Tally;

/// Both workspaces whose programs a user may run, all crates and features.
pub fn checks(tally: &mut Tally) {
    for manifest in ["Cargo.toml", "frameworks/Cargo.toml"] {
        for checks in [&["bans", "licenses", "sources"] as &[&str], &["advisories"]] {
            let what = format!("{} of {manifest}", checks.join(", "));
            match run(manifest, checks) {
                Ok(Some(missing)) => tally.skip(&what, missing),
                outcome => tally.check(&what, outcome.map(|_| "")),
            }
        }
    }
}

/// Why there is no outcome, if there is none.
fn run(manifest: &str, checks: &[&str]) -> Result<Option<&'static str>> {
    let mut deny = tool("cargo-deny", &["--workspace", "--locked", "--all-features", "--config", "deny.toml"])?;
    deny.args(["--manifest-path", manifest, "check", "--hide-inclusion-graph"]);
    // Each workspace uses only some of the exceptions, and doubled versions are no fault.
    deny.args(["--allow", "license-exception-not-encountered", "--allow", "duplicate"]).args(checks);
    // A network that swallows packets must not stop the test.
    deny.env("GIT_HTTP_LOW_SPEED_LIMIT", "1000").env("GIT_HTTP_LOW_SPEED_TIME", "30").env("GIT_TERMINAL_PROMPT", "0");
    let output = child::captured(&mut deny)?;
    match String::from_utf8_lossy(&output.stderr) {
        _ if output.status.success() => Ok(None),
        text if text.contains("failed to fetch advisory database") => {
            Ok(Some("no access to the database of advisories"))
        }
        text => bail!("{}", text.trim_end()),
    }
}
