//! The sizes of a library for one plan, as numbers that `export.sh` reads from its symbols: they take no memory.

use crate::front_end::BwFrontEnd;
use crate::state::BwState;

core::arch::global_asm!(
    ".globl bw_size_of_state",
    ".set bw_size_of_state, {state}",
    ".globl bw_size_of_front_end",
    ".set bw_size_of_front_end, {front_end}",
    state = const size_of::<BwState>(),
    front_end = const size_of::<BwFrontEnd>(),
);
