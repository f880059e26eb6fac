//! The records of one row of the table of the field, for other programs: the same seeds as those of
//! `bearing-watch-studies campaign --field`.
//!
//! `field_records ROW DRAW` writes to standard output one line of JSON, and then the records as binary numbers (f64,
//! little endian), set by set in the order of the header, record by record, column by column. `sets` of the header
//! names purpose, kind and severity of the defect, and the number of records; `columns` names the recorded columns.

use std::error::Error;
use std::io::{BufWriter, Write, stdout};

use bearing_watch_studies::campaign::{Cell, map_traces};
use bearing_watch_studies::field::Settings;
use bearing_watch_studies::field::rows::{CLASSES, Row, named};
use rig::{Defect, Scenario};
use serde_json::json;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, draw] = &arguments[..] else { return Err("usage: field_records ROW DRAW".into()) };
    let row = named(std::slice::from_ref(name))?[0];
    let mut out = BufWriter::new(stdout().lock());
    for (k, (cell, count)) in cells(&row, draw.parse()?).into_iter().enumerate() {
        let records = map_traces(&Scenario::STANDARD, &[cell], count, |recording| Ok(recording.trace))?;
        if k == 0 {
            let columns: Vec<&str> = records[0].recorded().into_iter().map(|(name, _)| name).collect();
            writeln!(out, "{}", header(&row, draw.parse()?, &columns))?;
        }
        for trace in records {
            for (_, column) in trace.recorded() {
                let bytes: Vec<u8> = column.iter().flat_map(|x| x.to_le_bytes()).collect();
                out.write_all(&bytes)?;
            }
        }
    }
    Ok(out.flush()?)
}

/// All cells of the row, those of the training set first, with their numbers of records.
fn cells(row: &Row, draw: u32) -> Vec<(Cell, u32)> {
    let settings = Settings::standard(1, draw);
    let classes = if row.classes { &CLASSES[..] } else { &CLASSES[..1] };
    let training = classes.iter().enumerate().map(|(k, kind)| {
        let count = if k == 0 { settings.healthy_training } else { settings.defects_training };
        (row.training(draw, Defect::full(*kind)), count)
    });
    let validation = row.judged_defects().into_iter();
    let validation = validation.map(|defect| (row.validation(draw, defect), settings.judged(defect.kind)));
    training.chain(validation).collect()
}

fn header(row: &Row, draw: u32, columns: &[&str]) -> serde_json::Value {
    let sets = cells(row, draw).into_iter().map(|(cell, count)| {
        let (purpose, defect) = (format!("{:?}", cell.purpose), cell.defect);
        json!({ "purpose": purpose, "kind": defect.kind.name(), "severity": defect.severity, "count": count })
    });
    json!({
        "interval_s": Scenario::STANDARD.sample_time_s,
        "samples": Scenario::STANDARD.samples,
        "outer": Scenario::STANDARD.bearing.orders().outer,
        "three_classes": row.classes,
        "columns": columns,
        "sets": sets.collect::<Vec<_>>(),
    })
}
