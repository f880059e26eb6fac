//! Argument groups of the commands, and their conversion to settings.

pub(super) mod alarms;
pub(super) mod classifier;
pub(super) mod estimation;
pub(super) mod exports;
pub(super) mod method;
pub(super) mod odds;
pub(super) mod park;
pub(super) mod shaft;
pub(super) mod traces;
