//! Running other programs: pass their lines through while reading them, and say plainly what failed.

use std::env;
use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};

/// Runs to the end and hands over every line of standard output as it comes. Standard error goes
/// straight to the user.
pub fn lines(command: &mut Command, mut each: impl FnMut(&str)) -> Result<ExitStatus> {
    let name = name(command);
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().with_context(|| format!("cannot start {name}"))?;
    if let Some(output) = child.stdout.take() {
        split(output, |line| each(line))?;
    }
    child.wait().with_context(|| format!("lost sight of {name}"))
}

/// Cuts a stream into lines; bytes that are not UTF-8 are replaced.
pub fn split(stream: impl Read, mut each: impl FnMut(&str)) -> Result<()> {
    let mut reader = BufReader::new(stream);
    let mut bytes = Vec::new();
    while reader.read_until(b'\n', &mut bytes)? > 0 {
        each(String::from_utf8_lossy(&bytes).trim_end_matches(['\n', '\r']));
        bytes.clear();
    }
    Ok(())
}

/// Runs to the end with all output on standard error, so that a JSON list on standard output stays
/// one; fails unless the program succeeds.
pub fn succeed(command: &mut Command) -> Result<()> {
    let name = name(command);
    let status =
        command.stdin(Stdio::null()).stdout(io::stderr()).status().with_context(|| format!("cannot start {name}"))?;
    if !status.success() {
        bail!("{name} failed ({status})");
    }
    Ok(())
}

/// Runs to the end and returns the lines of standard output; fails unless the program succeeds.
pub fn printed(command: &mut Command) -> Result<Vec<String>> {
    let mut printed = Vec::new();
    let status = lines(command, |line| printed.push(line.to_owned()))?;
    if !status.success() {
        bail!("{} failed ({status})", name(command));
    }
    Ok(printed)
}

/// Whether the program runs and succeeds; its output is dropped.
pub fn works(command: &mut Command) -> bool {
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// What the program prints, without the last line break; nothing if it fails.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim_end().to_owned())
}

/// Whether a program of this name is on the search path.
pub fn on_path(program: &str) -> bool {
    env::var_os("PATH").is_some_and(|path| env::split_paths(&path).any(|folder| folder.join(program).is_file()))
}

/// Processor time of the programs that have ended, and of theirs; unknown without Linux.
pub fn processor_time() -> Option<Duration> {
    // proc_pid_stat(5): `cutime` and `cstime` are fields 16 and 17, in hundredths of a second. The name before field 3
    // is in parentheses, and may have spaces.
    let text = fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(13);
    let mut next = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (next()? + next()?)))
}

/// The command as a user would type it, for messages.
fn name(command: &Command) -> String {
    let program = command.get_program().to_string_lossy();
    let program = program.rsplit('/').next().unwrap_or_default().to_owned();
    command.get_args().fold(program, |line, argument| format!("{line} {}", argument.to_string_lossy()))
}
