//! `cargo demo`: the demo alone, a program that is compiled without the file formats and commands of `bearing-watch`.

use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use bearing_watch_studies::demo::command::{Args, run};
use clap::Parser;
use model::session::{Log, Progress, Steps};

/// The whole chain on the simulated standard rig: traces, training, verdicts of the embedded detector, plots
#[derive(Debug, Parser)]
#[command(version)]
struct Demo {
    #[command(flatten)]
    args: Args,
}

/// Shows the part of a work that is done, on a terminal only.
struct Percent;

impl Progress for Percent {
    fn start(&self, what: &'static str, count: usize) -> Steps {
        let (all, shown) = (AtomicU64::new(0), std::io::stderr().is_terminal());
        Box::new(move |steps| {
            let done = all.fetch_add(steps, Ordering::Relaxed) + steps;
            if shown {
                let end = if done >= count as u64 { "\r\u{1b}[K" } else { "" };
                eprint!("\r{what} {:3} %{end}", 100 * done / count.max(1) as u64);
            }
        })
    }
}

fn main() -> ExitCode {
    let Demo { args } = Demo::parse();
    let report = match run(&args, &Log::new(&Percent)) {
        Ok(report) => report,
        Err(error) => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            return ExitCode::from(2);
        }
    };
    let text = if args.json { format!("{:#}", report.json) } else { report.lines.join("\n") };
    // A closed pipe is not an error.
    let _closed = writeln!(std::io::stdout(), "{text}");
    ExitCode::SUCCESS
}
