//! The state in the caller's memory, and how functions reach it.
//!
//! A state has two parts that are worked on at the same time: the sampling interrupt feeds the detector, and the main
//! loop solves. A closed segment waits between them. Each part has a lock that never blocks: a function that finds it
//! taken returns [`BwCode::Busy`]. A single-core chip whose interrupt calls `bw_collect` only, and whose main loop
//! masks that interrupt for `bw_adopt` and `bw_reset`, never sees it.

use core::cell::UnsafeCell;
use core::ffi::c_void;
use core::mem::{ManuallyDrop, offset_of};
use core::ops::Deref;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

use bearing_watch::drive::Alignment;
use bearing_watch::model::Sampling;
use bearing_watch::plan::Plan;
use bearing_watch::{Detector, Liveness, LivenessLimits, Model, Monitor, RateCheck, Segment};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{BW_STATE_ALIGN, Object, Tag, check, elements, put, room};
use crate::plan::Own;
use crate::waiting::Waiting;

/// Bytes of memory that are enough for `bw_init` of a library without a plan of its own; `bw_state_size` returns what
/// exactly is needed.
pub const BW_STATE_SIZE: usize = 23552;

const _: () = assert!(size_of::<WithModel>() <= BW_STATE_SIZE || cfg!(bearing_watch_plan));
const _: () = assert!(align_of::<BwState>() <= BW_STATE_ALIGN);

/// A detector of one drive, in memory of the caller.
#[derive(Debug)]
pub struct BwState(Halves);

/// A state with the model that it read.
#[repr(C)]
struct WithModel {
    state: BwState,
    model: Model<Own>,
}

/// In this order: short loads of the interrupt reach what it works on.
#[repr(C)]
#[derive(Debug)]
pub struct Halves {
    tag: Tag,
    /// Samples that were lost because a function was busy, and segments that were not taken.
    pub(crate) lost_samples: AtomicU32,
    pub(crate) lost_segments: AtomicU32,
    /// Segments that have closed, and those with a verdict, with wrap-around.
    pub(crate) closed_segments: AtomicU32,
    pub(crate) verdicts: AtomicU32,
    /// Samples lost since the last one that the detector took, which must know of the gap.
    pub(crate) missed: AtomicU32,
    /// Number of the segment that `bw_discard` has put in doubt; [`NO_SEGMENT`] at first.
    pub(crate) doubted: AtomicU32,
    /// Place in `Alignment::ALL` of what the front end knows of the wiring; none without a front end.
    pub(crate) alignment: AtomicU8,
    pub(crate) closed: Slot<Segment<Own>>,
    pub(crate) waiting: Waiting<Sample>,
    pub(crate) sampling: Lock<OwnDetector>,
    pub(crate) model: &'static Model<Own>,
    /// The open segment and the one of the slot, in turns.
    places: [UnsafeCell<Segment<Own>>; 2],
    pub(crate) solving: Lock<OwnMonitor>,
    pub(crate) clock: Lock<Clock>,
}

/// A sample of the plan.
pub(crate) type Sample = <Own as Plan>::Sample;

/// What the interrupt works on.
pub(crate) type OwnDetector = Detector<'static, Own, &'static mut Segment<Own>>;

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

