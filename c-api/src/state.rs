//! The state in the caller's memory, and how functions reach it.
//!
//! A state has two parts that are worked on at the same time: the sampling interrupt feeds the detector, and the main
//! loop solves. A closed segment waits between them. Each part has a lock that never blocks: a function that finds it
//! taken returns [`BwCode::Busy`]. A single-core chip whose interrupt calls `bw_collect` only, and whose main loop
//! masks that interrupt for `bw_adopt` and `bw_reset`, never sees it.

use core::cell::UnsafeCell;
use core::ffi::c_void;
use core::mem::{ManuallyDrop, MaybeUninit, offset_of};
use core::ops::Deref;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use bearing_watch::{Detector, Model, Monitor, Segment};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{BW_STATE_ALIGN, Object, Tag, check, elements, put, room};
use crate::plan::Own;

/// Bytes of memory that are enough for `bw_init` of a library without a plan of its own; `bw_state_size` returns what
/// exactly is needed.
pub const BW_STATE_SIZE: usize = 23552;

const _: () = assert!(size_of::<BwState>() <= BW_STATE_SIZE || cfg!(bearing_watch_plan));
const _: () = assert!(align_of::<BwState>() <= BW_STATE_ALIGN);

/// A detector of one drive, in memory of the caller.
#[derive(Debug)]
pub struct BwState(Halves);

/// In this order: short loads of the interrupt reach what it works on.
#[repr(C)]
#[derive(Debug)]
pub struct Halves {
    tag: Tag,
    /// Samples that were lost because a function was busy, and segments that were not taken.
    pub(crate) lost_samples: AtomicU32,
    pub(crate) lost_segments: AtomicU32,
    /// Samples lost since the last one that the detector took, which must know of the gap.
    pub(crate) missed: AtomicU32,
    /// Number of the segment that `bw_discard` has put in doubt; [`NO_SEGMENT`] at first.
    pub(crate) doubted: AtomicU32,
    pub(crate) sampling: Lock<Detector<'static, Own>>,
    pub(crate) model: Model<Own>,
    pub(crate) closed: Slot<Segment<Own>>,
    pub(crate) solving: Lock<OwnMonitor>,
}

/// What the main loop works on.
pub(crate) type OwnMonitor = Monitor<'static, Own>;

/// No segment has this number.
const NO_SEGMENT: u32 = u32::MAX;

impl Deref for BwState {
    type Target = Halves;

    fn deref(&self) -> &Halves {
        &self.0
    }
}

impl BwState {
    /// Works on what the main loop works on, once a report in doubt is withdrawn.
    ///
    /// # Errors
    /// [`BwCode::Busy`].
    pub(crate) fn settled<R>(&self, work: impl FnOnce(&mut OwnMonitor) -> R) -> Outcome<R> {
        self.solving.with(|monitor| {
            monitor.withdraw(self.doubted.load(Ordering::Relaxed));
            work(monitor)
        })
    }
}

impl Object for BwState {
    const MARK: u32 = 0x4257_4331;
    const PLACE_OF_TAG: usize = offset_of!(Self, 0.tag);
}

/// A value that one function at a time works on; others are refused, not made to wait.
#[derive(Debug)]
pub(crate) struct Lock<T> {
    taken: AtomicBool,
    value: UnsafeCell<T>,
}

// SAFETY: `with` gives access to one caller at a time, and `T` may be used from any thread.
unsafe impl<T: Send> Sync for Lock<T> {}

impl<T> Lock<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self { taken: AtomicBool::new(false), value: UnsafeCell::new(value) }
    }

    /// Works on the value.
    ///
    /// # Errors
    /// [`BwCode::Busy`] if another function works on it.
    #[inline]
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Outcome<R> {
        if self.taken.swap(true, Ordering::Acquire) {
            return Err(BwCode::Busy);
        }
        // SAFETY: the flag was free and is now taken by this function alone.
        let result = work(unsafe { &mut *self.value.get() });
        self.taken.store(false, Ordering::Release);
        Ok(result)
    }
}

/// Room for one value between the interrupt and the main loop. The flag says whose the room is: while it is not full, of
/// the one that fills it.
#[derive(Debug)]
pub(crate) struct Slot<T> {
    full: AtomicBool,
    value: UnsafeCell<MaybeUninit<T>>,
}

// SAFETY: one caller at a time fills and one empties, by the contracts of the functions, and the flag hands the value
// over.
unsafe impl<T: Send> Sync for Slot<T> {}

impl<T> Slot<T> {
    const fn new() -> Self {
        Self { full: AtomicBool::new(false), value: UnsafeCell::new(MaybeUninit::uninit()) }
    }

