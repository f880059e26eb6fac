//! One object for a drive, as part of the model's C header: what it reads, and the calls of its three contexts.

use bearing_watch::model::Channel;

use super::c_text::{fields, line};
use super::front_end_source::own;
use crate::trace::FrontEndFile;
use crate::trace::front_end::{Columns, Turn};

/// Names that a reading behind a front end has itself.
const TAKEN: [&str; 8] = ["number", "phases", "current_a", "position_missing", "position", "sin", "cos", "angle"];

/// Returns the part of the header, of a drive with a front end or with the channels of the model as its own signals.
pub(crate) fn drive_header(channels: &[Channel], needs_angle: bool, file: Option<&FrontEndFile>) -> String {
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
    let names = fields(&names, if file.is_some() { &TAKEN } else { &["angle"] });
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
        /* What a library for one plan needs is in bearing_watch_plan.h, which export.sh writes beside it. */\n\
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
        typedef struct BwDrive {\n    uint64_t detector_memory[(BW_MODEL_STATE_SIZE + 7) / 8];\n";
    if front_end {
        *out += "    uint64_t front_end_memory[(BW_MODEL_FRONT_END_SIZE + 7) / 8];\n    BwFrontEnd *front_end;\n";
    }
    *out += "    BwState *detector; /* for all other functions of bearing_watch.h */\n    \
        volatile uint32_t samples; /* that the detector was given */\n} BwDrive;\n";
}

fn start(out: &mut String, front_end: bool) {
    let constants = if front_end { ", const BwFrontEndConstants *constants" } else { "" };
    if front_end {
        *out += "/* At boot, before the interrupts run; with &bw_front_end, or a copy that is calibrated for this drive. */\n";
    } else {
        *out += "/* At boot, before the interrupts run. */\n";
    }
    *out += &format!(
        "BW_MUST_CHECK static inline BwCode bw_drive_start(BwDrive *drive{constants}) {{\n\
         \x20   BwCode code;\n\
         \x20   if (bw_known_answer_test() != 0u) {{ return BW_CODE_ARITHMETIC; }}\n\
         #ifdef BW_LIBRARY_HAS_MODEL\n\
         \x20   code = bw_init_own(drive->detector_memory, sizeof drive->detector_memory, BW_MODEL_ID, &drive->detector);\n\
         #else\n\
         \x20   code = bw_init(drive->detector_memory, sizeof drive->detector_memory, bw_model, BW_MODEL_LENGTH,\n\
         \x20                  &drive->detector);\n\
         #endif\n"
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
    *out += "/* In the interrupt of the current loop. BW_CODE_CLEAN_SAMPLE: request the interrupt of bw_drive_collect, also for a\n \
        * sample that found the queue full and is lost: BwReport::lost_samples counts it. */\n\
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
        \x20   bw_tell_alignment(drive->detector, clean.alignment);\n\
        \x20   put = bw_put(drive->detector, values, BW_MODEL_CHANNELS, clean.angle, clean.found_late != 0);\n\
        \x20   drive->samples = drive->samples + 1u;\n\
        \x20   return put < 0 && put != BW_CODE_SAMPLE_LOST ? put : code;\n}\n";
}

fn negated(angle: String, reversed: bool) -> String {
    if reversed { format!("0u - {angle}") } else { angle }
}

/// The call of the current loop, with signals of the drive's own.
fn sample(out: &mut String, names: &[String], needs_angle: bool) {
    let list: Vec<String> = names.iter().map(|name| format!("reading->{name}")).collect();
    let angle = if needs_angle { "reading->angle" } else { "0u" };
    *out += "/* In the sampling interrupt, at the rate of the model; BW_CODE_OK: request the interrupt of bw_drive_collect, also for\n \
        * a sample that found the queue full and is lost: BwReport::lost_samples counts it. */\n\
        static inline BwCode bw_drive_sample(BwDrive *drive, const BwReading *reading) {\n    BwCode put;\n";
    line(out, &format!("    const float values[BW_MODEL_CHANNELS] = {{ {} }};", list.join(", ")));
    line(out, "    drive->samples = drive->samples + 1u;");
    line(out, &format!("    put = bw_put(drive->detector, values, BW_MODEL_CHANNELS, {angle}, false);"));
    line(out, "    return put == BW_CODE_SAMPLE_LOST ? BW_CODE_OK : put;\n}");
}

const BELOW: &str = "/* In an interrupt below the current loop, or behind bw_drive_sample: the detector. */
static inline BwCode bw_drive_collect(BwDrive *drive) { return bw_collect_waiting(drive->detector); }
/* In the main loop, as often as you like, by a clock that the timer of the samples does not make: below 0 why the drive is
 * not watched, once until it is again. bw_error_text has the words. */
BW_MUST_CHECK static inline BwCode bw_drive_clock(BwDrive *drive, uint32_t milliseconds) {
    return bw_clock(drive->detector, drive->samples, milliseconds);
}
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
/* At power-down: ends the run, and writes the `length` bytes that the next start gives to bw_restore. */
static inline BwCode bw_drive_end_run(BwDrive *drive, uint8_t *bytes, size_t capacity, size_t *length) {
    BwCode code = bw_end_run(drive->detector);
    if (code >= 0) { code = bw_saved_size(drive->detector, length); }
    return code < 0 ? code : bw_save(drive->detector, bytes, capacity);
}
/* The word for a verdict: the name of the class, or that of bw_verdict_name. */
static inline const char *bw_drive_verdict(const BwReport *report) {
    static const char *const classes[BW_MODEL_CLASSES] = BW_MODEL_CLASS_NAMES;
    bool named = report->verdict == BW_VERDICT_CLASS && report->class_index < BW_MODEL_CLASSES;
    return named ? classes[report->class_index] : bw_verdict_name(report->verdict);
}
";

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::process::Command;

    use bearing_watch::Model;
    use bearing_watch::plan::RunTime;

    use crate::trace::{Channels, FrontEndFile, TextForm};
    use crate::train::sources::c_header::c_header;

    const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

    /// The header of the committed model behind a front end.
    fn header(front_end: &str) -> String {
        let file = std::fs::read(format!("{ROOT}/examples/support/actuator/model.bwm")).expect("the committed model");
        let model = Model::<RunTime>::from_bytes(&file).expect("a model");
        let front_end = FrontEndFile::parse(front_end).unwrap_or_else(|(place, problem)| panic!("{place}: {problem}"));
        let recorded = Channels {
            further: vec!["velocity_rad_s".into()],
            text: TextForm::default(),
            front_end: Some(front_end),
            ..Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm")
        };
        c_header(&model, (&[], &[]), Some(&recorded)).expect("a header")
    }

    const TRACKING: &str = "
[tracking]
bandwidth_hz = 300.0
damping = 0.7
error_limit_rad = 0.1
lost_samples = 20
settle_samples = 20

[motor]
pole_pairs = 7
park = \"standard\"
";

    fn quadrature(position: &str) -> String {
        let currents = "[currents]\nquantity = \"quadrature\"\ncolumns = [\"iq_a\"]\n";
        format!("control_rate_hz = 10000.0\nfactor = 10\n{currents}[position]\n{position}{TRACKING}")
    }

    fn phases(position: &str, which: &str) -> String {
        let lists = "offset_counts = [2048.0, 2048.0]\ngain_a = [0.02, 0.02]\nusable_counts = [16, 4079]\n";
        let currents = format!("[currents]\ncolumns = [\"b\", \"c\"]\nphases = \"{which}\"\n{lists}");
        let balance = "[balance]\nnoise_a = 0.5\ngain_tolerance = 0.02\nwindow = 400\n";
        format!("control_rate_hz = 10000.0\nfactor = 10\n{currents}{balance}[position]\n{position}{TRACKING}")
    }

    /// Compiles text beside the header in a folder; `false` without a compiler.
    fn compiles(header: &str, compiler: &str, arguments: &[&str], file: &Path) -> bool {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("model.h"), header).expect("writable");
        let mut command = Command::new(compiler);
        command.args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror"]).args(arguments).arg("-I").arg(folder.path());
        command.arg(format!("-I{ROOT}/c-api/include")).arg(format!("-I{ROOT}/c-api/glue"));
        let Ok(output) = command.arg(file).output() else {
            println!("skipped: {compiler} is not installed");
            return false;
        };
        assert!(output.status.success(), "{}\n{}", file.display(), String::from_utf8_lossy(&output.stderr));
        true
    }

    #[test]
    fn each_kind_of_sensors_has_an_object_that_compiles() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("use.c");
        let text = "#include \"model.h\"\nstatic BwDrive drive;\nint run(void) {\n    static BwReading now;\n    \
                    BwReport report;\n    BwAlarm alarm;\n    if (bw_drive_start(&drive, &bw_front_end) < 0) { return 1; }\n    \
                    bw_drive_sample(&drive, &now);\n    bw_drive_collect(&drive);\n    \
                    if (bw_drive_clock(&drive, 5u) < 0) { return 1; }\n    return bw_drive_advance(&drive, &report, &alarm);\n}\nint stop(uint8_t *bytes, size_t size) {\n    \
                    size_t length;\n    BwReport report;\n    bw_report(drive.detector, &report);\n    \
                    return bw_drive_verdict(&report) ? bw_drive_end_run(&drive, bytes, size, &length) : 0;\n}\n";
        std::fs::write(&file, text).expect("writable");
        let positions = [
            "counts = \"n\"\nbits = 14\n",
            "counts = \"n\"\ncounts_per_turn = 8000\nreversed = true\n",
            "angle_rad = \"angle\"\n",
            "sin = \"sin\"\ncos = \"cos\"\namplitude = [0.5, 1.5]\nmismatch = 0.1\n",
        ];
        for position in positions {
            for front_end in [quadrature(position), phases(position, "bc"), phases(position, "ca")] {
                let header = header(&front_end);
                for (compiler, language) in [("cc", "c"), ("c++", "c++")] {
                    compiles(&header, compiler, &["-x", language], &file);
                }
            }
        }
        // The thirds of a turn by which the first phase is behind phase a.
        let text = header(&phases(positions[0], "bc"));
        assert!(text.contains("2863311530u, /* electrical_offset_turn32 */"), "{text}");
    }

    /// The glue for the firmwares of others, against the declarations that stand in for them.
    #[test]
    fn the_glue_compiles_for_both_kinds_of_counts() {
        for position in ["counts = \"n\"\nbits = 32\n", "counts = \"n\"\ncounts_per_turn = 8192\n"] {
            let header = header(&quadrature(position));
            for (file, compiler, standard) in [
                ("odrive.cpp", "c++", "-std=gnu++17"),
                ("moteus.cpp", "c++", "-std=gnu++17"),
                ("simplefoc.cpp", "c++", "-std=c++14"),
                ("vesc.c", "cc", "-std=c99"),
            ] {
                let file = format!("{ROOT}/c-api/glue/{file}");
                compiles(&header, compiler, &[standard, "-DBEARING_WATCH_STAND_IN"], Path::new(&file));
            }
        }
    }
}