/// Adds one with wrap-around, for the clock, which compares differences.
pub(crate) fn count_on(counter: &AtomicU32) {
    counter.store(counter.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

/// What the clock is compared with.
#[derive(Debug)]
pub(crate) struct Clock {
    pub(crate) rate: RateCheck,
    /// Whether the last window of the rate was right.
    pub(crate) right: bool,
    /// Whether the clock was read.
    pub(crate) started: bool,
    pub(crate) liveness: Liveness,
}

impl Clock {
    pub(crate) fn new(sampling: &Sampling) -> Self {
        let liveness = Liveness::new(LivenessLimits::of_segments(sampling.segment_s()));
        Self { rate: RateCheck::of_milliseconds(sampling.interval_s), right: true, started: false, liveness }
    }

    /// Starts anew, after a pause of the samples.
    pub(crate) const fn restart(&mut self) {
        self.rate.restart();
        self.liveness.restart();
    }
}

impl BwState {
    /// Works on what the main loop works on, once a report in doubt is withdrawn.
    ///
    /// # Errors
    /// [`BwCode::Busy`].
    pub(crate) fn settled<R>(&self, work: impl FnOnce(&mut OwnMonitor) -> R) -> Outcome<R> {
        self.solving.with(|monitor| {
            self.settle(monitor);
            work(monitor)
        })
    }

    /// What is known of the wiring.
    pub(crate) fn alignment(&self) -> Alignment {
        let place = self.alignment.load(Ordering::Relaxed);
        Alignment::ALL.get(usize::from(place)).copied().unwrap_or_default()
    }

    // Here once, for all kinds of work.
    #[inline(never)]
    fn settle(&self, monitor: &mut OwnMonitor) {
        monitor.tell_alignment(self.alignment());
        monitor.withdraw(self.doubted.load(Ordering::Relaxed));
    }
}

impl Object for WithModel {
    const MARK: u32 = BwState::MARK;
    const PLACE_OF_TAG: usize = offset_of!(Self, state) + BwState::PLACE_OF_TAG;
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

/// The place of a segment between the interrupt and the main loop. The flag says whose it is: while it is not full, of
/// the interrupt, which exchanges it for the place of a closed segment.
#[derive(Debug)]
pub(crate) struct Slot<T: 'static> {
    full: AtomicBool,
    place: UnsafeCell<Option<&'static mut T>>,
}

// SAFETY: one caller at a time fills and one empties, by the contracts of the functions, and the flag hands the place
// over.
unsafe impl<T: Send> Sync for Slot<T> {}

impl<T> Slot<T> {
    const fn new(place: &'static mut T) -> Self {
        Self { full: AtomicBool::new(false), place: UnsafeCell::new(Some(place)) }
    }

    /// Whether a segment waits.
    pub(crate) fn is_full(&self) -> bool {
        self.full.load(Ordering::Acquire)
    }

    /// Lets a function have the place of an empty slot, and nothing of a full one.
    ///
    /// # Safety
    /// No other call of this function or of [`Slot::fill`] at the same time.
    #[inline]
    pub(crate) unsafe fn with_spare<R>(&self, work: impl FnOnce(&mut Option<&'static mut T>) -> R) -> R {
        let mut none = None;
        // SAFETY: an empty slot belongs to the one that fills it.
        let spare = if self.is_full() { &mut none } else { unsafe { &mut *self.place.get() } };
        // Called in one place: each has its copy of the code of a sample.
        work(spare)
    }

    /// Fills a slot whose place was taken.
    ///
    /// # Safety
    /// As [`Slot::with_spare`], which took the place.
    pub(crate) unsafe fn fill(&self, place: &'static mut T) {
        // SAFETY: a slot without its place is empty, and belongs to the one that fills it.
        unsafe { *self.place.get() = Some(place) };
        self.full.store(true, Ordering::Release);
    }

    /// Empties a full slot once a function has read it.
    ///
    /// # Safety
    /// No other call empties the slot at the same time.
    pub(crate) unsafe fn empty(&self, read: impl FnOnce(&mut T)) {
        if self.is_full() {
            // SAFETY: a full slot belongs to the one that empties it.
            unsafe { (*self.place.get()).as_deref_mut() }.map(read);
            self.full.store(false, Ordering::Release);
        }
    }
}

/// Returns the number of bytes of memory that `bw_init` needs: with a plan of its own a library needs less.
#[unsafe(no_mangle)]
pub extern "C" fn bw_state_size() -> usize {
    size_of::<WithModel>()
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
#[must_use]
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
    let whole: *mut WithModel = room(memory, size)?;
    // SAFETY: the memory is large enough, aligned, and writable by the contract, and no other function works on it;
    // the bytes are readable by the contract. What was there owns nothing that would have to be dropped. The model is
    // never changed, and stays where it is as long as the detector that borrows it: both are in this memory.
    unsafe {
        place_model(whole, elements(model, length)?)?;
        fill(whole.cast(), &(*whole).model, state)
    }
}

/// Makes a state with the model that the library was built with (`BEARING_WATCH_PLAN=model.rs`), whose `BW_MODEL_ID`
/// is `id`, and gives its address in `state`. Nothing is read or checked when it runs: the compiler has done that. It
/// needs less memory than `bw_init`, little stack, and half of the flash.
///
/// Returns `BW_CODE_OK`, `BW_CODE_MODEL_DOES_NOT_FIT` if the library was built with another model or with none, or what
/// is wrong with the memory.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the state is used no more. `state` is
/// NULL or writable. No other function works on the state.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_init_own(memory: *mut c_void, size: usize, id: u32, state: *mut *mut BwState) -> BwCode {
    let init = || {
        check(state)?;
        let own: *mut BwState = room(memory, size)?;
        let model = own_model().filter(|model| model.id() == id).ok_or(BwCode::ModelDoesNotFit)?;
        // SAFETY: the memory is large enough, aligned, and writable by the contract, and no other function works on it.
        unsafe {
            (&raw mut (*own).0.tag).write(Tag::none());
            fill(own, model, state)
        }
    };
    code(init())
}

/// The model that the library was built with.
#[cfg(bearing_watch_plan)]
fn own_model() -> Option<&'static Model<Own>> {
    Some(&crate::plan::MODEL)
}

#[cfg(not(bearing_watch_plan))]
const fn own_model() -> Option<&'static Model<Own>> {
    None
}

