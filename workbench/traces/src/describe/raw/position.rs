//! What the columns of the position tell: an angle, or counts and how many a turn.

use std::f64::consts::{PI, TAU};

/// The position.
#[derive(Debug)]
pub(super) struct Position {
    /// The angle of the shaft; NaN where it is missing.
    pub(super) angles_rad: Vec<f64>,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Bits(u32),
    Counts(u32),
    Angle,
    /// Amplitude of sine and cosine.
    Resolver(f64),
}

/// Whether all values are whole numbers.
pub(super) fn are_counts(column: &[f64]) -> bool {
    let mut known = column.iter().filter(|value| value.is_finite()).peekable();
    known.peek().is_some() && known.all(|value| value.fract() == 0.0)
}

impl Position {
    /// # Errors
    /// Counts that were never at the end of a turn: nothing tells how many a turn has.
    pub(super) fn of(columns: &[&[f64]]) -> Result<Self, String> {
        match columns {
            [sin, cos] => Ok(Self::resolver(sin, cos)),
            [column, ..] if are_counts(column) => Self::counts(column),
            [column, ..] => {
                let largest =
                    column.iter().filter(|value| value.is_finite()).fold(0.0_f64, |most, x| most.max(x.abs()));
                if (180.0..=360.5).contains(&largest) && wraps(column, 180.0).is_some() {
                    return Err("the angle seems to be in degrees: convert it to radians".into());
                }
                Ok(Self { angles_rad: column.to_vec(), kind: Kind::Angle })
            }
            [] => Err("no column of the position".into()),
        }
    }

    fn resolver(sin: &[f64], cos: &[f64]) -> Self {
        let angles_rad = sin.iter().zip(cos).map(|(sin, cos)| sin.atan2(*cos)).collect();
        let mut amplitudes: Vec<f64> = sin.iter().zip(cos).map(|(sin, cos)| sin.hypot(*cos)).collect();
        amplitudes.retain(|amplitude| amplitude.is_finite());
        amplitudes.sort_unstable_by(f64::total_cmp);
        let amplitude = amplitudes.get(amplitudes.len() / 2).copied().unwrap_or(1.0);
        Self { angles_rad, kind: Kind::Resolver(amplitude) }
    }

    fn counts(column: &[f64]) -> Result<Self, String> {
        let known = || column.iter().copied().filter(|value| value.is_finite());
        let (least, most) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let Some(turn) = wraps(column, 0.5 * (most - least)).filter(|_| least >= 0.0) else {
            return Err(format!(
                "the position counts from {least} to {most} and never starts anew: nothing tells the counts of a turn; \
                 record some turns with a counter that is reset at each"
            ));
        };
        // Above the largest count, and no further than a recording with few turns may miss.
        let bits = (most + 1.0).log2().ceil();
        let full = 2.0_f64.powf(bits);
        let kind = if (turn - full).abs() < 0.02 * full && most < full {
            Kind::Bits(bits as u32)
        } else {
            Kind::Counts(turn.round() as u32)
        };
        let per_turn = if let Kind::Counts(counts) = kind { f64::from(counts) } else { full };
        Ok(Self { angles_rad: column.iter().map(|counts| counts * TAU / per_turn).collect(), kind })
    }

    /// The section of the file.
    pub(super) fn lines(&self, names: &[String], reversed: bool) -> Vec<String> {
        let mut lines = match self.kind {
            Kind::Bits(bits) => vec![format!("counts = {}", names[0]), format!("bits = {bits}")],
            Kind::Counts(turn) => vec![format!("counts = {}", names[0]), format!("counts_per_turn = {turn}")],
            Kind::Angle => vec![format!("angle_rad = {}", names[0])],
            Kind::Resolver(amplitude) => vec![
                format!("sin = {}", names[0]),
                format!("cos = {}", names[1]),
                format!("amplitude = [{:.4}, {:.4}]", 0.5 * amplitude, 1.5 * amplitude),
                "mismatch = 0.1".into(),
            ],
        };
        if reversed && !matches!(self.kind, Kind::Resolver(_)) {
            lines.push("reversed = true  # it counts against the order of the phases".into());
        }
        lines
    }

    /// Whether a file can say that the position is reversed.
    pub(super) fn can_be_reversed(&self) -> bool {
        !matches!(self.kind, Kind::Resolver(_))
    }
}

/// The height of the jumps that are larger than this: the median, corrected by the motion beside each.
fn wraps(column: &[f64], least: f64) -> Option<f64> {
    let mut jumps: Vec<f64> = column
        .windows(4)
        .filter(|own| (own[2] - own[1]).abs() > least && least > 0.0)
        .map(|own| ((own[2] - own[1]) - 0.5 * (own[1] - own[0] + own[3] - own[2])).abs())
        .collect();
    jumps.retain(|jump| jump.is_finite());
    jumps.sort_unstable_by(f64::total_cmp);
    jumps.get(jumps.len() / 2).copied()
}

/// The shorter way from one angle to another.
pub(super) fn turned(from_rad: f64, to_rad: f64) -> f64 {
    let turned = (to_rad - from_rad).rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}
