//! One object for a drive, as part of the model's C header: what it reads, and the calls of its three contexts.

use bearing_watch::model::Channel;

use super::c_name::CName;
use super::c_text::{fields, line};
use super::front_end_source::own;
use crate::trace::FrontEndFile;
use crate::trace::front_end::{Columns, Turn};

/// Names that a reading behind a front end has itself.
const TAKEN: [&str; 8] = ["number", "phases", "current_a", "position_missing", "position", "sin", "cos", "angle"];

/// Returns the part of the header, of a drive with a front end or with the channels of the model as its own signals.
pub(crate) fn drive_header(
    channels: &[Channel],
    needs_angle: bool,
    file: Option<&FrontEndFile>,
    name: &CName,
) -> String {
    let mut out = format!("\n/* What the drive reads at one instant. */\ntypedef struct {}Reading {{\n", name.camel);
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
    line(&mut out, &format!("}} {}Reading;", name.camel));
    out += &start(file.is_some(), name);
    match file {
        Some(file) => raw_sample(&mut out, file, &names, name),
        None => sample(&mut out, &names, needs_angle, name),
    }
    out += &verdict(name);
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
            Columns::Counts { .. } => {
                "    int32_t position; /* counts of the encoder, over turns (bw_within_turn) or within one */"
            }
        },
    );
}

/// The object of a drive, its start and its end.
fn start(front_end: bool, CName { upper, lower, camel }: &CName) -> String {
    let (memory, constants, init, own) = if front_end {
        (
            "\x20   uint64_t front_end_memory[(BW_PLAN_FRONT_END_SIZE + 7) / 8];\n",
            ", const BwFrontEndConstants *constants",
            "    code = bw_front_end_init(drive->front_end_memory, sizeof drive->front_end_memory, constants, &front_end);\n\
             \x20   if (code < 0) { return code; }\n",
            format!("; with &{lower}front_end, or a copy that is calibrated for this drive"),
        )
    } else {
        ("", "", "", String::new())
    };
    format!(
        "\n/* A drive: zero it, as a static is. Two motors have two. */\n\
         typedef struct {camel}Drive {{\n\
         \x20   BwState *state; /* for bw_collect, bw_advance, bw_clock and all others; NULL while nothing runs */\n\
         \x20   uint64_t memory[(BW_PLAN_STATE_SIZE + 7) / 8];\n{memory}}} {camel}Drive;\n\
         /* Before the interrupts run, or behind the stop{own}.\n \
         * Below 0 nothing runs, and a start with right ones may follow; BW_CODE_BUSY: it runs already. */\n\
         BW_MUST_CHECK static inline BwCode {lower}drive_start({camel}Drive *drive{constants}) {{\n\
         \x20   BwFrontEnd *front_end = NULL;\n    BwCode code;\n\
         \x20   if (drive->state != NULL) {{ return BW_CODE_BUSY; }}\n{init}\
         #ifdef BW_LIBRARY_HAS_MODEL\n\
         \x20   code = bw_start_own(drive->memory, sizeof drive->memory, {upper}MODEL_ID, front_end, &drive->state);\n\
         #else\n\
         \x20   code = bw_start(drive->memory, sizeof drive->memory, {lower}model, {upper}MODEL_LENGTH, front_end, &drive->state);\n\
         #endif\n    return code;\n}}\n\
         /* In the main loop; another model or other constants may start then. */\n\
         BW_MUST_CHECK static inline BwCode {lower}drive_stop({camel}Drive *drive) {{\n\
         \x20   BwCode code = bw_stop(drive->state);\n\
         \x20   if (code >= 0) {{ drive->state = NULL; }}\n    return code;\n}}\n"
    )
}

