//! Blocks of samples from the interrupt, which fills them, to the main loop, which sends them.

use crate::code::{BwCode, Outcome};
use crate::memory::Lock;

/// What gathers the samples of a block.
pub(crate) trait Gather: Sized + Send {
    /// Whether the block takes no more samples.
    fn is_complete(&self) -> bool;

    /// Gives the block away and starts the next one.
    fn take(&mut self) -> Self;
}

/// The block that the interrupt fills, and a complete one that waits for the main loop.
#[derive(Debug)]
pub(crate) struct Blocks<R> {
    filling: Lock<R>,
    waiting: Lock<Option<R>>,
}

impl<R: Gather> Blocks<R> {
    pub(crate) const fn new(block: R) -> Self {
        Self { filling: Lock::new(block), waiting: Lock::new(None) }
    }

    /// Takes a sample by `push`, and hands over a complete block.
    ///
    /// # Errors
    /// [`BwCode::Busy`]; [`BwCode::RecorderFull`]: `push` was called, but has no block for the sample.
    #[inline]
    pub(crate) fn push(&self, push: impl Fn(&mut R)) -> Outcome {
        self.filling.with(|block| {
            if block.is_complete() && self.hand_over(block) == BwCode::Ok {
                // A recorder of samples counts those that it does not take.
                push(block);
                return Err(BwCode::RecorderFull);
            }
            push(block);
            Ok(self.hand_over(block))
        })?
    }

    /// Changes the block that is being filled, and hands it over if it is complete then.
    ///
    /// # Errors
    /// [`BwCode::Busy`].
    pub(crate) fn change(&self, change: impl FnOnce(&mut R)) -> Outcome {
        self.filling.with(|block| {
            change(block);
            self.hand_over(block)
        })
    }

    /// Moves a complete block to its place, if that is free: the main loop works on a block that waits.
    fn hand_over(&self, block: &mut R) -> BwCode {
        let place = |waiting: &mut Option<R>| {
            let free = block.is_complete() && waiting.is_none();
            if free {
                *waiting = Some(block.take());
            }
            free
        };
        if self.waiting.with(place) == Ok(true) { BwCode::Block } else { BwCode::Ok }
    }

    /// Works on the block that waits; if that succeeds, it waits no longer.
    ///
    /// # Errors
    /// [`BwCode::Idle`] if none waits, [`BwCode::Busy`], and what the work returns.
    pub(crate) fn serve<T>(&self, work: impl FnOnce(&R) -> Outcome<T>) -> Outcome<T> {
        let serve = |waiting: &mut Option<R>| {
            let done = work(waiting.as_ref().ok_or(BwCode::Idle)?)?;
            *waiting = None;
            Ok(done)
        };
        self.waiting.with(serve)?
    }
}
