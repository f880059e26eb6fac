//! Bytes on a line: what arrives is what was sent, and nothing else is taken for a frame.

use std::sync::LazyLock;

use bearing_watch::drive::{PhaseCounts, Position, RawSample};
use bearing_watch::telemetry::{Body, Decoder, Encoder, Frame, RawRecorder, Recorder, Source};
use bearing_watch::{Angle, Detector, Evidence};

use crate::checksum;
use crate::input::Input;
use crate::models::{LONG, WATCHED, shaft};

/// Most bytes of a frame.
const FRAME: usize = 512;

/// The frames of a drive, by their sequence: hellos, blocks of samples and of raw samples, and reports.
static SENT: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let model = &*WATCHED;
    let (mut detector, mut evidence) = (Detector::new(model), Evidence::new(model));
    let mut encoder = Encoder::new(model, Source { model_id: model.id(), session: 1 });
    let mut recorder = Recorder::<_, 200>::new(model.plan());
    let mut raw = RawRecorder::<1, 200>::new(4000.0);
    let mut plant = shaft::Plant::new(3);
    let mut buffer = [0; FRAME];
    let mut frames = vec![encoder.hello(&mut buffer).expect("fits").to_vec()];
    for number in 0..2 * LONG {
        let counts = |phase: u32| u16::try_from((number + phase) % 4096).unwrap_or_default();
        let position = match number % 50 {
            49 => Position::Missing,
            _ => Position::Absolute(Angle::from_counts(u32::from(counts(0)), 12)),
        };
        let currents = PhaseCounts::Three([0, 1, 2].map(counts));
        if raw.push(&RawSample { number, currents, position, further: [number as f32] }) {
            frames.push(encoder.raw(&raw.block(), &mut buffer).expect("fits").to_vec());
            raw.clear();
        }
        let sample = plant.motion().into();
        if recorder.push(&sample) {
            frames.push(encoder.samples(&recorder.block(), &mut buffer).expect("fits").to_vec());
            recorder.clear();
        }
        if let Some(report) = detector.step(&sample) {
            evidence.observe(report.decision.as_ref());
            frames.push(encoder.report(&report, &evidence, &mut buffer).expect("fits").to_vec());
        }
    }
    frames
});

/// Any bytes, a disturbed line, contents of any bytes under a right checksum, or one of them among good frames.
pub fn attack(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    match input.byte() % 8 {
        0 | 4 => any(input.bytes(usize::MAX)),
        1 => forged(&mut input),
        5 => alone(&mut input),
        _ => disturbed(&mut input),
    }
}

/// One frame of any content under a right checksum, among those of a drive: no other frame is lost.
fn alone(input: &mut Input<'_>) {
    let place = input.below(SENT.len());
    let number = input.byte();
    let mut content = vec![1 + number / 128, number % 4];
    content.extend(input.bytes(240));
    content.extend([0; 4]);
    checksum::put(&mut content);
    let mut forged = [0; FRAME];
    let used = cobs::encode(&content, &mut forged[..FRAME - 1]);
    let mut decoder = Decoder::<FRAME>::new();
    let mut arrived = |bytes: &[u8]| bytes.iter().filter(|byte| decoder.push(**byte).is_some()).count();
    for (number, frame) in SENT.iter().enumerate() {
        if number == place {
            // What is not a frame ends at a zero all the same.
            arrived(&forged[..=used]);
        }
        // Unless it is the next one, byte for byte, that was forged.
        let is_copy = frame[..] == forged[..=used];
        assert!(is_copy || arrived(frame) == 1, "frame {number} after a forged one at {place}");
    }
}

fn any(bytes: &[u8]) {
    let (mut small, mut large) = (Decoder::<16>::new(), Decoder::<FRAME>::new());
    for byte in bytes {
        small.push(*byte).iter().for_each(look);
        large.push(*byte).iter().for_each(look);
    }
}

/// A line of any bytes, of a drive's frames with changes, or of contents of any bytes under a right checksum.
pub fn line(input: &mut Input<'_>) -> Vec<u8> {
    match input.byte() % 4 {
        0 => input.bytes(usize::MAX).to_vec(),
        1 => contents(input),
        _ => changed(input),
    }
}

fn forged(input: &mut Input<'_>) {
    let mut decoder = Decoder::<FRAME>::new();
    for byte in contents(input) {
        decoder.push(byte).iter().for_each(look);
    }
}