/// The call of the current loop, with a front end.
fn raw_sample(out: &mut String, file: &FrontEndFile, names: &[String], name: &CName) {
    let CName { upper, lower, camel } = name;
    let phases = file.currents.columns.len();
    *out += &format!(
        "/* A reading as the library takes it; a raw recorder takes it, too. */\n\
         static inline BwRawSample {lower}drive_raw(const {camel}Reading *reading) {{\n\
         \x20   BwRawSample raw;\n    raw.number = reading->number;\n    raw.phases = {phases};\n"
    );
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
                Ok(Some(Turn::Counts(..))) => format!("{lower}front_end_angle(reading->position)"),
                Ok(_) | Err(_) => format!("bw_angle(reading->position, {upper}FRONT_END_POSITION_BITS)"),
            };
            ("ABSOLUTE", negated(angle, *reversed), ["0.0f"; 2])
        }
    };
    line(out, &format!("    raw.position = reading->position_missing ? BW_POSITION_MISSING : BW_POSITION_{kind};"));
    line(out, &format!("    raw.angle = {angle};"));
    line(out, &format!("    raw.sin = {};\n    raw.cos = {};", signals[0], signals[1]));
    *out += "    return raw;\n}\n";
    let further = if names.is_empty() {
        "    const float *further = NULL;\n".into()
    } else {
        let list: Vec<String> = names.iter().map(|name| format!("reading->{name}")).collect();
        format!("    const float further[{upper}FRONT_END_FURTHER] = {{ {} }};\n", list.join(", "))
    };
    *out += &format!(
        "/* In the interrupt of the current loop. BW_CODE_COLLECT: request the interrupt of bw_collect. */\n\
         static inline BwCode {lower}drive_sample({camel}Drive *drive, const {camel}Reading *reading) {{\n\
         \x20   BwRawSample raw = {lower}drive_raw(reading);\n{further}\
         \x20   return bw_sample_raw(drive->state, &raw, further, {upper}FRONT_END_FURTHER);\n}}\n"
    );
}

fn negated(angle: String, reversed: bool) -> String {
    if reversed { format!("0u - {angle}") } else { angle }
}

/// The call of the current loop, with signals of the drive's own.
fn sample(out: &mut String, names: &[String], needs_angle: bool, CName { upper, lower, camel }: &CName) {
    let list: Vec<String> = names.iter().map(|name| format!("reading->{name}")).collect();
    let (list, angle) = (list.join(", "), if needs_angle { "reading->angle" } else { "0u" });
    *out += &format!(
        "/* In the sampling interrupt, at the rate of the model. BW_CODE_COLLECT: request the interrupt of bw_collect. */\n\
         static inline BwCode {lower}drive_sample({camel}Drive *drive, const {camel}Reading *reading) {{\n\
         \x20   const float values[{upper}MODEL_CHANNELS] = {{ {list} }};\n\
         \x20   return bw_sample(drive->state, values, {upper}MODEL_CHANNELS, {angle});\n}}\n"
    );
}

