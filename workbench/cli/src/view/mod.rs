//! `bearing-watch view`

mod files;
mod index;
mod model_page;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::server::{Local, Reply, answer_to, decoded, stop_flag};

use crate::command_line::output;
use crate::drive::replay;
use crate::recordings::audit;
use files::{Folder, Kind};
use model::Error;

/// Serve pages over a folder of traces and models to a browser on this machine
///
/// Shows each trace with its signals, each model, traces replayed through a model, and pages saved by --report. Only
/// this machine is served; nothing is written. Ctrl-C ends it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch view recordings --open")]
pub(crate) struct Args {
    /// Folder with traces, models (.bwm) and pages; also those in its folders
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Port on 127.0.0.1; 0 is any free one
    #[arg(long, default_value_t = 8600)]
    port: u16,
    /// Open it in the browser
    #[arg(long)]
    open: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let folder = Folder::open(&args.folder)?;
    let stopped = stop_flag()?;
    let local = Local::open(args.port)?;
    let address = format!("http://{}/", local.address);
    output::say(format!("{} at {address}   Ctrl-C ends it", args.folder.display()))?;
    if args.open {
        open(&address);
    }
    local.answer(&stopped, &|path, query| answer(&folder, path, query));
    Ok(())
}

/// The answer to these bytes of a client of the folder, if they have the head of a request; for attacks.
pub(crate) fn answer_of(folder: &Path, bytes: &[u8]) -> Result<Option<Vec<u8>>, Error> {
    let folder = Folder::open(folder)?;
    Ok(answer_to(bytes, &|path, query| answer(&folder, path, query)))
}

fn answer(folder: &Folder, path: &str, query: &str) -> Reply {
    let parts = path.trim_start_matches('/').split_once('/');
    match (path, parts) {
        ("/", _) => Reply::page(index::page(folder)),
        ("/replay", _) => replayed(folder, query),
        (_, Some(("trace", name))) => file(folder, Kind::Trace, name, |path| Reply::page(audit::page_of(path))),
        (_, Some(("model", name))) => file(folder, Kind::Model, name, |path| Reply::page(model_page::page(path))),
        (_, Some(("page", name))) => file(folder, Kind::Page, name, |path| match std::fs::read(path) {
            Ok(bytes) => Reply::saved(bytes),
            Err(error) => Reply::problem(422, &Error::io(path)(error).to_string()),
        }),
        _ => Reply::problem(404, "There is no such page."),
    }
}

/// The reply for a file of the folder.
fn file(folder: &Folder, kind: Kind, name: &str, reply: impl Fn(&Path) -> Reply) -> Reply {
    match decoded(name).and_then(|name| folder.find(kind, &name)) {
        Some(path) => reply(&path),
        None => Reply::problem(404, &format!("The folder has no {} of this name.", kind.name())),
    }
}

/// The traces of the query through its model.
fn replayed(folder: &Folder, query: &str) -> Reply {
    let given = |key: &'static str| {
        let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.filter(move |(own, _)| *own == key).filter_map(|(_, value)| decoded(value)).collect::<Vec<_>>()
    };
    let found = |kind: Kind, key| given(key).iter().map(|name| folder.find(kind, name)).collect::<Option<Vec<_>>>();
    match (found(Kind::Model, "model").as_deref(), found(Kind::Trace, "trace").as_deref()) {
        (Some([model]), Some(traces @ [_, ..])) => Reply::page(replay::page_of(model, traces)),
        _ => Reply::problem(404, "Choose one model, and at least one trace of the folder."),
    }
}

fn open(address: &str) {
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let started = Command::new(program).arg(address).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if started.is_err() {
        output::warn(format!("{program} is not installed; open {address} yourself"));
    }
}
