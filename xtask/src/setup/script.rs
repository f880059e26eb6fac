//! Scripts that start unpacked programs: with the search path of their libraries, and with their fonts. Only these
//! programs look there.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::need::Need;
use super::{os, unpacked};

/// Writes a script that starts a program with these variables.
pub fn write(script: &Path, program: &Path, settings: &str) -> Result<()> {
    write_with(script, program, settings, "")
}

/// The same with these words before the arguments of the script.
fn write_with(script: &Path, program: &Path, settings: &str, words: &str) -> Result<()> {
    let text = format!("#!/bin/sh\n{settings}exec {}{words} \"$@\"\n", quoted(program));
    fs::write(script, text).with_context(|| script.display().to_string())?;
    os::make_executable(script)
}

/// Writes a script that starts the unpacked compiler, whose library is in the folder `sysroot`. The script names that
/// folder by a way that is in no workspace. By its plain name it is inside of this one and outside of all others, where
/// cargo calls it by different names, and each workspace would compile `core` again for the same target directory.
pub fn write_compiler(script: &Path, program: &Path, settings: &str, sysroot: &Path) -> Result<()> {
    let outside = Path::new("/proc/self/root").join(sysroot.strip_prefix("/").unwrap_or(sysroot));
    write_with(script, program, settings, &format!(" --sysroot {}", quoted(&outside)))
}

/// Writes a script that starts another program as an unpacked one is started. Whether the unpacked one is in use.
pub fn write_like(need: &Need, name: &str, program: &Path, script: &Path) -> Result<bool> {
    if !unpacked::programs().join(name).is_symlink() {
        return Ok(false);
    }
    let text = fs::read_to_string(unpacked::program(need, name))?;
    let settings: String =
        text.lines().filter(|line| line.starts_with("export ")).map(|line| format!("{line}\n")).collect();
    // It may be a link to the program.
    let _ = fs::remove_file(script);
    write(script, program, &settings)?;
    Ok(true)
}

/// The variables of the programs of a folder.
pub fn settings(need: &Need, part: &Path, libraries: &[PathBuf]) -> Result<String> {
    let mut text = String::new();
    if !libraries.is_empty() {
        let folders: Vec<String> = libraries.iter().map(|own| quoted(&unpacked::root(need).join(own))).collect();
        text += &format!("export LD_LIBRARY_PATH={}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\n", folders.join(":"));
    }
    let fonts = part.join("usr/share/fonts");
    if fonts.is_dir() {
        // The configuration of the packages names folders of the system only.
        let own = unpacked::root(need).join("usr/share/fonts");
        let cache = unpacked::root(need).join("cache");
        fs::write(
            part.join("fonts.conf"),
            FONTS.replace("OWN", &own.display().to_string()).replace("CACHE", &cache.display().to_string()),
        )?;
        text += &format!("export FONTCONFIG_FILE={}\n", quoted(&unpacked::root(need).join("fonts.conf")));
    }
    Ok(text)
}

/// What Chromium needs to draw text.
const FONTS: &str = r#"<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">
<fontconfig>
  <dir>/usr/share/fonts</dir>
  <dir>OWN</dir>
  <cachedir>CACHE</cachedir>
</fontconfig>
"#;

/// A path as a word of the shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

#[cfg(all(test, unix))]
mod tests {
    use std::process::Command;

    use anyhow::bail;

    use super::*;
    use crate::{child, workspace};

    #[test]
    fn a_script_sets_variables_and_passes_arguments_on() -> Result<()> {
        let root = unpacked::folder_for("it's")?;
        fs::create_dir_all(root.join("bin"))?;
        let program = root.join("show");
        fs::write(&program, "#!/bin/sh\necho $OWN \"$2\"\n")?;
        os::make_executable(&program)?;
        write(&root.join("bin/show"), &program, "export OWN=set\n")?;
        let printed = child::output(Command::new(root.join("bin/show")).args(["a", "b  c"]));
        assert_eq!(printed.as_deref(), Some("set b  c"));
        fs::remove_dir_all(root)?;
        Ok(())
    }

    #[test]
    fn the_compiler_s_library_is_the_same_folder_outside_of_the_workspace() -> Result<()> {
        let root = unpacked::folder_for("sysroot")?;
        let program = root.join("rustc");
        fs::write(&program, "#!/bin/sh\necho $1\necho $2\necho $3\n")?;
        os::make_executable(&program)?;
        write_compiler(&root.join("script"), &program, "", &root)?;
        let printed = child::output(Command::new(root.join("script")).arg("--version")).unwrap_or_default();
        let [option, sysroot, argument] = printed.lines().collect::<Vec<_>>()[..] else { bail!("{printed}") };
        assert_eq!((option, argument), ("--sysroot", "--version"));
        assert!(!Path::new(sysroot).starts_with(workspace::root()), "{sysroot}");
        assert!(Path::new(sysroot).join("rustc").is_file(), "{sysroot}");
        fs::remove_dir_all(root)?;
        Ok(())
    }
}
