//! The elementary functions of `libm`, under the names by which the standard library takes them from the system.
//!
//! A system's own differ from another's in the last bit, and with them a model that is trained. Here they are the same
//! on every system and in a browser, in this project's code and in that of others: the linker finds these first.
//!
//! `unsafe` is the name alone: arguments and result are those of the C library.
//!
//! Cost: about the time of the system's. Of functions with an exact result (square root, rounding, remainder) the
//! system's are the same everywhere.

macro_rules! functions {
    ($($double:ident $single:ident ($($x:ident),+);)+) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $double($($x: f64),+) -> f64 {
            libm::$double($($x),+)
        }

        #[unsafe(no_mangle)]
        extern "C" fn $single($($x: f32),+) -> f32 {
            libm::$single($($x),+)
        }
    )+};
}

functions! {
    sin sinf(x);
    cos cosf(x);
    tan tanf(x);
    asin asinf(x);
    acos acosf(x);
    atan atanf(x);
    atan2 atan2f(y, x);
    sinh sinhf(x);
    cosh coshf(x);
    tanh tanhf(x);
    exp expf(x);
    exp2 exp2f(x);
    expm1 expm1f(x);
    log logf(x);
    log2 log2f(x);
    log10 log10f(x);
    log1p log1pf(x);
    pow powf(x, y);
    cbrt cbrtf(x);
    hypot hypotf(x, y);
}
