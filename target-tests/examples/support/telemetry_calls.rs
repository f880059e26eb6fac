//! Calls of the frames for the example `panic_free`.

#[path = "bus_calls.rs"]
mod bus_calls;

use core::hint::black_box as opaque;

use bearing_watch::drive::{PhaseCounts, Position, RawSample};
use bearing_watch::plan::Plan;
use bearing_watch::telemetry::{
    Block, Body, CanJoin, CanPiece, CanPieces, CanSignal, Contributions, Decoder, Encoder, Hello, LinkStats, Numbers,
    RawBlock, RawEncoder, RawRecorder, Recorder, SegmentFrame, Source, Summary,
};
use bearing_watch::{Angle, Evidence, Model, Report};

/// Frames of a report and of samples; `show` writes an error.
pub fn encode<P: Plan>(
    model: &Model<P>,
    report: &Report<P>,
    evidence: &Evidence<P>,
    show: impl Fn(&dyn core::fmt::Display),
) {
    let mut encoder = opaque(Encoder::new(model, opaque(Source { model_id: 3, session: 4 })));
    let mut buffer = [0; 512];
    let length = opaque(512);
    let buffer = buffer.get_mut(..length).unwrap_or_default();
    match Encoder::hello(&mut encoder, buffer) {
        Ok(frame) => decode(frame),
        Err(error) => show(&error),
    }
    match Encoder::report(&mut encoder, opaque(report), opaque(evidence), buffer) {
        Ok(frame) => decode(frame),
        Err(error) => show(&error),
    }
}

/// The frame of a report for CAN, and what a receiver reads of one.
pub fn on_can<P: Plan>(model: &Model<P>, report: &Report<P>, evidence: &Evidence<P>) {
    pieces();
    let sent = opaque(SegmentFrame::of(model, opaque(report), opaque(evidence)));
    bus_calls::by_driver(sent);
    let Some(frame) = SegmentFrame::from_bytes(opaque(SegmentFrame::to_bytes(sent))) else { return };
    opaque((SegmentFrame::segment(frame), SegmentFrame::undetermined(frame), SegmentFrame::usable_percent(frame)));
    opaque((SegmentFrame::deviations(frame), SegmentFrame::distance(frame), SegmentFrame::is_silent(frame)));
    opaque(SegmentFrame::verdict_number(opaque(SegmentFrame::verdict(frame))));
    opaque(SegmentFrame::alarm_number(opaque(SegmentFrame::alarm(frame))));
    for signal in &opaque(SegmentFrame::SIGNALS) {
        opaque(CanSignal::largest(signal));
    }
}

/// Samples of a plan as a frame.
pub fn record<P: Plan>(model: &Model<P>, sample: &P::Sample, show: impl Fn(&dyn core::fmt::Display)) {
    let mut encoder = opaque(Encoder::new(model, opaque(Source::default())));
    let mut recorder = opaque(Recorder::<P, 100>::new(Model::plan(model)));
    for _ in 0..opaque(9) {
        if opaque(Recorder::push(&mut recorder, opaque(sample))) {
            let whole = opaque(Recorder::take(&mut recorder));
            let mut buffer = opaque([0; 200]);
            match Encoder::samples(&mut encoder, &Recorder::block(&whole), &mut buffer) {
                Ok(frame) => decode(frame),
                Err(error) => show(&error),
            }
        }
    }
    Recorder::skip(&mut recorder, opaque(7));
    opaque(Recorder::is_complete(&recorder));
    Recorder::clear(opaque(&mut recorder));
    record_raw(&mut encoder, show);
}

/// Raw samples as frames, with a model and without one.
fn record_raw<P: Plan>(encoder: &mut Encoder<'_, P>, show: impl Fn(&dyn core::fmt::Display)) {
    let mut without = opaque(RawEncoder::new(opaque(Source::default())));
    let mut recorder = opaque(RawRecorder::with_further(RawRecorder::<2, 100>::new(opaque(1e4)), opaque(1)));
    for number in 0..opaque(9) {
        let position = opaque(if number % 2 == 0 { Position::Absolute(Angle::ZERO) } else { Position::Missing });
        let raw = RawSample { number, currents: opaque(PhaseCounts::Two([7, 8])), position, further: [0.5; 2] };
        if opaque(RawRecorder::push(&mut recorder, opaque(&raw))) {
            let whole = opaque(RawRecorder::take(&mut recorder));
            let mut buffer = opaque([0; 200]);
            match RawEncoder::raw(&mut without, &RawRecorder::block(&whole), &mut buffer) {
                Ok(frame) => decode(frame),
                Err(error) => show(&error),
            }
            match Encoder::raw(encoder, &RawRecorder::block(&whole), &mut buffer) {
                Ok(frame) => decode(frame),
                Err(error) => show(&error),
            }
        }
    }
    opaque(RawRecorder::is_complete(&recorder));
    RawRecorder::clear(opaque(&mut recorder));
}

fn decode(bytes: &[u8]) {
    let mut decoder = opaque(Decoder::<512>::new());
    for byte in bytes {
        match Decoder::push(&mut decoder, opaque(*byte)).map(|frame| frame.body) {
            Some(Body::Hello(hello)) => greeted(&opaque(hello)),
            Some(Body::Report(summary)) => reported(&opaque(summary)),
            Some(Body::Samples(block)) => {
                let block = opaque(block);
                opaque((Block::len(&block), Block::is_empty(&block)));
                opaque((Block::value(&block, opaque(1), opaque(2)), Block::angle(&block, opaque(1))));
            }
            Some(Body::Raw(block)) => {
                let block = opaque(block);
                opaque((RawBlock::len(&block), RawBlock::is_empty(&block), RawBlock::further(&block, opaque(1), 0)));
                opaque((RawBlock::currents(&block, opaque(1)), RawBlock::position(&block, opaque(1))));
            }
            None => {}
        }
    }
    let counts: LinkStats = Decoder::counts(opaque(&decoder));
    opaque(counts);
}

fn greeted(hello: &Hello<'_>) {
    Hello::channels(hello).for_each(|channel| {
        opaque(channel);
    });
    Hello::coordinates(hello).for_each(|place| {
        opaque(place);
    });
    Hello::classes(hello).for_each(|class| {
        opaque(class);
    });
    Hello::features(hello).for_each(|feature| {
        opaque(feature);
    });
}

fn reported(summary: &Summary<'_>) {
    let numbers = &summary.posteriors;
    opaque((Numbers::len(numbers), Numbers::is_empty(numbers), Numbers::get(numbers, opaque(2))));
    opaque(Numbers::iter(numbers).sum::<f32>());
    let contributions = &summary.contributions;
    opaque((Contributions::len(contributions), Contributions::is_empty(contributions)));
    opaque(Contributions::iter(contributions).map(|(_, one)| one.deviations).sum::<f32>());
}

/// Frames over CAN.
fn pieces() {
    let frame = opaque([7_u8; 100]);
    for pieces in [CanPieces::classic(), CanPieces::fd()] {
        let (mut pieces, mut join) = (CanPieces::with_number(opaque(pieces), opaque(3)), CanJoin::new());
        for piece in CanPieces::cut(&mut pieces, &frame) {
            opaque(CanJoin::take(&mut join, CanPiece::data(&opaque(piece))));
        }
        opaque((CanPieces::number(&pieces), CanJoin::lost(&join), CanJoin::repeated(&join)));
    }
}
