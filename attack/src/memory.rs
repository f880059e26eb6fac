//! Memory of an attack: allocations are counted and limited.
//!
//! A binary that makes [`Guarded`] its allocator can tell that a part of the program allocates nothing, and ends if it
//! allocates more than [`LIMIT`] at a time, as it would for a length that a forged file claims.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Most bytes that may be in use.
pub const LIMIT: usize = 1 << 30;

thread_local! {
    /// Allocations of the thread so far.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}
static USED: AtomicUsize = AtomicUsize::new(0);

/// The allocator of the system, counted and limited. Beyond the limit it gives no memory, which ends the program.
#[derive(Debug)]
pub struct Guarded;

// SAFETY: every call is that of the system's allocator with the same arguments, or gives no memory.
unsafe impl GlobalAlloc for Guarded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        if USED.fetch_add(layout.size(), Ordering::Relaxed) > LIMIT.saturating_sub(layout.size()) {
            USED.fetch_sub(layout.size(), Ordering::Relaxed);
            return std::ptr::null_mut();
        }
        // SAFETY: the contract of the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        if USED.fetch_add(layout.size(), Ordering::Relaxed) > LIMIT.saturating_sub(layout.size()) {
            USED.fetch_sub(layout.size(), Ordering::Relaxed);
            return std::ptr::null_mut();
        }
        // SAFETY: the contract of the caller.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the contract of the caller.
        unsafe { System.dealloc(memory, layout) };
    }
}

/// Number of allocations of this thread so far; always 0 unless [`Guarded`] is the allocator.
#[must_use]
pub fn allocations() -> u64 {
    ALLOCATIONS.with(Cell::get)
}

/// Runs work that allocates nothing.
///
/// # Panics
/// If it does.
pub fn without_allocation(work: impl FnOnce()) {
    let before = allocations();
    work();
    let allocated = allocations() - before;
    assert_eq!(allocated, 0, "allocations of the core");
}
