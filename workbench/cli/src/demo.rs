//! `bearing-watch demo`

use model::Error;
pub(super) use studies::demo::command::Args;
use studies::demo::command::run as demo;

use super::output;

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let report = output::logged(|log| demo(args, log))?;
    if args.json { output::json("demo", report.json) } else { report.lines.iter().try_for_each(output::say) }
}
