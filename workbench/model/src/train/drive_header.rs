//! One object for a drive, as part of the model's C header: what it reads by names, and the calls of its three contexts.

use bearing_watch::model::Channel;

use super::c_text::{fields, line};
use super::front_end_source::own;
use crate::trace::FrontEndFile;
use crate::trace::front_end::{Columns, Turn};

/// Names that a reading has itself.
const TAKEN: [&str; 8] = ["number", "phases", "current_a", "position_missing", "position", "sin", "cos", "angle"];

/// Returns the part of the header, of a drive with a front end or with the channels of the model as its own signals.
pub(super) fn drive_header(channels: &[Channel], needs_angle: bool, file: Option<&FrontEndFile>) -> String {
    let mut out = String::from(
        "\n/* What the drive reads at one instant. */\n\
         typedef struct BwReading {\n",
    );
    match file {
        Some(file) => raw_fields(&mut out, file),
        None if needs_angle => line(&mut out, "    uint32_t angle; /* of the shaft, as bw_angle returns it */"),
        None => {}
    }
    let given: Vec<&Channel> = channels.iter().filter(|channel| file.is_none() || !own(channel)).collect();
    let names: Vec<&str> = given.iter().map(|channel| channel.name.as_str()).collect();
    let names = fields(&names, &TAKEN);
    for (channel, field) in given.iter().zip(&names) {
        // In ASCII, as the rest of the header.
        let unit = channel.unit.as_str().replace("N·m", "N m");
        let unit = if unit.is_ascii() && !unit.contains("*/") { unit } else { "in the unit of training".into() };
        line(&mut out, &format!("    float {field}; /* {unit}; NAN if it is missing */"));
    }
    line(&mut out, "} BwReading;");
    memory(&mut out, file.is_some());
    start(&mut out, file.is_some());
    match file {
        Some(file) => raw_sample(&mut out, file, &names),
        None => sample(&mut out, &names, needs_angle),
    }
    out += BELOW;
    out
}

fn raw_fields(out: &mut String, file: &FrontEndFile) {
    let phases = file.currents.columns.len();
    let which = match file.currents.phases.names() {
        _ if phases == 3 => "a, b and c".into(),
        [first, second] => format!("{first} and {second}"),
    };
    line(
        out,
        "    uint32_t number; /* of the instant, such as that of the PWM period: a missed interrupt leaves a gap */",
    );
    if phases == 1 {
        line(out, "    float current_a; /* quadrature current of the drive's own control; NAN if it is missing */");
    } else {
        line(out, &format!("    uint16_t phases[{phases}]; /* converter counts of the currents of phases {which} */"));
    }
    line(out, "    bool position_missing; /* the sensor or its line reports a fault */");
    line(
        out,
        match &file.position {
            Columns::Resolver { .. } => "    float sin, cos; /* demodulated signals of the resolver */",
            Columns::Angle { .. } => "    uint32_t position; /* angle of the shaft, as bw_angle returns it */",
            Columns::Counts { bits: Some(_), .. } => "    uint32_t position; /* counts of the position sensor */",
            Columns::Counts { .. } => "    int32_t position; /* counts of the encoder, over turns or within one */",
        },
    );
}

fn memory(out: &mut String, front_end: bool) {
    *out += "\n\
        /* The bytes that a library for one plan needs are in bearing_watch_plan.h, which export.sh writes beside it. */\n\
        #if defined(__has_include)\n\
        #if __has_include(\"bearing_watch_plan.h\")\n\
        #include \"bearing_watch_plan.h\"\n\
        #endif\n\
        #endif\n\
        #ifndef BW_MODEL_STATE_SIZE\n\
        #define BW_MODEL_STATE_SIZE BW_STATE_SIZE\n";
    if front_end {
        *out += "#define BW_MODEL_FRONT_END_SIZE BW_FRONT_END_SIZE\n";
    }
    *out += "#endif\n\
        /* A drive: zero it, as a static is. */\n\
        typedef struct BwDrive {\n    uint64_t detector_memory[BW_MODEL_STATE_SIZE / 8];\n";
    if front_end {
        *out += "    uint64_t front_end_memory[BW_MODEL_FRONT_END_SIZE / 8];\n    BwFrontEnd *front_end;\n";
    }
    *out += "    BwState *detector; /* for all other functions of bearing_watch.h */\n} BwDrive;\n";
}

fn start(out: &mut String, front_end: bool) {
    let constants = if front_end { ", const BwFrontEndConstants *constants" } else { "" };
    if front_end {
        *out += "/* At boot, before the interrupts run; with &bw_front_end, or a copy that is calibrated for this drive. */\n";
    } else {
        *out += "/* At boot, before the interrupts run. */\n";
    }
    *out += &format!(
        "static inline BwCode bw_drive_start(BwDrive *drive{constants}) {{\n\
         \x20   BwCode code;\n\
         \x20   if (bw_known_answer_test() != 0u) {{ return BW_CODE_ARITHMETIC; }}\n\
         \x20   code = bw_init(drive->detector_memory, sizeof drive->detector_memory, bw_model, BW_MODEL_LENGTH,\n\
         \x20                  &drive->detector);\n"
    );
    if front_end {
        *out += "    if (code >= 0) {\n\
            \x20       code = bw_front_end_init(drive->front_end_memory, sizeof drive->front_end_memory, constants,\n\
            \x20                                &drive->front_end);\n\
            \x20   }\n\
            \x20   return code < 0 ? code : bw_check_front_end(drive->detector, constants);\n}\n";
    } else {
        *out += "    return code;\n}\n";
    }
}

