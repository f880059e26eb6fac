//! The program `bearing-watch-studies`: what reproduces the source and the studies on the simulated rigs.
//!
//! It is compiled without the file formats and commands of `bearing-watch`; `cargo demo` is its command `demo`.

mod campaign;
mod demo;
mod output;
mod tables;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Studies of bearing-watch on simulated rigs: the demo, campaigns, the tables of the source
#[derive(Debug, Parser)]
#[command(name = "bearing-watch-studies", version)]
struct Program {
    #[command(subcommand)]
    study: Study,
    /// Print no progress and notes
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Study {
    Demo(demo::Args),
    Campaign(campaign::Args),
    Tables(tables::Args),
}

fn main() -> ExitCode {
    let Program { study, quiet } = Program::parse();
    let output = output::Output { quiet };
    let done = match &study {
        Study::Demo(args) => demo::run(args, output),
        Study::Campaign(args) => campaign::run(args, output),
        Study::Tables(args) => tables::run(args, output),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            ExitCode::from(2)
        }
    }
}