    /// Whether a value waits.
    pub(crate) fn is_full(&self) -> bool {
        self.full.load(Ordering::Acquire)
    }

    /// Fills an empty slot; returns whether it was empty.
    ///
    /// # Safety
    /// No other call fills the slot at the same time.
    pub(crate) unsafe fn fill(&self, value: T) -> bool {
        if self.full.load(Ordering::Acquire) {
            return false;
        }
        // SAFETY: an empty slot belongs to the one that fills it.
        unsafe { (*self.value.get()).write(value) };
        self.full.store(true, Ordering::Release);
        true
    }

    /// Empties a full slot into a function; returns whether it was full.
    ///
    /// # Safety
    /// No other call empties the slot at the same time.
    pub(crate) unsafe fn empty(&self, into: impl FnOnce(T)) -> bool {
        if !self.full.load(Ordering::Acquire) {
            return false;
        }
        // SAFETY: a full slot belongs to the one that empties it, and its value is taken once.
        into(unsafe { (*self.value.get()).assume_init_read() });
        self.full.store(false, Ordering::Release);
        true
    }
}

/// Returns the number of bytes of memory that `bw_init` needs: with a plan of its own a library needs less.
#[unsafe(no_mangle)]
pub extern "C" fn bw_state_size() -> usize {
    size_of::<BwState>()
}

/// Makes a state in memory of the caller from a model as `bearing-watch train --model` or `--c` writes it, and gives
/// its address in `state`. What follows the model, such as the erased rest of a flash sector, is ignored. The bytes of
/// the model are not needed afterwards. In case of an error the memory is unchanged. A state can be initialised again,
/// for another model, while no other function works on it. Needs about three times the memory of a model on the stack.
///
/// Returns `BW_CODE_OK`, or what is wrong with memory or model.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the state is used no more. `model` is
/// NULL or has `length` readable bytes. `state` is NULL or writable. No other function works on the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_init(
    memory: *mut c_void,
    size: usize,
    model: *const u8,
    length: usize,
    state: *mut *mut BwState,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { init(memory, size, (model, length), state) })
}

unsafe fn init(
    memory: *mut c_void,
    size: usize,
    (model, length): (*const u8, usize),
    state: *mut *mut BwState,
) -> Outcome {
    check(state)?;
    let own: *mut BwState = room(memory, size)?;
    // SAFETY: the memory is large enough, aligned, and writable by the contract, and no other function works on it;
    // the bytes are readable by the contract. What was there owns nothing that would have to be dropped. The model is
    // never changed, and stays where it is as long as the detector that borrows it: both are in this memory.
    unsafe {
        place_model(own, elements(model, length)?)?;
        (&raw mut (*own).0.lost_samples).write(AtomicU32::new(0));
        (&raw mut (*own).0.lost_segments).write(AtomicU32::new(0));
        (&raw mut (*own).0.missed).write(AtomicU32::new(0));
        (&raw mut (*own).0.doubted).write(AtomicU32::new(NO_SEGMENT));
        (&raw mut (*own).0.closed).write(Slot::new());
        place_detector(own, &(*own).0.model);
        place_monitor(own, &(*own).0.model);
        (*own).0.tag.set(own);
        put(state, own)?;
    }
    Ok(BwCode::Ok)
}

/// Reads the model, and puts it in its place if it is good. The state is not valid from there on.
// Out of line like the next two, so that none of them takes stack while another runs.
#[inline(never)]
unsafe fn place_model(own: *mut BwState, bytes: &[u8]) -> Outcome<()> {
    let model = ManuallyDrop::new(Model::<Own>::from_sector(bytes));
    match &*model {
        Ok(model) => {
            // SAFETY: the contract of the caller; the other model is neither used nor dropped after this. To take it out
            // of the result would move it once more on the stack.
            unsafe {
                (&raw mut (*own).0.tag).write(Tag::none());
                (&raw mut (*own).0.model).copy_from_nonoverlapping(model, 1);
            }
            Ok(())
        }
        Err(error) => Err((*error).into()),
    }
}

#[inline(never)]
unsafe fn place_detector(own: *mut BwState, model: &'static Model<Own>) {
    // SAFETY: the contract of the caller.
    unsafe { (&raw mut (*own).0.sampling).write(Lock::new(Detector::new(model))) };
}

#[inline(never)]
unsafe fn place_monitor(own: *mut BwState, model: &'static Model<Own>) {
    // SAFETY: the contract of the caller.
    unsafe { (&raw mut (*own).0.solving).write(Lock::new(Monitor::new(model))) };
}
