//! Firmware that measures and checks the core: instructions, stack and flash, equal bits on chip and host, no panic.
//!
//! The programs are in `examples`, those that a user copies in the folder of the same name at the top. `cargo xtask`
//! builds and runs them.
#![no_std]
