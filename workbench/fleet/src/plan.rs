//! What the rows of a part have in common: channels, preparation, and the detector that computed their features.
//!
//! The plan is JSON in the metadata of a part. Besides the constants of the core in binary form, which a checksum
//! protects, it has everything that a model's export needs, so that a model can be trained from parts alone.

use bearing_watch::model::{Feature, MAX_BYTES, Sampling};
use bearing_watch::plan::Method;
use bearing_watch::{Model, Park};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use model::Error;
use model::core::features::Catalogue;
use model::core::{Embedded, Parts};
use model::identify::Structure;
use model::trace::{Channels, Preparation};
use model::train::{Axis, Estimating, Estimation, Recipe, ShaftPlan, VelocitySource};

/// Version of the format of plans and parts.
pub const VERSION: u32 = 1;

/// The plan of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Plan {
    /// [`VERSION`].
    pub version: u32,
    /// Names of all features, the columns of a part.
    pub features: Vec<String>,
    /// Usual variance of the error of each feature.
    pub usual: Vec<f64>,
    /// Classes of the traces from which the detector's constants are.
    pub classes: Vec<String>,
    /// Column of the labels with the drive, if it was given.
    pub unit: Option<String>,
    /// Column of the labels with the run, if it was given.
    pub group: Option<String>,
    /// The channels of the recordings.
    #[serde(flatten, skip_deserializing, default = "Channels::unknown")]
    pub channels: Channels,
    /// Preparation of the recordings, and their sampling interval, s; 0 if it is not known.
    block_mean: usize,
    decimate: usize,
    recorded_interval_s: f64,
    /// Sampling interval of the detector, s.
    interval_s: f64,
    segment_samples: usize,
    /// Whether the segment was given, or traces are cut; otherwise it is the longest trace.
    segment_given: bool,
    /// na, nb, nc and both delays.
    order: [u8; 5],
    offset: bool,
    park: Option<String>,
    memory: Option<f64>,
    /// Place of the nominal class.
    nominal: usize,
    orders: Vec<(String, f64)>,
    velocity_from_angle: bool,
    load: bool,
    /// The core's model without a classifier, in hexadecimal digits.
    core: String,
}

/// What the traces of a plan have in common besides the detector.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The channels.
    pub channels: Channels,
    /// The preparation.
    pub preparation: Preparation,
    /// Sampling interval of the recordings, s; 0 if it is not known.
    pub recorded_interval_s: f64,
    /// Columns of the labels with drive and run.
    pub unit: Option<String>,
    /// The same of the run.
    pub group: Option<String>,
}

/// By the derived way.
impl Serialize for Plan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

/// The channels by themselves and the rest by the derived way.
impl<'de> Deserialize<'de> for Plan {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (channels, rest) = Channels::beside(deserializer, |value| Self::deserialize(value))?;
        Ok(Self { channels, ..rest })
    }
}

