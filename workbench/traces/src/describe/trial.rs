//! Tries a description before it is written: training by it must not be refused.

use std::path::Path;

use super::found::Found;
use super::values::{LEAST_SAMPLES, SEGMENTS, Values};
use crate::given::{Memory, given};
use model::session::{Log, Quiet, Session};
use model::settings::{DriveFile, literal};

/// Largest size of the recordings, in bytes, with which training is tried.
const MOST_BYTES: u64 = 2 << 30;

/// What came out.
pub(super) enum Outcome {
    /// Training accepts the values, these or simpler ones, which a line explains.
    Accepted(Option<String>),
    /// Training refuses all of them, the usual ones for this reason.
    Refused(String),
    /// The recordings are too large for a trial.
    Untried,
}

/// Tries the usual values, and then simpler ones in their place.
pub(super) fn tried(found: &Found, values: &mut Values, (out, text): (&Path, &dyn Fn(&Values) -> String)) -> Outcome {
    let bytes = found.all.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|about| about.len()).sum::<u64>();
    if bytes > MOST_BYTES {
        return Outcome::Untried;
    }
    let train = |values: &Values| -> Result<(), String> {
        let file = DriveFile::of(out, text(&values.answered())).map_err(|error| error.to_string())?;
        let settings = file.settings.completed();
        let log = Log::new(&Quiet);
        let train = || Session::new(settings.clone(), given(&settings, Memory::default())?, None)?.train(&log);
        train().map(drop).map_err(|error| error.to_string())
    };
    let Err(first) = train(values) else { return Outcome::Accepted(None) };
    let mut simpler = values.clone();
    for (what, change) in CHANGES {
        if !change(found, &mut simpler) {
            continue;
        }
        if train(&simpler).is_ok() {
            *values = simpler;
            return Outcome::Accepted(Some(format!("{what}, since training refuses the usual recipe: {first}")));
        }
    }
    Outcome::Refused(first)
}

type Change = fn(&Found, &mut Values) -> bool;

/// What becomes simpler, each in addition to those before; whether there is anything to change.
const CHANGES: [(&str, Change); 10] = [
    ("mean and rms of the current, until a bearing is given", |found, own| {
        let current = found.proposal.guess.current.as_ref().filter(|current| !current.contains('('));
        let (Some(current), false) = (current, own.values.contains_key("features")) else { return false };
        let names = ["mean", "rms"].map(|word| literal(&format!("{word}_{current}")));
        let why = "with a bearing, leave this line out: its orders are then the features";
        own.values.insert("features", format!("[{}]  # {why}", names.join(", ")));
        true
    }),
    ("a lower order", |found, own| {
        let (inputs, loads) = (u8::from(!found.proposal.alone), u8::from(own.values.contains_key("u2")));
        own.values.insert("order", format!("[1, {inputs}, {loads}, 1, 1]"));
        true
    }),
    ("a lower order and the usual features", |_, own| own.values.remove("features").is_some()),
    ("no shaft", |_, own| {
        let keys = ["angle", "velocity", "load", "velocity_ref", "current", "orders"];
        let had = keys.map(|key| own.values.remove(key).is_some()).contains(&true);
        if had {
            own.values.remove("features");
        }
        had
    }),
    ("the healthy class alone, cut into segments", |found, own| {
        let (_, labels, classes) = &found.labels;
        let (Some(healthy), true) = (own.values.get("healthy").cloned(), classes.len() > 1) else { return false };
        let records = classes.iter().find(|class| healthy == literal(class)).map_or(0, |class| labels.count(class));
        own.values.insert("classes", format!("[{healthy}]"));
        own.values.insert("segment", segment(found.rows, records, LEAST_SAMPLES).to_string());
        true
    }),
    ("mean and rms of one channel", |found, own| {
        let Some(y) = found.proposal.y.as_ref().filter(|y| found.names.contains(y)) else { return false };
        let names = ["mean", "rms"].map(|word| literal(&format!("{word}_{y}")));
        own.values.insert("features", format!("[{}]", names.join(", ")));
        true
    }),
    ("the mean of one channel", |found, own| {
        let Some(y) = found.proposal.y.as_ref().filter(|y| found.names.contains(y)) else { return false };
        own.values.insert("features", format!("[{}]", literal(&format!("mean_{y}"))));
        true
    }),
    ("short segments", |found, own| {
        let length = segment(found.rows, 1, FEWEST_SAMPLES);
        own.values.insert("segment", length.to_string());
        length < found.rows
    }),
    ("segments that count as independent, although so few recordings do not show that they are", |_, own| {
        let had = own.values.contains_key("group");
        own.values.insert("group", "\"none\"".into());
        !had
    }),
    ("no gate", |_, own| {
        own.values.remove("healthy");
        own.values.insert("novelty", "\"none\"".into());
        true
    }),
];

/// Least samples of a segment of a very short recording.
const FEWEST_SAMPLES: usize = 32;

/// Samples of a segment of `records` records of `rows` rows each, and at least `least`.
fn segment(rows: usize, records: usize, least: usize) -> usize {
    (rows * records / SEGMENTS).max(least).min(rows)
}
