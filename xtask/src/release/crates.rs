//! The published crates: their packages, bills of materials, public interface, features, and what their manifests
//! promise of old versions.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::dist::{self, VERSION, copy_of_tree, set_members};
use crate::cargo::{cargo, metadata};
use crate::child;
use crate::firmware::board::{Board, DRIVE, NO_FPU};
use crate::firmware::build::prepare;
use crate::firmware::way::Way;
use crate::python::{CYCLONEDX, HACK, SEMVER_CHECKS, tool};
use crate::report::Tally;
use crate::workspace::{root, target_dir};

/// The core, which is the package of the root.
const CORE: &str = "bearing-watch";

/// Names and folders of the packages that cargo would publish.
fn published() -> Result<Vec<(String, String)>> {
    let mut packages = Vec::new();
    for package in metadata()?.iter().filter(|package| package["publish"].is_null()) {
        let text = |key: &str| package[key].as_str().context("no text").map(ToOwned::to_owned);
        let folder = PathBuf::from(text("manifest_path")?);
        let folder = folder.parent().and_then(|folder| folder.strip_prefix(root()).ok()).context("outside")?;
        for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
            ensure!(root().join(folder).join(file).is_file(), "{} has no {file}", text("name")?);
        }
        packages.push((text("name")?, folder.to_string_lossy().into_owned()));
    }
    packages.sort();
    Ok(packages)
}

/// The folders of the published packages besides the root.
fn members() -> Result<Vec<String>> {
    Ok(published()?.into_iter().map(|(_, folder)| folder).filter(|folder| !folder.is_empty()).collect())
}

/// Makes the packages. Cargo builds each from what is in its package and, for those that are not published yet, from
/// the packages of the others.
pub fn packages() -> Result<String> {
    let packages = published()?;
    let mut cargo = cargo(&["package", "--locked", "--allow-dirty", "--target-dir"]);
    cargo.arg(target_dir()).env_remove("CARGO_TARGET_DIR");
    // As in the workspace's profile, which packages do not have: dependencies that are built already are used.
    cargo.envs([("CARGO_PROFILE_DEV_DEBUG", "false"), ("CARGO_PROFILE_DEV_LTO", "off")]);
    cargo.args(packages.iter().flat_map(|(name, _)| ["--package", name]));
    child::succeed(&mut cargo)?;
    dist::remove("", ".crate")?;
    for (name, _) in &packages {
        let file = format!("{name}-{VERSION}.crate");
        fs::copy(target_dir().join("package").join(&file), dist::folder()?.join(&file))?;
    }
    Ok(packages.into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(", "))
}

/// Bills of materials: the packages that each published crate is built from; of the core with all features. The wheel
/// contains its own, which maturin writes.
pub fn bills(tally: &mut Tally) {
    const ENDING: &str = ".cdx.json";
    let bill = |source: &Path, name: &str, folder: &str| -> Result<String> {
        // In a workspace of this package alone: others would turn on more features of what both use.
        set_members(source, &if folder.is_empty() { vec![] } else { vec![folder.to_owned()] })?;
        let stem = format!("{name}-{VERSION}");
        let mut bill = tool(CYCLONEDX, &["cyclonedx", "--format", "json", "--spec-version", "1.5", "--target", "all"])?;
        bill.args(["--no-build-deps", "--override-filename", &stem]).args((name == CORE).then_some("--all-features"));
        child::succeed(bill.arg("--manifest-path").arg(source.join(folder).join("Cargo.toml")).current_dir(source))?;
        // References contain the place of the copy.
        let text = fs::read_to_string(source.join(folder).join(format!("{stem}.json")))?;
        let text = text.replace(&*source.to_string_lossy(), "/bearing-watch");
        let components = serde_json::from_str::<Value>(&text)?["components"].as_array().map_or(0, Vec::len);
        ensure!(components > 0, "no components");
        fs::write(dist::folder()?.join(format!("{stem}{ENDING}")), text)?;
        Ok(format!("{components} packages"))
    };
    let prepared = || {
        dist::remove("", ENDING)?;
        anyhow::Ok((copy_of_tree("sbom", &members()?)?, published()?))
    };
    match prepared() {
        Ok((source, packages)) => packages.iter().for_each(|(name, folder)| {
            tally.check(&format!("bill of materials of {name}"), bill(&source, name, folder));
        }),
        Err(reason) => tally.check("bills of materials", Err::<&str, _>(reason)),
    }
}

