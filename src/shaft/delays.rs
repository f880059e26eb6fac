//! How far the ring of the shaft is read back for each signal, so that all refer to one instant.

/// Longest lag that can be compensated, samples.
pub const MAX_LAG: f32 = 5.0;
/// Samples kept for the delay: an interpolation reads one sample beyond the longest lag, the middle of an interval one
/// more.
pub(super) const RING: u8 = 8;

/// Samples by which measured signals lag behind the angle, 0 … [`MAX_LAG`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lags {
    /// Lag of the current.
    pub current: f32,
    /// Lag of the velocity; that of differences of the angle is half a sample.
    pub velocity: f32,
    /// Lag of the load.
    pub load: f32,
}

/// How far the ring is read back for one signal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Delay {
    pub whole: u8,
    /// The part of a sample beyond the whole ones.
    pub part: f32,
}

impl Delay {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 … 6 in a validated model")]
    fn of(samples: f32) -> Self {
        let whole = (samples as u8).min(RING - 2);
        Self { whole, part: samples - f32::from(whole) }
    }
}

/// The delays of current, velocity and load, and that to the middle of the last interval, to which the residual refers.
/// Two lists, since four [`Delay`]s would take twelve bytes more.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Delays {
    whole: [u8; 4],
    part: [f32; 4],
    /// Samples that a lost one spoils.
    pub spoilt: u8,
}

impl Delays {
    pub fn of(lags: &Lags) -> Self {
        let Lags { current, velocity, load } = *lags;
        let longest = current.max(velocity).max(load);
        let angle = Delay::of(longest + 0.5);
        let all = [Delay::of(longest - current), Delay::of(longest - velocity), Delay::of(longest - load), angle];
        let (whole, part) = (all.map(|delay| delay.whole), all.map(|delay| delay.part));
        Self { whole, part, spoilt: angle.whole.saturating_add(3) }
    }

    /// Those of current, velocity, load and angle.
    #[inline(always)]
    pub const fn all(&self) -> [Delay; 4] {
        let ([w0, w1, w2, w3], [p0, p1, p2, p3]) = (self.whole, self.part);
        [
            Delay { whole: w0, part: p0 },
            Delay { whole: w1, part: p1 },
            Delay { whole: w2, part: p2 },
            Delay { whole: w3, part: p3 },
        ]
    }
}
