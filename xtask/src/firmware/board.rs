//! The emulated boards: which machine, which compiler target, which memory map.

use std::path::PathBuf;

use crate::workspace;

/// One machine of the emulator and what firmware for it is built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// The processor, for people.
    pub core: &'static str,
    /// The emulator's name of the machine; of a chip that it does not have, the chip.
    pub machine: &'static str,
    /// The compiler's name of the target.
    pub target: &'static str,
    pub memory: Memory,
}

/// Where the memory map of a board is, and what selects it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// The `memory.x` at the top of the repository.
    Top,
    /// That of this folder of `boards`, by the variable that `build.rs` reads. All boards of a target share it: when it
    /// changes, the core is compiled again.
    Variable(&'static str),
    /// That of this folder of `boards`, by an argument of the linker.
    Linker(&'static str),
}

impl Memory {
    /// The file of the map.
    pub fn file(self) -> PathBuf {
        match self {
            Self::Top => workspace::root().join("memory.x"),
            Self::Variable(folder) | Self::Linker(folder) => {
                workspace::root().join("boards").join(folder).join("memory.x")
            }
        }
    }
}

const fn board(core: &'static str, machine: &'static str, target: &'static str, memory: Memory) -> Board {
    Board { core, machine, target, memory }
}

const WITH_FPU: &str = "thumbv7em-none-eabihf";

/// The chip of many motor drives, an STM32F405.
pub const DRIVE: Board = board("Cortex-M4F", "netduinoplus2", WITH_FPU, Memory::Top);

/// A processor of another architecture, for the C library: the emulator's machine has any core of 32 bits.
pub const RISCV: Board = board("RV32IMAFC", "virt", "riscv32imafc-unknown-none-elf", Memory::Top);

/// Other processors that must compute the same bits.
pub const OTHERS: [Board; 2] = [
    board("Cortex-M7", "mps2-an500", WITH_FPU, Memory::Linker("mps2")),
    board("Cortex-M33", "mps2-an505", "thumbv8m.main-none-eabihf", Memory::Variable("mps2-an505")),
];

/// A processor without a floating-point unit, on which the cost of a sample is counted.
pub const NO_FPU: Board = board("Cortex-M0", "microbit", "thumbv6m-none-eabi", Memory::Linker("nrf51"));

/// Code for that processor on a machine that has the memory for larger examples: a Cortex-M3, which runs it as well.
pub const NO_FPU_LARGE: Board = board("code of a Cortex-M0", "mps2-an385", NO_FPU.target, Memory::Linker("mps2"));

/// Chips of drives that the emulator does not have: firmware is built for them, and not run.
pub const NOT_EMULATED: [Board; 2] = [
    board("Cortex-M4F", "STM32G474", WITH_FPU, Memory::Linker("stm32g474")),
    board("Cortex-M7", "STM32H743", WITH_FPU, Memory::Linker("stm32h743")),
];
