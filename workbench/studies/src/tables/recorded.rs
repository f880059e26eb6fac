//! Traces of a draw with all their signals, and the selection of traces for a table.

use super::published::{TRACES_CHAPTER_3, TRACES_CHAPTER_4};
use crate::campaign::run::motion;
use crate::demo::{FirstInput, class_names};
use model::trace::Trace;
use model::trace::labels::LabelledTrace;
use rig::RigTrace;

/// A trace of the rig with all its signals.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Name of the trace.
    pub id: String,
    /// Index in [`CLASSES`](crate::demo::CLASSES).
    pub class: usize,
    /// The signals.
    pub signals: RigTrace,
}

impl Recorded {
    /// Labelled trace with y = current, u1 as given by `input`, u2 = load torque.
    #[must_use]
    pub fn labelled(&self, input: FirstInput) -> LabelledTrace {
        let RigTrace { t_s, velocity_ref_rad_s, velocity_rad_s, current_a, load_torque_nm, .. } = &self.signals;
        let u1 = match input {
            FirstInput::Reference => velocity_ref_rad_s.clone(),
            FirstInput::Error => velocity_ref_rad_s.iter().zip(velocity_rad_s).map(|(r, w)| r - w).collect(),
        };
        let interval_s = t_s.windows(2).next().map(|pair| pair[1] - pair[0]);
        let (id, y, u2) = (self.id.clone(), current_a.clone(), load_torque_nm.clone());
        let motion = Some(motion(&self.signals));
        LabelledTrace { trace: Trace { id, interval_s, y, u1, u2, motion, ..Trace::default() }, class: self.class }
    }
}

/// Selection of traces of a draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Number of classes: classes 0 to `classes` − 1.
    pub classes: usize,
    /// Number of traces per class.
    pub traces: u32,
}

impl Selection {
    /// Healthy and both defects, as in chapter 4.
    pub const CHAPTER_4: Self = Self { classes: 3, traces: TRACES_CHAPTER_4 };
    /// Healthy and Defect A, as in the example of chapter 3.
    pub const CHAPTER_3: Self = Self { classes: 2, traces: TRACES_CHAPTER_3 };

    /// Names of the selected classes.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        class_names().into_iter().take(self.classes).collect()
    }

    /// The first traces of each class.
    pub fn pick<'a, T>(&self, all: &'a [T], class_of: impl Fn(&T) -> usize) -> Vec<&'a T> {
        let mut left = vec![self.traces; self.classes];
        let mut take = |item: &&T| match left.get_mut(class_of(item)) {
            Some(left) if *left > 0 => {
                *left -= 1;
                true
            }
            _ => false,
        };
        all.iter().filter(&mut take).collect()
    }
}
