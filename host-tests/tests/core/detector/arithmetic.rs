//! A processor that flushes subnormal numbers where the detector runs, as an Arm core may in interrupts only: the test
//! at boot passes, and the first segment says so.
#![cfg(target_arch = "x86_64")]

use core::arch::asm;

use bearing_watch::{ArithmeticFault, Reason, Verdict, arithmetic_test, known_answer_test};
use host_tests::halves::{Interrupt, conclude};

use crate::standard_rig;
use standard_rig::model::MODEL;

/// The bits of MXCSR that flush subnormal results and inputs to zero, and the one that rounds downwards.
const FLUSH: u32 = 1 << 15 | 1 << 6;
const DOWNWARDS: u32 = 1 << 13;

/// Works with these bits set, as in an interrupt with settings of its own.
fn in_context<T>(bits: u32, work: impl FnOnce() -> T) -> T {
    let mut before = 0_u32;
    // SAFETY: the address is that of a word.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut before, options(nostack)) };
    let inside = before | bits;
    // SAFETY: only bits that change the results of arithmetic are set, and the register is written back below.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const inside, options(nostack)) };
    let made = work();
    // SAFETY: as it was.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const before, options(nostack)) };
    made
}

#[test]
fn the_first_segment_tells_of_an_interrupt_that_computes_otherwise() {
    for (bits, kernel) in [(FLUSH, ArithmeticFault::Subnormals), (DOWNWARDS, ArithmeticFault::Rounding)] {
        assert_eq!(known_answer_test(), Ok(()), "in main");
        assert_eq!(in_context(bits, known_answer_test), Err(kernel));
        assert_eq!(in_context(bits, arithmetic_test), Err(kernel));
        let mut detector = Interrupt::new(&MODEL);
        let mut stream = standard_rig::samples();
        let segment = in_context(bits, || stream.find_map(|sample| detector.collect(&sample))).expect("a segment");
        let report = conclude(&MODEL, segment);
        assert_eq!(report.verdict, Verdict::Undetermined(Reason::Arithmetic(kernel)));
        assert!(report.decision.is_none());
        // The main loop, too.
        let segment = stream.find_map(|sample| detector.collect(&sample)).expect("a segment");
        let report = in_context(bits, || conclude(&MODEL, segment));
        assert_eq!(report.verdict, Verdict::Undetermined(Reason::Arithmetic(kernel)));
        let report = conclude(&MODEL, stream.find_map(|sample| detector.collect(&sample)).expect("a segment"));
        assert!(matches!(report.verdict, Verdict::Class(_)), "as ever: {report:?}");
    }
}
