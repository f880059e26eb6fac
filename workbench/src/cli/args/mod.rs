//! Argument groups that commands share, and what their values mean.

pub(super) mod alarms;
pub(super) mod estimation;
pub(super) mod odds;
pub(super) mod shaft;
pub(super) mod traces;
