//! Arguments of the files of a model.

use std::path::{Path, PathBuf};

use clap::Args;

use model::Error;

#[derive(Clone, Debug, Args)]
pub(crate) struct ExportArgs {
    /// The binary model
    #[arg(long, value_name = "FILE")]
    pub(crate) model: PathBuf,
    /// The model as Rust constants
    #[arg(long, value_name = "FILE")]
    rust: Option<PathBuf>,
    /// With --rust, also the constants for `Model::commissioning` with so many healthy segments of a drive
    #[arg(long, value_name = "SEGMENTS", requires = "rust", value_parser = clap::value_parser!(u32).range(2..=10_000))]
    commissioning: Option<u32>,
    /// The model as a C header, for the library of `c-api`
    #[arg(long, value_name = "FILE")]
    c: Option<PathBuf>,
}

/// The contents of the files.
#[derive(Debug)]
pub(crate) struct Exported {
    pub(crate) model: Vec<u8>,
    rust: Option<String>,
    c: Option<String>,
}

impl ExportArgs {
    /// The files that are written.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        [Some(self.model.as_path()), self.rust.as_deref(), self.c.as_deref()].into_iter().flatten()
    }

    /// The contents of the files: the model, and the sources by these functions if they are wanted; that of Rust takes
    /// the segments of a commissioning.
    pub(crate) fn exported(
        &self,
        model: Vec<u8>,
        rust: impl FnOnce(Option<u32>) -> Result<String, Error>,
        c: impl FnOnce() -> Result<String, Error>,
    ) -> Result<Exported, Error> {
        let rust = self.rust.as_ref().map(|_| rust(self.commissioning)).transpose()?;
        Ok(Exported { model, rust, c: self.c.as_ref().map(|_| c()).transpose()? })
    }

    /// The files with their contents.
    pub(crate) fn contents<'a>(&'a self, exported: &'a Exported) -> Vec<(&'a Path, &'a [u8])> {
        let texts = [(&self.rust, &exported.rust), (&self.c, &exported.c)];
        let texts = texts.into_iter().filter_map(|(path, text)| Some((path.as_deref()?, text.as_ref()?.as_bytes())));
        texts.chain([(self.model.as_path(), exported.model.as_slice())]).collect()
    }
}
