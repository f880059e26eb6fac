//! What survives power-off: the saved state of the alarm, and records in flash.

mod saved;
mod storage;