/// The word for a verdict.
fn verdict(CName { upper, lower, .. }: &CName) -> String {
    format!(
        "/* The word for a verdict: the name of the class, or that of bw_verdict_name. */\n\
         static inline const char *{lower}drive_verdict(const BwReport *report) {{\n\
         \x20   static const char *const classes[{upper}MODEL_CLASSES] = {upper}MODEL_CLASS_NAMES;\n\
         \x20   bool named = report->verdict == BW_VERDICT_CLASS && report->class_index < {upper}MODEL_CLASSES;\n\
         \x20   return named ? classes[report->class_index] : bw_verdict_name(report->verdict);\n}}\n"
    )
}

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
        header_of(front_end, None)
    }

    fn header_of(front_end: &str, name: Option<&str>) -> String {
        let file = std::fs::read(format!("{ROOT}/examples/support/actuator/model.bwm")).expect("the committed model");
        let model = Model::<RunTime>::from_bytes(&file).expect("a model");
        let front_end = FrontEndFile::parse(front_end).unwrap_or_else(|(place, problem)| panic!("{place}: {problem}"));
        let recorded = Channels {
            further: vec!["velocity_rad_s".into()],
            text: TextForm::default(),
            front_end: Some(front_end),
            ..Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm")
        };
        c_header(&model, (&[], &[]), Some(&recorded), name).expect("a header")
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

    /// Compiles text beside the header in a folder.
    fn compiles(header: &str, compiler: &str, arguments: &[&str], file: &Path) {
        if let Some((success, said)) = compiled(header, compiler, arguments, file) {
            assert!(success, "{}\n{said}", file.display());
        }
    }

    /// Whether it compiles, and what the compiler says; `None` without one.
    fn compiled(header: &str, compiler: &str, arguments: &[&str], file: &Path) -> Option<(bool, String)> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("model.h"), header).expect("writable");
        let mut command = Command::new(compiler);
        command.args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror"]).args(arguments).arg("-I").arg(folder.path());
        command.arg(format!("-I{ROOT}/c-api/include")).arg(format!("-I{ROOT}/c-api/glue"));
        let Ok(output) = command.arg(file).output() else {
            println!("skipped: {compiler} is not installed");
            return None;
        };
        Some((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
    }

    #[test]
    fn each_kind_of_sensors_has_an_object_that_compiles() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("use.c");
        let text = "#include \"model.h\"\nstatic BwDrive drive;\nint run(void) {\n    static BwReading now;\n    \
                    BwReport report;\n    BwAlarm alarm;\n    if (bw_drive_start(&drive, &bw_front_end) < 0) { return 1; }\n    \
                    bw_drive_sample(&drive, &now);\n    bw_collect(drive.state);\n    \
                    if (bw_clock(drive.state, 5u) < 0) { return 1; }\n    return bw_advance(drive.state, &report, &alarm);\n}\nint stop(uint8_t *bytes, size_t size) {\n    \
                    size_t length;\n    BwReport report;\n    bw_report(drive.state, &report);\n    \
                    if (bw_drive_verdict(&report)) { bw_end_run(drive.state, bytes, size, &length); }\n    return bw_drive_stop(&drive);\n}\n";
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

    /// With names of their own, and without: then the compiler says why.
    #[test]
    fn a_program_has_two_models_if_they_have_names() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("use.c");
        let position = "counts = \"n\"\ncounts_per_turn = 8000\n";
        let rig =
            std::fs::read(format!("{ROOT}/examples/support/standard_rig/model.bwm")).expect("the committed model");
        let rig = Model::<RunTime>::from_bytes(&rig).expect("a model");
        for (name, good) in [(Some("left"), true), (None, false)] {
            let other = c_header(&rig, (&[], &[]), None, name).expect("a header");
            std::fs::write(folder.path().join("other.h"), other).expect("writable");
            let text = "#include \"model.h\"\n#include \"other.h\"\n#include \"model.h\"\n\
                        int run(void);\nint run(void) {\n    static BwDrive drive;\n    static BwLeftDrive left;\n    \
                        return bw_drive_start(&drive, &bw_front_end) + bw_left_drive_start(&left);\n}\n";
            std::fs::write(&file, text).expect("writable");
            for (compiler, language) in [("cc", "c"), ("c++", "c++")] {
                let said = compiled(&header(&quadrature(position)), compiler, &["-x", language], &file);
                let Some((success, said)) = said else { return };
                assert!(success == good && (good || said.contains("--c-name")), "{said}");
            }
        }
        let named = header_of(&phases(position, "bc"), Some("Pump_2"));
        let names = ["BwPump2Reading", "bw_pump_2_front_end_angle(reading->position)", "BW_PUMP_2_FRONT_END_FACTOR"];
        assert!(names.iter().all(|name| named.contains(name)), "{named}");
        // No name of the header is one that another header has.
        let own = |word: &&str| {
            ["bw_model", "bw_drive", "BwDrive", "BwReading", "BW_MODEL"].iter().any(|own| word.starts_with(own))
        };
        let words = named.split(|c: char| !c.is_alphanumeric() && c != '_');
        assert_eq!(words.filter(own).collect::<Vec<_>>(), [""; 0]);
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
