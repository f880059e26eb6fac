//! Where things are: the workspace's root, its target directory, the cargo that runs us.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::child;

/// The workspace's root.
pub fn root() -> PathBuf {
    // Cargo sets the variable for `cargo run`; the compiled-in value serves a binary started by hand.
    let own =
        env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    own.parent().map_or_else(|| own.clone(), Path::to_path_buf)
}

/// Cargo's target directory for the host.
pub fn target_dir() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(
        || root().join("target"),
        // Relative to where the user stands, as cargo takes it.
        |named| std::path::absolute(&named).unwrap_or_else(|_| PathBuf::from(named)),
    )
}

/// The cargo that started this program, at the workspace's root.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    command
}

/// Returns a call of the command line `bearing-watch` at the workspace's root, as the host tests build it: a build of the
/// program alone has other features of dependencies, and would compile the workbench again.
pub fn workbench() -> Result<Command> {
    child::succeed(&mut cargo(&["test", "--quiet", "--workspace", "--no-run"]))?;
    let program = format!("debug/bearing-watch{}", env::consts::EXE_SUFFIX);
    let mut command = Command::new(target_dir().join(program));
    command.current_dir(root());
    Ok(command)
}
