//! Where things are: the workspace's root and the target directory.

use std::env;
use std::path::{Path, PathBuf};

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

/// The folder of unpacked Debian packages.
pub fn debian() -> PathBuf {
    target_dir().join("tools/debian")
}
