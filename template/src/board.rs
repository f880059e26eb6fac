//! Stands for a board: `rows.bin`, a recording that `bearing-watch replay --rows` wrote, in place of the converters;
//! the file `state.bin` of the computer in place of a flash sector; `SysTick` in place of the interrupt at the end of
//! the current conversion. A drive replaces all of it.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicUsize, Ordering};

use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, hprintln, syscall};

use crate::model::Reading;

static RECORDING: &[u8] = include_bytes!("../rows.bin");
/// Rows that were read.
static ROWS: AtomicUsize = AtomicUsize::new(0);

/// Bytes before the first row, and of a row with two further channels.
const HEAD: usize = 8;
const ROW: usize = 24;
/// The rate of the recording.
const ROWS_A_MILLISECOND: usize = 10;
/// Clock cycles between two interrupts: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
/// recording of 10 kHz is played at 2 kHz.
const CYCLES: u32 = 84_000;
/// Rows without a new reading behind the end: the main loop concludes the last segment.
const REST: usize = 200;

/// What the converters read; `None` behind the end of the recording.
pub fn read() -> Option<Reading> {
    let number = ROWS.load(Ordering::Relaxed);
    ROWS.store(number + 1, Ordering::Relaxed);
    let row = RECORDING.get(HEAD + number * ROW..)?.first_chunk::<ROW>()?;
    let half = |place| row.get(place..place + 2).and_then(|b| b.try_into().ok()).map_or(0, u16::from_le_bytes);
    let word = |place| row.get(place..place + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
    Some(Reading {
        number: word(0),
        phases: [half(4), half(6), half(8)],
        position: Some(word(12) >> 18), // the angle as a fraction of 2³²; the converter has 14 bits
        load_torque_nm: f32::from_bits(word(16)),
        velocity_ref_rad_s: f32::from_bits(word(20)),
    })
}

/// A clock that does not come from the interrupt: on a board, another timer than that of the current loop.
pub fn milliseconds() -> u32 {
    (ROWS.load(Ordering::Relaxed) / ROWS_A_MILLISECOND) as u32
}

/// Whether the recording goes on.
pub fn runs() -> bool {
    ROWS.load(Ordering::Relaxed) < (RECORDING.len() - HEAD) / ROW + REST
}

/// Starts the interrupt of the current loop; `PendSV` gets the lowest priority.
pub fn start_interrupts() {
    let Some(mut peripherals) = Peripherals::take() else { fail("the peripherals are taken") };
    // SAFETY: no interrupt runs yet whose priority would change.
    unsafe { peripherals.SCB.set_priority(SystemHandler::PendSV, 0xff) };
    let mut timer = peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CYCLES - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

const STATE: &str = "state.bin\0";
/// Modes `rb` and `wb` of `fopen`.
const READ: usize = 1;
const WRITE: usize = 5;

fn open(mode: usize) -> Option<usize> {
    // SAFETY: the arguments are those of SYS_OPEN: text that ends with a zero, a mode, the length without it.
    let handle = unsafe { syscall!(OPEN, STATE.as_ptr(), mode, STATE.len() - 1) };
    (handle != usize::MAX).then_some(handle)
}

/// The bytes that the run before has stored, if there are any.
pub fn load(state: &mut [u8]) -> Option<&[u8]> {
    let handle = open(READ)?;
    // SAFETY: SYS_READ writes at most that number of bytes to the slice, which lives until the call returns.
    let left = unsafe { syscall!(READ, handle, state.as_mut_ptr(), state.len()) };
    state.get(..state.len().checked_sub(left)?)
}

/// Stores bytes for the next run. On a board: two flash sectors in turn, as `bearing_watch::storage` does.
pub fn store(state: &[u8]) {
    let Some(handle) = open(WRITE) else { fail("state.bin cannot be written") };
    // SAFETY: SYS_WRITE reads that number of bytes of the slice, which lives until the call returns.
    let left = unsafe { syscall!(WRITE, handle, state.as_ptr(), state.len()) };
    if left != 0 {
        fail("state.bin is not complete");
    }
}

/// Ends the program.
pub fn finish() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

/// A drive goes into its safe state instead.
pub fn fail(message: &str) -> ! {
    hprintln!("{}", message);
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    fail("panic")
}
