//! Numbers → bytes and an identity, also in constants.

/// Appends numbers to a buffer, and mixes them into an identity. It is `const`, so that an exported model has its
/// identity at compile time. Lists of other numbers have other identities, but for one pair in 2³².
pub(crate) struct Output<'b> {
    free: &'b mut [u8],
    written: usize,
    lost: bool,
    mixed: u32,
}

impl<'b> Output<'b> {
    /// Into this buffer; an empty one is enough for the identity.
    pub(crate) const fn new(free: &'b mut [u8]) -> Self {
        Self { free, written: 0, lost: false, mixed: 0 }
    }

    /// Number of bytes; `None` if they did not fit.
    pub(crate) const fn written(&self) -> Option<usize> {
        if self.lost { None } else { Some(self.written) }
    }

    /// The identity of the numbers so far.
    pub(crate) const fn identity(&self) -> u32 {
        self.mixed
    }

    /// Multiplication spreads a word upwards, the shift downwards.
    pub(crate) const fn mix(&mut self, word: u32) {
        let mixed = (self.mixed ^ word).wrapping_mul(0x9E37_79B1);
        self.mixed = mixed ^ (mixed >> 15);
    }

    /// Bytes that are not part of the identity, such as names.
    #[expect(clippy::mem_replace_with_default, reason = "`take` is not `const`")]
    pub(crate) const fn text(&mut self, bytes: &[u8]) {
        let mut rest = bytes;
        while let [byte, later @ ..] = rest {
            if let [cell, free @ ..] = core::mem::replace(&mut self.free, &mut []) {
                *cell = *byte;
                self.free = free;
                self.written = self.written.wrapping_add(1);
            } else {
                self.lost = true;
            }
            rest = later;
        }
    }

    pub(crate) const fn u8(&mut self, x: u8) {
        self.mix(x as u32);
        self.text(&[x]);
    }

    pub(crate) const fn u16(&mut self, x: u16) {
        self.mix(x as u32);
        self.text(&x.to_le_bytes());
    }

    pub(crate) const fn u32(&mut self, x: u32) {
        self.mix(x);
        self.text(&x.to_le_bytes());
    }

    pub(crate) const fn f32(&mut self, x: f32) {
        self.u32(x.to_bits());
    }

    pub(crate) const fn floats(&mut self, values: &[f32]) {
        let mut rest = values;
        while let [x, later @ ..] = rest {
            self.f32(*x);
            rest = later;
        }
    }
}
