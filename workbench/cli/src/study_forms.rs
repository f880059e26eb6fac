//! The forms of JSON of the simulated studies, and of a drive that is listened to.

use super::forms::{Form, Key};

const ROWS: Key = ("rows", "array", "One object for each row of the table");
const DRAWS: Key = ("draws", "integer", "Draws of training and validation sets");

/// `demo --json`.
pub(super) const DEMO: Form = Form {
    name: "demo",
    about: "Errors of the source's method and of others on a simulated motor",
    list: false,
    keys: &[
        ("first_draw", "object", "Confusion matrix and rates of the first draw, with all parameters"),
        ("first_draw_literal", "object", "The same of the source's own method"),
        ("methods", "array", "Mean and standard deviation of the error of each method over all draws, percent"),
    ],
    optional: &[],
};

/// `tables --json`.
pub(super) const TABLES: Form = Form {
    name: "tables",
    about: "The source's tables reproduced on the simulated rigs",
    list: false,
    keys: &[
        ("repetitions", "integer", "Draws of training and validation sets"),
        ("seed", "integer", "Seed of the first draw"),
        ("ours", "string", "What this project's own method is"),
        ("tables", "array", "Id, title, conditions, columns, rows and note of each table"),
    ],
    optional: &[],
};

/// `campaign --json`.
pub(super) const CAMPAIGN: Form = Form {
    name: "campaign",
    about: "Errors on the standard rig under every condition, beside the goals",
    list: false,
    keys: &[
        ("repetitions", "integer", "Draws of training and validation sets"),
        ("figures", "array", "Error or detection of each experiment, with its interval, goal, and whether it is met"),
        ("alarms", "array", "Record at which the alarm of each class is raised"),
        ("false_alarms", "array", "False alarms of many gates at each set rate; none with --quick"),
    ],
    optional: &[],
};

/// `campaign --ema --json`.
pub(super) const CAMPAIGN_EMA: Form = Form {
    name: "campaign-ema",
    about: "Errors on the simulated actuator",
    list: false,
    keys: &[
        DRAWS,
        ("records", "integer", "Records of each class in a set"),
        ("experiments", "array", "Error of each experiment, with its interval and goal"),
        ("source", "array", "Errors of the source's method, by its table"),
        ("calibration", "array", "Errors of the source's method, by the size of the defects"),
    ],
    optional: &[],
};

/// `campaign --field --json`.
pub(super) const CAMPAIGN_FIELD: Form = Form {
    name: "campaign-field",
    about: "Detected records and false alarms under the effects of the field",
    list: false,
    keys: &[
        DRAWS,
        ("first", "integer", "Number of the first draw"),
        ("healthy_training", "integer", "Healthy records that train the gate"),
        ("defects_training", "integer", "Records of each class that train the discriminant"),
        ("healthy", "integer", "Healthy records that are judged in a draw"),
        ("defects", "integer", "Records of each defect that are judged in a draw"),
        ("false_alarm", "number", "Set rate of false alarms"),
        ("features", "array", "Names of the features of the gate"),
        ("columns", "array", "Headings: false alarms, and kind and size of each defect"),
        ROWS,
    ],
    optional: &[],
};

/// `campaign --field --bounds --json`.
pub(super) const CAMPAIGN_BOUNDS: Form = Form {
    name: "campaign-bounds",
    about: "What one record can tell at best, beside what is found",
    list: false,
    keys: &[ROWS],
    optional: &[],
};

/// `campaign --field --sessions --json`.
pub(super) const CAMPAIGN_SESSIONS: Form = Form {
    name: "campaign-sessions",
    about: "False alarms of a fleet on drives that were not in training",
    list: false,
    keys: &[ROWS],
    optional: &[],
};

/// `campaign --field --delay --json`.
pub(super) const CAMPAIGN_DELAY: Form = Form {
    name: "campaign-delay",
    about: "Hours between false alarms and runs until the alarm, on drives that were not in training",
    list: false,
    keys: &[ROWS],
    optional: &[],
};

/// `campaign --field --growth --json`.
pub(super) const CAMPAIGN_GROWTH: Form = Form {
    name: "campaign-growth",
    about: "Time left of growing defects beside the truth, on drives that were not in training",
    list: false,
    keys: &[ROWS],
    optional: &[],
};

