//! The smallest program around a detector: inputs that change by themselves, a place for the verdict, no text.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use bearing_watch::Verdict;

/// What converters write: bits of y, u1, u2.
static INPUTS: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];

/// What the drive reads: a class, or 255 for none.
static VERDICT: AtomicU32 = AtomicU32::new(255);

/// The inputs now.
pub fn inputs() -> [f32; 3] {
    let [y, u1, u2] = &INPUTS;
    let read = |input: &AtomicU32| f32::from_bits(input.load(Relaxed));
    [read(y), read(u1), read(u2)]
}

/// Stores a verdict.
pub fn tell(verdict: Verdict) {
    let class = if let Verdict::Class(class) = verdict { class } else { 255 };
    VERDICT.store(u32::from(class), Relaxed);
}

/// The host only builds it.
#[cfg(not(target_os = "none"))]
macro_rules! program {
    ($run:path) => {
        fn main() {
            let _never_called = $run as fn() -> !;
        }
    };
}

/// No printer and no fault handler: a panic that could be reached would not link. Signatures are the exception, since
/// their verification has index checks that the compiler cannot prove.
#[cfg(target_os = "none")]
macro_rules! program {
    ($run:path) => {
        #[cfg(feature = "defmt")]
        use defmt_semihosting as _;
        #[cfg(not(any(debug_assertions, feature = "defmt", feature = "signature")))]
        use panic_never as _;

        #[cfg(any(debug_assertions, feature = "defmt", feature = "signature"))]
        #[panic_handler]
        fn panic(_: &core::panic::PanicInfo) -> ! {
            loop {
                cortex_m::asm::wfi();
            }
        }

        #[cortex_m_rt::entry]
        fn main() -> ! {
            $run()
        }
    };
}
