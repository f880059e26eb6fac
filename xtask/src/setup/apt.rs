//! apt with a state of its own below the target directory: it reads the system's sources, keys and list of packages,
//! and writes nothing outside.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use super::{stanza, unpacked};
use crate::child;

const INSTALLED: &str = "/var/lib/dpkg/status";

/// What is not unpacked: a program starts with the loader of the system, and with no other library of C than its own.
const OF_THE_SYSTEM: [&str; 2] = ["libc6_", "libc-bin_"];

/// Hooks of the system, which would write outside, and what is not read.
const SETTINGS: &str = r#"
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
#clear DPkg::Post-Invoke;
Acquire::IndexTargets::deb::DEP-11::DefaultEnabled "false";
Acquire::IndexTargets::deb::Contents-deb::DefaultEnabled "false";
Acquire::Languages "none";
// An address that does not answer ends the command in its first minute.
Acquire::Retries "1";
Acquire::http::Timeout "10";
Acquire::https::Timeout "10";
APT::Get::Assume-Yes "true";
APT::Get::allow-change-held-packages "true";
APT::Get::allow-downgrades "true";
APT::Get::allow-remove-essential "true";
APT::Install-Recommends "false";
APT::Keep-Downloaded-Packages "true";
APT::Sandbox::User "root";
Debug::NoLocking "true";
"#;

/// The private state.
pub struct Apt {
    folder: PathBuf,
    /// Why a source could not be read, if one could not.
    unread: Option<String>,
}

/// Packages that are fetched for a need.
#[derive(Debug, PartialEq, Eq)]
pub struct Plan {
    /// Names of their files.
    files: Vec<String>,
    bytes: u64,
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} packages, {:.0} MB", self.files.len(), self.bytes as f64 / 1e6)
    }
}

impl Apt {
    /// Makes the state and reads the lists of the system's sources.
    pub fn new() -> Result<Self> {
        let mut apt = Self { folder: unpacked::folder().join("apt"), unread: None };
        for folder in ["lists/partial", "none/partial"] {
            fs::create_dir_all(apt.folder.join(folder)).with_context(|| apt.folder.display().to_string())?;
        }
        let place = apt.folder.display();
        let settings = format!(
            "Dir::State \"{place}\";\nDir::State::lists \"{place}/lists\";\nDir::State::status \"{place}/status\";\n\
             Dir::Cache \"{place}\";\nDir::Cache::archives \"{place}/none\";\n{SETTINGS}"
        );
        fs::write(apt.configuration(), settings)?;
        apt.write_status(&apt.folder.join("status"), &[], &BTreeSet::new())?;
        eprintln!("reading the lists of packages");
        let update = child::captured(apt.call("apt-get").args(["--quiet", "update"]))?;
        // A source of another project may be out of reach; it matters if what is missing is not in the others.
        let messages = String::from_utf8_lossy(&update.stderr);
        apt.unread =
            messages.lines().find(|line| line.starts_with("E: ") || line.contains("Failed to fetch")).map(Into::into);
        Ok(apt)
    }

    fn configuration(&self) -> PathBuf {
        self.folder.join("apt.conf")
    }

    fn call(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.arg("--config-file").arg(self.configuration());
        // Messages are read.
        command.env("LC_ALL", "C");
        command
    }

    fn write_status(&self, file: &Path, wanted: &[&str], sources: &BTreeSet<String>) -> Result<()> {
        let installed = fs::read(INSTALLED).with_context(|| format!("cannot read {INSTALLED}"))?;
        fs::write(file, stanza::reduced(&String::from_utf8_lossy(&installed), wanted, sources))?;
        Ok(())
    }

    /// `apt-get install` with the list of installed packages that this need has to see.
    fn install(&self, name: &str) -> Command {
        let mut install = self.call("apt-get");
        install.arg("install").arg("-o").arg(format!("Dir::State::status={}", self.status(name).display()));
        install
    }

    fn status(&self, name: &str) -> PathBuf {
        self.folder.join(format!("status-{name}"))
    }

