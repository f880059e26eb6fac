//! The conditions of a set by their names: at most one of the rig, and parts of an axis on top of it.

use super::options::Simulation;
use model::Error;
use rig::axis::parts::{AxisOptions, motion, weighs};
use rig::{Axis, AxisPart};

/// The conditions of a set.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// Name of the condition of the rig; MIX under an axis, if none is named.
    pub(super) rig: &'static str,
    /// Parts of the axis.
    pub(super) parts: Vec<AxisPart>,
    /// Ratio and weight of the axis.
    pub(super) axis: AxisOptions,
    /// All names, joined by `+`.
    pub(super) name: String,
}

impl Chosen {
    /// The conditions of these options.
    ///
    /// # Errors
    /// Names and options that do not go together.
    pub(super) fn new(args: &Simulation) -> Result<Self, Error> {
        let refused = |problem: String| Err(Error::Usage(problem));
        if args.mix && !args.condition.is_empty() {
            return refused("--mix cannot be used with --condition".into());
        }
        for (k, name) in args.condition.iter().enumerate() {
            if args.condition[..k].contains(name) {
                return refused(format!("--condition names {name} twice"));
            }
        }
        let parts: Vec<AxisPart> = args.condition.iter().filter_map(|name| AxisPart::named(name)).collect();
        let rigs: Vec<&'static str> =
            args.condition.iter().copied().filter(|name| AxisPart::named(name).is_none()).collect();
        if let [one, other, ..] = rigs[..] {
            return refused(format!("--condition {one},{other}: only the parts of an axis combine; leave out one"));
        }
        if parts.contains(&AxisPart::Cycle) && parts.contains(&AxisPart::AnyCycle) {
            return refused("--condition cycle,any-cycle: an axis has one motion; leave out one".into());
        }
        if args.ratio.is_some() && parts.is_empty() {
            return refused("--ratio belongs to an axis; add a part of it to --condition, for example gear".into());
        }
        if args.weight.is_some() && !weighs(&parts) {
            return refused("--weight belongs to an axis with gravity; add gravity to --condition".into());
        }
        let usual = if args.mix || !parts.is_empty() { "mix" } else { "standard" };
        let name = if args.condition.is_empty() { usual.into() } else { args.condition.join("+") };
        let axis = AxisOptions { ratio: args.ratio, weight_nm: args.weight };
        Ok(Self { rig: rigs.first().copied().unwrap_or(usual), parts, axis, name })
    }

    /// Returns an error if the condition of the rig has an axis or a motion already.
    ///
    /// # Errors
    /// What cannot be combined.
    pub(super) fn refuse_rivals(&self, axis: Option<&Axis>, moves: bool) -> Result<(), Error> {
        let rig = self.rig;
        if axis.is_some() && !self.parts.is_empty() {
            return Err(Error::Usage(format!(
                "--condition {rig} is an axis already; leave out the parts of another one"
            )));
        }
        if moves && self.has_motion() {
            return Err(Error::Usage(format!("--condition {rig} sets the reference already; leave out the cycle")));
        }
        Ok(())
    }

    /// Whether a part sets the motion.
    pub(super) fn has_motion(&self) -> bool {
        motion(&self.parts).is_some()
    }
}