/// Fills all of a state but its tag, which is none.
///
/// # Safety
/// The state has its memory, and no other function works on it. `state` is writable.
unsafe fn fill(own: *mut BwState, model: &'static Model<Own>, state: *mut *mut BwState) -> Outcome {
    // SAFETY: the contract of the caller.
    unsafe {
        (&raw mut (*own).0.model).write(model);
        (&raw mut (*own).0.lost_samples).write(AtomicU32::new(0));
        (&raw mut (*own).0.lost_segments).write(AtomicU32::new(0));
        (&raw mut (*own).0.missed).write(AtomicU32::new(0));
        (&raw mut (*own).0.waiting).write(Waiting::new());
        (&raw mut (*own).0.doubted).write(AtomicU32::new(NO_SEGMENT));
        (&raw mut (*own).0.alignment).write(AtomicU8::new(Alignment::Unknown as u8));
        let [open, spare] = place_segments(own);
        (&raw mut (*own).0.closed).write(Slot::new(spare));
        place_detector(own, model, open);
        place_monitor(own, model);
        (&raw mut (*own).0.clock).write(Lock::new(Clock::new(&model.constants().sampling)));
        (&raw mut (*own).0.closed_segments).write(AtomicU32::new(0));
        (&raw mut (*own).0.verdicts).write(AtomicU32::new(0));
        (*own).0.tag.set(own);
        put(state, own)?;
    }
    Ok(BwCode::Ok)
}

/// Reads the model, and puts it in its place if it is good. The state is not valid from there on.
// Out of line like the next three, so that none of them takes stack while another runs.
#[inline(never)]
unsafe fn place_model(whole: *mut WithModel, bytes: &[u8]) -> Outcome<()> {
    let model = ManuallyDrop::new(Model::<Own>::from_sector(bytes));
    match &*model {
        Ok(model) => {
            // SAFETY: the contract of the caller; the other model is neither used nor dropped after this. To take it out
            // of the result would move it once more on the stack.
            unsafe {
                (&raw mut (*whole).state.0.tag).write(Tag::none());
                (&raw mut (*whole).model).copy_from_nonoverlapping(model, 1);
            }
            Ok(())
        }
        Err(error) => Err((*error).into()),
    }
}

/// Makes the places, which stay where they are, and to which nothing else refers.
#[inline(never)]
unsafe fn place_segments(own: *mut BwState) -> [&'static mut Segment<Own>; 2] {
    // SAFETY: the contract of the caller.
    let places = unsafe { &raw mut (*own).0.places }.cast::<UnsafeCell<Segment<Own>>>();
    [0, 1].map(|k| {
        // SAFETY: as above; there are two of them.
        unsafe {
            places.add(k).write(UnsafeCell::new(Segment::new((*own).0.model)));
            &mut *UnsafeCell::raw_get(places.add(k))
        }
    })
}

#[inline(never)]
unsafe fn place_detector(own: *mut BwState, model: &'static Model<Own>, open: &'static mut Segment<Own>) {
    // SAFETY: the contract of the caller.
    unsafe { (&raw mut (*own).0.sampling).write(Lock::new(Detector::with_place(model, open))) };
}

#[inline(never)]
unsafe fn place_monitor(own: *mut BwState, model: &'static Model<Own>) {
    // SAFETY: the contract of the caller.
    unsafe { (&raw mut (*own).0.solving).write(Lock::new(Monitor::new(model))) };
}
