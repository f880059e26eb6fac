//! The runs of a drive that have ended, with the size of a defect at the end of each.

use bearing_watch::alarm::{Contribution, Growth};
use model::core::AlarmState;

/// A run that has ended.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Place of its last segment among those of the drive.
    pub(crate) last: usize,
    /// What each direction contributes.
    pub(crate) contributions: Vec<Contribution>,
    /// The size of a defect in each direction, its slope, and the time left.
    pub(crate) growths: Vec<Growth>,
}

/// All runs, in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Runs {
    list: Vec<Run>,
    /// The evidence after the last segment.
    now: Option<AlarmState>,
}

impl Runs {
    /// Takes the evidence after the segment of this place.
    pub(super) fn take(&mut self, place: usize, watched: &AlarmState) {
        if !watched.run.is_empty() {
            let (contributions, growths) = (watched.run.clone(), watched.growths.clone());
            self.list.push(Run { last: place, contributions, growths });
        }
        self.now = Some(watched.clone());
    }

    /// The runs.
    pub(crate) fn list(&self) -> &[Run] {
        &self.list
    }

    /// What each direction contributed at the end of the last run.
    pub(super) fn contributions(&self) -> &[Contribution] {
        self.list.last().map_or(&[], |run| &run.contributions)
    }

    /// The direction whose size is told: the one that raised the alarm, else that of the largest score. One run has no
    /// course, and then there is none.
    pub(crate) fn direction(&self) -> Option<u8> {
        let now = self.now.as_ref().filter(|_| self.list.len() >= 2)?;
        now.growth.map(|(direction, _)| direction)
    }

    /// The size in this direction, whether it grows, and the time left, in sentences; empty without such a direction.
    pub(super) fn size(&self, name: &dyn Fn(u8) -> String) -> String {
        match (&self.now, self.direction()) {
            (Some(now), Some(_)) => format!(
                "Size of a defect, {}. This is an estimate from the past of this drive, and no promise.",
                now.size(name)
            ),
            _ => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bearing_watch::alarm::Interval;

    /// The evidence after a segment, with the size in the second of two directions; a run ends with the last segment.
    fn watched(size: f32, left: Option<f32>, run_ends: bool) -> AlarmState {
        let about = |value: f32| Interval { value, low: 0.5 * value, high: 2.0 * value };
        let (size, slope, left) = (about(size), about(0.25), left.map(about));
        let growth = Growth { size, slope, named: 12.0, left, run_hours: 0.5 };
        let both = [0, 1].map(|direction| Contribution { direction, deviations: 4.0, score: 1.0, since: 3 });
        let (run, growths) = if run_ends { (both.to_vec(), vec![growth; 2]) } else { (vec![], vec![]) };
        AlarmState { score: 1.0, alarm: None, main: None, growth: Some((1, growth)), silence: None, run, growths }
    }

    fn name(direction: u8) -> String {
        ["drag", "outer order"][usize::from(direction)].into()
    }

    #[test]
    fn the_size_is_told_from_the_second_run_on() {
        let mut runs = Runs::default();
        assert_eq!((runs.size(&name), runs.direction()), (String::new(), None));
        for (place, run_ends) in [false, true, false].into_iter().enumerate() {
            runs.take(place, &watched(6.0, None, run_ends));
            assert_eq!((runs.size(&name), runs.direction()), (String::new(), None), "{place}");
        }
        runs.take(3, &watched(6.0, None, true));
        assert_eq!(runs.direction(), Some(1));
        assert_eq!(
            runs.size(&name),
            "Size of a defect, outer order: 6.0 [3.0, 12.0] deviations above what is usual for this drive (90 % \
             interval), not growing. This is an estimate from the past of this drive, and no promise."
        );
        assert_eq!(runs.list().iter().map(|run| run.last).collect::<Vec<_>>(), [1, 3]);
    }

    #[test]
    fn a_growth_has_its_time_left() {
        let mut runs = Runs::default();
        (0..2).for_each(|place| runs.take(place, &watched(6.0, Some(80.0), true)));
        let words = runs.size(&name);
        let course = "grows by 0.50 [0.25, 1.00] an hour of segments; if it goes on so, 40.0 [20.0, 80.0] hours of segments, or \
             80.0 [40.0, 160.0] usual runs, until 12 deviations, which a single segment shows.";
        assert!(words.contains(course), "{words}");
        let mut untimed = watched(6.0, Some(80.0), true);
        untimed.growth.iter_mut().for_each(|(_, growth)| growth.run_hours = 0.0);
        runs.take(2, &untimed);
        let words = runs.size(&name);
        let course = "grows by 0.25 [0.12, 0.50] a usual run; if it goes on so, 80.0 [40.0, 160.0] usual runs until 12 \
                      deviations, which a single segment shows.";
        assert!(words.contains(course), "{words}");
    }

    #[test]
    fn a_size_that_is_reached_has_no_time_left() {
        let mut runs = Runs::default();
        (0..2).for_each(|place| runs.take(place, &watched(20.0, Some(0.0), true)));
        let words = runs.size(&name);
        let course = ", grows by 0.50 [0.25, 1.00] an hour of segments, and has reached 12 deviations, which a single \
                      segment shows. This";
        assert!(words.contains(course), "{words}");
    }

    #[test]
    fn a_model_without_directions_has_no_size() {
        let mut runs = Runs::default();
        let plain = AlarmState { growth: None, run: vec![], growths: vec![], ..watched(6.0, None, true) };
        (0..3).for_each(|place| runs.take(place, &plain));
        assert_eq!((runs.size(&name), runs.contributions()), (String::new(), &[][..]));
    }
}
