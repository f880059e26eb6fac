//! The alias `demo`, as `.cargo/config.toml` has it.

use std::fs;

use anyhow::{Context, Result};

use crate::workspace;

/// The arguments of cargo.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alias {
    /// What is built: the options of `cargo run`.
    pub options: Vec<String>,
    /// What the program is called with.
    pub arguments: Vec<String>,
}

impl Alias {
    /// Reads the configuration.
    pub fn demo() -> Result<Self> {
        let text = fs::read_to_string(workspace::root().join(".cargo/config.toml"))?;
        Self::read(&text).context("the configuration of cargo has no line `demo = \"run …\"`")
    }

    fn read(text: &str) -> Option<Self> {
        let line = text.lines().find_map(|line| line.strip_prefix("demo = \"run "))?;
        let mut words = line.split('"').next()?.split_whitespace().map(ToOwned::to_owned);
        let options = words.by_ref().take_while(|word| word != "--").collect();
        Some(Self { options, arguments: words.collect() })
    }

    /// The folder of the profile in the target directory.
    pub fn profile(&self) -> &str {
        let named = self.options.iter().skip_while(|word| *word != "--profile").nth(1);
        match named.map(String::as_str) {
            Some("dev") => "debug",
            Some(name) => name,
            None if self.options.iter().any(|word| word == "--release") => "release",
            None => "debug",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_arguments_are_those_of_the_line() -> Result<()> {
        let alias = Alias::read("[alias]\ndemo = \"run --release --package a -- demo x\"\n").context("no alias")?;
        assert_eq!(alias.options, ["--release", "--package", "a"]);
        assert_eq!(alias.arguments, ["demo", "x"]);
        assert_eq!(alias.profile(), "release");
        Ok(())
    }

    #[test]
    fn a_profile_has_its_folder() {
        let folder =
            |options: &str| Alias::read(&format!("demo = \"run {options}\"")).map(|own| own.profile().to_owned());
        assert_eq!(folder("--profile dev -- x").as_deref(), Some("debug"));
        assert_eq!(folder("--profile quick").as_deref(), Some("quick"));
        assert_eq!(folder("--bin x").as_deref(), Some("debug"));
    }

    #[test]
    fn the_repository_has_the_alias() -> Result<()> {
        // Without a package: features of the default members together are those with which the tests are built.
        assert_eq!(Alias::demo()?.options, ["--bin", "bearing-watch-studies"]);
        Ok(())
    }
}
