//! The section `[balance]`: by what the currents of the phases are checked against each other.

use bearing_watch::drive::BalanceLimits;
use serde::{Deserialize, Serialize};

/// [`BalanceLimits`]; the noise is given in amperes, or in counts, which stay what they are when a gain is changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhaseBalance {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    noise_a: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    noise_counts: Option<f32>,
    /// Largest offset that is removed, of any phase; twice the noise if it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    offset_a: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    offset_counts: Option<f32>,
    gain_tolerance: f32,
    window: u16,
}

impl PhaseBalance {
    /// Of currents without phases, which are not checked.
    pub(super) const UNUSED: BalanceLimits =
        BalanceLimits { noise_a: 1.0, offset_a: 2.0, gain_tolerance: 0.02, window: 400 };

    /// # Errors
    /// Neither or both of the noises, or both offsets.
    pub(super) fn check(self) -> Result<(), String> {
        if self.offset_a.is_some() && self.offset_counts.is_some() {
            return Err("[balance] has offset_counts, or offset_a".into());
        }
        match (self.noise_a, self.noise_counts) {
            (Some(_), None) | (None, Some(_)) => Ok(()),
            (None, None) | (Some(_), Some(_)) => Err("[balance] has noise_counts, or noise_a".into()),
        }
    }

    /// The limits for sensors with these amperes a count.
    pub(super) fn limits(self, gain_a: &[f32]) -> BalanceLimits {
        let Self { noise_a, noise_counts, offset_a, offset_counts, gain_tolerance, window } = self;
        let largest = gain_a.iter().fold(0.0_f32, |largest, gain| largest.max(gain.abs()));
        let noise_a = noise_a.or(noise_counts.map(|counts| counts * largest));
        let noise_a = noise_a.unwrap_or(f32::NAN);
        let offset_a = offset_a.or(offset_counts.map(|counts| counts * largest)).unwrap_or(2.0 * noise_a);
        BalanceLimits { noise_a, offset_a, gain_tolerance, window }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_in_amperes_or_in_counts() {
        let of = |noise: &str| toml::from_str::<PhaseBalance>(&format!("{noise}\ngain_tolerance = 0.02\nwindow = 400"));
        let limits = |noise: &str| {
            let balance = of(noise).expect("a section");
            balance.check().map(|()| balance.limits(&[0.25, -0.5]).noise_a)
        };
        assert_eq!(limits("noise_a = 0.5"), Ok(0.5));
        assert_eq!(limits("noise_counts = 3.0"), Ok(1.5));
        let both = Err("[balance] has noise_counts, or noise_a".to_owned());
        let offset = |text: &str| of(&format!("noise_counts = 3.0\n{text}")).expect("a section").limits(&[0.25, -0.5]);
        assert_eq!([offset("").offset_a, offset("offset_counts = 8.0").offset_a], [3.0, 4.0]);
        assert!(of("noise_a = 1.0\noffset_a = 1.0\noffset_counts = 8.0").expect("a section").check().is_err());
        assert_eq!([limits(""), limits("noise_a = 0.5\nnoise_counts = 3.0")], [both.clone(), both]);
    }
}
