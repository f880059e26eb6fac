//! Where an output goes: regular files are replaced when they are complete, everything else is written to.
//!
//! ```text
//! absent, or a regular file   a temporary file beside it, renamed
//! a link                      the same for the file that it leads to, whether that exists or not
//! a device, a pipe, a stream  a temporary file, whose bytes are appended when they are complete
//! ```
//!
//! A rename would put a regular file in the place of a device or a link.

use std::fs::{File, Metadata, OpenOptions, Permissions};
use std::io::{self, Seek as _};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Error;

/// Largest number of symbolic links that are followed one after another; that of Linux.
const MOST_LINKS: usize = 40;
/// Bytes at the end of the name of an output that end the name of its temporary file too: the format depends on them.
const ENDING: usize = 24;

/// Where an output goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// A regular file, or none yet.
    File(PathBuf),
    /// A device, a pipe, or a stream of this process.
    Stream(PathBuf),
}

/// Follows the links of an output.
///
/// # Errors
/// A circle of links.
pub(super) fn target(path: &Path) -> Result<Target, Error> {
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        // An open file of a process: its name, if it has one, may belong to another file by now.
        if place.starts_with("/proc") || place.metadata().is_ok_and(|about| !about.is_file() && !about.is_dir()) {
            return Ok(Target::Stream(path.to_path_buf()));
        }
        match place.read_link() {
            Ok(link) => place = folder_of(&place).join(link),
            Err(_) => return Ok(Target::File(place)),
        }
    }
    Err(Error::Usage(format!("{} is a circle of links; choose another name", path.display())))
}

/// The folder of a file.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// An output that is being made.
#[derive(Debug)]
pub struct Staged {
    file: NamedTempFile,
    target: Target,
    /// The name that was asked for.
    path: PathBuf,
}

impl Staged {
    /// Opens a temporary file for this output.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn new(path: &Path) -> Result<Self, Error> {
        let target = target(path)?;
        let file = match &target {
            Target::File(place) => {
                let file = beside(place).map_err(named(path))?;
                if let Ok(about) = place.metadata() {
                    keep_permissions(file.as_file(), &about).map_err(named(path))?;
                }
                file
            }
            Target::Stream(_) => builder(path, |builder| builder.tempfile()).map_err(named(path))?,
        };
        Ok(Self { file, target, path: path.to_path_buf() })
    }

    /// The temporary file.
    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// The name of the temporary file, which ends like that of the output.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Whether a failure leaves something of the output.
    pub(super) const fn is_stream(&self) -> bool {
        matches!(self.target, Target::Stream(_))
    }

    /// Puts the content in its place.
    ///
    /// # Errors
    /// A place that cannot be written.
    pub fn finish(self) -> Result<(), Error> {
        let Self { file, target, path } = self;
        match target {
            Target::File(place) => file.persist(place).map(drop).map_err(|failed| failed.error),
            Target::Stream(place) => append(file, &place),
        }
        .map_err(Error::io(path))
    }
}

/// A temporary file in the folder of a file, with the permissions of an output.
pub(super) fn beside(path: &Path) -> io::Result<NamedTempFile> {
    let file = builder(path, |builder| builder.tempfile_in(folder_of(path)))?;
    #[cfg(unix)]
    {
        // Temporary files are readable by their owner only; an output has the usual permissions.
        use std::os::unix::fs::PermissionsExt as _;
        file.as_file().set_permissions(Permissions::from_mode(0o644))?;
    }
    Ok(file)
}

fn builder(
    path: &Path,
    open: impl FnOnce(&tempfile::Builder<'_, '_>) -> io::Result<NamedTempFile>,
) -> io::Result<NamedTempFile> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let ending = (name.len().saturating_sub(ENDING)..=name.len()).find_map(|start| name.get(start..));
    open(tempfile::Builder::new().prefix(".bearing-watch").suffix(ending.unwrap_or_default()))
}

/// A replaced file keeps who may read and write it.
fn keep_permissions(file: &File, about: &Metadata) -> io::Result<()> {
    let permissions: Permissions = about.permissions();
    file.set_permissions(permissions)
}

/// The error names the requested file, not the temporary one.
pub(super) fn named(path: &Path) -> impl Fn(io::Error) -> Error + '_ {
    move |error| Error::Io { path: path.into(), source: error.kind().into() }
}

fn append(mut staged: NamedTempFile, path: &Path) -> io::Result<()> {
    staged.as_file_mut().rewind()?;
    let mut stream = OpenOptions::new().append(true).open(path)?;
    io::copy(staged.as_file_mut(), &mut stream).map(drop)
}
