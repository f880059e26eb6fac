//! The little that RTIC wants of a chip: the number of priority bits, and one interrupt for software tasks. A drive
//! takes the peripheral access crate of its chip instead, for example `stm32f4`.

use cortex_m::interrupt::InterruptNumber;

/// Of the STM32F4.
pub const NVIC_PRIO_BITS: u8 = 4;

/// The interrupts up to the one that RTIC dispatches software tasks from; no peripheral of this program raises it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// Of the external line 0.
    EXTI0 = 6,
}

/// The name by which RTIC looks for the interrupts.
pub use Interrupt as interrupt;

// SAFETY: the number is that of the vector table below, and never changes.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    fn EXTI0();
    fn DefaultHandler();
}

/// The interrupts of the vector table.
// SAFETY: the section is where cortex-m-rt with the feature `device` expects a table of this name.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [unsafe extern "C" fn(); 7] = {
    let mut table: [unsafe extern "C" fn(); 7] = [DefaultHandler; 7];
    table[Interrupt::EXTI0 as usize] = EXTI0;
    table
};
