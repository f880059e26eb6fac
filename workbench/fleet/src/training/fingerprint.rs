//! A fingerprint of a model on rounded constants.

use std::fmt::Write as _;

use bearing_watch::model::Classifier;
use crc::{CRC_64_XZ, Crc};

use model::Error;
use model::train::Trained;

/// Returns sixteen hexadecimal digits that are equal for models whose features are equal and whose constants agree in
/// five digits, but for the rare constant at the edge of rounding.
///
/// # Errors
/// A model that the core refuses.
pub fn fingerprint(trained: &Trained) -> Result<String, Error> {
    let model = trained.to_core()?;
    let constants = model.constants();
    let Classifier { features, projection, discriminant, novelty, .. } = &constants.classifier;
    let mut text = format!("{:?} {:?} {features:?}", constants.labels, constants.sampling);
    let mut add = |numbers: &[f32]| {
        // Sums of rounding errors about zero have no digits.
        let largest = numbers.iter().filter(|x| x.is_finite()).fold(0.0_f32, |most, x| most.max(x.abs()));
        for x in numbers {
            let x = if x.abs() < 1e-5 * largest { 0.0 } else { *x };
            let _never_fails = write!(text, " {x:.4e}");
        }
    };
    add(&projection.matrix);
    add(&projection.mean);
    add(&projection.usual);
    add(&discriminant.means);
    add(&discriminant.factors);
    add(&discriminant.log_prior);
    add(&discriminant.costs);
    add(&novelty.mean);
    add(&novelty.factor);
    novelty.knots.iter().chain(novelty.laws.iter().flatten()).for_each(|knot| add(knot));
    let evidence = &constants.evidence;
    add(&[evidence.bet, evidence.limit, evidence.cap, evidence.log_mean, evidence.defect_log_mean]);
    Ok(format!("{:016x}", Crc::<u64>::new(&CRC_64_XZ).checksum(text.as_bytes())))
}
