//! Loops as straight-line code in the hot path at every optimisation level, and as loops elsewhere.
//!
//! At `opt-level = "s"` the compiler unrolls no loop, and calls small functions of core such as `Zip::new` and
//! `into_iter`. A plan fixes the length of every array, and most loops of a sample have two to four passes: iterators
//! would cost more than the work of such a loop.

/// A `while let` whose first 32 passes stand one after the other. With lengths known at compile time, only the passes
/// that are made remain.
///
/// ```text
/// unrolled!(let ([x, xs @ ..], [y, ys @ ..]) = (a, b) => { sum += x * y; (a, b) = (xs, ys); });
/// ```
macro_rules! unrolled {
    (let $pattern:pat = $value:expr => $pass:block) => {
        'passes: {
            unrolled!(32: if let $pattern = $value $pass else { break 'passes });
            while let $pattern = $value $pass
        }
    };
    (32: $($pass:tt)*) => { unrolled!(16: $($pass)*); unrolled!(16: $($pass)*); };
    (16: $($pass:tt)*) => { unrolled!(8: $($pass)*); unrolled!(8: $($pass)*); };
    (8: $($pass:tt)*) => { unrolled!(4: $($pass)*); unrolled!(4: $($pass)*); };
    (4: $($pass:tt)*) => { $($pass)* $($pass)* $($pass)* $($pass)* };
}

pub(crate) use unrolled;

/// Hides a value from the compiler, such as the slice or the length of a loop: a loop of known length becomes
/// straight-line code, several times as large, where code runs once a segment.
#[inline(always)]
pub fn no_unroll<T>(value: T) -> T {
    core::hint::black_box(value)
}
