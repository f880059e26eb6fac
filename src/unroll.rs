//! Loops of the hot path as straight-line code at every optimisation level.
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
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            if let $pattern = $value $pass else { break 'passes }
            while let $pattern = $value $pass
        }
    };
}

pub(crate) use unrolled;
