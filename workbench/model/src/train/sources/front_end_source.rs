//! The front end that a model was trained with, as Rust source behind the model.

use std::fmt::Write as _;

use bearing_watch::drive::{FrontEndConstants, PhaseSensor};
use bearing_watch::model::Channel;
use bearing_watch::plan::{Plan, RunTime};
use bearing_watch::{Model, Park};

use crate::Error;
use crate::core::{column, fields};
use crate::trace::front_end::{Columns, Turn};
use crate::trace::{Channels, FrontEndFile};

/// Returns the source: type and constants of the front end, what the drive reads with its conversion, the conversion of
/// clean samples to those of the detector, and the static that ties them.
///
/// # Errors
/// A model with a channel that is a difference of columns: the front end makes columns only.
pub fn front_end_source(model: &Model<RunTime>, recorded: &Channels, file: &FrontEndFile) -> Result<String, Error> {
    let channels = &model.constants().channels;
    further_columns(model, recorded, "--rust")?;
    let further = further_channels(model);
    let (count, factor) = (further.len(), file.factor);
    let mut out = String::new();
    let mut line = |text: &str| {
        let _ = writeln!(out, "{text}");
    };
    let quoted: Vec<String> = further.iter().map(|name| format!("`{name}`")).collect();
    let listed = if quoted.is_empty() { "none".into() } else { quoted.join(", ") };
    line("/// The front end that the recordings passed. Its further channels, in this order:");
    line(&format!("/// {listed}."));
    line(&format!("pub type DriveFrontEnd = bearing_watch::drive::FrontEnd<FURTHER, {factor}>;"));
    line("");
    line("/// Number of its further channels.");
    line(&format!("pub const FURTHER: usize = {count};"));
    line("");
    line("/// The constants of this front end; `drive::OffsetCalibration` measures the offsets of a drive.");
    line("#[rustfmt::skip]");
    line("pub const FRONT_END: bearing_watch::drive::FrontEndConstants = bearing_watch::drive::FrontEndConstants {");
    constants(&file.constants()).iter().for_each(|text| line(&format!("    {text}")));
    line("};");
    position(&file.position)?.iter().for_each(|text| line(text));
    reading(model, file).iter().for_each(|text| line(text));
    line("");
    line("#[rustfmt::skip]");
    line("impl From<bearing_watch::drive::CleanSample<FURTHER>> for Sample {");
    line("    fn from(clean: bearing_watch::drive::CleanSample<FURTHER>) -> Self {");
    line(&format!("        let [{}] = clean.further;", further.join(", ")));
    let field = |channel: &Channel| {
        let name = channel.name.as_str();
        if own(channel) { format!("{name}: clean.{name}") } else { name.to_string() }
    };
    let angle = model.plan().layout().needs_angle().then(|| "angle: clean.angle".to_string());
    let fields: Vec<String> = channels.iter().map(field).chain(angle).collect();
    line(&format!("        Self {{ {} }}", fields.join(", ")));
    line("    }");
    line("}");
    line("");
    line("bearing_watch::watch_static! {");
    line("    /// Front end, detector and monitor of the drive.");
    line("    pub static WATCH: Drive, DriveFrontEnd;");
    line("}");
    Ok(out)
}

