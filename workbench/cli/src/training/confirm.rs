//! `bearing-watch confirm`: what an inspection said of an alarm, as labels for the next training.

use std::path::{Path, PathBuf};

use crate::command_line::output;
use model::Error;
use model::near::among;
use model::settings::HEALTHY_NAMES;
use model::trace::{TraceNames, file_name, stem, trace_name};
use traces::read_labels;

/// File an alarm as false or true: label its recordings for the next training
///
/// After a false alarm, train again with these recordings as healthy: the healthy class then contains them. In the
/// drive, deny the alarm by Monitor::deny, bw_deny or Detector.deny. What raised it must then be larger to raise the
/// next one; after three denied alarms this stays as it is, so that no growing defect is hidden.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  bearing-watch confirm --false --labels labels.csv --set session=7 june/*.csv\n  \
                  bearing-watch confirm --true outer --labels labels.csv --set session=7 june/*.csv")]
#[command(group = clap::ArgGroup::new("finding").required(true))]
pub(crate) struct Args {
    /// Recordings of the runs that raised the alarm
    #[arg(required = true, value_name = "TRACES")]
    traces: Vec<PathBuf>,
    /// The bearing is sound
    #[arg(long = "false", group = "finding")]
    unfounded: bool,
    /// The bearing has this defect, a class of the labels or a new one
    #[arg(long = "true", value_name = "CLASS", group = "finding")]
    defect: Option<String>,
    /// The labels, which get a row for each recording; rows of known ones are changed
    #[arg(long, value_name = "FILE")]
    labels: PathBuf,
    /// Cell of another column of these rows, such as the run; may be repeated
    #[arg(long, value_name = "COLUMN=VALUE", value_parser = assignment)]
    set: Vec<(String, String)>,
}

fn assignment(text: &str) -> Result<(String, String), String> {
    let parts = text.split_once('=').filter(|(column, value)| !column.is_empty() && !value.is_empty());
    let (column, value) = parts.ok_or("write COLUMN=VALUE, such as session=7")?;
    Ok((column.into(), value.into()))
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let labels = read_labels(&args.labels)?;
    let class = match &args.defect {
        Some(class) if HEALTHY_NAMES.contains(&class.as_str()) => {
            return Err(Error::Usage(format!("a {class} bearing is no defect: --false files a false alarm")));
        }
        Some(class) => class.clone(),
        None => {
            HEALTHY_NAMES.into_iter().find(|name| labels.count(name) > 0).map(String::from).ok_or_else(|| {
                Error::content(&args.labels, "column class_name", "no class is named healthy or normal")
            })?
        }
    };
    let mut table = labels.table();
    let mut known = 0;
    for trace in &args.traces {
        known += usize::from(args.file(&mut table, trace, &class)?);
    }
    // What is written can be read again.
    let read = model::trace::Labels::of_cells(&args.labels, table[0].clone(), table[1..].to_vec())?;
    output::write(&args.labels, output::csv(&table)?)?;
    let (count, file) = (args.traces.len(), args.labels.display());
    let filed = if count == 1 { "recording is" } else { "recordings are" };
    output::say(format!("{count} {filed} {class} in {file} ({known} of them labelled before)"))?;
    output::say(match &args.defect {
        None => {
            "Train again with them, and deny the alarm in the drive: Monitor::deny, bw_deny or Detector.deny.".into()
        }
        Some(class) => format!(
            "The labels have {} recordings of {class}. After the repair, reset the drive: Monitor::reset or bw_reset.",
            read.count(class)
        ),
    })
}

impl Args {
    /// Gives a recording its row; whether it had one.
    fn file(&self, table: &mut Vec<Vec<String>>, trace: &Path, class: &str) -> Result<bool, Error> {
        if !trace.is_file() {
            let problem = format!("{} is no file; name the recordings of the alarm", trace.display());
            return Err(Error::Usage(problem));
        }
        let id = stem(&file_name(trace)).to_owned();
        let column = |name: &str| {
            table[0].iter().position(|column| column == name).ok_or_else(|| {
                let problem = format!("no column {name}{}", among(name, &table[0]));
                Error::content(&self.labels, "header", problem)
            })
        };
        let (id_place, class_place) = (column("trace")?, column("class_name")?);
        let mut cells = vec![(class_place, class.to_owned())];
        for (name, value) in &self.set {
            if ["trace", "class_name"].contains(&name.as_str()) {
                return Err(Error::Usage(format!("--set {name}: it is what the command writes")));
            }
            cells.push((column(name)?, value.clone()));
        }
        let whole = traces::whole_name(trace);
        let names = TraceNames::of(table.iter().skip(1).map(|row| trace_name(&row[id_place]).into_owned()));
        let known = names.longest(&whole);
        let labelled = table.iter().skip(1).position(|row| known == Some(&*trace_name(&row[id_place])));
        let place = labelled.map_or(table.len(), |place| place + 1);
        if labelled.is_none() {
            let mut row = vec![String::new(); table[0].len()];
            row[id_place] = id;
            table.push(row);
        }
        cells.into_iter().for_each(|(at, text)| table[place][at] = text);
        let empty = table[place].iter().position(String::is_empty).filter(|_| labelled.is_none());
        if let Some(at) = empty {
            let name = &table[0][at];
            let problem = format!("{} needs a cell of column {name}: --set {name}=…", trace.display());
            return Err(Error::Usage(problem));
        }
        Ok(labelled.is_some())
    }
}
