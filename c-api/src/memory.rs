//! Memory of the caller: pointers, and objects that live in it.

use core::ffi::c_void;
use core::sync::atomic::{AtomicU32, Ordering};

use crate::code::{BwCode, Outcome};
use crate::state::BW_STATE_ALIGN;

/// What the library keeps in memory of the caller. It has a tag, made of a mark and its address, so that neither other
/// memory nor a copy passes for it.
pub(crate) trait Object: Sized {
    /// Another one for each type.
    const MARK: u32;
    /// Bytes before the tag, an [`AtomicU32`].
    const PLACE_OF_TAG: usize;
}

/// The tag of an object at this address.
#[expect(clippy::cast_possible_truncation, reason = "on a host the lower half of the address is enough")]
pub(crate) fn tag<T: Object>(object: *const T) -> u32 {
    T::MARK ^ object.addr() as u32
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
    let place = object.wrapping_byte_add(T::PLACE_OF_TAG).cast_mut().cast();
    // SAFETY: aligned, and readable by the contract; an atomic of any bits is valid.
    let found = unsafe { AtomicU32::from_ptr(place) }.load(Ordering::Acquire);
    if found != tag(object) {
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
        let mark = place.wrapping_byte_add(T::PLACE_OF_TAG).cast();
        AtomicU32::from_ptr(mark).store(tag(place), Ordering::Release);
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
