//! What only a board can tell: that its processor computes as the host of the training, in threads and in interrupts,
//! what the calls of a drive cost there, and that its flash keeps records.
//!
//! ```text
//! cd frameworks/on-board && cargo test --release        # with the runner: probe-rs run --chip STM32F405RG
//! ```

#![no_std]
#![no_main]

use core::sync::atomic::{AtomicBool, Ordering};

use bearing_watch::known_answer_test;
use cortex_m_rt::exception;

#[allow(dead_code, reason = "what `train` writes is for other programs, too")]
#[path = "../../../examples/support/actuator/model.rs"]
mod model;

/// Whether the interrupt has run, and found the known answers.
static RAN: AtomicBool = AtomicBool::new(false);
static RIGHT: AtomicBool = AtomicBool::new(false);

#[exception]
fn PendSV() {
    RIGHT.store(known_answer_test().is_ok(), Ordering::SeqCst);
    RAN.store(true, Ordering::SeqCst);
}

#[embedded_test::tests]
mod tests {
    use core::sync::atomic::Ordering;

    use bearing_watch::storage::{RecordKind, RecordLabel, SlotPair};
    use bearing_watch::{ArithmeticFault, known_answer_test, model::Label};
    use cortex_m::peripheral::{DCB, DWT, Peripherals, SCB};
    use on_board::{MOST_CYCLES, flash};

    use crate::model::{FRONT_END, MODEL, Reading, WATCH};

    #[test]
    fn known_answers_in_a_thread() -> Result<(), ArithmeticFault> {
        known_answer_test()
    }

    /// An interrupt takes the settings of its arithmetic from `FPDSCR`.
    #[test]
    fn known_answers_in_an_interrupt() {
        SCB::set_pendsv();
        cortex_m::asm::isb();
        while !crate::RAN.load(Ordering::SeqCst) {}
        assert!(crate::RIGHT.load(Ordering::SeqCst), "the interrupt computes otherwise");
    }

    #[test]
    #[timeout(120)]
    fn a_drive_takes_no_more_cycles_than_the_table() {
        let Some(mut peripherals) = Peripherals::take() else { panic!("the peripherals are taken") };
        DCB::enable_trace(&mut peripherals.DCB);
        peripherals.DWT.enable_cycle_counter();
        assert!(WATCH.start(&MODEL, &FRONT_END).is_ok(), "the drive does not start");
        let (mut sample, mut collect) = (0, 0);
        let cycles = |work: &mut dyn FnMut()| {
            let before = DWT::cycle_count();
            work();
            DWT::cycle_count().wrapping_sub(before)
        };
        // The first call of `collect` tests the arithmetic.
        WATCH.collect();
        for number in 0..30_000_u32 {
            // A shaft that turns by a tenth of its counts a millisecond, with a current that turns with it.
            let position = number.wrapping_mul(41) & 0x3FFF;
            let step = (number % 400) as u16;
            let reading = Reading {
                number,
                phases: [1848 + step, 2248 - step, 2048],
                position: Some(position),
                load_torque_nm: 0.1,
                velocity_ref_rad_s: 157.0,
            };
            sample = cycles(&mut || _ = WATCH.sample(reading)).max(sample);
            collect = cycles(&mut || _ = WATCH.collect()).max(collect);
            WATCH.advance(|_| ());
        }
        // An emulator has no counter, which then stands.
        let counted = [sample, collect];
        assert!(counted.iter().zip(MOST_CYCLES).all(|(own, most)| *own <= most), "{counted:?} beside {MOST_CYCLES:?}");
        assert_eq!(WATCH.status().lost_samples, 0);
    }

    #[test]
    #[timeout(60)]
    fn the_flash_keeps_the_newest_record() {
        let Some((mut flash, start, slot_bytes)) = flash() else { return };
        let Ok(pair) = SlotPair::<64>::new(&flash, start, slot_bytes, RecordKind::State) else {
            panic!("the slots do not fit the flash")
        };
        let label = RecordLabel { model: 7, drive: Label::constant("board") };
        for payload in [b"first state", b"later state"] {
            assert!(pair.prepare(&mut flash).is_ok() && pair.store(&mut flash, &label, payload).is_ok());
        }
        let mut buffer = [0; 64];
        let found = pair.load(&mut flash, &mut buffer, |_, bytes| (bytes == b"later state").then_some(()));
        assert!(found.is_ok(), "the record is not there");
    }
}
