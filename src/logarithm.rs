//! The natural logarithm and the cube root, in one place: the compiler would copy them to each caller.

/// ln x.
#[inline(never)]
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// The cube root, 0 of numbers that are not above 0: libm's works in double precision, which the chip does in software.
#[inline(never)]
pub fn cube_root(x: f32) -> f32 {
    if x > f32::MIN_POSITIVE { libm::expf(ln(x) / 3.0) } else { 0.0 }
}

/// ln x, of at least the smallest normal number: a level of zero has no logarithm.
pub fn ln_of_level(x: f32) -> f32 {
    ln(if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE })
}
