//! Output: files that are complete or absent, lines on standard output, and progress bars.

use std::cell::RefCell;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use tempfile::NamedTempFile;

use model::Error;

/// Returns an error, before any work is done, if an output cannot be written or would overwrite an input or another
/// output.
pub(super) fn plan(outputs: &[&Path], inputs: &[PathBuf]) -> Result<(), Error> {
    let whole = |path: &Path| match (folder_of(path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    };
    let inputs: Vec<PathBuf> = inputs.iter().map(|input| whole(input)).collect();
    for (k, output) in outputs.iter().enumerate() {
        let (shown, folder) = (output.display(), folder_of(output));
        if !folder.is_dir() {
            return Err(Error::Usage(format!("{shown}: there is no folder {}; make it first", folder.display())));
        }
        if output.is_dir() {
            return Err(Error::Usage(format!("{shown} is a folder; give the name of a file in it")));
        }
        if inputs.contains(&whole(output)) {
            return Err(Error::Usage(format!("{shown} is an input and would be overwritten; choose another name")));
        }
        if outputs[..k].iter().any(|other| whole(other) == whole(output)) {
            return Err(Error::Usage(format!("{shown} is named for two outputs; choose different names")));
        }
    }
    Ok(())
}

pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes each file as a temporary file in its folder, and renames all of them when they are complete.
pub(super) fn write_all(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let staged = files.iter().map(|(path, content)| stage(path, content)).collect::<Result<Vec<_>, Error>>()?;
    for (file, (path, _)) in staged.into_iter().zip(files) {
        file.persist(path).map_err(|e| Error::Io { path: path.to_path_buf(), source: e.error })?;
    }
    Ok(())
}

/// Writes one file, completely or not at all.
pub(super) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    write_all(&[(path, content.as_ref())])
}

fn stage(path: &Path, content: &[u8]) -> Result<NamedTempFile, Error> {
    let mut file = temporary(path)?;
    file.write_all(content).map_err(Error::io(path))?;
    Ok(file)
}

/// Returns a temporary file in the folder of this file, with the permissions of an output.
pub(super) fn temporary(path: &Path) -> Result<NamedTempFile, Error> {
    // The error names the requested file, not the temporary one.
    let named = |error: std::io::Error| Error::Io { path: path.into(), source: error.kind().into() };
    let file = tempfile::Builder::new().prefix(".bearing-watch").tempfile_in(folder_of(path)).map_err(named)?;
    #[cfg(unix)]
    {
        // Temporary files are readable by their owner only; an output has the usual permissions.
        use std::os::unix::fs::PermissionsExt as _;
        let ordinary = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(ordinary).map_err(Error::io(path))?;
    }
    Ok(file)
}

/// Prints a line; a closed pipe (`| head`) is not an error.
pub(super) fn say(text: impl AsRef<str>) -> Result<(), Error> {
    match writeln!(std::io::stdout(), "{}", text.as_ref()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}

thread_local! {
    /// The warnings of this thread, if a program that calls the workbench collects them.
    static COLLECTED: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Prints a warning on standard error, unless it is collected.
pub(super) fn warn(text: impl AsRef<str>) {
    COLLECTED.with_borrow_mut(|collected| match collected {
        Some(collected) => collected.push(text.as_ref().into()),
        None => eprintln!("warning: {}", text.as_ref()),
    });
}

/// Runs work, and returns the warnings that it gave on this thread.
pub(super) fn with_warnings<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    let before = COLLECTED.replace(Some(vec![]));
    let result = work();
    (result, COLLECTED.replace(before).unwrap_or_default())
}

/// Prints a report, as JSON or as lines.
pub(super) fn report(report: super::call::Report, as_json: bool) -> Result<(), Error> {
    if as_json { json(&report.json) } else { report.lines.iter().try_for_each(say) }
}

/// Returns the rows as CSV, quoted if needed.
pub(super) fn csv(rows: &[Vec<String>]) -> Result<String, Error> {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for row in rows {
        writer.write_record(row).map_err(|e| Error::Usage(e.to_string()))?;
    }
    let bytes = writer.into_inner().map_err(|e| Error::Usage(e.to_string()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns a progress bar; it is shown on a terminal only.
pub(super) fn progress(what: &'static str, count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg:>12} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// Prints a JSON value on standard output.
pub(super) fn json(value: &serde_json::Value) -> Result<(), Error> {
    say(format!("{value:#}"))
}
