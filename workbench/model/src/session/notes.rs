//! Notes in a model file for the workbench.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::trace::{Channels, Preparation};
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
            orders: trained.recipe.catalogue().orders.unwrap_or_default(),
            features: trained.feature_names.clone(),
            trained_on,
            contents: vec![],
            units,
            group: None,
        }
    }

    /// The same with the contents of the training traces.
    #[must_use]
    pub fn with_contents(self, contents: Vec<u32>) -> Self {
        Self { contents, ..self }
    }

    /// The same with the column that told the runs.
    #[must_use]
    pub fn with_group(self, group: Option<&String>) -> Self {
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
