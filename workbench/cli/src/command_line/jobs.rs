//! The settings that commands take beside those of the library's jobs.

use crate::command_line::options::Job;
use model::settings::{CHANNELS, PREPARATION, TIMES, Use};

/// Defines a command's job: name, settings, and those that it does not do without.
macro_rules! jobs {
    ($($(#[$doc:meta])* $name:ident = $use:expr $(, help: $help:expr)?;)+) => {
        $($(#[$doc])*
        #[derive(Clone, Debug)]
        pub(crate) enum $name {}

        impl Job for $name {
            const USE: Use = $use;
            $(const HELP: &'static [(&'static str, &'static str)] = $help;)?
        })+
    };
}

const WHERE: (&str, &str) = ("test_where", "Only the rows with this, e.g. 'run>4'; may be repeated, all must hold");
const TRACES: (&str, &str) = ("traces", "Trace files or folders, with all folders below");
const FITTED: &[&str] = &["traces", "y", "u1", "order"];
const STRUCTURE: &[&str] = &["order", "offset"];

jobs! {
    /// `train`.
    Train = Use::TRAIN;
    /// `evaluate`.
    Evaluate = Use::EVALUATE, help: &[WHERE];
    /// `features`.
    Features = Use::FEATURES, help: &[
        ("train_where", "Only the rows with this, e.g. 'run<=4'; may be repeated, all must hold"),
        (
            "features",
            "Averages of columns are computed if they are named here: mean_CHANNEL, rms_CHANNEL; all other features \
             always are",
        ),
        ("covariates", "The same"),
        ("healthy", "The healthy class, whose mean is the nominal model unless --nominal is given"),
    ];
    /// `train-features`.
    TrainFeatures = Use::TRAIN_FEATURES, help: &[
        ("train_where", "Only segments with this in a column of the parts, e.g. 'run<=4'; may be repeated, all must hold"),
        ("covariates", "Not for sums of features: refused, unless empty"),
    ];
    /// `identify`, `validate`.
    Fit = Use {
        name: "identify",
        keys: &[&["traces"], TIMES, CHANNELS, STRUCTURE, PREPARATION],
        required: FITTED,
    }, help: &[TRACES];
    /// `structure`.
    Structures = Use {
        name: "structure",
        keys: &[TIMES, CHANNELS, &["offset"], PREPARATION],
        required: &["y", "u1"],
    };
    /// `replay`.
    Replay = Use::REPLAY, help: &[
        TRACES,
        ("bearing", "A designation, or balls, ball and pitch diameter, contact angle in degrees: tells which swings are short"),
        ("labels", "Labels with the column of --group; by default those of the drive file"),
        (
            "group",
            "Column of the labels whose value is the same in all traces of a run, from power-up to power-up; by default \
             that of the training",
        ),
    ];
    /// Commands that take traces alone.
    Recordings = Use { name: "grey-box", keys: &[&["traces"]], required: &["traces"] }, help: &[TRACES];
    /// `grey-box motor`, `grey-box electrical`.
    Balanced = Use {
        name: "grey-box",
        keys: &[&["traces", "current", "velocity", "load"]],
        required: &["traces"],
    }, help: &[
        TRACES,
        ("current", "Torque-producing current, A [default: current_a]"),
        ("velocity", "Measured velocity, rad/s [default: velocity_rad_s]"),
        (
            "load",
            "Load torque opposing positive rotation, N·m: a channel, or of a motor \"constant\" for an unknown constant \
             one, or \"none\" [default: load_torque_nm]",
        ),
    ];
    /// `grey-box cogging`.
    Cogging = Use {
        name: "cogging",
        keys: &[&["traces"], TIMES, &["current", "velocity", "velocity_ref", "angle", "load"]],
        required: &["traces"],
    }, help: &[
        TRACES,
        ("current", "Torque-producing current, A [default: current_a]"),
        ("velocity", "Measured velocity, rad/s [default: velocity_rad_s]"),
        ("velocity_ref", "Reference of the velocity, rad/s [default: velocity_ref_rad_s]"),
        ("angle", "Absolute angle of the shaft, rad [default: angle_rad]"),
        (
            "load",
            "Load torque opposing positive rotation, N·m: a channel, \"constant\" for an unknown constant one, or \"none\" \
             [default: load_torque_nm]",
        ),
    ];
    /// `audit`.
    Audit = traces::audit::USE, help: &[
        ("labels", "Labels: the classes of the traces; without TRACES, their folder is read"),
        ("where", "Only traces whose labels meet this condition, e.g. load_kgf=20; may be repeated, all must hold"),
        ("healthy", "The healthy class; by default the one named healthy or normal"),
        ("false_alarm", "False-alarm rate of the smallest line [default: 0.01]"),
        ("current", "Current, in which orders are looked for; by default the likely one"),
        ("velocity", "Velocity, rad/s; by default the likely one"),
        ("velocity_ref", "Reference of the velocity; by default the likely one"),
        ("angle", "Angle of the shaft, rad; by default the likely one, or the integral of the velocity"),
        ("load", "Load; by default the likely channel"),
    ];
    /// `convert`.
    Convert = Use { name: "convert", keys: &[&["traces"], TIMES], required: &["traces"] }, help: &[
        ("traces", "Trace files or folders: .csv .tsv .txt (also with .gz or .zst), .mat, .h5, .parquet, .arrow, .npz, .npy"),
    ];
    /// `init`, which writes a drive file.
    Init = traces::describe::USE, help: &[TRACES];
}