    /// The packages with what they need and the system does not have.
    pub fn plan(&self, name: &str, packages: &[&str]) -> Result<Plan> {
        let shown = child::output(self.call("apt-cache").args(["show", "--no-all-versions"]).args(packages));
        let shown = shown.with_context(|| match &self.unread {
            Some(reason) => format!("the lists of packages cannot be read: {reason}"),
            None => format!("the system's sources do not have {}", packages.join(", ")),
        })?;
        self.write_status(&self.status(name), packages, &stanza::sources(&shown))?;
        let listed = child::captured(self.install(name).arg("--print-uris").args(packages))?;
        if !listed.status.success() {
            bail!("{}", complaint(&String::from_utf8_lossy(&listed.stderr)));
        }
        let plan = read(&String::from_utf8_lossy(&listed.stdout));
        ensure!(!plan.files.is_empty(), "apt-get names no package");
        Ok(plan)
    }

    /// Fetches the packages of a plan, checked by apt; returns their files.
    pub fn fetch(&self, name: &str, packages: &[&str], plan: &Plan) -> Result<Vec<PathBuf>> {
        let archives = self.archives(name);
        fs::create_dir_all(archives.join("partial"))?;
        let mut fetch = self.install(name);
        fetch.args(["--download-only", "--quiet", "--quiet"]);
        fetch.arg("-o").arg(format!("Dir::Cache::archives={}", archives.display()));
        child::succeed(fetch.args(packages))?;
        let files: Vec<PathBuf> = plan.files.iter().map(|file| archives.join(file)).collect();
        if let Some(absent) = files.iter().find(|file| !file.is_file()) {
            bail!("apt-get did not fetch {}", absent.display());
        }
        Ok(files)
    }

    fn archives(&self, name: &str) -> PathBuf {
        self.folder.join(format!("archives-{name}"))
    }

    /// Removes what was fetched for a need.
    pub fn forget(&self, name: &str) -> Result<()> {
        fs::remove_dir_all(self.archives(name))?;
        fs::remove_file(self.status(name))?;
        Ok(())
    }
}

/// Reads lines `'https://…' NAME_VERSION_ARCHITECTURE.deb BYTES SHA256:…`.
fn read(listed: &str) -> Plan {
    let lines = listed.lines().filter(|line| line.starts_with('\''));
    let mut plan = Plan { files: Vec::new(), bytes: 0 };
    for line in lines {
        let mut words = line.split(' ').skip(1);
        if let (Some(file), Some(Ok(bytes))) = (words.next(), words.next().map(str::parse::<u64>))
            && !OF_THE_SYSTEM.iter().any(|start| file.starts_with(start))
        {
            plan.files.push(file.to_owned());
            plan.bytes += bytes;
        }
    }
    plan
}

/// The errors among apt's messages.
fn complaint(messages: &str) -> String {
    let errors: Vec<&str> = messages.lines().filter_map(|line| line.strip_prefix("E: ")).collect();
    if errors.is_empty() { messages.trim().to_owned() } else { errors.join("; ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_bytes_are_read_from_the_list() {
        let plan = read(
            "Reading package lists...\nThe following packages will be REMOVED:\n  qemu-utils\n\
             'https://host/libc6_2.36_amd64.deb' libc6_2.36_amd64.deb 2700000 SHA256:00\n\
             'https://host/a_1%3a1_amd64.deb' a_1%3a1_amd64.deb 1500000 SHA256:00\n'https://host/b' b_2_all.deb 700000 \n",
        );
        assert_eq!(plan.files, ["a_1%3a1_amd64.deb", "b_2_all.deb"]);
        assert_eq!(plan.to_string(), "2 packages, 2 MB");
    }

    #[test]
    fn errors_are_told_apart_from_warnings() {
        assert_eq!(complaint("W: old\nE: Unable to locate package x\n"), "Unable to locate package x");
        assert_eq!(complaint(" unlike anything \n"), "unlike anything");
    }
}
