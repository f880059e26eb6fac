//! Argument groups of the commands, and the settings that they stand for.

pub(super) mod alarms;
pub(super) mod estimation;
pub(super) mod odds;
pub(super) mod shaft;
pub(super) mod traces;
