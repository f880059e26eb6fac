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

impl Board {
    /// The prefix of the binary utilities for this processor, and what their linker must be told of it.
    pub fn utilities(self) -> (&'static str, &'static str) {
        if self.target == RISCV.target { ("riscv64-unknown-elf-", "-m elf32lriscv") } else { ("arm-none-eabi-", "") }
    }
}

impl Memory {
    /// The file of the map.
    pub fn file(self) -> PathBuf {
        let root = workspace::root();
        let folder = match self {
            Self::Top => root,
            Self::Variable(folder) | Self::Linker(folder) => root.join("boards").join(folder),
        };
        folder.join("memory.x")
    }
}

/// The chip of many motor drives, an STM32F405.
pub const DRIVE: Board =
    Board { core: "Cortex-M4F", machine: "netduinoplus2", target: "thumbv7em-none-eabihf", memory: Memory::Top };

/// A processor of another architecture, for the C library: the emulator's machine has any core of 32 bits.
pub const RISCV: Board =
    Board { core: "RV32IMAFC", machine: "virt", target: "riscv32imafc-unknown-none-elf", memory: Memory::Top };

/// What a C compiler needs to know of [`DRIVE`].
pub const DRIVE_FLAGS: [&str; 4] = ["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"];

/// Other processors that must compute the same bits.
pub const OTHERS: [Board; 2] = [
    Board { core: "Cortex-M7", machine: "mps2-an500", target: "thumbv7em-none-eabihf", memory: Memory::Linker("mps2") },
    Board {
        core: "Cortex-M33",
        machine: "mps2-an505",
        target: "thumbv8m.main-none-eabihf",
        memory: Memory::Variable("mps2-an505"),
    },
];

/// A processor without a floating-point unit, on which the cost of a sample is counted.
pub const NO_FPU: Board =
    Board { core: "Cortex-M0", machine: "microbit", target: "thumbv6m-none-eabi", memory: Memory::Linker("nrf51") };

/// Code for that processor on a machine that has the memory for larger examples: a Cortex-M3, which runs it as well.
pub const NO_FPU_LARGE: Board =
    Board { core: "code of a Cortex-M0", machine: "mps2-an385", memory: Memory::Linker("mps2"), ..NO_FPU };

/// Chips of drives that the emulator does not have: firmware is built for them, and not run.
pub const NOT_EMULATED: [Board; 2] = [
    Board {
        core: "Cortex-M4F",
        machine: "STM32G474",
        target: "thumbv7em-none-eabihf",
        memory: Memory::Linker("stm32g474"),
    },
    Board {
        core: "Cortex-M7",
        machine: "STM32H743",
        target: "thumbv7em-none-eabihf",
        memory: Memory::Linker("stm32h743"),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_board_has_its_memory_map_and_a_machine_of_its_own() {
        let mut machines = Vec::new();
        for board in OTHERS.iter().chain(&NOT_EMULATED).chain([&DRIVE, &NO_FPU, &NO_FPU_LARGE]) {
            let map = board.memory.file();
            assert!(map.is_file(), "no {}", map.display());
            assert!(!machines.contains(&board.machine), "{} twice", board.machine);
            machines.push(board.machine);
        }
    }
}
