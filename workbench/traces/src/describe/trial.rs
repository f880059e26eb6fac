//! Tries a description before it is written: training by it must not be refused.
//!
//! Of many recordings some of each class are tried first. If training refuses these, all are tried.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::found::Found;
use super::remembered::Kept;
use super::values::{LEAST_SAMPLES, SEGMENTS, UNTIL_A_BEARING, Values, mean_and_rms};
use crate::given::{Memory, given};
use crate::listing::naming::whole_name;
use model::session::{Log, Quiet, Session};
use model::settings::{DriveFile, literal};
use model::trace::{Cells, Labels, Recorded};

/// Largest size of the recordings, in bytes, with which training is tried.
const MOST_BYTES: u64 = 2 << 30;
/// Recordings that are tried first, and the least number of each class.
const TRIED: usize = 400;
const OF_CLASS: usize = 60;

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
    let kept = Kept::default();
    let train = |values: &Values, sample: Option<&Sample>| -> Result<(), String> {
        let file = DriveFile::of(out, text(&values.answered(found))).map_err(|error| error.to_string())?;
        let mut settings = file.settings.completed();
        let memory = sample.map_or_else(Memory::default, |sample| {
            settings.data.traces.clone_from(&sample.files);
            Memory { labels: Some(Arc::clone(&sample.labels)), ..Memory::default() }
        });
        let log = Log::new(&Quiet);
        let train =
            || Session::new(settings.clone(), kept.given(given(&settings, memory)?)?, None)?.of_trial().train(&log);
        train().map(drop).map_err(|error| error.to_string())
    };
    let (_, labels, classes) = &found.labels;
    let sample = Sample::of(&found.all, labels, classes);
    let accepted_by_some = |values: &Values| {
        let sample = sample.as_ref().filter(|sample| train(values, Some(sample)).is_ok())?;
        let (tried, all) = (sample.files.len(), found.all.len());
        Some(format!("training was tried with {tried} of {all} recordings only; it may still refuse others"))
    };
    if let Some(note) = accepted_by_some(values) {
        return Outcome::Accepted(Some(note));
    }
    let Err(first) = train(values, None) else { return Outcome::Accepted(None) };
    let mut simpler = values.clone();
    for (what, change) in CHANGES {
        if !change(found, &mut simpler) {
            continue;
        }
        let some = accepted_by_some(&simpler);
        if some.is_some() || train(&simpler, None).is_ok() {
            *values = simpler;
            let why = format!("{what}, since training refuses the usual recipe: {first}");
            return Outcome::Accepted(Some([Some(why), some].into_iter().flatten().collect::<Vec<_>>().join("; ")));
        }
    }
    Outcome::Refused(first)
}

/// Some recordings of each class, in the order of the labels, and their labels.
struct Sample {
    files: Vec<PathBuf>,
    labels: Arc<Recorded>,
}

impl Sample {
    /// `None` if it were not much smaller than all, or if files are not the traces of the labels.
    fn of(all: &[PathBuf], labels: &Labels, classes: &[String]) -> Option<Self> {
        let names = labels.names();
        let wholes: Vec<String> = all.iter().map(|file| whole_name(file)).collect();
        let files: HashMap<&str, &PathBuf> =
            wholes.iter().zip(all).filter_map(|(whole, file)| Some((names.longest(whole)?, file))).collect();
        let mut chosen = labels.select(&[]).ok()?;
        if chosen.len() != all.len() || !chosen.iter().all(|(id, _)| files.contains_key(id.as_str())) {
            return None;
        }
        let most = (TRIED / classes.len().max(1)).max(OF_CLASS);
        let of_class = classes.iter().map(|class| (class, (labels.count(class).div_ceil(most), 0_usize)));
        let mut every: HashMap<&String, (usize, usize)> = of_class.collect();
        chosen.retain(|(_, class)| {
            let Some((step, seen)) = every.get_mut(class) else { return false };
            *seen += 1;
            (*seen - 1).is_multiple_of(*step)
        });
        if 2 * chosen.len() > all.len() {
            return None;
        }
        let ids = || chosen.iter().map(|(id, _)| id.as_str());
        let cells = |name: &String| Some((name.clone(), Cells::Texts(labels.cells(name, ids()).ok()?)));
        let columns = labels.columns().iter().map(cells).collect::<Option<_>>()?;
        let labels = Arc::new(Recorded::new("labels", columns).ok()?);
        Some(Self { files: ids().filter_map(|id| files.get(id).map(|file| file.to_path_buf())).collect(), labels })
    }
}

type Change = fn(&Found, &mut Values) -> bool;

/// What becomes simpler, each in addition to those before; whether there is anything to change.
const CHANGES: [(&str, Change); 10] = [
    ("mean and rms of the current, until a bearing is given", |found, own| {
        let current = found.proposal.guess.current.as_ref().filter(|own| found.is_plain(own));
        let (Some(current), false) = (current, own.values.contains_key("features")) else { return false };
        own.values.insert("features", format!("{}  # {UNTIL_A_BEARING}", mean_and_rms(current)));
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
        let Some(y) = found.proposal.y.as_ref().filter(|y| found.is_plain(y)) else { return false };
        own.values.insert("features", mean_and_rms(y));
        true
    }),
    ("the mean of one channel", |found, own| {
        let Some(y) = found.proposal.y.as_ref().filter(|y| found.is_plain(y)) else { return false };
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The files of a folder with so many of each class, and their labels.
    fn recordings(counts: [usize; 2]) -> (Vec<PathBuf>, Labels) {
        let names = ["healthy", "spall"].into_iter().zip(counts);
        let names: Vec<(String, &str)> =
            names.flat_map(|(class, count)| (0..count).map(move |k| (format!("{class}/{k}.csv"), class))).collect();
        let rows = names.iter().map(|(name, class)| vec![name.clone(), class.to_string(), format!("of {name}")]);
        let columns = ["trace", "class_name", "run"].map(String::from).to_vec();
        let labels = Labels::of_cells(Path::new("labels.csv"), columns, rows.collect()).expect("labels");
        (names.iter().map(|(name, _)| Path::new("data").join(name)).collect(), labels)
    }

    fn sample(files: &[PathBuf], labels: &Labels) -> Option<Sample> {
        Sample::of(files, labels, &["healthy".into(), "spall".into()])
    }

    #[test]
    fn some_of_many_recordings_are_tried_of_each_class_with_their_own_labels() {
        let (files, labels) = recordings([1900, 100]);
        let some = sample(&files, &labels).expect("many");
        let of = |labels: &Labels| ["healthy", "spall"].map(|class| labels.count(class));
        let own_labels = Labels::of(&some.labels).expect("labels");
        assert_eq!((of(&own_labels), some.files.len()), ([190, 100], 290));
        for (row, file) in own_labels.table()[1..].iter().zip(&some.files) {
            assert!(file.ends_with(&row[0]) && row[2] == format!("of {}", row[0]), "{row:?}");
        }
    }

    #[test]
    fn few_recordings_or_others_than_the_labels_name_are_all_tried() {
        let (files, labels) = recordings([300, 200]);
        assert!(sample(&files, &labels).is_none());
        let (mut files, labels) = recordings([1900, 100]);
        files[7] = "data/other.csv".into();
        assert!(sample(&files, &labels).is_none());
    }
}
