//! Runs firmware in the emulator: output by semihosting, repeatable time, and an end in any case.

use std::io::Read;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use super::board::{Board, RISCV};
use super::elf;
use crate::{cargo, child};

/// Far above what any example takes; firmware for another core prints nothing and does not end.
const PATIENCE: Duration = Duration::from_secs(300);

/// Runs an ELF file on a board and returns its lines, decoded where it logs by `defmt`. Fails when it does not end by
/// itself, or ends with a failing status.
pub fn run(elf: &Path, board: Board) -> Result<Vec<String>> {
    run_in(Path::new("."), elf, board)
}

/// The same in a folder, whose files the firmware reads by semihosting.
pub fn run_in(folder: &Path, elf: &Path, board: Board) -> Result<Vec<String>> {
    within(&mut emulator(folder, elf, board, "")?, PATIENCE, decoder(elf)?, None).with_context(|| title(elf, board))
}

/// Runs one test of a program for probe-rs, which gets its address as words of a command line.
pub fn run_test(elf: &Path, board: Board, address: &str) -> Result<Vec<String>> {
    let words = format!(",arg=run_addr,arg={address}");
    within(&mut emulator(Path::new("."), elf, board, &words)?, PATIENCE, None, None).with_context(|| title(elf, board))
}

/// Runs an ELF file by a command that takes it as its last argument, as cargo calls a runner.
pub fn run_by(runner: &mut Command, elf: &Path) -> Result<Vec<String>> {
    within(runner.arg(std::path::absolute(elf)?), PATIENCE, None, None).with_context(|| format!("{runner:?}"))
}

/// Takes the lines of the log of the emulator.
type Log<'a> = &'a mut (dyn FnMut(&str) -> Result<()> + Send);

/// Runs a program, and hands over the lines of the log of the emulator: the instructions of every translated block, and
/// every block that is executed.
pub fn trace(folder: &Path, elf: &Path, board: Board, log: Log<'_>) -> Result<Vec<String>> {
    let mut command = emulator(folder, elf, board, "")?;
    command.args(["-d", "in_asm,exec,nochain"]).stderr(Stdio::piped());
    within(&mut command, PATIENCE, None, Some(log)).with_context(|| title(elf, board))
}

/// A call of the emulator, with further words of the configuration of semihosting.
fn emulator(folder: &Path, elf: &Path, board: Board, words: &str) -> Result<Command> {
    let mut emulator = Command::new("qemu-system-arm");
    let mut hosting = format!("enable=on,target=native{words}");
    if board == RISCV {
        // Its output by semihosting is not that of the console.
        emulator = Command::new("qemu-system-riscv32");
        emulator.args(["-bios", "none", "-serial", "none", "-monitor", "none", "-chardev", "stdio,id=out"]);
        hosting += ",chardev=out";
    }
    emulator.current_dir(folder).args(["-machine", board.machine, "-semihosting-config", &hosting]);
    emulator.args(if board == RISCV { ["-display", "none"].as_slice() } else { &["-nographic"] });
    // Every instruction takes 2⁸ ns of emulated time: the count of instructions is exact.
    emulator.args(["-icount", "shift=8", "-kernel"]).arg(std::path::absolute(elf)?);
    Ok(emulator)
}

fn title(elf: &Path, board: Board) -> String {
    format!("{} on {}", elf.file_stem().unwrap_or_default().to_string_lossy(), board.machine)
}

/// The decoder for the frames of firmware that logs by `defmt`, a program of its own.
fn decoder(elf: &Path) -> Result<Option<Command>> {
    if !elf::has_section(elf, ".defmt").unwrap_or(false) {
        return Ok(None);
    }
    let mut decoder = cargo::program("--bin", "log-decoder")?;
    decoder.arg(std::path::absolute(elf)?);
    Ok(Some(decoder))
}

fn within(
    command: &mut Command,
    patience: Duration,
    decoder: Option<Command>,
    log: Option<Log<'_>>,
) -> Result<Vec<String>> {
    let mut emulator = child::start(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    let mut output = emulator.0.stdout.take().context("the emulator has no output")?;
    let mut behind = None;
    if let Some(mut decoder) = decoder {
        let mut started = child::start(decoder.stdin(output).stdout(Stdio::piped()))?;
        output = started.0.stdout.take().context("the decoder has no output")?;
        behind = Some(started);
    }
    let (reader, receiver) = read(output);
    let stderr = emulator.0.stderr.take();
    let (status, logged) = thread::scope(|scope| {
        let logging = log.zip(stderr).map(|(line, log)| scope.spawn(move || each(log, line)));
        (wait(&mut emulator.0, patience), logging.map_or(Ok(Ok(())), |logging| logging.join()))
    });
    logged.ok().context("the reader panicked")??;
    if status.is_ok() {
        reader.join().ok().context("the reader panicked")??;
        if let Some(mut decoder) = behind {
            ensure!(decoder.0.wait()?.success(), "the lines of the firmware cannot be decoded");
        }
    }
    let lines: Vec<String> = receiver.try_iter().collect();
    let last = || lines.last().map_or_else(|| "it printed nothing".to_owned(), |line| format!("its last line: {line}"));
    let status = status.with_context(last)?;
    ensure!(status.success(), "the firmware failed ({status}); {}", last());
    Ok(lines)
}

/// Hands over the lines of a stream, which is read to its end also after an error.
fn each(stream: impl Read, line: Log<'_>) -> Result<()> {
    let mut outcome = Ok(());
    child::split(stream, |text| {
        if outcome.is_ok() {
            outcome = line(text);
        }
    })?;
    outcome
}

/// Reads lines on a thread, which must not hold up the clock of the emulator, and ends with its output.
fn read(output: ChildStdout) -> (JoinHandle<Result<()>>, Receiver<String>) {
    let (sender, receiver) = mpsc::channel();
    let reader = thread::spawn(move || {
        child::split(output, |line| {
            let _receiver_gone = sender.send(line.to_owned());
        })
    });
    (reader, receiver)
}

fn wait(child: &mut Child, patience: Duration) -> Result<ExitStatus> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if start.elapsed() > patience {
            child.kill()?;
            child.wait()?;
            bail!("no end after {} s: stopped", patience.as_secs_f32());
        }
        thread::sleep(Duration::from_millis(5));
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_fails_or_has_no_end_is_an_error_with_its_last_line() {
        let shell = |script: &str, ms| {
            let outcome = within(Command::new("sh").args(["-c", script]), Duration::from_millis(ms), None, None);
            outcome.map_err(|error| format!("{error:#}"))
        };
        assert_eq!(shell("echo a; printf b", 20_000), Ok(vec!["a".to_owned(), "b".to_owned()]));
        assert!(shell("echo bad; exit 1", 20_000).is_err_and(|text| text.contains("its last line: bad")));
        assert!(shell("echo before; exec sleep 30", 300).is_err_and(|text| text.contains("no end after 0.3 s")));
    }
}
