//! Notes in a model file for the workbench, by which it knows recordings again.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::trace::labels::LabelledTrace;
use crate::trace::{Channels, Preparation, Trace, trace_name};
use crate::train::Trained;

/// Notes in a model file for the workbench; the firmware ignores them.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Notes {
    /// The columns that the model reads.
    #[serde(flatten, skip_deserializing, default = "Channels::unknown")]
    pub channels: Channels,
    /// The drive file that it was trained with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) drive: Option<String>,
    /// Preparation on the host, before the detector.
    host_block_mean: usize,
    decimate: usize,
    /// Names of the tracked orders.
    #[serde(default)]
    pub orders: Vec<String>,
    /// Names of the features.
    pub features: Vec<String>,
    /// Ids of the training traces, used to warn if the model is evaluated on them.
    pub trained_on: Vec<String>,
    /// Numbers of their contents, by which they are known under any name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contents: Vec<u32>,
    /// The units (drives) of the training traces, if they were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub units: Vec<String>,
    /// The column of the labels that told the runs, if one did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
}

/// By the derived way.
impl Serialize for Notes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

/// The channels by themselves and the rest by the derived way.
impl<'de> Deserialize<'de> for Notes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (channels, rest) = Channels::beside(deserializer, |value| Self::deserialize(value))?;
        Ok(Self { channels, ..rest })
    }
}

impl Notes {
    /// Of a model, the ids of the traces and the units with which it was trained, and the text of its drive file.
    #[must_use]
    pub fn new(
        channels: &Channels,
        host: Preparation,
        trained: &Trained,
        (trained_on, units): (Vec<String>, &[String]),
        drive: Option<String>,
    ) -> Self {
        let mut units = units.to_vec();
        units.sort_unstable();
        units.dedup();
        Self {
            channels: channels.clone(),
            drive,
            host_block_mean: host.block_mean,
            decimate: host.decimate,
            orders: trained.catalogue().orders.unwrap_or_default(),
            features: trained.feature_names.clone(),
            trained_on,
            contents: vec![],
            units,
            group: None,
        }
    }

    /// The same with the contents of the training traces.
    pub(crate) fn with_contents(self, contents: Vec<u32>) -> Self {
        Self { contents, ..self }
    }

    /// The same with the column that told the runs.
    pub(crate) fn with_group(self, group: Option<&String>) -> Self {
        Self { group: group.cloned(), ..self }
    }

    /// What is done to recordings before the detector.
    #[must_use]
    pub fn preparation(&self) -> Preparation {
        Preparation { block_mean: self.host_block_mean.max(1), decimate: self.decimate.max(1) }
    }

    /// The drive file that the model was trained with.
    #[must_use]
    pub fn drive(&self) -> Option<&str> {
        self.drive.as_deref()
    }

    /// As the model file has them.
    #[must_use]
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A number of the output of a trace, which every model reads: equal recordings have equal ones, and two different ones
/// agree by a chance of 2⁻³².
#[must_use]
pub fn content(trace: &Trace) -> u32 {
    // FNV-1a, 64 bits, over the numbers.
    let each = |hash: u64, x: &f64| (hash ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
    let hash = trace.y.iter().fold(0xcbf2_9ce4_8422_2325, each);
    (hash ^ hash >> 32) as u32
}

/// How many of these traces a model was trained on, and in words how that is known; none if there are none.
pub(crate) fn seen(traces: &[LabelledTrace], (ids, contents): (&[String], &[u32])) -> (usize, Option<String>) {
    let is_id = |t: &&LabelledTrace| ids.iter().any(|id| *id == trace_name(&t.trace.id));
    let (count, what) = if contents.is_empty() {
        (traces.iter().filter(is_id).count(), "have the names of traces that the model was trained on")
    } else {
        let is_known = |t: &&LabelledTrace| contents.contains(&content(&t.trace));
        (traces.iter().filter(is_known).count(), "were trained on")
    };
    let words = || format!("{count} of {} traces {what}: the rates flatter the model", traces.len());
    (count, (count > 0).then(words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_and_the_name_only_without_it() {
        let labelled = |id: &str, y: &[f64]| LabelledTrace {
            trace: Trace { id: id.into(), y: y.to_vec(), ..Trace::default() },
            class: 0,
        };
        let (one, copy, other) =
            (labelled("a.csv", &[1.0, 2.0]), labelled("b.csv", &[1.0, 2.0]), labelled("a", &[2.0, 1.0]));
        let contents = [content(&one.trace)];
        let (ids, all) = (["a".to_string()], [one, copy, other]);
        let (count, words) = seen(&all, (&ids, &contents));
        assert_eq!((count, words.as_deref()), (2, Some("2 of 3 traces were trained on: the rates flatter the model")));
        let (count, words) = seen(&all, (&ids, &[]));
        assert!(count == 2 && words.is_some_and(|words| words.contains("have the names of")));
        assert_eq!(seen(&all[2..], (&ids, &contents)), (0, None));
        assert_ne!(content(&labelled("", &[0.0, 1.0]).trace), content(&labelled("", &[1.0, 0.0]).trace));
    }
}
