//! Measures stack by painting: what is below the stack pointer gets a pattern, and the deepest word that lost it tells
//! how far a call went down.

/// Bytes that are painted; a call that goes further down panics instead of misleading.
const DEPTH: usize = 8192;

const PAINT: u32 = 0xA5C3_96E1;

/// Bytes of stack below the caller of `work`. Whatever it gives back belongs to the caller: drop it inside.
#[inline(never)]
pub fn stack_of(work: impl FnOnce()) -> usize {
    let top = cortex_m::register::msp::read() as usize;
    let bottom = top - DEPTH;
    for address in (bottom..top).step_by(4) {
        // SAFETY: aligned RAM below the stack pointer, which nobody owns: this loop calls nothing, no interrupt is
        // enabled, and the examples' statics end far below.
        unsafe { (address as *mut u32).write_volatile(PAINT) };
    }
    call(work);
    let is_painted = |address: &usize| {
        // SAFETY: as above, and painted or written by `work` since.
        let word = unsafe { (*address as *const u32).read_volatile() };
        word == PAINT
    };
    let untouched = (bottom..top).step_by(4).take_while(is_painted).count() * 4;
    assert!(untouched > 0, "deeper than {DEPTH} bytes");
    DEPTH - untouched
}

/// A frame of its own, so that what the optimiser inlines counts.
#[inline(never)]
fn call(work: impl FnOnce()) {
    work();
}