/// The function that makes a position from what the sensor reads.
fn position(columns: &Columns) -> Result<Vec<String>, Error> {
    let (parameters, angle, reversed) = match columns {
        Columns::Resolver { .. } => return Ok(vec![]),
        Columns::Angle { reversed, .. } => ("angle: bearing_watch::Angle", "angle".into(), *reversed),
        Columns::Counts { reversed, .. } => match columns.turn().map_err(Error::Usage)? {
            Some(Turn::Counts(..)) => ("counts: i32", "TURN.angle(counts)".into(), *reversed),
            Some(Turn::Bits(bits)) => {
                ("counts: u32", format!("bearing_watch::Angle::from_counts(counts, {bits})"), *reversed)
            }
            None => return Ok(vec![]),
        },
    };
    let mut lines = vec![String::new()];
    if let Ok(Some(Turn::Counts(turn, _))) = columns.turn() {
        lines.push("/// Counts of the position sensor in a turn.".into());
        lines.push("pub const TURN: bearing_watch::EncoderCounts =".into());
        lines.push(format!("    bearing_watch::EncoderCounts::new({turn}).expect(\"a number of counts\");"));
        lines.push(String::new());
    }
    let angle = if reversed { format!("{angle}.negated()") } else { angle };
    lines.push("/// The reading of the position sensor.".into());
    lines.push("#[must_use]".into());
    lines.push(format!("pub const fn position({parameters}) -> bearing_watch::drive::Position {{"));
    lines.push(format!("    bearing_watch::drive::Position::Absolute({angle})"));
    lines.push("}".into());
    Ok(lines)
}

/// The field of the phases, with its documentation.
fn phase_field(which: &str, phases: usize) -> [String; 2] {
    [format!("/// Converter counts of the currents of phases {which}."), format!("pub phases: [u16; {phases}],")]
}

/// The field of a channel: that of its name, unless the reading has one of this name itself.
fn field_of(name: &str) -> String {
    let taken = ["number", "phases", "position", "resolver"].contains(&name);
    if taken { format!("{name}_channel") } else { name.into() }
}

/// What the drive reads at one instant, by names, and its conversion.
fn reading(model: &Model<RunTime>, file: &FrontEndFile) -> Vec<String> {
    let phases = file.currents.columns.len();
    let (current, currents) = match file.currents.phases.names() {
        _ if phases == 1 => (
            [
                "/// Quadrature current of the drive's own control, A; NaN if it is missing.".into(),
                "pub current_a: f32,".into(),
            ],
            "Quadrature(reading.current_a)",
        ),
        _ if phases == 3 => (phase_field("a, b and c", 3), "Three(reading.phases)"),
        [first, second] => (phase_field(&format!("{first} and {second}"), 2), "Two(reading.phases)"),
    };
    let (field, kind_of_field, doc, made) = match file.position {
        Columns::Resolver { .. } => (
            "resolver",
            "Option<[f32; 2]>",
            "Demodulated sine and cosine of the resolver; `None` if they are missing.",
            "map_or(bearing_watch::drive::Position::Missing, |[sin, cos]| bearing_watch::drive::Position::Resolver { sin, cos })",
        ),
        Columns::Angle { .. } => (
            "position",
            "Option<bearing_watch::Angle>",
            "Angle of the shaft; `None` if it is missing.",
            "map_or(bearing_watch::drive::Position::Missing, position)",
        ),
        Columns::Counts { bits, .. } => (
            "position",
            if bits.is_some() { "Option<u32>" } else { "Option<i32>" },
            "Counts of the position sensor; `None` if the reading is missing.",
            "map_or(bearing_watch::drive::Position::Missing, position)",
        ),
    };
    let channels = model.constants().channels.iter().filter(|channel| !own(channel));
    let mut lines: Vec<String> = vec![
        String::new(),
        "/// What the drive reads at one instant of its control loop.".into(),
        "#[derive(Clone, Copy, Debug)]".into(),
        "pub struct Reading {".into(),
        "    /// Number of the instant, such as that of the PWM period: a missed interrupt leaves a gap.".into(),
        "    pub number: u32,".into(),
    ];
    lines.extend(current.map(|text| format!("    {text}")));
    lines.extend([format!("    /// {doc}"), format!("    pub {field}: {kind_of_field},")]);
    for channel in channels {
        lines.push(format!("    /// {}; NaN if it is missing.", channel.unit.as_str()));
        lines.push(format!("    pub {}: f32,", field_of(channel.name.as_str())));
    }
    let further =
        further_channels(model).iter().map(|name| format!("reading.{}", field_of(name))).collect::<Vec<_>>().join(", ");
    lines.extend([
        "}".into(),
        String::new(),
        "#[rustfmt::skip]".into(),
        "impl From<Reading> for bearing_watch::drive::RawSample<FURTHER> {".into(),
        "    #[inline]".into(),
        "    fn from(reading: Reading) -> Self {".into(),
        format!("        let currents = bearing_watch::drive::PhaseCounts::{currents};"),
        format!("        let position = reading.{field}.{made};"),
        format!("        Self {{ number: reading.number, currents, position, further: [{further}] }}"),
        "    }".into(),
        "}".into(),
    ]);
    lines
}