/// The public interface of the core beside that of a revision, or of the newest tag of a release: what breaks programs
/// of users needs another version. The libraries of the workbench serve its command line and the Python package.
pub fn interface(tally: &mut Tally, baseline: Option<&str>) {
    let mut describe = Command::new("git");
    describe.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"]).current_dir(root());
    let Some(revision) = baseline.map(ToOwned::to_owned).or_else(|| child::output(&mut describe)) else {
        return tally.skip("public interface", "there is no release yet (no tag v…): nothing to compare with");
    };
    let compare = || {
        let core = metadata()?.into_iter().find(|package| package["name"] == CORE).context("no core")?;
        let features = core["features"].as_object().context("no features")?.keys();
        let promised = features.filter(|name| !["default", "internals"].contains(&name.as_str())).cloned();
        let features = promised.collect::<Vec<_>>().join(",");
        let mut checks = tool(SEMVER_CHECKS, &["semver-checks", "--package", CORE, "--baseline-rev", &revision])?;
        child::succeed(checks.args(["--only-explicit-features", "--features", &features]))
    };
    tally.check(&format!("public interface beside {revision}"), compare().map(|()| "compatible with its version"));
}

/// Combinations of the core's features, by cargo-hack: none, each, and each pair; for the host, for a chip with and one
/// without floating-point hardware. All features together are a check of `cargo xtask test`.
pub fn features(tally: &mut Tally, way: Way) {
    let check = |board: Option<Board>| -> Result<String> {
        // In a copy whose workspace has the core alone: cargo-hack leaves the choice of the package to cargo, which
        // would take the default members of the workspace, and with them features that they want.
        let source = copy_of_tree("features", &[])?;
        let mut hack = tool(HACK, &["hack", "check", "--lib", "--feature-powerset", "--depth", "2"])?;
        hack.current_dir(&source).env("CARGO_TARGET_DIR", target_dir().join("features/target"));
        if let Some(board) = board {
            prepare(&mut hack, way);
            hack.args(["--target", board.target]);
            hack.args(if way == Way::Debian { &["-Z", "build-std=core,alloc"] as &[&str] } else { &[] });
        }
        let mut list = Command::new(hack.get_program());
        list.args(hack.get_args()).arg("--print-command-list").current_dir(&source);
        let count = child::output(&mut list).map_or(0, |list| list.lines().count());
        ensure!(count > 2, "cargo hack names {count} combinations");
        child::succeed(&mut hack).map(|()| format!("{count} combinations"))
    };
    tally.check("pairs of features on the host", check(None));
    for board in [DRIVE, NO_FPU] {
        let title = format!("pairs of features on {}", board.target);
        match way.hindrance(board.target) {
            Some(hindrance) => tally.missing(&title, &hindrance),
            None => tally.check(&title, check(Some(board))),
        }
    }
}

/// What the manifests promise of old versions: the crates with the lowest versions of their dependencies, and by the
/// lowest version of the compiler.
pub fn oldest(tally: &mut Tally) {
    let check = |mut cargo: Command, folder: &Path, target: &str| -> Result<&'static str> {
        cargo.args(["check", "--locked", "--all-features"]).current_dir(folder);
        cargo.args(published()?.iter().flat_map(|(name, _)| ["--package", name]));
        child::succeed(cargo.env("CARGO_TARGET_DIR", target_dir().join("oldest").join(target)))?;
        Ok("")
    };
    let lowest = || {
        let copy = copy_of_tree("oldest", &members()?)?;
        fs::remove_file(copy.join("Cargo.lock"))?;
        // The option is one of nightly; the variable admits it, and only for this.
        let mut resolve = cargo(&["generate-lockfile", "-Z", "direct-minimal-versions"]);
        child::succeed(resolve.current_dir(&copy).env("RUSTC_BOOTSTRAP", "1"))?;
        check(cargo(&[]), &copy, "target")
    };
    tally.check("the packages with the lowest versions of their dependencies", lowest());
    // The compiler is looked for in the file system, because rustup's own commands may start to download.
    let version = env!("CARGO_PKG_RUST_VERSION");
    let home = env::var_os("RUSTUP_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(Path::new(&env::var_os("HOME")?).join(".rustup"))).unwrap_or_default();
    let folders = home.join("toolchains").read_dir().into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let named = |folder: &PathBuf| folder.file_name().is_some_and(|own| own.to_string_lossy().starts_with(version));
    let title = format!("the packages by rustc {version}");
    match folders.into_iter().find(named) {
        Some(folder) => {
            let mut old = Command::new(folder.join("bin/cargo"));
            old.env("RUSTC", folder.join("bin/rustc")).env_remove("RUSTUP_TOOLCHAIN").env_remove("LD_LIBRARY_PATH");
            tally.check(&title, check(old, &root(), "compiler"));
        }
        None => tally.missing(&title, &format!("rustup toolchain install {version} --profile minimal")),
    }
}

#[test]
fn the_published_packages_have_what_they_need() -> Result<()> {
    assert_eq!(published()?.first().map(|(name, folder)| (name.as_str(), folder.as_str())), Some((CORE, "")));
    Ok(())
}
