//! Array lengths as types, so that one plan fixes every length of a detector.
//!
//! Stable Rust accepts no expression of a type's constants as an array length inside a generic type. A [`Size`] carries
//! the length instead: [`Fixed`] stands for an array of `N` elements, `Heap` (feature `alloc`) for a vector whose
//! length is known at run time only, and `Bounded` (feature `bounded`) for such a vector in an array of `N` places,
//! without an allocator. A length of 0 or 1 stands for a part that a plan leaves out or has.

use crate::printable::Printable;

/// An element of an array whose length a plan fixes.
pub trait Item: Clone + PartialEq + Printable {}
impl<T: Clone + PartialEq + Printable> Item for T {}

/// Elements of one type, as many as a [`Size`] says.
pub trait Cells<T>: Clone + PartialEq + Printable {
    /// Whether kernels for each length are worth their flash. Where the length is known at run time only, none of them
    /// can be left out.
    const UNROLL: bool = true;

    /// `length` elements; an array has its own length and ignores the argument.
    fn from_fn(length: usize, element: impl FnMut(usize) -> T) -> Self;

    /// The elements.
    fn cells(&self) -> &[T];

    /// The elements, to be changed.
    fn cells_mut(&mut self) -> &mut [T];

    /// `length` copies of a value.
    #[inline(always)]
    fn filled(length: usize, value: T) -> Self
    where
        T: Clone,
    {
        Self::from_fn(length, |_| value.clone())
    }

    /// The only element of an array of length 1; `None` for length 0.
    #[inline(always)]
    fn part(&self) -> Option<&T> {
        self.cells().first()
    }

    /// The only element of an array of length 1, to be changed; `None` for length 0.
    #[inline(always)]
    fn part_mut(&mut self) -> Option<&mut T> {
        self.cells_mut().first_mut()
    }
}

/// A length.
pub trait Size: sealed::Sealed + Copy + PartialEq + Printable {
    /// Elements of type `T`.
    type Array<T: Item>: Cells<T>;

    /// A function of each element.
    fn map<T: Item, U: Item>(from: &Self::Array<T>, element: impl FnMut(&T) -> U) -> Self::Array<U>;
}

/// The length of a part that a plan has or leaves out: 1 or 0.
pub trait Presence: Size {
    /// The part if `present`; an array has its own length and ignores the argument.
    fn part<T: Item>(present: bool, part: impl FnOnce() -> T) -> Self::Array<T>;

    /// A function of the part, if there is one.
    fn map_part<T: Item, U: Item>(from: &Self::Array<T>, part: impl FnOnce(&T) -> U) -> Self::Array<U>;
}

/// Elements of type `T`, as many as the size `S` says.
pub type Array<S, T> = <S as Size>::Array<T>;

/// The length `N`, known at compile time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fixed<const N: usize>;

impl<const N: usize> Size for Fixed<N> {
    type Array<T: Item> = [T; N];

    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "the index is below N")]
    fn map<T: Item, U: Item>(from: &[T; N], mut element: impl FnMut(&T) -> U) -> [U; N] {
        // Not by `each_ref().map`, which moves every element once more.
        core::array::from_fn(|k| element(&from[k]))
    }
}

/// The length 0 or 1, known at compile time.
// Not `Fixed`: its generic functions move a part, which may have hundreds of bytes, once more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Present<const N: usize>;

impl<const N: usize> Size for Present<N> {
    type Array<T: Item> = [T; N];

    #[inline(always)]
    fn map<T: Item, U: Item>(from: &[T; N], element: impl FnMut(&T) -> U) -> [U; N] {
        Fixed::<N>::map(from, element)
    }
}

impl Presence for Present<0> {
    #[inline(always)]
    fn part<T: Item>(_present: bool, _part: impl FnOnce() -> T) -> [T; 0] {
        []
    }

    #[inline(always)]
    fn map_part<T: Item, U: Item>([]: &[T; 0], _part: impl FnOnce(&T) -> U) -> [U; 0] {
        []
    }
}

impl Presence for Present<1> {
    #[inline(always)]
    fn part<T: Item>(_present: bool, part: impl FnOnce() -> T) -> [T; 1] {
        [part()]
    }

    #[inline(always)]
    fn map_part<T: Item, U: Item>([from]: &[T; 1], part: impl FnOnce(&T) -> U) -> [U; 1] {
        [part(from)]
    }
}

impl<T: Item, const N: usize> Cells<T> for [T; N] {
    #[inline(always)]
    fn from_fn(_length: usize, element: impl FnMut(usize) -> T) -> Self {
        core::array::from_fn(element)
    }

    #[inline(always)]
    fn cells(&self) -> &[T] {
        self
    }

    #[inline(always)]
    fn cells_mut(&mut self) -> &mut [T] {
        self
    }
}