/// The channels of a model that the front end takes as further ones, in their order.
pub(crate) fn further_channels(model: &Model<RunTime>) -> Vec<&str> {
    model.constants().channels.iter().filter(|channel| !own(channel)).map(|channel| channel.name.as_str()).collect()
}

/// The recorded columns of these channels, if the front end makes all of them; otherwise an error about an option.
///
/// # Errors
/// A channel that is a difference of columns.
pub fn further_columns(model: &Model<RunTime>, recorded: &Channels, option: &str) -> Result<Vec<String>, Error> {
    let fields = fields(&model.plan().layout()).unwrap_or_default();
    let columns = recorded.names();
    let channels = model.constants().channels.iter().enumerate().filter(|(_, channel)| !own(channel));
    let each = |(place, channel): (usize, &Channel)| {
        let name = channel.name.as_str();
        let recorded = fields.get(place).and_then(|field| column(*field, recorded));
        let known = recorded.or_else(|| columns.contains(&name).then_some(name));
        known.filter(|name| !name.contains('-')).map(String::from).ok_or_else(|| {
            let problem =
                format!("{option}: the front end makes no channel {name}, a difference of columns; use its columns");
            Error::Usage(problem)
        })
    };
    channels.map(each).collect()
}

/// Whether the front end makes the channel from currents and angle.
pub(crate) fn own(channel: &Channel) -> bool {
    matches!(channel.name.as_str(), "current_a" | "velocity_rad_s")
}

fn constants(constants: &FrontEndConstants) -> Vec<String> {
    let FrontEndConstants { control_rate_hz, sensors, stuck_samples, balance, tracking, frame } = constants;
    let sensor = |sensor: &PhaseSensor| format!("    bearing_watch::drive::{sensor:?},");
    let park = match frame.park {
        Park::Standard => "Standard",
        Park::Thesis => "Thesis",
    };
    let mut lines = vec![format!("control_rate_hz: {control_rate_hz:?},"), "sensors: [".into()];
    lines.extend(sensors.iter().map(sensor));
    lines.push("],".into());
    lines.push(format!("stuck_samples: {stuck_samples},"));
    lines.push(format!("balance: bearing_watch::drive::{balance:?},"));
    let resolver = tracking.resolver;
    lines.push("tracking: bearing_watch::drive::TrackingConstants {".into());
    for (name, value) in [
        ("bandwidth_hz", format!("{:?}", tracking.bandwidth_hz)),
        ("damping", format!("{:?}", tracking.damping)),
        ("error_limit_rad", format!("{:?}", tracking.error_limit_rad)),
        ("lost_samples", tracking.lost_samples.to_string()),
        ("settle_samples", tracking.settle_samples.to_string()),
        ("resolver", format!("bearing_watch::drive::{resolver:?}")),
    ] {
        lines.push(format!("    {name}: {value},"));
    }
    lines.push("},".into());
    let offset = frame.electrical_offset.bits();
    lines.push("frame: bearing_watch::drive::RotorFrame {".into());
    lines.push(format!("    pole_pairs: {},", frame.pole_pairs));
    lines.push(format!("    electrical_offset: bearing_watch::Angle::from_bits({offset}),"));
    lines.push(format!("    park: bearing_watch::Park::{park},"));
    lines.push("},".into());
    lines
}
