//! Files that are complete or absent.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Error;

/// Returns an error, before any work is done, if an output cannot be written or would overwrite an input or another
/// output.
///
/// # Errors
/// It would.
pub fn plan(outputs: &[&Path], inputs: &[PathBuf]) -> Result<(), Error> {
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

/// The folder of a file.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes each file as a temporary file in its folder, and renames all of them when they are complete.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let staged = files.iter().map(|(path, content)| stage(path, content)).collect::<Result<Vec<_>, Error>>()?;
    for (file, (path, _)) in staged.into_iter().zip(files) {
        file.persist(path).map_err(|e| Error::Io { path: path.to_path_buf(), source: e.error })?;
    }
    Ok(())
}

/// Writes one file, completely or not at all.
///
/// # Errors
/// A folder that cannot be written.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    write_all(&[(path, content.as_ref())])
}

fn stage(path: &Path, content: &[u8]) -> Result<NamedTempFile, Error> {
    let mut file = temporary(path)?;
    file.write_all(content).map_err(Error::io(path))?;
    Ok(file)
}

/// Returns a temporary file in the folder of this file, with the permissions of an output.
///
/// # Errors
/// A folder that cannot be written.
pub fn temporary(path: &Path) -> Result<NamedTempFile, Error> {
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
