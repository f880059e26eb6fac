//! `bearing-watch dbc`: the frame that a drive sends for each segment, as a DBC file.
//!
//! Signals and numbers are those of the core's `SegmentFrame`; the names are those of the model.

use std::path::PathBuf;

use bearing_watch::telemetry::SegmentFrame;
use bearing_watch::{ArithmeticFault, Cause, FrictionTerm, Implausible, Reason, Verdict};

use crate::command_line::output;
use crate::drive::can_id::CanId;
use model::Error;
use model::core::coordinates::Side;
use model::session::{ModelFile, Notes};

/// What a DBC file adds to an extended identifier.
const EXTENDED: u32 = 1 << 31;

/// Write the DBC file of the CAN frame in which a drive sends the report of a segment
///
/// It describes each signal of the 8 bytes that SegmentFrame of Rust, or bw_can_frame in C, makes, with the names of
/// classes, reasons and features of this model. Files of several drives can be merged: the name of the message has the
/// identifier in it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch dbc --model model.bwm --id 0x123 --out drive.dbc")]
pub(crate) struct Args {
    /// The model of the drive
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Identifier of the frame; more than three digits are an extended one
    #[arg(long, value_name = "ID", value_parser = CanId::parse)]
    id: CanId,
    /// The DBC file; by default it is printed
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    output::plan(&args.out.iter().map(PathBuf::as_path).collect::<Vec<_>>(), std::slice::from_ref(&args.model))?;
    let text = text(&ModelFile::read(&args.model)?, args.id);
    match &args.out {
        Some(file) => output::write(file, text),
        None => output::say(text.trim_end()),
    }
}

fn text(file: &ModelFile, id: CanId) -> String {
    let number = id.number | if id.extended { EXTENDED } else { 0 };
    let name = id.to_string().replace("0x", "");
    let mut text = format!("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Drive_{name}\n\n");
    text += &format!("BO_ {number} Segment_{name}: 8 Drive_{name}\n");
    for signal in SegmentFrame::SIGNALS {
        let (start, length, factor, largest) = (signal.start, signal.length, signal.factor, signal.largest());
        let top = f32::from(largest) * factor;
        let place = format!("{start}|{length}@1+ ({factor},0) [0|{top}]");
        text += &format!(" SG_ {} : {place} \"{}\" Vector__XXX\n", signal.name, signal.unit);
    }
    text += &format!("\nCM_ BO_ {number} \"Report of a segment by bearing-watch\";\n");
    for signal in SegmentFrame::SIGNALS {
        let about = if signal.name == PLACE { place(file, signal.about) } else { signal.about.into() };
        text += &format!("CM_ SG_ {number} {} \"{}\";\n", signal.name, plain(&about));
    }
    text += "\n";
    for (signal, names) in [("Verdict", verdicts(file)), ("Reason", reasons()), ("Alarm", causes(file))] {
        let list: String = names.iter().map(|(value, name)| format!("{value} \"{}\" ", plain(name))).collect();
        text += &format!("VAL_ {number} {signal} {list};\n");
    }
    text
}

/// The signal whose meaning depends on the reason.
const PLACE: &str = "Place";

fn verdicts(ModelFile { model, .. }: &ModelFile) -> Vec<(u8, String)> {
    let verdict = |verdict, name: &str| (SegmentFrame::verdict_number(verdict), name.to_string());
    let fixed = [
        verdict(Verdict::Undetermined(Reason::AtRest), "undetermined"),
        verdict(Verdict::Novel, "novel"),
        verdict(Verdict::Ambiguous, "ambiguous"),
    ];
    let classes = (0_u8..).zip(&model.classes).map(|(class, name)| verdict(Verdict::Class(class), name));
    once(fixed.into_iter().chain(classes))
}

fn causes(ModelFile { model, notes: Notes { orders, .. } }: &ModelFile) -> Vec<(u8, String)> {
    let cause = |cause, name: String| (SegmentFrame::alarm_number(cause), name);
    let fixed = [cause(None, "none".into()), cause(Some(Cause::Unknown), "unknown".into())];
    let classes = (0_u8..).zip(&model.classes).map(|(class, name)| cause(Some(Cause::Class(class)), name.clone()));
    // Only a model with directions names a coordinate.
    let coordinates = if model.directions() > 0 { model.coordinate_names(orders) } else { vec![] };
    let risen = (0_u8..)
        .zip(&coordinates)
        .map(|(place, name)| cause(Some(Cause::Coordinate(place)), format!("{}: {name}", Side::Risen)));
    let fallen = (0_u8..)
        .zip(&coordinates)
        .map(|(place, name)| cause(Some(Cause::Fallen(place)), format!("{}: {name}", Side::Fallen)));
    once(fixed.into_iter().chain(classes).chain(risen).chain(fallen))
}

fn reasons() -> Vec<(u8, String)> {
    let named = (0_u8..).zip(SegmentFrame::REASONS).filter(|(_, name)| !name.is_empty());
    named.map(|(kind, name)| (kind, name.to_string())).collect()
}

/// A number that several share has the name of the first.
fn once(names: impl Iterator<Item = (u8, String)>) -> Vec<(u8, String)> {
    let mut list: Vec<(u8, String)> = names.collect();
    list.dedup_by_key(|(number, _)| *number);
    list
}

/// What the place is, by the reason.
fn place(ModelFile { model, .. }: &ModelFile, about: &str) -> String {
    let list = |names: &[&str]| {
        let numbered: Vec<String> = names.iter().enumerate().map(|(k, name)| format!("{k} {name}")).collect();
        numbered.join(", ")
    };
    let parts = "1 regression, 2 torque balance, 3 bearing orders, 4 classifier";
    format!(
        "{about}. Part: {parts}. Term: {}. Channel: {}. Error: {}. Arithmetic: {}. Parameter and covariate from 0 on",
        list(&FrictionTerm::ALL.map(FrictionTerm::name)),
        list(&model.channel_names()),
        list(&Implausible::ALL.map(Implausible::message)),
        list(&ArithmeticFault::ALL.map(ArithmeticFault::message)),
    )
}

/// A text in quotes of a DBC file has no quotes, and programs do not agree on letters beyond ASCII.
fn plain(text: &str) -> String {
    let letter = |letter: char| match letter {
        '"' => '\'',
        '\\' => '/',
        ' '..='~' => letter,
        _ => '?',
    };
    text.chars().map(letter).collect()
}