/// Frames of any contents with a right checksum.
fn contents(input: &mut Input<'_>) -> Vec<u8> {
    let mut all = vec![];
    while !input.is_empty() {
        let length = usize::from(input.byte());
        // Version and kind, as a rule good ones.
        let mut content = match input.byte() {
            kind @ 0..=199 => vec![1 + kind / 100, kind % 5],
            _ => vec![],
        };
        content.extend(input.bytes(length));
        content.extend([0; 4]);
        checksum::put(&mut content);
        let mut line = [0; FRAME];
        let used = cobs::encode(&content, &mut line[..FRAME - 1]);
        all.extend(&line[..=used]);
    }
    all
}

/// The frames of a drive, some of whose bytes are changed, lost, added or repeated.
fn changed(input: &mut Input<'_>) -> Vec<u8> {
    let mut line: Vec<u8> = SENT.concat();
    while !input.is_empty() && !line.is_empty() {
        let place = usize::from(input.half()) % line.len();
        match input.byte() % 6 {
            0 | 1 => line[place] ^= 1 << (input.byte() % 8),
            2 => line[place] = input.byte(),
            3 => {
                let end = line.len().min(place + usize::from(input.byte()));
                line.drain(place..end);
            }
            4 => line.insert(place, input.byte()),
            _ => {
                let end = line.len().min(place + usize::from(input.byte()));
                let copy = line[place..end].to_vec();
                let to = usize::from(input.half()) % line.len();
                line.splice(to..to, copy);
            }
        }
    }
    line
}

fn disturbed(input: &mut Input<'_>) {
    let line = changed(input);
    let mut decoder = Decoder::<FRAME>::new();
    let mut arrived = 0;
    for byte in line {
        let Some(frame) = decoder.push(byte) else { continue };
        look(&frame);
        arrived += 1;
        let sent = SENT.get(frame.sequence as usize).expect("a number that was sent");
        let mut clean = Decoder::<FRAME>::new();
        let same = sent.iter().any(|byte| {
            let sent = clean.push(*byte);
            // Debug output tells equal bits apart from NaN.
            sent.is_some_and(|sent| sent == frame || format!("{sent:?}") == format!("{frame:?}"))
        });
        assert!(same, "{frame:?} was not sent");
    }
    let counts = decoder.counts();
    assert_eq!(counts.frames, arrived, "{counts:?}");
}

/// Looks at everything in a frame.
fn look(frame: &Frame<'_>) {
    match &frame.body {
        Body::Hello(hello) => {
            let channels = hello.channels().map(|(name, unit)| name.len() + unit.len()).sum::<usize>();
            let classes = hello.classes().map(str::len).sum::<usize>();
            assert!(channels + classes < FRAME);
            assert_eq!(hello.channels().count(), usize::from(hello.channel_count));
            assert_eq!(hello.classes().count(), usize::from(hello.class_count));
            assert!(hello.features().count() <= 255 && hello.orders.iter().count() == hello.orders.len());
        }
        Body::Report(summary) => {
            for numbers in [&summary.posteriors, &summary.features, &summary.order_scores] {
                assert_eq!(numbers.iter().count(), numbers.len());
                assert_eq!((numbers.get(numbers.len()), numbers.is_empty()), (None, numbers.is_empty()));
            }
            let contributions = summary.contributions;
            let count = contributions.iter().count();
            assert_eq!((count, count == 0), (contributions.len(), contributions.is_empty()));
        }
        Body::Samples(block) => {
            for k in 0..block.len() {
                let values = (0..=usize::from(block.channels)).filter_map(|channel| block.value(k, channel));
                assert_eq!(values.count(), usize::from(block.channels));
                assert_eq!(block.angle(k).is_some(), block.with_angle);
            }
            assert_eq!((block.value(block.len(), 0), block.angle(block.len())), (None, None));
        }
        Body::Raw(block) => {
            for k in 0..block.len() {
                assert!(block.currents(k).is_some() && block.position(k).is_some());
                let further = (0..=usize::from(block.further)).filter_map(|channel| block.further(k, channel));
                assert_eq!(further.count(), usize::from(block.further));
            }
            assert_eq!((block.currents(block.len()), block.position(block.len())), (None, None));
        }
    }
}
