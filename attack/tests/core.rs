//! A short attack on each door of the core, without coverage: kept inputs and changes of them, with every allocation
//! counted.

use attack::core::DOORS;
use attack::memory::{self, Guarded};

mod support;

#[global_allocator]
static MEMORY: Guarded = Guarded;

/// Changes of kept inputs of each door.
const CHANGES: usize = 2000;

#[test]
fn every_door_of_the_core_holds() {
    DOORS.iter().for_each(|door| support::attack(door, CHANGES));
}

#[test]
fn allocations_are_counted() {
    let before = memory::allocations();
    drop(std::hint::black_box(vec![0_u8; 100]));
    assert!(memory::allocations() > before);
    let found = std::panic::catch_unwind(|| memory::without_allocation(|| drop(std::hint::black_box(vec![0_u8; 9]))));
    assert!(found.is_err(), "an allocation is found");
}
