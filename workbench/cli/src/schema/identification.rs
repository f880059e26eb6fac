//! The forms of JSON of identification and audit.

use super::form::Form;

/// `identify --json`.
pub(crate) const IDENTIFY: Form = Form {
    name: "identify",
    about: "The difference model of each trace",
    list: true,
    keys: &[
        ("trace", "string", "Name of the trace"),
        ("parameters", "object", "Value of each parameter by its name"),
        ("sd", "object", "Standard deviation of each parameter"),
        ("covariance", "array", "Covariance of the parameters, in their order"),
        ("variance", "number?", "Variance of the residuals"),
        ("rows", "integer", "Rows of the regression"),
        ("fit_percent", "number?", "Fit of the simulation"),
        ("prediction_fit_percent", "number?", "Fit of the prediction by one sample"),
        ("noise", "object", "Kind of the model of the noise, and its polynomial"),
        ("convergence", "object?", "Iterations, and whether they converged"),
    ],
    optional: &[],
};

/// `structure --json`.
pub(crate) const STRUCTURE: Form = Form {
    name: "structure",
    about: "The structures that were compared, and the best by each criterion",
    list: false,
    keys: &[
        ("best_fit", "object?", "The best by the fit on the validation trace"),
        ("best_aic", "object?", "The best by Akaike's criterion"),
        ("best_mdl", "object?", "The best by the description length"),
        ("best_by_parameters", "array", "The best of each number of parameters"),
        ("compare", "object?", "The structure of --compare"),
        ("structures", "array", "All structures"),
        ("refused", "array", "Structures that could not be estimated, with the reason"),
    ],
    optional: &[],
};

/// `validate --json`.
pub(crate) const VALIDATE: Form = Form {
    name: "validate",
    about: "Tests of the residuals of each trace, its fit, poles and zeros",
    list: true,
    keys: &[
        ("trace", "string", "Name of the trace"),
        ("independence", "object", "Test of the residuals against past inputs"),
        ("whiteness", "object", "Test of the residuals against each other"),
        ("feedback", "object", "Test of the residuals against future inputs"),
        ("simulation_fit_percent", "number?", "Fit of the simulation"),
        ("prediction_fit_percent", "number?", "Fit of the prediction by one sample"),
        ("poles", "array", "Poles, with real and imaginary part"),
        ("zeros_u1", "array", "Zeros from the first input"),
        ("zeros_u2", "array", "Zeros from the second input"),
        ("removable_poles", "array", "Poles that a zero of every input cancels"),
        ("autocorrelation", "object", "Autocorrelation of the residuals, with its limit"),
        ("cross_correlation_u1", "object", "Correlation with the first input"),
        ("cross_correlation_u2", "object", "Correlation with the second input"),
    ],
    optional: &[],
};

/// `grey-box --json`.
pub(crate) const GREY_BOX: Form = Form {
    name: "grey-box",
    about: "Physical constants of each trace",
    list: true,
    keys: &[
        ("trace", "string", "Name of the trace"),
        ("quantities", "object", "Value, standard deviation and unit of each quantity"),
        ("relative_error_percent", "number", "Error of the model"),
        ("validation_error_percent", "object", "Its error on each trace of --validate"),
        ("asymmetry", "object", "Difference of the directions, with --asymmetric"),
        ("rows", "integer", "Rows of the regression"),
        ("notes", "array", "What there is to say of the result"),
    ],
    optional: &[],
};

/// `cogging --json`.
pub(crate) const COGGING: Form = Form {
    name: "cogging",
    about: "What turns with the rotor; intervals are half of those of 95 %",
    list: false,
    keys: &[
        ("torque_constant_nm_a", "number", "Torque constant"),
        ("turns", "array", "Turns of the shaft forward and backward"),
        ("residual_nm", "array", "Root mean square of the residual of the torque balance, with the lines and without"),
        ("lines", "array", "Orders with amplitude and phase of the torque (N·m) and of the ripple of Kt (relative)"),
        ("change", "object?", "What has changed since the recordings of --since"),
    ],
    optional: &[],
};

/// `init --json`.
pub(crate) const INIT: Form = Form {
    name: "init",
    about: "What recordings have, and what the user has to say; exit code 1 if training refuses the drive file",
    list: false,
    keys: &[
        ("drive_file", "string", "The drive file that was written"),
        ("told", "string", "What was found, in a line"),
        ("refused", "string?", "Why training refuses the drive file, if it does"),
        ("labels", "string", "The file of the labels"),
        ("classes", "array", "The classes of the labels"),
        ("files", "integer", "Number of recordings"),
        ("rows", "integer", "Rows of the first one"),
        ("rate_hz", "number?", "Rows a second, if there is a time"),
        (
            "columns",
            "array",
            "Columns of the first recording: name, the channel that it is taken as (role), quantity and unit by the \
             name, rows without a number (missing), and lowest and highest value of up to 120 parts (course)",
        ),
        (
            "questions",
            "array",
            "Each with its text (question), the texts of the drive file in which the answer takes the place of the \
             question mark (marks), or the key of the drive file (key), and the answers, none if it is a number",
        ),
    ],
    optional: &[],
};

/// `audit --json`.
pub(crate) const AUDIT: Form = Form {
    name: "audit",
    about: "What recordings are worth",
    list: false,
    keys: &[
        ("rotor_rate_hz", "number?", "Rate of the rows by the lines of the rotor, if there is no time"),
        ("traces", "array", "Rows and times of each trace"),
        ("lines", "array", "Lines of the bearing and of the rotor"),
        ("findings", "array", "What is wrong, and in which traces"),
        ("friction", "array", "What each term of the torque balance can tell"),
        ("weight", "object?", "The weight on an axis, where no load is measured: turns, explained part, amplitude"),
    ],
    optional: &[],
};
