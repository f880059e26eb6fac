//! Memory of the caller: pointers, and objects that live in it.

use core::ffi::c_void;
use core::sync::atomic::{AtomicU32, Ordering};

use spin::mutex::SpinMutex;

use crate::code::{BwCode, Outcome};

/// Alignment of the memory of a state, bytes, and of the memory of all other objects.
pub const BW_STATE_ALIGN: usize = 8;

/// What the library keeps in memory of the caller, with a tag.
pub(crate) trait Object: Sized {
    /// Another one for each type.
    const MARK: u32;
    /// Bytes before the tag.
    const PLACE_OF_TAG: usize;
}

/// The mark of the type and the address of an object: neither other memory, nor an object of another type, nor a copy
/// passes for it. They are two words, since a word made of both would be that of another type at another address.
#[derive(Debug)]
pub(crate) struct Tag {
    mark: AtomicU32,
    address: AtomicU32,
}

impl Tag {
    /// Of no object yet.
    pub(crate) const fn none() -> Self {
        Self { mark: AtomicU32::new(0), address: AtomicU32::new(0) }
    }

    /// Makes it that of an object at this address, all of which is written.
    pub(crate) fn set<T: Object>(&self, object: *const T) {
        self.address.store(address(object), Ordering::Relaxed);
        self.mark.store(T::MARK, Ordering::Release);
    }

    /// Makes it that of no object.
    pub(crate) fn clear(&self) {
        self.mark.store(0, Ordering::Release);
    }

    fn is_of<T: Object>(&self, object: *const T) -> bool {
        self.mark.load(Ordering::Acquire) == T::MARK && self.address.load(Ordering::Relaxed) == address(object)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "on a host the lower half of the address is enough")]
fn address<T>(object: *const T) -> u32 {
    object.addr() as u32
}

/// Checks a pointer.
///
/// # Errors
/// [`BwCode::Null`] or [`BwCode::Misaligned`].
pub(crate) fn check<T>(pointer: *const T) -> Outcome<()> {
    if pointer.is_null() {
        Err(BwCode::Null)
    } else if !pointer.is_aligned() {
        Err(BwCode::Misaligned)
    } else {
        Ok(())
    }
}

/// The object at an address.
///
/// # Errors
/// As [`check`], and [`BwCode::NotInitialised`].
///
/// # Safety
/// The address is NULL, or that of as many readable bytes as an object has, that live as long as the result.
pub(crate) unsafe fn at<'a, T: Object>(object: *const T) -> Outcome<&'a T> {
    check(object)?;
    let place = object.wrapping_byte_add(T::PLACE_OF_TAG).cast::<Tag>();
    // SAFETY: aligned, and readable by the contract; atomics of any bits are valid.
    if !unsafe { &*place }.is_of(object) {
        return Err(BwCode::NotInitialised);
    }
    // SAFETY: the whole object is written before its tag.
    Ok(unsafe { &*object })
}

/// The place of an object in memory of `size` bytes.
///
/// # Errors
/// [`BwCode::Null`], [`BwCode::Misaligned`] or [`BwCode::MemoryTooSmall`].
pub(crate) fn room<T: Object>(memory: *mut c_void, size: usize) -> Outcome<*mut T> {
    const { assert!(align_of::<T>() <= BW_STATE_ALIGN) };
    check(memory)?;
    if !memory.addr().is_multiple_of(BW_STATE_ALIGN) {
        return Err(BwCode::Misaligned);
    }
    if size < size_of::<T>() { Err(BwCode::MemoryTooSmall) } else { Ok(memory.cast()) }
}

/// Puts an object into its place, and its address into `pointer`.
///
/// # Errors
/// As [`check`], of the pointer.
///
/// # Safety
/// The place is one of [`room`], with as many writable bytes, which no other function uses. The pointer is NULL or
/// writable.
pub(crate) unsafe fn put_object<T: Object>(place: *mut T, object: T, pointer: *mut *mut T) -> Outcome {
    check(pointer)?;
    // SAFETY: the contract of the caller. What was there owns nothing that would have to be dropped.
    unsafe {
        place.write(object);
        (*place.wrapping_byte_add(T::PLACE_OF_TAG).cast::<Tag>()).set(place);
        put(pointer, place)?;
    }
    Ok(BwCode::Ok)
}

