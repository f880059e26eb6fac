//! Work without the interpreter's lock, on threads of this process.
//!
//! A process that is forked (`multiprocessing` on Linux) has the memory of its parent, but none of its threads: work
//! that waits for the parent's would wait for ever. So a forked process makes its own.

use std::cell::RefCell;
use std::process;
use std::sync::{Arc, OnceLock};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// The threads of a process.
type Owned = (u32, Arc<ThreadPool>);

/// Those of the process that worked first.
static FIRST: OnceLock<Owned> = OnceLock::new();

thread_local! {
    /// Those of a process that was forked from it. Only the thread that forked goes on in it, so that no other
    /// thread uses these.
    static FORKED: RefCell<Option<Owned>> = const { RefCell::new(None) };
}

fn made() -> Result<Owned, ThreadPoolBuildError> {
    Ok((process::id(), Arc::new(ThreadPoolBuilder::new().build()?)))
}

/// The threads of this process.
fn threads() -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let is_own = |(owner, _): &&Owned| *owner == process::id();
    if FIRST.get().is_none() {
        let (owner, threads) = made()?;
        // Another thread may be faster; both are right.
        let _taken = FIRST.set((owner, threads));
    }
    if let Some((_, threads)) = FIRST.get().filter(is_own) {
        return Ok(Arc::clone(threads));
    }
    FORKED.with_borrow_mut(|forked| {
        if let Some((_, threads)) = forked.as_ref().filter(is_own) {
            return Ok(Arc::clone(threads));
        }
        let owned = made()?;
        let threads = Arc::clone(&owned.1);
        // To drop those of a parent would be to wait for them.
        std::mem::forget(forked.replace(owned));
        Ok(threads)
    })
}

/// Works without the interpreter's lock, on the threads of this process; on its own thread where the system gives none.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    let threads = threads();
    py.detach(|| match threads {
        Ok(threads) => threads.install(work),
        Err(_none) => work(),
    })
}
