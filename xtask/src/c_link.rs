//! Programs in C with and without the library: what it adds to their flash, and that they keep the functions of their
//! own C library.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::board::DRIVE_FLAGS;
use crate::{child, elf, workspace};

/// Most bytes of flash that a whole drive adds to a program in C: front end, shaft of four orders, alarm. What a
/// segment would have seen, checks of the signals, offsets that last and liveness take 10 kB of it.
const MOST_OF_A_DRIVE: u64 = 78_000;

/// Functions that Rust brings along too.
const SHARED: [&str; 4] = ["sinf", "cosf", "memcpy", "__aeabi_dmul"];

/// What the linker gets for sizes.
const LAST: &[&str] = &["PROGRAM", "-lm", "-lc", "LIBRARY"];

/// The linkers, and what each gets; `LIBRARY` stands for the one that is checked.
const ORDERS: [(&str, &[&str]); 5] = [
    ("gcc", &["PROGRAM", "-lm", "-lc", "LIBRARY"]),
    ("gcc", &["PROGRAM", "LIBRARY", "-lm", "-lc"]),
    ("gcc", &["-Wl,--start-group", "LIBRARY", "-lm", "-lc", "PROGRAM", "-Wl,--end-group"]),
    ("g++", &["PROGRAM", "LIBRARY"]),
    ("g++", &["LIBRARY", "PROGRAM", "LIBRARY"]),
];

/// A program, and the folder of its model.
#[derive(Clone, Copy, Debug)]
struct Program {
    name: &'static str,
    model: &'static str,
}

const BESIDE_NEWLIB: Program = Program { name: "beside_newlib", model: "examples/support/standard_rig" };
const WHOLE_DRIVE: Program = Program { name: "whole_drive", model: "examples/support/actuator" };

/// Links a program with the library in all [`ORDERS`]: its functions of the C library must be those that it has without
/// it. Returns the bytes of flash that the library adds.
pub fn orders(library: &Path) -> Result<String> {
    let place = Place::new("orders", library)?;
    let without = place.alone(BESIDE_NEWLIB)?;
    let (expected, alone) = (sizes(&without)?, elf::sizes(&without)?.flash);
    ensure!(expected.len() == SHARED.len(), "the program has {expected:?} of {SHARED:?}");
    let object = place.compile(BESIDE_NEWLIB, &[])?;
    let mut added = Vec::new();
    for (linker, order) in ORDERS {
        let program = place.link(linker, order, &object)?;
        let linked = sizes(&program)?;
        ensure!(linked == expected, "{linker} {}: {linked:?} instead of {expected:?}", order.join(" "));
        added.push(elf::sizes(&program)?.flash - alone);
    }
    let [least, most] = [added.iter().min(), added.iter().max()].map(|bytes| bytes.copied().unwrap_or_default());
    // Functions have other addresses, and steps between them other lengths.
    ensure!(least > 0 && most - least <= 64, "it adds {least} to {most} bytes");
    Ok(format!("{most} bytes of flash"))
}

/// The bytes of flash that a whole drive adds, and words with the parts of it that take most.
pub fn whole_drive(library: &Path) -> Result<(u64, String)> {
    let place = Place::new("whole_drive", library)?;
    let alone = elf::sizes(&place.alone(WHOLE_DRIVE)?)?.flash;
    let program = place.link("gcc", LAST, &place.compile(WHOLE_DRIVE, &[])?)?;
    let sizes = elf::sizes(&program)?;
    let added = sizes.flash - alone;
    let parts = parts(&elf::parts(&program)?);
    Ok((added, format!("{added} bytes of flash, {} of RAM; {parts}", sizes.ram)))
}

/// The same, if it is within its bound.
pub fn bounded_drive(library: &Path) -> Result<String> {
    let (added, words) = whole_drive(library)?;
    ensure!(added <= MOST_OF_A_DRIVE, "{words}; {MOST_OF_A_DRIVE} are allowed");
    Ok(words)
}

/// Parts with their bytes, the largest first.
fn parts(bytes: &BTreeMap<String, u64>) -> String {
    let mut parts: Vec<(&String, &u64)> = bytes.iter().filter(|(_, bytes)| **bytes >= 1000).collect();
    parts.sort_by_key(|(_, bytes)| std::cmp::Reverse(**bytes));
    parts.iter().map(|(name, bytes)| format!("{name} {bytes}")).collect::<Vec<_>>().join(", ")
}

fn sizes(program: &Path) -> Result<BTreeMap<String, u64>> {
    elf::global_sizes(program, &SHARED)
}

/// Where programs are linked with a library.
struct Place<'a> {
    folder: PathBuf,
    library: &'a Path,
}

impl<'a> Place<'a> {
    fn new(name: &str, library: &'a Path) -> Result<Self> {
        let folder = workspace::target_dir().join("c").join(name);
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        // g++ links with the library of C++, which its package does not have and the program does not need.
        for empty in ["libstdc++.a", "libstdc++_nano.a"] {
            fs::write(folder.join(empty), "!<arch>\n")?;
        }
        Ok(Self { folder, library })
    }

    /// The program without the library.
    fn alone(&self, program: Program) -> Result<PathBuf> {
        self.link("gcc", &["PROGRAM", "-lm", "-lc"], &self.compile(program, &["-DALONE"])?)
    }

    fn compile(&self, program: Program, flags: &[&str]) -> Result<PathBuf> {
        let root = workspace::root();
        let Program { name, model } = program;
        let object = self.folder.join(format!("{name}{}.o", flags.concat()));
        let mut compiler = Command::new("arm-none-eabi-gcc");
        compiler.args(DRIVE_FLAGS).args(["-std=c99", "-Wall", "-Werror", "-O2", "-ffunction-sections"]).args(flags);
        // The library's own header lies beside it.
        compiler.arg("-I").arg(self.library.parent().unwrap_or(&self.folder));
        compiler.arg("-I").arg(root.join("c-api/include")).arg("-I").arg(root.join(model));
        let source = root.join("c-api/tests/chip").join(name).with_extension("c");
        child::succeed(compiler.arg("-c").arg(source).arg("-o").arg(&object))?;
        Ok(object)
    }

    fn link(&self, linker: &str, order: &[&str], object: &Path) -> Result<PathBuf> {
        let program = self.folder.join("program");
        let _none_of_before = fs::remove_file(&program);
        let script = workspace::root().join("c-api/examples/stm32f405.ld");
        let mut command = Command::new(format!("arm-none-eabi-{linker}"));
        command.args(DRIVE_FLAGS).args(["--specs=nano.specs", "-nostartfiles", "-Wl,--gc-sections", "-Wl,-e,main"]);
        command.args(["-Wl,-z,noexecstack", "-Wl,--no-warn-rwx-segments"]);
        command.arg("-L").arg(&self.folder).arg("-T").arg(script);
        for argument in order {
            match *argument {
                "PROGRAM" => command.arg(object),
                "LIBRARY" => command.arg(self.library),
                other => command.arg(other),
            };
        }
        child::succeed(command.arg("-o").arg(&program))?;
        Ok(program)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_kilobyte_are_named_the_largest_first() {
        let bytes = [("shaft", 2000), ("alarm", 999), ("drive", 3000)].map(|(name, bytes)| (name.to_owned(), bytes));
        assert_eq!(parts(&bytes.into()), "drive 3000, shaft 2000");
    }
}
