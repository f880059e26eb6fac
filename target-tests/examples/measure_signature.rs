//! Counts the instructions and the stack of signed models and sealed states, as lines of JSON: run it by
//! `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[cfg(target_os = "none")]
#[allow(dead_code, reason = "its samples are not wanted here")]
#[path = "../../examples/support/standard_rig/model.rs"]
mod model;

main!(run);

#[cfg(not(target_os = "none"))]
fn run() {
    say!("instructions are counted on the target only: cargo xtask measure");
}

#[cfg(target_os = "none")]
fn run() {
    on_target::run();
}

#[cfg(target_os = "none")]
mod on_target {
    use core::hint::black_box;

    use bearing_watch::signature::{BLOCK, SEAL, StateKey, Trust, head};
    use bearing_watch::{Evidence, Model};
    use ed25519_compact::{KeyPair, Seed};

    use super::support::long_count::LongCounter;
    use super::support::paint::stack_of;

    use super::model::{Drive, MODEL};

    pub fn run() {
        let mut buffer = [0; 4096];
        let record = MODEL.to_bytes("", &mut buffer).expect("a model of less than 4 kB");
        let pair = KeyPair::from_seed(Seed::new([1; 32]));
        let (message, signature) = (record + 24, record + BLOCK);
        buffer[record..message].copy_from_slice(&head(record as u32, &pair.pk, 5));
        let signed = pair.sk.sign(&buffer[..message], None);
        buffer[message..signature].copy_from_slice(&*signed);
        let keys = [*pair.pk];
        let trust = Trust { keys: &keys, least_counter: 5 };
        let bytes = &buffer[..signature];
        let counter = LongCounter::new();
        let mut verified = true;
        let instructions =
            counter.instructions(|| verified = black_box(black_box(&trust).verify(black_box(bytes))).is_ok());
        assert!(verified, "a good signature");
        line("signed model of the standard rig, verified", instructions, record);
        let stack = stack_of(|| {
            verified = black_box(black_box(&trust).verify(black_box(bytes))).is_ok();
        });
        say!(r#"{{"name":"stack, signed model, verified","n":null,"instructions":null,"bytes":{stack}}}"#);
        let instructions =
            counter.instructions(|| verified = black_box(Model::<Drive>::from_bytes(&bytes[..record])).is_ok());
        assert!(verified, "a good model");
        line("the same model, read", instructions, record);
        states(&counter);
    }

    fn states(counter: &LongCounter) {
        let (key, evidence, mut buffer) = (StateKey::new(black_box([2; 32])), Evidence::new(&MODEL), [0; 512]);
        let length = evidence.save(&MODEL, &mut buffer).expect("a state");
        let mut sealed = 0;
        let instructions =
            counter.instructions(|| sealed = black_box(&key).seal(black_box(&mut buffer), length, 7).unwrap_or(0));
        assert_eq!(sealed, length + SEAL);
        line("saved state, sealed", instructions, length);
        let mut opened = false;
        let bytes = &buffer[..sealed];
        let instructions =
            counter.instructions(|| opened = black_box(black_box(&key).open(black_box(bytes), 7)).is_ok());
        assert!(opened, "a good seal");
        line("sealed state, opened", instructions, length);
        let stack = stack_of(|| {
            opened = black_box(black_box(&key).open(black_box(bytes), 7)).is_ok();
        });
        say!(r#"{{"name":"stack, sealed state, opened","n":null,"instructions":null,"bytes":{stack}}}"#);
    }

    fn line(name: &str, instructions: u32, bytes: usize) {
        say!(r#"{{"name":"{name}","n":null,"instructions":{instructions},"bytes":{bytes}}}"#);
    }
}