/// The call of the current loop, with a front end.
fn raw_sample(out: &mut String, file: &FrontEndFile, names: &[String]) {
    *out += "/* In the interrupt of the current loop. BW_CODE_CLEAN_SAMPLE: request the interrupt of bw_drive_collect. */\n\
        static inline BwCode bw_drive_sample(BwDrive *drive, const BwReading *reading) {\n\
        \x20   BwRawSample raw;\n    BwCleanSample clean;\n    float values[BW_MODEL_CHANNELS];\n";
    let phases = file.currents.columns.len();
    if names.is_empty() {
        *out += "    const float *further = NULL;\n";
    } else {
        let list: Vec<String> = names.iter().map(|name| format!("reading->{name}")).collect();
        line(out, &format!("    const float further[BW_FRONT_END_FURTHER] = {{ {} }};", list.join(", ")));
    }
    *out += "    BwCode code, put;\n    raw.number = reading->number;\n";
    line(out, &format!("    raw.phases = {phases};"));
    line(out, &format!("    raw.current_a = {};", if phases == 1 { "reading->current_a" } else { "0.0f" }));
    for k in 0..3 {
        let counts = if k < phases && phases > 1 { format!("reading->phases[{k}]") } else { "0".into() };
        line(out, &format!("    raw.counts[{k}] = {counts};"));
    }
    let (kind, angle, signals) = match &file.position {
        Columns::Resolver { .. } => ("RESOLVER", "0u".into(), ["reading->sin", "reading->cos"]),
        Columns::Angle { reversed, .. } => ("ABSOLUTE", negated("reading->position".into(), *reversed), ["0.0f"; 2]),
        Columns::Counts { reversed, .. } => {
            let angle = match file.position.turn() {
                Ok(Some(Turn::Counts(..))) => "bw_front_end_angle(reading->position)",
                Ok(_) | Err(_) => "bw_angle(reading->position, BW_FRONT_END_POSITION_BITS)",
            };
            ("ABSOLUTE", negated(angle.into(), *reversed), ["0.0f"; 2])
        }
    };
    line(out, &format!("    raw.position = reading->position_missing ? BW_POSITION_MISSING : BW_POSITION_{kind};"));
    line(out, &format!("    raw.angle = {angle};"));
    line(out, &format!("    raw.sin = {};\n    raw.cos = {};", signals[0], signals[1]));
    *out += "    code = bw_front_end_push(drive->front_end, &raw, further, BW_FRONT_END_FURTHER, &clean);\n\
        \x20   if (code != BW_CODE_CLEAN_SAMPLE) { return code; }\n\
        \x20   bw_front_end_values(&clean, values);\n\
        \x20   put = bw_put(drive->detector, values, BW_MODEL_CHANNELS, clean.angle, clean.found_late != 0);\n\
        \x20   return put < 0 ? put : code;\n}\n";
}

fn negated(angle: String, reversed: bool) -> String {
    if reversed { format!("0u - {angle}") } else { angle }
}

/// The call of the current loop, with signals of the drive's own.
fn sample(out: &mut String, names: &[String], needs_angle: bool) {
    let list: Vec<String> = names.iter().map(|name| format!("reading->{name}")).collect();
    let angle = if needs_angle { "reading->angle" } else { "0u" };
    *out += "/* In the sampling interrupt, at the rate of the model; then request the interrupt of bw_drive_collect. */\n\
        static inline BwCode bw_drive_sample(BwDrive *drive, const BwReading *reading) {\n";
    line(out, &format!("    const float values[BW_MODEL_CHANNELS] = {{ {} }};", list.join(", ")));
    line(out, &format!("    return bw_put(drive->detector, values, BW_MODEL_CHANNELS, {angle}, false);\n}}"));
}

const BELOW: &str = "/* In an interrupt below the current loop, or behind bw_drive_sample: the detector. */
static inline BwCode bw_drive_collect(BwDrive *drive) { return bw_collect_waiting(drive->detector); }
/* In the main loop, one bounded step: BW_CODE_REPORT if report and alarm were written. */
static inline BwCode bw_drive_advance(BwDrive *drive, BwReport *report, BwAlarm *alarm) {
    BwCode code = bw_advance(drive->detector);
    if (code == BW_CODE_REPORT) {
        bw_adopt(drive->detector);
        bw_report(drive->detector, report);
        bw_alarm(drive->detector, alarm);
    }
    return code;
}
";
