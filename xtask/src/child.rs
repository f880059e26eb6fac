//! Runs other programs: passes their lines through while reading them, and says plainly what failed. They are in the
//! process group of this one, which the signals of a terminal end as a whole.

use std::env;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread;

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// A program that was started. Whoever lets go of one that still runs, as after an error, ends it.
#[derive(Debug)]
pub struct Started(pub Child);

impl Drop for Started {
    fn drop(&mut self) {
        // An error means that it has ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a program with what was set up on its search path.
pub fn start(command: &mut Command) -> Result<Started> {
    if !command.get_envs().any(|(name, _)| name == "PATH") {
        command.env("PATH", search_path());
    }
    Ok(Started(command.spawn().with_context(|| format!("cannot start {}", name(command)))?))
}

/// Runs to the end and hands over every line of standard output as it comes. Standard error goes straight to the user.
pub fn lines(command: &mut Command, mut each: impl FnMut(&str)) -> Result<ExitStatus> {
    let mut started = start(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    if let Some(output) = started.0.stdout.take() {
        split(output, |line| each(line))?;
    }
    Ok(started.0.wait()?)
}

/// Cuts a stream into lines; bytes that are not UTF-8 are replaced.
pub fn split(stream: impl Read, mut each: impl FnMut(&str)) -> Result<()> {
    let (mut reader, mut bytes) = (BufReader::new(stream), Vec::new());
    while reader.read_until(b'\n', &mut bytes)? > 0 {
        each(String::from_utf8_lossy(&bytes).trim_end_matches(['\n', '\r']));
        bytes.clear();
    }
    Ok(())
}

/// Runs to the end with all output on standard error, so that a JSON list on standard output stays one; fails unless
/// the program succeeds.
pub fn succeed(command: &mut Command) -> Result<()> {
    let status = start(command.stdin(Stdio::null()).stdout(io::stderr()))?.0.wait()?;
    ensure!(status.success(), "{} failed ({status})", name(command));
    Ok(())
}

/// Runs to the end and returns the lines of standard output; fails unless the program succeeds.
pub fn printed(command: &mut Command) -> Result<Vec<String>> {
    let mut printed = Vec::new();
    let status = lines(command, |line| printed.push(line.to_owned()))?;
    ensure!(status.success(), "{} failed ({status})", name(command));
    Ok(printed)
}

/// Whether the program runs and succeeds; its output is dropped.
pub fn works(command: &mut Command) -> bool {
    captured(command).is_ok_and(|output| output.status.success())
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
    Ok(Output { status: started.0.wait()?, stdout, stderr })
}

fn all(stream: Option<impl Read>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.map(|mut stream| stream.read_to_end(&mut bytes)).transpose()?;
    Ok(bytes)
}

/// Whether a program of this name is on the search path.
pub fn on_path(program: &str) -> bool {
    find(program).is_some()
}

/// The first program of this name on the search path.
pub fn find(program: &str) -> Option<PathBuf> {
    env::split_paths(&search_path()).map(|folder| folder.join(program)).find(|file| file.is_file())
}

/// The search path of the programs that are started: first what was unpacked, which is there only where nothing
/// installed serves.
pub fn search_path() -> OsString {
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = [workspace::debian().join("bin")].into_iter().chain(env::split_paths(&path));
    env::join_paths(folders).unwrap_or(path)
}

/// The command as a user would type it, for messages.
fn name(command: &Command) -> String {
    let program = command.get_program().to_string_lossy();
    let program = program.rsplit('/').next().unwrap_or_default().to_owned();
    command.get_args().fold(program, |line, argument| format!("{line} {}", argument.to_string_lossy()))
}
