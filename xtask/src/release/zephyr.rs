//! The archive as a module of Zephyr: its options by the reader of Zephyr's own builds, and the firmware by CMake with
//! stand-ins of Zephyr's functions.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::user::{self, Recorded};
use crate::newcomer::{Folder, blocks, c, timed};
use crate::tally::Tally;
use crate::target::brief;
use crate::{child, python};

/// The functions of Zephyr that the module calls, for the program `drive`, and the module.
const STAND_INS: &str = "
add_executable(${CMAKE_PROJECT_NAME} main.c recorded_drive.c board.c rows.s)
target_include_directories(${CMAKE_PROJECT_NAME} PRIVATE model)
function(zephyr_include_directories)
    target_include_directories(${CMAKE_PROJECT_NAME} PRIVATE ${ARGV})
endfunction()
function(zephyr_link_libraries)
    target_link_libraries(${CMAKE_PROJECT_NAME} m c ${ARGV})
endfunction()
set(CONFIG_BEARING_WATCH y)
add_subdirectory(../bearing-watch/zephyr zephyr-module)
";

/// What Zephyr reads options with.
const READER: &str = "kconfiglib==14.1.0";
/// The options of the user.
const OPTIONS: &str = "prj.conf";
/// Zephyr's own options that the module depends on, of a Cortex-M4F.
const KCONFIG: &str = "config CPU_CORTEX_M4
\tbool
\tdefault y
config CPU_CORTEX_M7
\tbool
config FPU
\tbool \"Floating-point unit\"
config FP_HARDABI
\tbool \"Numbers in its registers\"
config FPU_SHARING
\tbool \"Registers of each thread\"
osource \"bearing-watch/zephyr/Kconfig\"
";
/// Prints the value of the module's option with the file of the user, and warnings.
const SCRIPT: &str = "import kconfiglib
options = kconfiglib.Kconfig('Kconfig', warn_to_stderr=False)
options.load_config('prj.conf')
print(options.syms['BEARING_WATCH'].str_value, *options.warnings)
";

/// Options and firmware.
pub fn checks(tally: &mut Tally, recorded: &Recorded) {
    tally.check("the archive as a module of Zephyr", brief(timed(|| firmware(recorded))));
    let title = "the module's options, read by kconfiglib";
    match python::with_packages("zephyr", &[READER]) {
        Ok(python) => tally.check(title, brief(options(&python))),
        Err(reason) => tally.missing(title, &format!("{reason:#}")),
    }
}

/// The project by CMake, in which the module takes the place of the library.
fn firmware(recorded: &Recorded) -> Result<String> {
    let folder = Folder::new("zephyr")?;
    let project = user::project(folder.path())?;
    let file = project.join("CMakeLists.txt");
    let text = fs::read_to_string(&file)?;
    let (settings, _) = text.split_once("add_executable(").context("the project has no program")?;
    fs::write(&file, format!("{settings}{STAND_INS}"))?;
    let [.., cmake] = &c::BUILDERS;
    user::built(cmake, &project, recorded)
}

/// The options of the document select the module; without the floating-point unit it cannot be selected.
fn options(python: &Path) -> Result<String> {
    let folder = Folder::new("kconfig")?;
    let blocks = user::unpacked(folder.path())?;
    let text = &blocks::named(&blocks, OPTIONS)?.text;
    fs::write(folder.path().join("Kconfig"), KCONFIG)?;
    let read = |text: &str| -> Result<String> {
        fs::write(folder.path().join(OPTIONS), text)?;
        let mut script = Command::new(python);
        let said = child::output(script.args(["-c", SCRIPT]).current_dir(folder.path()));
        Ok(said.context("the options cannot be read")?.trim().to_owned())
    };
    let (all, without) = (read(text)?, read(&text.replace("CONFIG_FPU=y\n", ""))?);
    ensure!(all == "y", "with {text}: {all}");
    ensure!(without == "n", "without CONFIG_FPU: {without}");
    Ok(String::new())
}
