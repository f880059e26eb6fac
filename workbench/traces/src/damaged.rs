//! Readers of other crates, some of which panic at damaged files.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

/// What there is to say of a file at which its reader panics.
pub const DAMAGED: &str = "the file is damaged; write it again";

thread_local! {
    /// Whether a panic of this thread is caught, and is not to be told.
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Runs a reader; returns nothing if it panics.
pub fn guarded<T>(read: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !CAUGHT.get() {
                before(panic);
            }
        }));
    });
    let outer = CAUGHT.replace(true);
    // What the reader was working on is not used after a panic.
    let found = catch_unwind(AssertUnwindSafe(read));
    CAUGHT.set(outer);
    found.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_no_result() {
        assert_eq!(guarded(|| 3), Some(3));
        let inner = || guarded(|| -> () { panic!("inner") });
        assert_eq!(guarded(inner), Some(None));
        let refused: Option<()> = guarded(|| panic!("outer"));
        assert_eq!(refused, None);
    }
}
