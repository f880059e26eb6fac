//! Files of the host, by semihosting on the target.

pub use on::File;

#[cfg(not(target_os = "none"))]
mod on {
    use std::io::{BufReader, Read as _};

    /// A file that is read in blocks of `BLOCK` bytes.
    pub struct File<const BLOCK: usize>(BufReader<std::fs::File>);

    impl<const BLOCK: usize> File<BLOCK> {
        /// `name` ends with a zero, which semihosting wants.
        pub fn open(name: &str) -> Option<Self> {
            let file = std::fs::File::open(name.trim_end_matches('\0')).ok()?;
            Some(Self(BufReader::with_capacity(BLOCK, file)))
        }

        /// Whether all of `bytes` was read.
        pub fn fill(&mut self, bytes: &mut [u8]) -> bool {
            self.0.read_exact(bytes).is_ok()
        }
    }
}

#[cfg(target_os = "none")]
mod on {
    use cortex_m_semihosting::syscall;

    /// Mode `rb` of `fopen`.
    const READ_BINARY: usize = 1;

    /// A file that is read in blocks of `BLOCK` bytes.
    pub struct File<const BLOCK: usize> {
        handle: usize,
        block: [u8; BLOCK],
        used: usize,
        filled: usize,
    }

    impl<const BLOCK: usize> File<BLOCK> {
        /// `name` ends with a zero, which semihosting wants.
        pub fn open(name: &str) -> Option<Self> {
            // SAFETY: the arguments are those of SYS_OPEN: text that ends with a zero, a mode, the length without it.
            let handle = unsafe { syscall!(OPEN, name.as_ptr(), READ_BINARY, name.len() - 1) };
            (handle != usize::MAX).then_some(Self { handle, block: [0; BLOCK], used: 0, filled: 0 })
        }

        /// Whether all of `bytes` was read.
        pub fn fill(&mut self, bytes: &mut [u8]) -> bool {
            bytes.iter_mut().all(|byte| self.next().map(|next| *byte = next).is_some())
        }

        fn next(&mut self) -> Option<u8> {
            if self.used == self.filled {
                // SAFETY: SYS_READ writes at most BLOCK bytes to the block, which lives until the call returns.
                let left = unsafe { syscall!(READ, self.handle, self.block.as_mut_ptr(), BLOCK) };
                (self.used, self.filled) = (0, BLOCK.checked_sub(left)?);
            }
            let byte = self.block.get(..self.filled)?.get(self.used).copied()?;
            self.used += 1;
            Some(byte)
        }
    }
}
