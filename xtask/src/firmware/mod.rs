//! Firmware: boards, the two ways to a compiler, builds, runs in the emulator, and what an ELF file takes.

pub mod board;
pub mod build;
pub mod elf;
pub mod qemu;
pub mod way;