/// `campaign --healthy-sets --json`.
pub(super) const CAMPAIGN_HEALTHY_SETS: Form = Form {
    name: "campaign-healthy-sets",
    about: "Gates of healthy sets that are not normal, not independent, or not healthy",
    list: false,
    keys: &[ROWS],
    optional: &[],
};

/// `listen --json`.
pub(super) const LISTEN: Form = Form {
    name: "listen",
    about: "One object a line; its kind tells which of the further keys it has",
    list: false,
    keys: &[("kind", "string", "view, hello, report, trace or end; of a CAN bus segment, can or end")],
    optional: &[
        ("address", "string", "view: address of the page"),
        ("model_id", "integer", "hello: number of the model"),
        ("session", "integer", "hello: number of the session of the drive"),
        ("interval_s", "number?", "hello: sampling interval"),
        ("channels", "array", "hello: names and units of the channels"),
        ("angle", "boolean", "hello: whether samples have the angle"),
        ("classes", "array", "hello: names of the classes"),
        ("features", "array|object", "hello: names of the features; report: their values by name"),
        ("orders", "array", "hello: orders of the bearing"),
        ("segment", "integer", "report, segment: number of the segment"),
        ("class", "string?", "report, segment: the class, if the verdict is one"),
        ("verdict", "string", "report, segment: the class, novel, ambiguous or undetermined"),
        ("undetermined", "string?", "report, segment: why there is no verdict"),
        ("posteriors", "object", "report: probability of each class"),
        ("distance", "number?", "report, segment: distance from the healthy class in its standard deviations"),
        ("surprise", "number?", "report: −ln of the probability that a healthy segment is as distant, nats"),
        ("score", "number?", "report: evidence so far, nats"),
        (
            "alarm",
            "object?",
            "report: segment, time and cause of the alarm, once it is raised, and of one by a direction deviations and \
             first segment; end: segment and cause; segment: cause and deviations",
        ),
        ("directions", "array", "report: feature, deviations, score and first segment of each direction of the alarm"),
        ("order_scores", "array", "report: score of each order of the bearing"),
        ("undetermined_segments", "integer", "report: segments without a verdict so far"),
        ("rows", "integer", "report: rows of the regression"),
        ("rejected", "integer", "report: samples that were rejected"),
        ("saturated", "integer", "report: samples at the limit of a sensor"),
        ("downweighted", "integer", "report: rows with less weight"),
        ("still", "integer", "report: samples at rest"),
        ("stuck", "array", "report: channels that are stuck"),
        ("file", "string", "trace: name of the file"),
        ("first", "integer", "trace: number of its first sample"),
        ("samples", "integer?", "trace: its samples; end: all that were written"),
        ("frames", "integer", "end: frames that came; can: data frames"),
        ("bad", "integer", "end: damaged frames; can: frames that are no pieces"),
        ("oversize", "integer", "end: frames that are too long"),
        ("unknown", "integer", "end: frames of another format version"),
        ("lost", "integer", "end, can: frames that are missing by their numbers"),
        ("repeated", "integer", "end, can: frames that came again"),
        ("files", "integer?", "end: files that were written"),
        ("unusable_samples", "integer?", "end: samples that are no numbers"),
        ("unnamed_samples", "integer", "end: samples before the names of their channels"),
        ("time_s", "number", "segment: time of the log"),
        ("again", "boolean|integer", "segment: whether a frame came with the same number; end: such frames"),
        ("usable_percent", "integer", "segment: share of its samples that are usable rows"),
        ("silent", "boolean", "segment: whether no segment has had a verdict for too long"),
        ("id", "string", "end, can: identifier of the frames"),
        ("segments", "integer", "end: segments that came"),
        ("verdicts", "object", "end: segments with each verdict"),
        ("withdrawn", "integer", "end: reports that were withdrawn"),
        ("restarts", "integer", "end: how often the drive has started again"),
        ("other_buses", "integer", "end, can: frames of the identifier on another bus than its first"),
        ("other_ids", "integer", "end, can: frames of other identifiers"),
        ("remote", "integer", "end, can: remote frames"),
        ("error_frames", "integer", "end: error frames"),
        ("unread_lines", "integer", "end: lines that are of no known format"),
    ],
};
