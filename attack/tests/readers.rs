//! A short attack on each reader of the workbench, without coverage: kept inputs and changes of them.
#![cfg(feature = "readers")]

use attack::memory::Guarded;
use attack::readers::DOORS;

mod support;

#[global_allocator]
static MEMORY: Guarded = Guarded;

/// Changes of kept inputs of each door.
const CHANGES: usize = 200;

#[test]
fn every_reader_holds() {
    DOORS.iter().for_each(|door| support::attack(door, CHANGES));
}
