//! What the static library exports: the functions `bw_…` alone, so that a program which links it calls the functions of
//! its own C library, wherever that comes on the linker's command line.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::board::DRIVE_FLAGS;
use crate::{child, elf, workspace};

/// The name of the library that exports the interface only, beside the one that cargo makes.
const FILE: &str = "libbearing_watch.a";

/// Functions that Rust brings along too.
const SHARED: [&str; 4] = ["sinf", "cosf", "memcpy", "__aeabi_dmul"];

/// The linkers, and what each gets; `LIBRARY` stands for the one that is checked.
const ORDERS: [(&str, &[&str]); 5] = [
    ("gcc", &["PROGRAM", "-lm", "-lc", "LIBRARY"]),
    ("gcc", &["PROGRAM", "LIBRARY", "-lm", "-lc"]),
    ("gcc", &["-Wl,--start-group", "LIBRARY", "-lm", "-lc", "PROGRAM", "-Wl,--end-group"]),
    ("g++", &["PROGRAM", "LIBRARY"]),
    ("g++", &["LIBRARY", "PROGRAM", "LIBRARY"]),
];

/// Makes the library by the script that users call, with the binary utilities of a prefix.
pub fn export(prefix: &str, library: &Path) -> Result<PathBuf> {
    let made = library.with_file_name(FILE);
    let script = workspace::root().join("c-api/export.sh");
    child::succeed(Command::new("sh").arg(script).args([prefix]).args([library, &made]))?;
    Ok(made)
}

/// All global symbols are those of the interface.
pub fn check(library: &Path) -> Result<()> {
    let (functions, others): (Vec<_>, Vec<_>) =
        elf::global_symbols(library)?.into_iter().partition(|name| name.starts_with("bw_"));
    ensure!(functions.iter().any(|name| name == "bw_init"), "no bw_init among {functions:?}");
    ensure!(others.is_empty(), "it defines {}", others.join(", "));
    Ok(())
}

/// Links a program with the library in all [`ORDERS`]: its functions of the C library must be those that it has without
/// it. Returns the bytes of flash that the library adds.
pub fn orders(library: &Path) -> Result<String> {
    let folder = workspace::target_dir().join("c/orders");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    // g++ links with the library of C++, which its package does not have and the program does not need.
    for empty in ["libstdc++.a", "libstdc++_nano.a"] {
        fs::write(folder.join(empty), "!<arch>\n")?;
    }
    let without = link(&folder, "gcc", &["PROGRAM", "-lm", "-lc"], &compile(&folder, &["-DALONE"], library)?, library)?;
    let (expected, alone) = (sizes(&without)?, elf::sizes(&without)?.flash);
    ensure!(expected.len() == SHARED.len(), "the program has {expected:?} of {SHARED:?}");
    let object = compile(&folder, &[], library)?;
    let mut added = Vec::new();
    for (linker, order) in ORDERS {
        let program = link(&folder, linker, order, &object, library)?;
        let linked = sizes(&program)?;
        ensure!(linked == expected, "{linker} {}: {linked:?} instead of {expected:?}", order.join(" "));
        added.push(elf::sizes(&program)?.flash - alone);
    }
    let [least, most] = [added.iter().min(), added.iter().max()].map(|bytes| bytes.copied().unwrap_or_default());
    // Functions have other addresses, and steps between them other lengths.
    ensure!(least > 0 && most - least <= 64, "it adds {least} to {most} bytes");
    Ok(format!("{most} bytes of flash"))
}

fn sizes(program: &Path) -> Result<BTreeMap<String, u64>> {
    elf::global_sizes(program, &SHARED)
}

fn compile(folder: &Path, flags: &[&str], library: &Path) -> Result<PathBuf> {
    let root = workspace::root();
    let object = folder.join(format!("beside_newlib{}.o", flags.concat()));
    let mut compiler = Command::new("arm-none-eabi-gcc");
    compiler.args(DRIVE_FLAGS).args(["-std=c99", "-Wall", "-Werror", "-O2", "-ffunction-sections"]).args(flags);
    // The library's own header lies beside it.
    compiler.arg("-I").arg(library.parent().unwrap_or(folder));
    compiler.arg("-I").arg(root.join("c-api/include")).arg("-I").arg(root.join("examples/support/standard_rig"));
    child::succeed(compiler.arg("-c").arg(root.join("c-api/tests/chip/beside_newlib.c")).arg("-o").arg(&object))?;
    Ok(object)
}

fn link(folder: &Path, linker: &str, order: &[&str], object: &Path, library: &Path) -> Result<PathBuf> {
    let program = folder.join("program");
    let _none_of_before = fs::remove_file(&program);
    let script = workspace::root().join("c-api/examples/stm32f405.ld");
    let mut command = Command::new(format!("arm-none-eabi-{linker}"));
    command.args(DRIVE_FLAGS).args(["--specs=nano.specs", "-nostartfiles", "-Wl,--gc-sections", "-Wl,-e,main"]);
    command.args(["-Wl,-z,noexecstack", "-Wl,--no-warn-rwx-segments"]).arg("-L").arg(folder).arg("-T").arg(script);
    for argument in order {
        match *argument {
            "PROGRAM" => command.arg(object),
            "LIBRARY" => command.arg(library),
            other => command.arg(other),
        };
    }
    child::succeed(command.arg("-o").arg(&program))?;
    Ok(program)
}
