//! Recorded runs of one drive at sizes of one kind of defect.

use bearing_watch::Evidence;
use bearing_watch::plan::RunTime;
use rand::{Rng, RngExt};
use rayon::prelude::*;

use crate::campaign::Cell;
use crate::field::delay::{self, Place, places, record};
use model::Error;
use model::core::{Embedded, SegmentReport};

/// Recorded sizes.
pub(super) const SIZES: [f64; 6] = [0.0, 0.0625, 0.125, 0.25, 0.5, 1.0];
/// First session with a defect, as in the study of delays.
const DEFECTIVE: u32 = 500;

/// A run: its segments.
pub(super) type Run = Vec<SegmentReport>;

/// The runs of a drive.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    /// Place of the direction.
    pub(super) direction: usize,
    /// s₀.
    scale: f64,
    /// Runs at each of [`SIZES`], those without a defect by the mean of the direction.
    runs: Vec<Vec<Run>>,
    /// μ, in s₀.
    means: Vec<f64>,
}

impl Drive {
    /// Records a drive.
    pub(super) fn recorded(
        model: &Embedded,
        (direction, scale): (usize, f64),
        cell: &dyn Fn(f64) -> Cell,
        unit: u32,
        settings: &delay::Settings,
    ) -> Result<Self, Error> {
        let of_size = |size: f64| {
            let sessions = if size > 0.0 { DEFECTIVE..DEFECTIVE + settings.defective } else { 0..settings.healthy };
            let all = places(unit..unit + 1, sessions, settings.records);
            let cell = cell(size);
            let one = |place: &Place| Ok(model.run(&record(cell, *place)?.trace));
            let records: Vec<Vec<SegmentReport>> = all.par_iter().map(one).collect::<Result<_, Error>>()?;
            let runs = records.chunks(settings.records as usize).map(|run| run.concat());
            let mut runs: Vec<(f64, Run)> =
                runs.filter_map(|run| mean(&run, direction).map(|mean| (mean, run))).collect();
            runs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let level = runs.iter().map(|run| run.0).sum::<f64>() / runs.len().max(1) as f64 / scale;
            if runs.is_empty() {
                return Err(Error::Training("a judged drive has no run with a value of the direction".into()));
            }
            Ok((level, runs.into_iter().map(|run| run.1).collect::<Vec<_>>()))
        };
        let recorded: Vec<(f64, Vec<Run>)> = SIZES.into_iter().map(of_size).collect::<Result<_, Error>>()?;
        let (means, runs) = recorded.into_iter().unzip();
        Ok(Self { direction, scale, runs, means })
    }

    /// μ(a) − μ(0) in s₀.
    pub(super) fn shift(&self, size: f64) -> f64 {
        let upper = SIZES.iter().position(|recorded| *recorded >= size).unwrap_or(SIZES.len() - 1).max(1);
        let part = (size - SIZES[upper - 1]) / (SIZES[upper] - SIZES[upper - 1]);
        self.means[upper - 1] + part * (self.means[upper] - self.means[upper - 1]) - self.means[0]
    }

    /// A run at a size.
    pub(super) fn run(&self, size: f64, random: &mut impl Rng) -> Run {
        let off = |place: &usize| (SIZES[*place] - size).abs();
        let nearest = (0..SIZES.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
        let runs = &self.runs[nearest];
        let shift = self.shift(size) - (self.means[nearest] - self.means[0]);
        let mut run = runs[random.random_range(0..runs.len())].clone();
        for value in run.iter_mut().filter_map(|segment| segment.directed.get_mut(self.direction)) {
            value.value += (shift * self.scale) as f32;
        }
        run
    }

    /// The healthy run that this part of all do not exceed.
    pub(super) fn healthy(&self, part: f64) -> &Run {
        let runs = &self.runs[0];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place among few runs")]
        let place = (part.clamp(0.0, 1.0) * runs.len() as f64) as usize;
        &runs[place.min(runs.len() - 1)]
    }
}

/// Takes the segments of a run, and ends it.
pub(super) fn observe(evidence: &mut Evidence<RunTime>, model: &Embedded, run: &Run) {
    for segment in run {
        evidence.observe(model.decision(segment).as_ref());
    }
    evidence.end_run();
}

/// Mean of the direction over the segments of a run that have it.
fn mean(run: &Run, direction: usize) -> Option<f64> {
    let values = run.iter().filter_map(|segment| segment.directed.get(direction));
    let good: Vec<f64> =
        values.filter(|value| value.variance.is_finite()).map(|value| f64::from(value.value)).collect();
    (!good.is_empty()).then(|| good.iter().sum::<f64>() / good.len() as f64)
}
