//! A trained gate → the constants with which a drive merges it with its own healthy segments.
//!
//! The core does the merging ([`bearing_watch::Commissioning`]). The trained mean counts as κ₀ = (1 − λ)/λ
//! segments, where λ is the part of the variance that is between drives or runs: that is the weight of the conjugate
//! prior if means scatter by λ about the trained one and segments by 1 − λ about theirs. Without runs λ is not known,
//! and κ₀ is 1. The trained covariance contains both parts and is wider than that of one drive: it counts as no more
//! segments than there are coordinates.

use bearing_watch::model::{CommissioningConstants, EvidenceConstants};

use super::alarm;
use super::gate::Gate;
use crate::Error;

/// The trained mean counts as at most this part of the segments.
const MOST_PART: f64 = 0.25;

impl Gate {
    /// Returns the constants for a commissioning with so many segments, and those of the alarm, which are `trained` for
    /// the gate itself.
    ///
    /// # Errors
    /// Too few segments for the alarm's mean time between false alarms.
    pub fn commissioning(&self, segments: u32, trained: EvidenceConstants) -> Result<CommissioningConstants, Error> {
        let coordinates = self.mean.len();
        let most = MOST_PART * f64::from(segments);
        let mean_weight = self.runs.as_ref().map_or(1.0, |runs| (1.0 - runs.between) / runs.between).clamp(0.0, most);
        let evidence = alarm::commissioned(trained, coordinates, segments as usize, self.limit).ok_or_else(|| {
            let limit = trained.limit;
            Error::Training(format!(
                "{segments} segments say too little of a drive for an alarm limit of {limit:.1} nats; give more"
            ))
        })?;
        Ok(CommissioningConstants {
            mean_weight: mean_weight as f32,
            covariance_weight: coordinates as f32,
            trained_freedom: self.runs.as_ref().map_or(self.rows as f64 - 1.0, |runs| runs.freedom) as f32,
            evidence: Some(evidence),
            ..CommissioningConstants::new(segments, 1.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::super::gate_of;
    use super::*;

    #[test]
    fn fewer_segments_need_more_evidence() {
        let healthy: Vec<_> = (0..60)
            .map(|k| DVector::from_vec(vec![f64::from(k * 7 % 11), f64::from(k * 5 % 13), f64::from(k * 3 % 17)]))
            .collect();
        let gate = gate_of(&healthy, 0.01).expect("a gate");
        let trained = EvidenceConstants {
            bet: alarm::BET,
            limit: 12.0,
            cap: 6.5,
            segments_a_run: 1,
            log_mean: 0.5,
            defect_log_mean: 0.25,
        };
        let of = |segments| gate.commissioning(segments, trained).expect("enough");
        let [few, many] = [30, 1000].map(of);
        let log_mean = |own: &CommissioningConstants| own.evidence.expect("constants").log_mean;
        println!("ln μ: {} of 30 segments, {} of 1000", log_mean(&few), log_mean(&many));
        assert!(log_mean(&few) > log_mean(&many) + 0.1);
        let evidence = few.evidence.expect("constants");
        // Two runs of a large defect reach the limit, one does not.
        assert!((2.0 * (evidence.cap - evidence.log_mean) - 12.0).abs() < 0.5, "{evidence:?}");
        assert!((evidence.limit, evidence.defect_log_mean) == (12.0, 0.25));
        assert!((few.mean_weight, few.covariance_weight, few.trained_freedom) == (1.0, 3.0, 59.0));
        assert!(gate.commissioning(5, trained).is_err());
    }
}
