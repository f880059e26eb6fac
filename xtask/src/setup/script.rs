//! Scripts that start unpacked programs: with the search path of their libraries, and with their fonts. Only these
//! programs look there.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::need::Need;
use super::{os, unpacked};

/// Writes a script that starts a program with these variables.
pub fn write(script: &Path, program: &Path, settings: &str) -> Result<()> {
    let text = format!("#!/bin/sh\n{settings}exec {} \"$@\"\n", quoted(program));
    fs::write(script, text).with_context(|| script.display().to_string())?;
    os::make_executable(script)
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

    use super::*;
    use crate::child;

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
}
