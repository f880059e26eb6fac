//! The target's half of the glue: a line printer, the end of the program, and what a panic does.

use core::fmt::{self, Write};
use core::panic::PanicInfo;

use cortex_m_semihosting::{debug, hio};
// Its linker script, which all examples get with the feature, wants a logger in each.
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

/// The longest line that goes out in one host call; a longer one takes several.
const LINE: usize = 256;

/// A line under construction. Every semihosting call stops the processor, for milliseconds with a debug probe: what
/// `fmt` writes is gathered, and one call sends it.
struct Line {
    host: hio::HostStream,
    bytes: [u8; LINE],
    used: usize,
}

impl Line {
    const fn new(host: hio::HostStream) -> Self {
        Self { host, bytes: [0; LINE], used: 0 }
    }

    fn send(&mut self) -> fmt::Result {
        let line = self.bytes.get(..self.used).unwrap_or_default();
        self.used = 0;
        self.host.write_all(line).map_err(|()| fmt::Error)
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for &byte in text.as_bytes() {
            if self.used == LINE {
                self.send()?;
            }
            if let Some(slot) = self.bytes.get_mut(self.used) {
                *slot = byte;
                self.used += 1;
            }
        }
        Ok(())
    }
}

/// Prints one line on the host's standard output.
pub fn say(words: fmt::Arguments) {
    if let Ok(host) = hio::hstdout() {
        // Ignored: the program runs also without a debugger, and a failed print has no other place to be reported.
        let _ = print(host, words);
    }
}

fn print(host: hio::HostStream, words: fmt::Arguments) -> fmt::Result {
    let mut line = Line::new(host);
    line.write_fmt(words)?;
    line.write_char('\n')?;
    line.send()
}

/// Ends the program; the host sees exit status 0.
pub fn succeed() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    halt()
}

/// A panic becomes a line on the host's standard error and a failing exit status.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    fail(format_args!("{info}"))
}

/// A fault (wrong address, undefined instruction) ends like a panic.
#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    fail(format_args!("hard fault at {:#010x}", frame.pc()))
}

/// Without the exit a failed run would hang until its time-out.
fn fail(words: fmt::Arguments) -> ! {
    if let Ok(host) = hio::hstderr() {
        // Ignored: the program ends here with a failing status, printed or not.
        let _ = print(host, words);
    }
    debug::exit(debug::EXIT_FAILURE);
    halt()
}

/// Where the program rests when no debugger ends it.
fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
