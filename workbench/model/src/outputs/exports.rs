//! The files of a model: binary, and as source code.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::Error;

/// Segments of a commissioning.
const COMMISSIONING: std::ops::RangeInclusive<u32> = 2..=10_000;

/// Where a model is written.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Exports {
    /// The binary model
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE")))]
    pub model: PathBuf,
    /// The model as Rust constants
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE")))]
    pub rust: Option<PathBuf>,
    /// With --rust, also the constants for `Commissioning` with so many healthy segments of a drive
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "SEGMENTS")))]
    pub commissioning: Option<NonZeroU32>,
    /// The model as a C header, for the library of `c-api`
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE")))]
    pub c: Option<PathBuf>,
}

/// The contents of the files.
#[derive(Debug)]
pub struct Exported {
    /// The binary model.
    pub model: Vec<u8>,
    rust: Option<String>,
    c: Option<String>,
}

impl Exports {
    /// Returns an error if the files do not go together.
    ///
    /// # Errors
    /// A commissioning of too few or too many segments, or without Rust.
    pub fn check(&self) -> Result<(), Error> {
        let Some(segments) = self.commissioning else { return Ok(()) };
        let (least, most) = COMMISSIONING.into_inner();
        if !COMMISSIONING.contains(&segments.get()) {
            return Err(Error::Usage(format!("--commissioning {segments}: {least} to {most} segments")));
        }
        let lone = || Error::Usage("--commissioning adds to the Rust constants; give --rust too".into());
        self.rust.as_ref().map(|_| ()).ok_or_else(lone)
    }

    /// The files that are written.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [Some(self.model.as_path()), self.rust.as_deref(), self.c.as_deref()].into_iter().flatten()
    }

    /// The contents of the files: the model, and the sources by these functions if they are wanted; that of Rust takes
    /// the segments of a commissioning.
    ///
    /// # Errors
    /// Those of the functions.
    pub fn exported(
        &self,
        model: Vec<u8>,
        rust: impl FnOnce(Option<u32>) -> Result<String, Error>,
        c: impl FnOnce() -> Result<String, Error>,
    ) -> Result<Exported, Error> {
        let rust = self.rust.as_ref().map(|_| rust(self.commissioning.map(NonZeroU32::get))).transpose()?;
        Ok(Exported { model, rust, c: self.c.as_ref().map(|_| c()).transpose()? })
    }

    /// The files with their contents.
    #[must_use]
    pub fn contents<'a>(&'a self, exported: &'a Exported) -> Vec<(&'a Path, &'a [u8])> {
        let texts = [(&self.rust, &exported.rust), (&self.c, &exported.c)];
        let texts = texts.into_iter().filter_map(|(path, text)| Some((path.as_deref()?, text.as_ref()?.as_bytes())));
        texts.chain([(self.model.as_path(), exported.model.as_slice())]).collect()
    }
}
