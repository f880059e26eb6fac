//! False alarms of healthy sets that are not what a gate assumes, and of offsets that last.

mod healthy_sets;
mod lasting;
