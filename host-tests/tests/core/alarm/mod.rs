//! Gates and alarms: set false-alarm rates, defects that are found, and the arithmetic of both.

mod drives;
mod evidence;
mod missing;
mod novelty;
mod rising;
