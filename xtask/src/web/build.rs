//! Builds the program for WebAssembly, either way: by the target of rustup, or by Debian's compiler and the source of
//! its library. Both take clang for the one library in C.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::cargo::cargo as host_cargo;
use crate::firmware::build::prepare;
use crate::firmware::way::Way;
use crate::{child, setup, workspace};

/// The target: a program with files, arguments and standard streams.
pub const TARGET: &str = "wasm32-wasip1";
/// The profile of `Cargo.toml`.
const PROFILE: &str = "web";

/// Builds the program; returns its file.
pub fn program(way: Way) -> Result<PathBuf> {
    let mut cargo = if way == Way::Rustup { host_cargo(&[]) } else { Command::new(setup::of_compiler("cargo")) };
    prepare(&mut cargo, way);
    let folder = workspace::target_dir().join(if way == Way::Rustup { "" } else { "fw" });
    cargo.current_dir(workspace::root()).args(["rustc", "--profile", PROFILE, "--target", TARGET]);
    cargo.args(["--package", "bearing-watch-workbench", "--bin", "bearing-watch"]);
    // The stack of the native program, of which a training takes more than the usual one of WebAssembly.
    let mut flags = vec!["-Clink-arg=-zstack-size=8388608".to_owned()];
    let clang = ["clang-19", "clang"].into_iter().find(|name| child::on_path(name)).context("no clang")?;
    if way == Way::Debian {
        let library = setup::library_of_wasm().context("no C library for WebAssembly")?;
        let linker = child::find("wasm-ld-19").context("no linker wasm-ld-19")?;
        cargo.args(["-Z", "build-std=std,panic_abort"]);
        cargo.args(["--config", &format!("target.{TARGET}.linker = {:?}", linker.display().to_string())]);
        // The start of a program, and its C library, are no part of Debian's compiler.
        flags.extend(["-Clink-self-contained=no".to_owned(), format!("-Lnative={}", library.display())]);
        flags.push(format!("-Clink-arg={}", library.join("crt1-command.o").display()));
        flags.push(format!("-Clink-arg={}", additions(clang, &library)?.display()));
    }
    // Of the program alone: its dependencies do not depend on them.
    cargo.arg("--").args(flags);
    // The library in C has its own headers; those of the compiler must not ask for a C library.
    cargo.env("CC_wasm32_wasip1", clang).env("CFLAGS_wasm32_wasip1", "-ffreestanding");
    if !child::on_path("llvm-ar") {
        cargo.env("AR_wasm32_wasip1", "ar");
    }
    cargo.env("PATH", child::search_path());
    child::succeed(&mut cargo)?;
    let file = folder.join(TARGET).join(PROFILE).join("bearing-watch.wasm");
    ensure!(file.is_file(), "cargo succeeded, but there is no {}", file.display());
    Ok(file)
}

/// Compiles what Debian's C library lacks; returns the object.
fn additions(clang: &str, library: &Path) -> Result<PathBuf> {
    let headers = library.with_file_name("").join("../include/wasm32-wasi");
    let object = workspace::target_dir().join("fw/wasm-libc.o");
    fs::create_dir_all(workspace::target_dir().join("fw"))?;
    let mut compile = Command::new(clang);
    compile.args(["--target=wasm32-wasip1", "-O1", "-c", "-isystem"]).arg(headers).arg("-o").arg(&object);
    child::succeed(compile.arg(workspace::root().join("xtask/wasm-libc.c")))?;
    Ok(object)
}
