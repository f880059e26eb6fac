//! The natural logarithm, in one place: the compiler would copy it to each caller.

/// ln x.
#[inline(never)]
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// ln x, of at least the smallest normal number: a level of zero has no logarithm.
pub fn ln_of_level(x: f32) -> f32 {
    ln(if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE })
}
