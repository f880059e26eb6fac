//! Files that are whole or absent, lines on standard output, and progress.

use std::io::Write as _;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

use crate::Error;

/// Writes a file beside its place and moves it there when complete.
pub(super) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut file = tempfile::Builder::new().prefix(".bearing-watch").tempfile_in(folder).map_err(Error::io(path))?;
    file.write_all(content.as_ref()).map_err(Error::io(path))?;
    #[cfg(unix)]
    {
        // Temporary files are private; an output is an ordinary file.
        use std::os::unix::fs::PermissionsExt as _;
        let ordinary = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(ordinary).map_err(Error::io(path))?;
    }
    file.persist(path).map_err(|e| Error::Io { path: path.into(), source: e.error })?;
    Ok(())
}

/// Prints a line; a reader that has gone away (`| head`) is no error.
pub(super) fn say(text: impl AsRef<str>) {
    let _ = writeln!(std::io::stdout(), "{}", text.as_ref());
}

/// A bar on a terminal, nothing elsewhere.
pub(super) fn progress(what: &'static str, count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg:>12} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// A JSON value on standard output.
pub(super) fn json(value: &serde_json::Value) {
    say(format!("{value:#}"));
}
