//! The front end that a model was trained with, as part of the model's C header.

use bearing_watch::drive::{FrontEndConstants, PhaseSensor};
use bearing_watch::plan::RunTime;
use bearing_watch::{Model, Park};

use super::c_name::CName;
use super::c_text::{enumeration, line, number, texts};
use super::front_end_source::{further_channels, further_columns, own};
use crate::Error;
use crate::trace::front_end::Turn;
use crate::trace::{Channels, FrontEndFile};

/// Further channels that the C interface takes at most, its `BW_MAX_FURTHER`.
const MAX_FURTHER: usize = 6;

/// Returns the part of the header: the constants as `bw_front_end`, and the further channels.
///
/// # Errors
/// A model with a channel that is a difference of columns, or with more further channels than the C interface takes.
pub(crate) fn front_end_header(
    model: &Model<RunTime>,
    recorded: &Channels,
    file: &FrontEndFile,
    CName { upper, lower, .. }: &CName,
) -> Result<String, Error> {
    further_columns(model, recorded, "--c")?;
    let names = further_channels(model);
    if names.len() > MAX_FURTHER {
        let problem = format!("--c: the C interface takes {MAX_FURTHER} channels besides current and velocity");
        return Err(Error::Usage(problem));
    }
    let channels = &model.constants().channels;
    let units: Vec<&str> =
        channels.iter().filter(|channel| !own(channel)).map(|channel| channel.unit.as_str()).collect();
    let mut out = String::from("\n/* The front end that the recordings passed: raw samples per clean sample. */\n");
    line(&mut out, &format!("#define {upper}FRONT_END_FACTOR {}u", file.factor));
    match file.position.turn().map_err(Error::Usage)? {
        Some(Turn::Bits(bits)) => {
            line(&mut out, "/* Bits a turn of the position sensor, for `bw_angle`. */");
            line(&mut out, &format!("#define {upper}FRONT_END_POSITION_BITS {bits}u"));
        }
        Some(Turn::Counts(turn, _)) => {
            line(&mut out, "/* Counts a turn of the encoder, for `bw_angle_from_cpr`. */");
            line(&mut out, &format!("#define {upper}FRONT_END_COUNTS_PER_TURN {turn}"));
            out += &angle_of_counts(turn, upper, lower);
        }
        None => {}
    }
    line(&mut out, "/* Its further channels, in this order, with names and units. */");
    line(&mut out, &format!("#define {upper}FRONT_END_FURTHER {}u", names.len()));
    if !names.is_empty() {
        enumeration(&mut out, &format!("{upper}FRONT_END_FURTHER_"), &names);
        line(&mut out, &format!("#define {upper}FRONT_END_FURTHER_NAMES {}", texts(&names)));
        line(&mut out, &format!("#define {upper}FRONT_END_FURTHER_UNITS {}", texts(&units)));
    }
    out += "/* For `bw_front_end_init`; `bw_calibration_finish` puts the offsets of a drive into a copy. */\n";
    out += &format!("static const BwFrontEndConstants {lower}front_end = {{\n");
    for (value, name) in constants(&file.constants(), file.factor, names.len()) {
        line(&mut out, &format!("    {value}, /* {name} */"));
    }
    out += "};\n";
    Ok(out)
}

/// `bw_angle_from_cpr` of a number that the compiler knows: without its division of 64 bits.
fn angle_of_counts(turn: u32, upper: &str, lower: &str) -> String {
    let scale = (1_u64 << 48) / u64::from(turn) + 1;
    format!(
        "static inline uint32_t {lower}front_end_angle(int32_t counts) {{\n\
         \x20   int32_t within = counts % {upper}FRONT_END_COUNTS_PER_TURN;\n\
         \x20   if (within < 0) {{ within += {upper}FRONT_END_COUNTS_PER_TURN; }}\n\
         \x20   return (uint32_t)(((uint64_t)(uint32_t)within * {scale}u) >> 16);\n}}\n"
    )
}