impl Plan {
    /// Creates the plan of a detector.
    ///
    /// # Errors
    /// Constants that the core refuses.
    pub fn new(found: &Estimating, classes: &[String], origin: Origin) -> Result<Self, Error> {
        let Estimating { recipe, parts, segment, interval_s } = found;
        let samples = u32::try_from(*segment).map_err(|_| Error::Usage("the segment is too long".into()))?;
        let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: samples };
        let refused = |error: bearing_watch::ModelError| Error::Training(format!("the detector is refused: {error}"));
        let mut bytes = vec![0; MAX_BYTES];
        let length = parts.estimating(sampling).and_then(|model| model.to_bytes("", &mut bytes)).map_err(refused)?;
        let Origin { channels, preparation, recorded_interval_s, unit, group } = origin;
        let Structure { na, nb, nc, nkb, nkc, offset } = recipe.structure;
        let plan = recipe.shaft.as_ref();
        let features = recipe.catalogue().names();
        Ok(Self {
            version: VERSION,
            usual: vec![0.0; features.len()],
            features,
            classes: classes.to_vec(),
            unit,
            group,
            channels,
            block_mean: preparation.block_mean,
            decimate: preparation.decimate,
            recorded_interval_s,
            interval_s: *interval_s,
            segment_samples: *segment,
            segment_given: recipe.estimation.segment.is_some(),
            order: [na, nb, nc, nkb, nkc],
            offset,
            park: recipe.park.map(|park| if park == Park::Standard { "standard" } else { "thesis" }.into()),
            memory: recipe.estimation.memory,
            nominal: recipe.estimation.nominal,
            orders: plan.map_or_else(Vec::new, |plan| plan.orders.clone()),
            velocity_from_angle: plan.is_some_and(|plan| plan.velocity == VelocitySource::Angle),
            load: plan.is_some_and(|plan| plan.load),
            core: bytes[..length].iter().map(|byte| format!("{byte:02x}")).collect(),
        })
    }

    /// Reads the plan of a part.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let value: Value = serde_json::from_str(text).map_err(|error| format!("the plan is no JSON: {error}"))?;
        let version = value["version"].as_u64();
        if version != Some(u64::from(VERSION)) {
            let version = version.map_or_else(|| "none".into(), |version| version.to_string());
            return Err(format!("the plan has version {version}, not {VERSION}; compute the features again"));
        }
        let plan: Self =
            serde_json::from_value(value.clone()).map_err(|error| format!("the plan is incomplete: {error}"))?;
        let known = serde_json::to_value(&plan).unwrap_or_default();
        let is_strange = |(key, cell): &(&String, &Value)| known.get(key).is_none() && !cell.is_null();
        if let Some((key, _)) = value.as_object().and_then(|own| own.iter().find(is_strange)) {
            return Err(format!("the plan has an unknown field {key}; this program is too old for it"));
        }
        if plan.usual.len() != plan.features.len() {
            return Err("the plan has not one usual error for each feature".into());
        }
        plan.model()?;
        if plan.catalogue().names() != plan.features {
            return Err("the plan's features are not those of its detector".into());
        }
        Ok(plan)
    }

    /// Returns the plan as JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    fn model(&self) -> Result<Model<bearing_watch::plan::RunTime>, String> {
        let digits = |k: usize| self.core.get(2 * k..2 * k + 2).and_then(|two| u8::from_str_radix(two, 16).ok());
        let bytes: Option<Vec<u8>> = (0..self.core.len().div_ceil(2)).map(digits).collect();
        let bytes = bytes.ok_or("the plan's detector is not written in hexadecimal digits")?;
        Model::from_bytes(&bytes).map_err(|error| format!("the plan's detector: {error}; compute the features again"))
    }

    /// Returns the detector that computes the features.
    ///
    /// # Errors
    /// A damaged plan.
    pub fn estimator(&self) -> Result<Embedded, Error> {
        let model = self.model().map_err(Error::Training)?;
        Embedded::new(model).map_err(|error| Error::Training(format!("the plan's detector: {error}")))
    }

    /// Returns the core's channels, regression and shaft.
    ///
    /// # Errors
    /// A damaged plan.
    pub fn parts(&self) -> Result<Parts, Error> {
        let model = self.model().map_err(Error::Training)?;
        let (layout, constants) = (model.plan().layout(), model.constants());
        Ok(Parts {
            channels: constants.channels.clone(),
            regression: layout.regression.zip(constants.regression.first().cloned()),
            shaft: layout.shaft.zip(constants.shaft.first().cloned()),
            averaged: layout.averaged,
        })
    }

    /// Returns the recipe of the detector; features, discriminant and alarms are those of [`Recipe::new`].
    #[must_use]
    pub fn recipe(&self) -> Recipe {
        let shaft = self.channels.shaft.is_some().then(|| {
            let velocity = if self.velocity_from_angle { VelocitySource::Angle } else { VelocitySource::Channel };
            ShaftPlan { velocity, load: self.load, axis: self.axis(), ..ShaftPlan::new(self.orders.clone()) }
        });
        let method = self.model().ok().and_then(|model| model.plan().layout().regression).map(|own| own.method);
        let estimation = Estimation {
            method: method.unwrap_or(Method::LeastSquares),
            nominal: self.nominal,
            segment: self.segment_given.then_some(self.segment_samples),
            memory: self.memory,
            ..Estimation::default()
        };
        let park = self.park.as_ref().map(|park| if park == "standard" { Park::Standard } else { Park::Thesis });
        Recipe { columns: self.channels.clone(), park, estimation, shaft, ..Recipe::new(self.structure()) }
    }

    /// What its detector has of an axis.
    fn axis(&self) -> Axis {
        let layout = self.model().ok().and_then(|model| model.plan().layout().shaft);
        layout.map_or(Axis::None, |own| Axis::of(own.load))
    }

    /// Returns the structure of the regression.
    #[must_use]
    pub const fn structure(&self) -> Structure {
        let [na, nb, nc, nkb, nkc] = self.order;
        Structure { na, nb, nc, nkb, nkc, offset: self.offset }
    }

    /// Number of parameters of the regression; they come first, and the logarithm of its variance next.
    #[must_use]
    pub const fn structure_parameters(&self) -> usize {
        self.structure().parameters()
    }

    /// Returns the names and places of all features.
    #[must_use]
    pub fn catalogue(&self) -> Catalogue {
        // Averaged channels are named by their features.
        let averaged = self.features.iter().filter(|name| model::core::features::averaged(name).is_some());
        Recipe { features: averaged.cloned().collect(), ..self.recipe() }.catalogue()
    }

    /// Returns the preparation of the recordings.
    #[must_use]
    pub const fn preparation(&self) -> Preparation {
        Preparation { block_mean: self.block_mean, decimate: self.decimate }
    }

    /// Returns the sampling intervals of the recordings and of the detector, s; 0 if they are not known.
    #[must_use]
    pub const fn intervals_s(&self) -> [f64; 2] {
        [self.recorded_interval_s, self.interval_s]
    }

    /// Returns the number of samples in a segment of the detector.
    #[must_use]
    pub const fn segment_samples(&self) -> usize {
        self.segment_samples
    }

    /// Returns the column of a variance, if errors of this feature have one.
    #[must_use]
    pub fn has_variance(feature: Feature) -> bool {
        matches!(feature, Feature::Friction(_) | Feature::LogFriction(_))
    }

    /// Returns the first key in which another plan differs, with both values; `None` if they are the same.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<String> {
        let [own, other] = [self, other].map(|plan| serde_json::to_value(plan).unwrap_or_default());
        let short = |value: &Value| {
            let text = value.to_string();
            if text.len() > 60 { format!("{}…", text.chars().take(60).collect::<String>()) } else { text }
        };
        let keys = own.as_object()?.keys();
        let key = keys.into_iter().find(|key| own[key.as_str()] != other[key.as_str()])?;
        Some(match key.as_str() {
            "core" => "the constants of the detector".into(),
            key => format!("{key} {} and {}", short(&own[key]), short(&other[key])),
        })
    }
}
