//! `features-sum`: sums of parts and of sums.

use std::path::PathBuf;
use std::time::Instant;

use serde::Deserialize;
use serde_json::{Value, json};

use super::inputs::Inputs;
use super::memory::peak_memory_mb;
use crate::{Choice, Sums, Units, Wanted};
use model::Error;
use model::outputs;
use model::session::Log;
use model::settings::Settings;
use model::train::Recipe;

/// What is summed.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SumOptions {
    /// Parts, and sums of other parts, or folders of them
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "PARTS", "x-positional" = true)))]
    pub parts: Vec<PathBuf>,
    /// Drives are not complete: further parts have segments of them
    #[serde(default)]
    pub keep_units: bool,
    /// The sums
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE")))]
    pub out: PathBuf,
}

/// Sums that are written.
#[derive(Debug)]
pub struct Summed {
    /// The sums.
    pub sums: Sums,
    /// Size of the file.
    pub bytes: usize,
    out: PathBuf,
    seconds: f64,
}

/// Sums parts and sums, and writes the result.
///
/// # Errors
/// What cannot be read or written, other plans, or drives that are complete in two of them.
pub fn features_sum(settings: &Settings, options: &SumOptions, log: &Log<'_>) -> Result<Summed, Error> {
    let start = Instant::now();
    outputs::plan(&[&options.out], &options.parts)?;
    let inputs = Inputs::open(&options.parts)?;
    let asked = &settings.model.features;
    let features = match inputs.parts.first() {
        Some(part) => {
            let recipe = Recipe { features: asked.clone(), ..part.plan.recipe() };
            Choice::new(&part.plan, &recipe)?.features
        }
        None if asked.is_empty() => vec![],
        None => return Err(Error::Usage("--features chooses those of parts; sums have theirs".into())),
    };
    let units = if options.keep_units { Units::Open } else { Units::Remembered };
    let wanted = Wanted { features, chosen: asked.clone(), conditions: settings.validation.train_where.clone() };
    let sums = inputs.sums(&wanted, units, log)?;
    let bytes = sums.to_bytes()?;
    outputs::write(&options.out, &bytes)?;
    Ok(Summed { sums, bytes: bytes.len(), out: options.out.clone(), seconds: start.elapsed().as_secs_f64() })
}

impl Summed {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { sums, bytes, out, seconds } = self;
        let [open, closed] = sums.units();
        json!({
            "sums": out, "rows": sums.rows, "features": sums.features, "bytes": bytes,
            "open_units": open, "complete_units": closed, "classes": sums.names().collect::<Vec<_>>(),
            "seconds": seconds, "peak_memory_mb": peak_memory_mb(),
        })
    }
}