/// The values of a `BwFrontEndConstants` with their names, in the order of the header: C++ has no designators before
/// 2020.
fn constants(own: &FrontEndConstants, factor: usize, further: usize) -> Vec<(String, &'static str)> {
    let FrontEndConstants { control_rate_hz, sensors, stuck_samples, balance, tracking, frame } = own;
    let sensor = |own: &PhaseSensor| {
        let PhaseSensor { offset_counts, gain_a, usable: [lowest, highest] } = own;
        format!("{{ {}, {}, {lowest}, {highest} }}", number(*offset_counts), number(*gain_a))
    };
    let sensors: Vec<String> = sensors.iter().map(sensor).collect();
    let park = match frame.park {
        Park::Standard => "BW_PARK_STANDARD",
        Park::Thesis => "BW_PARK_THESIS",
    };
    vec![
        (number(*control_rate_hz), "control_rate_hz"),
        (factor.to_string(), "factor"),
        (further.to_string(), "further"),
        (format!("{{ {} }}", sensors.join(", ")), "sensors: offset_counts, gain_a, lowest_counts, highest_counts"),
        (stuck_samples.to_string(), "stuck_samples"),
        (balance.window.to_string(), "balance_window_samples"),
        (number(balance.noise_a), "balance_noise_a"),
        (number(balance.offset_a), "balance_offset_a"),
        (number(balance.gain_tolerance), "balance_gain_tolerance"),
        (number(tracking.bandwidth_hz), "tracking_bandwidth_hz"),
        (number(tracking.damping), "tracking_damping"),
        (number(tracking.error_limit_rad), "tracking_error_limit_rad"),
        (tracking.lost_samples.to_string(), "tracking_lost_samples"),
        (tracking.settle_samples.to_string(), "tracking_settle_samples"),
        (number(tracking.resolver.low), "resolver_lowest_amplitude"),
        (number(tracking.resolver.high), "resolver_highest_amplitude"),
        (number(tracking.resolver.mismatch), "resolver_mismatch"),
        (format!("{}u", frame.pole_pairs), "pole_pairs"),
        (format!("{}u", frame.electrical_offset.bits()), "electrical_offset_turn32"),
        (park.to_owned(), "park"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::front_end::FACTORS;
    use crate::train::sources::c_header::c_header;
    use rig::ema::EmaScenario;

    const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

    fn text(path: &str) -> String {
        std::fs::read_to_string(format!("{ROOT}/{path}")).unwrap_or_else(|error| panic!("{path}: {error}"))
    }

    /// The channels of the committed model, from the front end of its rig.
    fn recorded() -> Channels {
        let name = String::from;
        Channels {
            y: name("current_a"),
            u1: name("velocity_ref_rad_s"),
            u2: name("load_torque_nm"),
            shaft: None,
            further: vec![name("velocity_rad_s")],
            time: None,
            text: crate::trace::TextForm::default(),
            rate_hz: None,
            front_end: EmaScenario::RIT.front_end_toml(&FACTORS).and_then(|text| FrontEndFile::parse(&text).ok()),
        }
    }

    fn model() -> Model<RunTime> {
        let file = std::fs::read(format!("{ROOT}/examples/support/actuator/model.bwm")).expect("the committed model");
        Model::from_bytes(&file).expect("a model")
    }

    #[test]
    fn the_committed_header_is_that_of_the_committed_model() {
        let source = text("examples/support/actuator/model.rs");
        let notes = source.lines().skip(2).map_while(|line| line.strip_prefix("// ")).map(String::from);
        let orders = ["outer", "inner", "ball", "cage"].map(String::from);
        let header =
            c_header(&model(), (&notes.collect::<Vec<_>>(), &orders), Some(&recorded()), None).expect("a header");
        if std::env::var_os("BEARING_WATCH_WRITE_HEADER").is_some() {
            std::fs::write(format!("{ROOT}/examples/support/actuator/model.h"), &header).expect("a writable file");
        }
        let same = header == text("examples/support/actuator/model.h");
        assert!(same, "this test writes it anew with the variable BEARING_WATCH_WRITE_HEADER:\n{header}");
    }

    /// The fields have no designators: their order is that of the interface.
    #[test]
    fn names_and_order_are_those_of_the_interface() {
        let interface = text("c-api/include/bearing_watch.h");
        let (_, rest) = interface.split_once("typedef struct BwFrontEndConstants {").expect("the type");
        let fields = rest.split_once('}').expect("its end").0.lines();
        let fields = fields.filter_map(|line| line.split("//").next()?.trim().strip_suffix(';'));
        let fields: Vec<&str> = fields.filter_map(|line| line.split_whitespace().last()?.split('[').next()).collect();
        let file = recorded().front_end.expect("a front end");
        let written = constants(&file.constants(), file.factor, 2);
        let written: Vec<&str> = written.iter().filter_map(|(_, name)| name.split(':').next()).collect();
        assert_eq!(written, fields);
        let service = text("c-api/include/bearing_watch_service.h");
        assert!(service.contains(&format!("#define BW_MAX_FURTHER {MAX_FURTHER}\n")));
    }

    #[test]
    fn a_channel_that_the_front_end_does_not_make_is_refused() {
        let without = Channels { u2: "load_torque_nm-other".into(), ..recorded() };
        let problem = c_header(&model(), (&[], &[]), Some(&without), None).expect_err("a difference").to_string();
        assert!(problem.contains("--c") && problem.contains("load_torque_nm"), "{problem}");
    }
}
