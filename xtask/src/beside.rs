//! The stages of the target in a process of their own, beside those of the host.

use std::env;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use clap::ValueEnum as _;

use crate::processes::Started;
use crate::stages::Stages;
use crate::tally::Tally;
use crate::test::Stage;
use crate::toolchain::Way;
use crate::{child, workspace};

/// The process, and the file of what it prints, which is shown when it has ended: lines of two at once are hard to
/// read.
pub struct Beside(Result<(Started, PathBuf)>);

impl Beside {
    /// Starts a run of these stages.
    pub fn start(way: Way, stages: &[Stage]) -> Self {
        let started = Self::spawn(way, stages);
        if let Ok((_, path)) = &started {
            println!(
                "\nThe stages of the target run beside those of the host; meanwhile they print to {}",
                path.display()
            );
        }
        Self(started)
    }

    fn spawn(way: Way, stages: &[Stage]) -> Result<(Started, PathBuf)> {
        let path = workspace::target_dir().join("target-stages.log");
        // One file for both streams, at one place in it.
        let printed = File::create(&path).with_context(|| path.display().to_string())?;
        let errors = printed.try_clone()?;
        let mut command = Command::new(env::current_exe().context("where is this program?")?);
        command.args(["--way", &way.to_string(), "test", "--beside"]);
        let names = stages.iter().filter_map(|stage| Some(stage.to_possible_value()?.get_name().to_owned()));
        command.args(names);
        Ok((child::start_own(command.stdin(Stdio::null()).stdout(printed).stderr(errors))?, path))
    }

    /// Waits for the end, shows the output, and adds the stages.
    pub fn end(self, stages: &mut Stages) {
        if let Err(error) = self.ended(stages) {
            stages.stage("target", |tally: &mut Tally| tally.check::<&str, _>("stages", Err(format!("{error:#}"))));
        }
    }

    fn ended(self, stages: &mut Stages) -> Result<()> {
        let (mut started, path) = self.0?;
        let status = started.0.wait()?;
        let mut rows = 0;
        child::split(File::open(path)?, |line| {
            if stages.take_row(line) {
                rows += 1;
            } else {
                println!("{line}");
            }
        })?;
        ensure!(rows > 0, "the stages of the target ended early ({status})");
        Ok(())
    }
}