/// A length known at run time only.
#[cfg(any(test, feature = "alloc"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heap;

/// A vector, whatever the length.
#[cfg(any(test, feature = "alloc"))]
pub type AnyLength<const N: usize> = Heap;

#[cfg(any(test, feature = "alloc"))]
impl Size for Heap {
    type Array<T: Item> = alloc::vec::Vec<T>;

    fn map<T: Item, U: Item>(from: &alloc::vec::Vec<T>, element: impl FnMut(&T) -> U) -> alloc::vec::Vec<U> {
        from.iter().map(element).collect()
    }
}

#[cfg(any(test, feature = "alloc"))]
impl Presence for Heap {
    fn part<T: Item>(present: bool, part: impl FnOnce() -> T) -> alloc::vec::Vec<T> {
        if present { alloc::vec![part()] } else { alloc::vec::Vec::new() }
    }

    fn map_part<T: Item, U: Item>(from: &alloc::vec::Vec<T>, part: impl FnOnce(&T) -> U) -> alloc::vec::Vec<U> {
        from.first().map(part).into_iter().collect()
    }
}

#[cfg(any(test, feature = "alloc"))]
impl<T: Item> Cells<T> for alloc::vec::Vec<T> {
    fn from_fn(length: usize, element: impl FnMut(usize) -> T) -> Self {
        (0..length).map(element).collect()
    }

    #[inline(always)]
    fn cells(&self) -> &[T] {
        self
    }

    #[inline(always)]
    fn cells_mut(&mut self) -> &mut [T] {
        self
    }
}

/// A length known at run time only, at most `N`; elements beyond are dropped. [`Plan::of`](super::Plan::of) must refuse
/// layouts with longer arrays.
#[cfg(any(test, feature = "bounded"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounded<const N: usize>;

#[cfg(any(test, feature = "bounded"))]
impl<const N: usize> Size for Bounded<N> {
    type Array<T: Item> = heapless::Vec<T, N>;

    fn map<T: Item, U: Item>(from: &heapless::Vec<T, N>, element: impl FnMut(&T) -> U) -> heapless::Vec<U, N> {
        first(from.iter().map(element))
    }
}

#[cfg(any(test, feature = "bounded"))]
impl<const N: usize> Presence for Bounded<N> {
    fn part<T: Item>(present: bool, part: impl FnOnce() -> T) -> heapless::Vec<T, N> {
        first(present.then(part).into_iter())
    }

    fn map_part<T: Item, U: Item>(from: &heapless::Vec<T, N>, part: impl FnOnce(&T) -> U) -> heapless::Vec<U, N> {
        first(from.first().map(part).into_iter())
    }
}

#[cfg(any(test, feature = "bounded"))]
impl<T: Item, const N: usize> Cells<T> for heapless::Vec<T, N> {
    const UNROLL: bool = false;

    fn from_fn(length: usize, element: impl FnMut(usize) -> T) -> Self {
        first((0..length).map(element))
    }

    #[inline(always)]
    fn cells(&self) -> &[T] {
        self
    }

    #[inline(always)]
    fn cells_mut(&mut self) -> &mut [T] {
        self
    }
}

/// The first `N` elements. Not by `collect`, which panics if there are more.
#[cfg(any(test, feature = "bounded"))]
#[inline(always)]
fn first<T, const N: usize>(elements: impl Iterator<Item = T>) -> heapless::Vec<T, N> {
    let mut cells = heapless::Vec::new();
    for element in elements.take(N) {
        // Never full: at most N elements come.
        let _full = cells.push(element);
    }
    cells
}

mod sealed {
    pub trait Sealed {}
    impl<const N: usize> Sealed for super::Fixed<N> {}
    impl<const N: usize> Sealed for super::Present<N> {}
    #[cfg(any(test, feature = "alloc"))]
    impl Sealed for super::Heap {}
    #[cfg(any(test, feature = "bounded"))]
    impl<const N: usize> Sealed for super::Bounded<N> {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounded_lengths_are_those_asked_for_up_to_the_bound() {
        let cells = <Array<Bounded<3>, usize> as Cells<usize>>::from_fn(2, |k| 10 * k);
        assert_eq!(cells.cells(), [0, 10]);
        assert_eq!(Bounded::<3>::map(&cells, |x| x + 1).cells(), [1, 11]);
        assert_eq!(<Array<Bounded<3>, u8> as Cells<u8>>::filled(5, 7).cells(), [7; 3]);
        let part = Bounded::<1>::part(true, || 2.5);
        assert_eq!(Bounded::<1>::map_part(&part, |x| 2.0 * x).part(), Some(&5.0));
        assert_eq!(Bounded::<1>::part(false, || 2.5).part(), None);
        assert_eq!(Bounded::<0>::part(true, || 2.5).part(), None);
    }
}
