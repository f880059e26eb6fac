//! The bytes of a block that is being filled.

/// At most `BYTES` bytes, sample by sample; a complete block takes no more samples.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Filling<const BYTES: usize> {
    used: usize,
    complete: bool,
    bytes: [u8; BYTES],
}

impl<const BYTES: usize> Filling<BYTES> {
    pub const fn new() -> Self {
        Self { used: 0, complete: false, bytes: [0; BYTES] }
    }

    /// Hands the words of a sample of so many bytes over to be written; whether there was space. A block without it is
    /// complete, as is one without space for another sample.
    #[inline]
    pub fn add(&mut self, bytes: usize, write: impl FnOnce(&mut [[u8; 4]])) -> bool {
        let end = self.used.saturating_add(bytes);
        let cells = if self.complete { None } else { self.bytes.get_mut(self.used..end) };
        let Some(cells) = cells else {
            self.complete = true;
            return false;
        };
        write(cells.as_chunks_mut().0);
        self.used = end;
        self.complete = end.saturating_add(bytes) > BYTES;
        true
    }

    pub const fn is_empty(&self) -> bool {
        self.used == 0
    }

    pub const fn is_complete(&self) -> bool {
        self.complete
    }

    /// Takes no more samples.
    pub const fn complete(&mut self) {
        self.complete = true;
    }

    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.used).unwrap_or(&[])
    }

    pub const fn clear(&mut self) {
        (self.used, self.complete) = (0, false);
    }
}
