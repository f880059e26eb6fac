//! Bytes → numbers.

use super::field::Field;

/// Why bytes are no list of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// There are fewer or more bytes.
    Truncated,
    /// A byte that selects one of several variants selects none.
    OutOfRange(Field),
    /// Only a newer build knows the variant.
    Newer,
}

/// Bytes that are left to be read. After the first fault, which [`Input::finish`] tells, what is read means nothing.
pub(crate) struct Input<'a> {
    rest: &'a [u8],
    fault: Option<Fault>,
}

impl<'a> Input<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, fault: None }
    }

    /// Keeps the first fault.
    pub(crate) const fn refuse(&mut self, fault: Fault) {
        if self.fault.is_none() {
            self.fault = Some(fault);
        }
    }

    /// What was wrong so far.
    ///
    /// # Errors
    /// The first fault.
    pub(crate) fn so_far(&self) -> Result<(), Fault> {
        self.fault.map_or(Ok(()), Err)
    }

    /// What was wrong with all of it, which includes bytes that are left over.
    ///
    /// # Errors
    /// The first fault.
    pub(crate) fn finish(&self) -> Result<(), Fault> {
        self.so_far()?;
        if self.rest.is_empty() { Ok(()) } else { Err(Fault::Truncated) }
    }

    pub(crate) fn array<const N: usize>(&mut self) -> [u8; N] {
        let Some((head, rest)) = self.rest.split_first_chunk() else {
            self.rest = &[];
            self.refuse(Fault::Truncated);
            return [0; N];
        };
        self.rest = rest;
        *head
    }

    pub(crate) fn u8(&mut self) -> u8 {
        u8::from_le_bytes(self.array())
    }

    pub(crate) fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    pub(crate) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    pub(crate) fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.array())
    }

    /// A byte that is 0 … `most`.
    pub(crate) fn choice(&mut self, most: u8, field: Field) -> u8 {
        let byte = self.u8();
        if byte > most {
            self.refuse(Fault::OutOfRange(field));
        }
        byte
    }

    pub(crate) fn flag(&mut self, field: Field) -> bool {
        self.choice(1, field) == 1
    }
}
