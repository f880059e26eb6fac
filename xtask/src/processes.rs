//! The programs that this one has started: each in a process group of its own, and a signal that ends this program ends
//! all of them, with those that they have started.

use std::process::{Child, Command};
use std::sync::Mutex;
use std::time::Duration;

use anyhow::{Context, Result};

/// Starts a program in a process group of its own.
pub fn spawn(command: &mut Command) -> Result<Started> {
    start(command, imp::PATIENCE)
}

/// The same for a program that itself ends what it has started, and takes time for it.
pub fn spawn_own(command: &mut Command) -> Result<Started> {
    start(command, 3 * imp::PATIENCE)
}

fn start(command: &mut Command, patience: Duration) -> Result<Started> {
    let program = command.get_program().to_string_lossy().into_owned();
    imp::in_own_group(command);
    // Held while the program starts: a signal either comes before, and nothing starts any more, or finds the group.
    let mut groups = GROUPS.lock().ok().context("the list of programs is lost")?;
    let child = command.spawn().with_context(|| format!("cannot start {program}"))?;
    groups.push(Group { leader: child.id(), patience });
    Ok(Started(child))
}

/// A program that has been started.
#[derive(Debug)]
pub struct Started(pub Child);

impl Drop for Started {
    /// Whoever lets go of a program that still runs, as after an error, ends it.
    fn drop(&mut self) {
        if !matches!(self.0.try_wait(), Ok(Some(_))) {
            imp::kill(self.0.id());
            // An error means that the exit status was collected before.
            let _ = self.0.wait();
        }
        if let Ok(mut groups) = GROUPS.lock() {
            groups.retain(|group| group.leader != self.0.id());
        }
    }
}

/// A process group that has not ended.
#[derive(Clone, Copy, Debug)]
struct Group {
    leader: u32,
    /// From the request to end until it is killed.
    patience: Duration,
}

static GROUPS: Mutex<Vec<Group>> = Mutex::new(Vec::new());

/// From now on, Ctrl-C, SIGTERM and SIGHUP end all programs that were started, and this one with status 130.
pub fn end_by_signal() -> Result<()> {
    ctrlc::set_handler(|| {
        // Not released again: nothing starts any more.
        let groups = GROUPS.lock();
        if let Ok(groups) = &groups {
            imp::end(groups);
        }
        std::process::exit(130);
    })
    .context("signals cannot be handled")
}

/// Returns unless a signal is ending the programs: its handler then ends this one too.
pub fn settle() {
    // The handler holds it to the end.
    drop(GROUPS.lock());
}

#[cfg(unix)]
mod imp {
    use std::os::unix::process::CommandExt as _;
    use std::process::Command;
    use std::thread;
    use std::time::{Duration, Instant};

    use nix::sys::signal::{Signal, killpg};
    use nix::sys::wait::{WaitPidFlag, waitpid};
    use nix::unistd::Pid;

    use super::Group;

    /// Compilers, emulator and browser end at once.
    pub const PATIENCE: Duration = Duration::from_secs(2);

    pub fn in_own_group(command: &mut Command) {
        command.process_group(0);
    }

    fn pid(leader: u32) -> Pid {
        // The kernel's numbers fit; for one that does not, no group is found.
        Pid::from_raw(i32::try_from(leader).unwrap_or(i32::MAX))
    }

    pub fn kill(leader: u32) {
        // A group that has ended meanwhile is no fault.
        let _ = killpg(pid(leader), Signal::SIGKILL);
    }

    /// Whether a process of the group is left.
    fn lives(leader: u32) -> bool {
        // A leader that has ended counts until somebody has waited for it, and its starter may be held up.
        let _ = waitpid(Pid::from_raw(-pid(leader).as_raw()), Some(WaitPidFlag::WNOHANG));
        killpg(pid(leader), None).is_ok()
    }

    /// Asks every group to end, waits, and kills what is left.
    pub fn end(groups: &[Group]) {
        for group in groups {
            let _ = killpg(pid(group.leader), Signal::SIGTERM);
        }
        let start = Instant::now();
        for group in groups {
            while lives(group.leader) {
                if start.elapsed() > group.patience {
                    kill(group.leader);
                    break;
                }
                thread::sleep(Duration::from_millis(10));
            }
        }
    }
}

#[cfg(not(unix))]
mod imp {
    use std::process::Command;
    use std::time::Duration;

    use super::Group;

    pub const PATIENCE: Duration = Duration::ZERO;

    pub fn in_own_group(_: &mut Command) {}

    pub fn kill(_: u32) {}

    pub fn end(_: &[Group]) {}
}