/// Elements at an address.
///
/// # Errors
/// As [`check`].
///
/// # Safety
/// The address is NULL, or that of `count` readable elements that live as long as the result.
pub(crate) unsafe fn elements<'a, T>(first: *const T, count: usize) -> Outcome<&'a [T]> {
    check(first)?;
    // SAFETY: aligned, and readable by the contract.
    Ok(unsafe { core::slice::from_raw_parts(first, count) })
}

/// Elements at an address, to be written.
///
/// # Errors
/// As [`check`].
///
/// # Safety
/// The address is NULL, or that of `count` writable elements that live as long as the result, and no other reference to
/// them does.
pub(crate) unsafe fn elements_mut<'a, T>(first: *mut T, count: usize) -> Outcome<&'a mut [T]> {
    check(first)?;
    // SAFETY: aligned, and writable by the contract.
    Ok(unsafe { core::slice::from_raw_parts_mut(first, count) })
}

/// Reads a value at an address.
///
/// # Errors
/// As [`check`].
///
/// # Safety
/// The address is NULL, or that of a readable value.
pub(crate) unsafe fn get<T: Copy>(place: *const T) -> Outcome<T> {
    check(place)?;
    // SAFETY: aligned, and readable by the contract.
    Ok(unsafe { place.read() })
}

/// Writes a value to an address.
///
/// # Errors
/// As [`check`].
///
/// # Safety
/// The address is NULL or writable.
pub(crate) unsafe fn put<T>(place: *mut T, value: T) -> Outcome<()> {
    check(place)?;
    // SAFETY: aligned, and writable by the contract.
    unsafe { place.write(value) };
    Ok(())
}

/// A value that one function at a time works on; others are refused, not made to wait.
#[derive(Debug)]
pub(crate) struct Lock<T>(SpinMutex<T>);

impl<T> Lock<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self(SpinMutex::new(value))
    }

    /// Works on the value.
    ///
    /// # Errors
    /// [`BwCode::Busy`] if another function works on it.
    #[inline]
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Outcome<R> {
        self.0.try_lock().map(|mut value| work(&mut value)).ok_or(BwCode::Busy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::mem::offset_of;

    #[derive(Debug)]
    struct One {
        tag: Tag,
    }

    #[derive(Debug)]
    struct Other {
        tag: Tag,
    }

    impl Object for One {
        const MARK: u32 = 0x4257_4331;
        const PLACE_OF_TAG: usize = offset_of!(Self, tag);
    }

    impl Object for Other {
        const MARK: u32 = 0x4257_4339;
        const PLACE_OF_TAG: usize = offset_of!(Self, tag);
    }

    /// The marks differ by the distance of the places: mark and address in one word would be equal.
    #[test]
    fn a_copied_object_is_none_of_another_type() {
        for (from, to) in (0..8).flat_map(|from| (0..8).map(move |to| (from, to))) {
            let mut memory = [0_u64; 8];
            let first = memory.as_mut_ptr();
            let (from, to) = (first.wrapping_add(from), first.wrapping_add(to));
            let mut made = core::ptr::null_mut();
            // SAFETY: both places are in the memory, and an object has eight bytes.
            unsafe {
                assert_eq!(put_object(from.cast(), One { tag: Tag::none() }, &raw mut made), Ok(BwCode::Ok));
                assert!(at::<One>(made).is_ok());
                to.write(from.read());
                assert_eq!(at::<Other>(to.cast()).err(), Some(BwCode::NotInitialised));
                assert_eq!(at::<One>(to.cast()).is_ok(), to == from);
            }
        }
    }
}
