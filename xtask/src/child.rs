//! Running other programs: pass their lines through while reading them, and say plainly what failed.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::process::{Command, ExitStatus, Output, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::processes::{self, Started};
use crate::setup::unpacked;

/// Starts a program: with what was set up on its search path, and so that it ends with this one.
pub fn start(command: &mut Command) -> Result<Started> {
    processes::spawn(prepared(command))
}

/// The same for another run of this program.
pub fn start_own(command: &mut Command) -> Result<Started> {
    processes::spawn_own(prepared(command))
}

fn prepared(command: &mut Command) -> &mut Command {
    let own = command.get_envs().any(|(name, _)| name == "PATH");
    if own { command } else { command.env("PATH", search_path()) }
}

/// Runs to the end and hands over every line of standard output as it comes. Standard error goes
/// straight to the user.
pub fn lines(command: &mut Command, mut each: impl FnMut(&str)) -> Result<ExitStatus> {
    let mut started = start(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    if let Some(output) = started.0.stdout.take() {
        split(output, |line| each(line))?;
    }
    end(&mut started, command)
}

/// Waits for the end.
fn end(started: &mut Started, command: &Command) -> Result<ExitStatus> {
    started.0.wait().with_context(|| format!("lost sight of {}", name(command)))
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
    let status = status(command.stdout(io::stderr()))?;
    if !status.success() {
        bail!("{} failed ({status})", name(command));
    }
    Ok(())
}

/// Runs to the end without input.
pub fn status(command: &mut Command) -> Result<ExitStatus> {
    let mut started = start(command.stdin(Stdio::null()))?;
    end(&mut started, command)
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
    status(command.stdout(Stdio::null()).stderr(Stdio::null())).is_ok_and(|status| status.success())
}

/// What the program prints, without the last line break; nothing if it fails.
pub fn output(command: &mut Command) -> Option<String> {
    let Output { status, stdout, .. } = captured(command).ok()?;
    let text = String::from_utf8(stdout).ok()?;
    status.success().then(|| text.trim_end().to_owned())
}

/// Runs to the end and returns what was printed on both streams.
pub fn captured(command: &mut Command) -> Result<Output> {
    let mut started = start(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()))?;
    let (out, errors) = (started.0.stdout.take(), started.0.stderr.take());
    // Both at once: a program waits while one of its pipes is full.
    let reader = thread::spawn(move || all(errors));
    let stdout = all(out)?;
    let stderr = reader.join().ok().context("the reader panicked")??;
    Ok(Output { status: end(&mut started, command)?, stdout, stderr })
}

fn all(stream: Option<impl Read>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.map(|mut stream| stream.read_to_end(&mut bytes)).transpose()?;
    Ok(bytes)
}

/// Whether a program of this name is on the search path.
pub fn on_path(program: &str) -> bool {
    env::split_paths(&search_path()).any(|folder| folder.join(program).is_file())
}

/// The search path of the programs that are started: first what was unpacked, which is there only where nothing
/// installed serves.
pub fn search_path() -> OsString {
    let path = path_of_the_system();
    let own = unpacked::programs();
    let folders = own.is_dir().then_some(own).into_iter().chain(env::split_paths(&path));
    env::join_paths(folders).unwrap_or(path)
}

/// The search path without what was unpacked, which is on it if another run has started this one.
pub fn path_of_the_system() -> OsString {
    let (path, own) = (env::var_os("PATH").unwrap_or_default(), unpacked::programs());
    env::join_paths(env::split_paths(&path).filter(|folder| *folder != own)).unwrap_or(path)
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
