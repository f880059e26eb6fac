//! The memory of both segments, which contexts hand to each other while the watch runs.

use spin::mutex::SpinMutex as TryLock;
use static_cell::StaticCell;

use crate::detector::Segment;
use crate::model::Model;
use crate::plan::Plan;

/// Room for a segment.
pub(super) type Place<P> = &'static mut Segment<P>;

/// Both places: in their memory before the first start, free before the next one.
pub(super) struct Places<P: Plan + 'static> {
    memory: [StaticCell<Segment<P>>; 2],
    free: TryLock<[Option<Place<P>>; 2]>,
}

impl<P: Plan> Places<P> {
    pub(super) const fn new() -> Self {
        Self { memory: [const { StaticCell::new() }; 2], free: TryLock::new([None, None]) }
    }

    /// Both places, clear for this model; `None` while one of them is in use.
    pub(super) fn take(&'static self, model: &'static Model<P>) -> Option<[Place<P>; 2]> {
        let mut free = self.free.try_lock()?;
        for (place, memory) in free.iter_mut().zip(&self.memory) {
            match place {
                Some(place) => place.clear(model),
                None => *place = memory.try_init_with(|| Segment::new(model)),
            }
        }
        if free.iter().any(Option::is_none) {
            return None;
        }
        let [first, second] = &mut *free;
        Some([first.take()?, second.take()?])
    }

    /// Takes a place back.
    pub(super) fn give(&self, place: Place<P>) {
        if let Some(mut free) = self.free.try_lock()
            && let Some(room) = free.iter_mut().find(|free| free.is_none())
        {
            *room = Some(place);
        }
    }
}
