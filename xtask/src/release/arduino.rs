//! The archive as a library of the Arduino IDE: its sketch, compiled as the IDE does, with stand-ins of the core.

use std::fs;
use std::process::Command;

use anyhow::{Result, ensure};

use super::{manifests, user};
use crate::board::{DRIVE, DRIVE_FLAGS};
use crate::newcomer::Folder;
use crate::newcomer::outcome::same_classes;
use crate::target::on_host;
use crate::{child, qemu, workspace};

/// The place of the sketch in the archive.
const SKETCH: &str = "examples/BearingWatch";
/// The core.
const STAND_INS: &str = "c-api/tests/arduino";

/// The sketch must print the verdicts of the Rust example on the host.
pub fn sketch() -> Result<String> {
    let (root, folder) = (workspace::root(), Folder::new("arduino")?);
    user::unpacked(folder.path())?;
    let archive = folder.path().join(user::UNPACKED);
    let sketch = archive.join(SKETCH);
    // The IDE puts the header of the core before the sketch.
    let text = fs::read_to_string(sketch.join("BearingWatch.ino"))?;
    fs::write(folder.path().join("sketch.cpp"), format!("#include <Arduino.h>\n{text}"))?;
    let flags = |program: &str| {
        let mut command = Command::new(program);
        command.args(DRIVE_FLAGS).args(["-O2", "-Wall", "-Wextra", "-Werror", "-ffunction-sections"]);
        for include in [&archive.join("src"), &sketch, &root.join(STAND_INS), &root.join("c-api/examples")] {
            command.arg("-I").arg(include);
        }
        command.current_dir(folder.path());
        command
    };
    let (core, examples) = (root.join(STAND_INS).join("core.cpp"), root.join("c-api/examples"));
    let mut cpp = flags("arm-none-eabi-g++");
    cpp.args(["-std=gnu++17", "-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics", "-c", "sketch.cpp"]);
    child::succeed(cpp.arg(core))?;
    let mut link = flags("arm-none-eabi-gcc");
    link.args(["--specs=nano.specs", "--specs=rdimon.specs", "-nostartfiles"]);
    link.args(["-Wl,--gc-sections,-z,noexecstack,--no-warn-rwx-segments", "sketch.o", "core.o"]);
    link.arg("-T").arg(examples.join("stm32f405.ld")).args([examples.join("board.c"), examples.join("held_out.s")]);
    link.arg(format!("-Wa,-I{}", root.join("examples/support/standard_rig").display()));
    let [precompiled, _] = manifests::ARDUINO;
    link.arg("-L").arg(archive.join("src").join(precompiled)).args(["-lbearing_watch_c", "-lm", "-o", "sketch"]);
    child::succeed(&mut link)?;
    let lines = qemu::run(&folder.path().join("sketch"), DRIVE.machine, qemu::Echo::Off)?;
    let verdicts = user::classes(&lines);
    ensure!(verdicts.len() == lines.len(), "{lines:?}");
    same_classes(&user::classes(&on_host("monitor")?), &verdicts)
}
