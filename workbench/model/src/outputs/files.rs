//! Files that are complete or absent.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::staged::{self, Staged, Target, folder_of};
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
    let real = |input: &PathBuf| input.canonicalize().unwrap_or_else(|_| whole(input));
    let inputs: Vec<PathBuf> = inputs.iter().map(real).collect();
    let mut before = Vec::new();
    for output in outputs {
        // Anything may go to a device, also twice.
        let Target::File(place) = staged::target(output)? else { continue };
        let (shown, folder) = (output.display(), folder_of(&place));
        if !folder.is_dir() {
            return Err(Error::Usage(format!("{shown}: there is no folder {}; make it first", folder.display())));
        }
        if output.is_dir() {
            return Err(Error::Usage(format!("{shown} is a folder; give the name of a file in it")));
        }
        let place = whole(&place);
        if inputs.contains(&place) {
            return Err(Error::Usage(format!("{shown} is an input and would be overwritten; choose another name")));
        }
        if before.contains(&place) {
            return Err(Error::Usage(format!("{shown} is named for two outputs; choose different names")));
        }
        before.push(place);
    }
    Ok(())
}

/// Makes each file as a temporary one, and puts all of them in their places when they are complete: a regular file is
/// replaced, a link followed, a device or pipe written to.
///
/// # Errors
/// A place that cannot be written.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let staged = files.iter().map(|(path, content)| stage(path, content)).collect::<Result<Vec<_>, Error>>()?;
    // What goes to a device or a pipe may fail, and comes before the renames, which hardly do.
    let (streams, files): (Vec<Staged>, Vec<Staged>) = staged.into_iter().partition(Staged::is_stream);
    streams.into_iter().chain(files).try_for_each(Staged::finish)
}

/// Writes one file, completely or not at all.
///
/// # Errors
/// A place that cannot be written.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    write_all(&[(path, content.as_ref())])
}

fn stage(path: &Path, content: &[u8]) -> Result<Staged, Error> {
    let mut staged = Staged::new(path)?;
    staged.file().write_all(content).map_err(Error::io(path))?;
    Ok(staged)
}

/// Returns a temporary file in the folder of this file, with the permissions of an output.
///
/// # Errors
/// A folder that cannot be written.
pub fn temporary(path: &Path) -> Result<NamedTempFile, Error> {
    staged::beside(path).map_err(staged::named(path))
}
