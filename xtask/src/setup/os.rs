//! Links and programs in the file system; systems without them have no Debian packages either.

pub use imp::{link, make_executable};

#[cfg(unix)]
mod imp {
    use std::fs;
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    use std::path::Path;

    use anyhow::Result;

    pub fn link(target: &Path, link: &Path) -> Result<()> {
        Ok(symlink(target, link)?)
    }

    pub fn make_executable(file: &Path) -> Result<()> {
        Ok(fs::set_permissions(file, fs::Permissions::from_mode(0o755))?)
    }
}

#[cfg(not(unix))]
mod imp {
    use std::path::Path;

    use anyhow::{Result, bail};

    pub fn link(_: &Path, _: &Path) -> Result<()> {
        bail!("no links here")
    }

    pub fn make_executable(_: &Path) -> Result<()> {
        bail!("no scripts here")
    }
}
