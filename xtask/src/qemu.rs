//! Runs firmware in the emulator: output by semihosting, repeatable time, and an end in any case.

use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use crate::{child, log};

/// The emulator.
pub const PROGRAM: &str = "qemu-system-arm";

/// Far above what any example takes; firmware for another core hangs without a word.
const PATIENCE: Duration = Duration::from_secs(300);

/// Whether the firmware's lines also go to standard output as they come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Echo {
    On,
    Off,
}

/// Runs an ELF file on a machine and returns its lines, decoded where it logs by `defmt`. Fails when it does not end by
/// itself, or ends with a failing status.
pub fn run(elf: &Path, machine: &str, echo: Echo) -> Result<Vec<String>> {
    run_in(Path::new("."), elf, machine, echo)
}

/// The same in a folder, whose files the firmware reads by semihosting.
pub fn run_in(folder: &Path, elf: &Path, machine: &str, echo: Echo) -> Result<Vec<String>> {
    let mut emulator = emulator(folder, elf, machine)?;
    within(&mut emulator, PATIENCE, echo, log::decoder(elf)?).with_context(|| title(elf, machine))
}

/// Runs one test of a program for probe-rs, which gets its address as words of a command line.
pub fn run_test(elf: &Path, machine: &str, address: &str) -> Result<Vec<String>> {
    let mut emulator = Command::new(PROGRAM);
    let words = format!("enable=on,target=native,arg=run_addr,arg={address}");
    emulator.args(["-machine", machine, "-nographic", "-semihosting-config", &words, "-icount", "shift=8", "-kernel"]);
    run_by(&mut emulator, elf)
}

/// The same, and hands over the lines of the log of the emulator: the instructions of every translated block, and every
/// block that is executed.
pub fn trace(
    folder: &Path,
    elf: &Path,
    machine: &str,
    mut line: impl FnMut(&str) -> Result<()> + Send,
) -> Result<Vec<String>> {
    let mut command = emulator(folder, elf, machine)?;
    command.args(["-d", "in_asm,exec,nochain"]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut started = child::start(&mut command)?;
    let log = started.0.stderr.take().context("the emulator has no log")?;
    let (printing, receiver) = read(started.0.stdout.take().context("the emulator has no output")?, Echo::Off);
    let (status, outcome) = thread::scope(|scope| {
        let reader = scope.spawn(move || {
            let mut outcome = Ok(());
            child::split(log, |text| {
                if outcome.is_ok() {
                    outcome = line(text);
                }
            })?;
            outcome
        });
        (wait(&mut started.0, PATIENCE), reader.join())
    });
    outcome.ok().context("the reader panicked")?.with_context(|| title(elf, machine))?;
    let status = status.with_context(|| title(elf, machine))?;
    ensure!(status.success(), "{} failed ({status}) in a trace", title(elf, machine));
    printing.join().ok().context("the reader panicked")??;
    Ok(receiver.try_iter().collect())
}

/// Runs a program for RISC-V, whose output by semihosting is not that of the console.
pub fn run_riscv(elf: &Path, machine: &str) -> Result<Vec<String>> {
    let mut emulator = Command::new("qemu-system-riscv32");
    emulator.args(["-machine", machine, "-bios", "none", "-display", "none", "-serial", "none", "-monitor", "none"]);
    emulator.args(["-chardev", "stdio,id=out", "-semihosting-config", "enable=on,target=native,chardev=out"]);
    emulator.args(["-icount", "shift=8", "-kernel"]).arg(elf);
    within(&mut emulator, PATIENCE, Echo::Off, None).with_context(|| title(elf, machine))
}

fn emulator(folder: &Path, elf: &Path, machine: &str) -> Result<Command> {
    let mut emulator = Command::new(PROGRAM);
    emulator
        .current_dir(folder)
        .args(["-machine", machine, "-nographic"])
        .args(["-semihosting-config", "enable=on,target=native"])
        // Every instruction takes 2⁸ ns of emulated time: the count of instructions is exact.
        .args(["-icount", "shift=8"])
        .arg("-kernel")
        .arg(std::path::absolute(elf)?);
    Ok(emulator)
}

fn title(elf: &Path, machine: &str) -> String {
    format!("{} on {machine}", elf.file_stem().unwrap_or_default().to_string_lossy())
}

/// Runs an ELF file by a command that takes it as its last argument, as cargo calls a runner.
pub fn run_by(runner: &mut Command, elf: &Path) -> Result<Vec<String>> {
    runner.arg(std::path::absolute(elf)?);
    within(runner, PATIENCE, Echo::Off, None).with_context(|| format!("{runner:?}"))
}

fn within(command: &mut Command, patience: Duration, echo: Echo, decoder: Option<Command>) -> Result<Vec<String>> {
    let mut emulator = child::start(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    let mut output = emulator.0.stdout.take().context("the emulator has no output")?;
    let mut behind = None;
    if let Some(mut decoder) = decoder {
        let mut started = log::decode(&mut decoder, output)?;
        output = started.0.stdout.take().context("the decoder has no output")?;
        behind = Some(started);
    }
    let (reader, receiver) = read(output, echo);
    let status = wait(&mut emulator.0, patience);
    if status.is_ok() {
        reader.join().ok().context("the reader panicked")??;
        if let Some(mut decoder) = behind {
            ensure!(decoder.0.wait()?.success(), "the lines of the firmware cannot be decoded");
        }
    }
    let lines: Vec<String> = receiver.try_iter().collect();
    let last = || match lines.last() {
        Some(line) => format!("its last line: {line}"),
        None => "it printed nothing".to_owned(),
    };
    let status = status.with_context(last)?;
    if !status.success() {
        bail!("the firmware failed ({status}); {}", last());
    }
    Ok(lines)
}

/// Reads lines on a thread, which must not hold up the clock of the emulator, and ends with its output.
fn read(output: ChildStdout, echo: Echo) -> (JoinHandle<Result<()>>, Receiver<String>) {
    let (sender, receiver) = mpsc::channel();
    let reader = thread::spawn(move || {
        child::split(output, |line| {
            if echo == Echo::On {
                println!("{line}");
            }
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

    fn shell(script: &str, patience: Duration) -> Result<Vec<String>> {
        within(Command::new("sh").args(["-c", script]), patience, Echo::Off, None)
    }

    #[test]
    fn lines_of_a_good_run_come_back() {
        let lines = shell("echo a; printf b", Duration::from_secs(20)).unwrap_or_default();
        assert_eq!(lines, ["a", "b"]);
    }

    #[test]
    fn a_failing_status_is_an_error() {
        let text = shell("echo bad; exit 1", Duration::from_secs(20)).err();
        assert!(text.is_some_and(|e| format!("{e:#}").contains("its last line: bad")));
    }

    #[test]
    fn a_run_without_end_is_stopped() {
        let start = Instant::now();
        let text = shell("echo before; exec sleep 30", Duration::from_millis(300)).err();
        assert!(start.elapsed() < Duration::from_secs(20));
        assert!(text.is_some_and(|e| {
            let text = format!("{e:#}");
            text.contains("no end after 0.3 s") && text.contains("before")
        }));
    }
}
