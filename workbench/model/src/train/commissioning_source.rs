//! The constants of a commissioning as Rust source: how a drive merges the trained gate with its own healthy segments.

use std::fmt::Write as _;

use bearing_watch::model::CommissioningConstants;

use super::Trained;
use super::export::{evidence, number};
use crate::Error;

/// Returns a constant for a commissioning with so many healthy segments of the drive.
///
/// # Errors
/// A model without a novelty gate; too few segments for its mean time between false alarms.
pub fn commissioning_source(trained: &Trained, segments: u32) -> Result<String, Error> {
    let gate = trained.watch.gate.as_ref().ok_or_else(|| {
        Error::Usage("--commissioning merges a novelty gate with that of a drive: give --healthy".into())
    })?;
    let own = gate.commissioning(segments, trained.watch.evidence)?;
    let CommissioningConstants { mean_weight, covariance_weight, fewest, .. } = own;
    let mut out = format!(
        "/// For `Commissioning::new`: {fewest} healthy segments of the drive; the trained mean counts as {mean_weight} \
         more of\n/// them, the trained covariance as {covariance_weight}.\n"
    );
    let fields = [
        ("mean_weight", number(mean_weight)),
        ("covariance_weight", number(covariance_weight)),
        ("fewest", fewest.to_string()),
        ("farthest", number(own.farthest)),
        ("widest", number(own.widest)),
        ("trained_freedom", number(own.trained_freedom)),
        ("evidence", own.evidence.map_or_else(|| "None".into(), |own| format!("Some({})", evidence(&own)))),
    ];
    out += "#[rustfmt::skip]\n";
    out += "pub const COMMISSIONING: bearing_watch::model::CommissioningConstants = ";
    out += "bearing_watch::model::CommissioningConstants {\n";
    for (name, value) in fields {
        let _ = writeln!(out, "    {name}: {value},");
    }
    out += "};\n";
    Ok(out)
}
