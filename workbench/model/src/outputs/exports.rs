//! The files of a model: binary, and as source code.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::Error;
use crate::train::sources::c_name::CName;

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
    /// The model as a C header, for the library of `c-api`
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE")))]
    pub c: Option<PathBuf>,
    /// Name of the model in the C header, if a program has several: `left` for `BW_LEFT_MODEL_…` and `BwLeftDrive`
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NAME")))]
    pub c_name: Option<String>,
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
    /// The files that are written.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [Some(self.model.as_path()), self.rust.as_deref(), self.c.as_deref()].into_iter().flatten()
    }

    /// Checks what a long training is not to end with.
    ///
    /// # Errors
    /// A name that is not one of C.
    pub fn check(&self) -> Result<(), Error> {
        CName::new(self.c_name.as_deref()).map(|_| ())
    }

    /// The contents of the files: the model, and the sources by these functions if they are wanted.
    ///
    /// # Errors
    /// Those of the functions.
    pub fn exported(
        &self,
        model: Vec<u8>,
        rust: impl FnOnce() -> Result<String, Error>,
        c: impl FnOnce(Option<&str>) -> Result<String, Error>,
    ) -> Result<Exported, Error> {
        let rust = self.rust.as_ref().map(|_| rust()).transpose()?;
        Ok(Exported { model, rust, c: self.c.as_ref().map(|_| c(self.c_name.as_deref())).transpose()? })
    }

    /// The files with their contents.
    #[must_use]
    pub fn contents<'a>(&'a self, exported: &'a Exported) -> Vec<(&'a Path, &'a [u8])> {
        let texts = [(&self.rust, &exported.rust), (&self.c, &exported.c)];
        let texts = texts.into_iter().filter_map(|(path, text)| Some((path.as_deref()?, text.as_ref()?.as_bytes())));
        texts.chain([(self.model.as_path(), exported.model.as_slice())]).collect()
    }
}
