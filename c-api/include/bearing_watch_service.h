/* The C interface of bearing-watch, second part: numbers behind a report, growth of a defect, commissioning, telemetry,
 * flash, signed models. Made by cbindgen from c-api/src: do not edit. */

#ifndef BEARING_WATCH_SERVICE_H
#define BEARING_WATCH_SERVICE_H

#include "bearing_watch.h"

// Largest number of channels of a sample.
#define BW_MAX_CHANNELS 8

// Largest number of further channels: as many as the largest model of `BW_MAX_CHANNELS` has besides current and
// velocity.
#define BW_MAX_FURTHER 6

// Largest number n of parameters of the regression.
#define BW_MAX_PARAMETERS 12

// Largest number of columns of its rows: n + 1, and by instrumental variables na more.
#define BW_MAX_COLUMNS 16

// Largest sum of the delays nkb + nkc.
#define BW_MAX_DELAYS 16

// Largest number of filter cells of instrumental variables: na + max(na, nb) + max(na, nc).
#define BW_MAX_FILTERS 16

// Largest number of bearing orders.
#define BW_MAX_ORDERS 6

// Largest number of channels that are averaged.
#define BW_MAX_AVERAGED 4

// Largest number of features.
#define BW_MAX_FEATURES 16

// Largest number of covariates.
#define BW_MAX_COVARIATES 4

// Largest number of coordinates after the projection.
#define BW_MAX_COORDINATES 12

// Largest number of coordinates that only rise with a defect.
#define BW_MAX_RISING 8

// Largest number of directions that the alarm watches.
#define BW_MAX_DIRECTIONS 8

// Largest number of classes.
#define BW_MAX_CLASSES 6

// Largest number of elements of the projection: coordinates times features.
#define BW_MAX_PROJECTION 144

// Largest number of elements of the covariances: Z (Z + 1)/2 for Z coordinates, of a quadratic discriminant for each
// class.
#define BW_MAX_DENSITIES 234

// Bytes of memory that are enough for `bw_calibration_init`, aligned to `BW_STATE_ALIGN` bytes.
#define BW_CALIBRATION_SIZE 128

// Bytes of memory that are enough for `bw_wiring_init`, aligned to `BW_STATE_ALIGN` bytes.
#define BW_WIRING_SIZE 512

// Bytes of a block. A sample has four for each channel, and four for the angle of a model that needs it.
#define BW_BLOCK_BYTES 480

// Bytes of memory that are enough for `bw_recorder_init`, aligned to `BW_STATE_ALIGN` bytes.
#define BW_RECORDER_SIZE 1152

// Bytes of memory that are enough for `bw_raw_recorder_init`, aligned to `BW_STATE_ALIGN` bytes.
#define BW_RAW_RECORDER_SIZE 1088

// Bytes of memory that are enough for `bw_telemetry_init`, aligned to `BW_STATE_ALIGN` bytes.
#define BW_TELEMETRY_SIZE 48

// A buffer of so many bytes is enough for every frame of a library without a plan of its own, and of any plan that is
// not larger than `BW_MAX_…`.
#define BW_FRAME_SIZE 560

// Bytes of the frame of `bw_can_frame`.
#define BW_CAN_FRAME_SIZE 8

// Every address and length that the functions of a `BwFlash` get is a multiple of this number of bytes, the largest
// word that a microcontroller programs at once.
#define BW_FLASH_UNIT 32

#if defined(BEARING_WATCH_SIGNATURE)
// Bytes of a public key.
#define BW_KEY_SIZE 32
#endif

#if defined(BEARING_WATCH_SIGNATURE)
// Bytes of a drive's key.
#define BW_STATE_KEY_SIZE 32
#endif

#if defined(BEARING_WATCH_SIGNATURE)
// Bytes that `bw_seal` adds to a state.
#define BW_SEAL_SIZE 48
#endif

// What is wrong with the wiring, or why nothing can be said. The value is that of `BwWiring`.
typedef int BwWiringFault;
enum {
  BW_WIRING_FAULT_NONE = 0, // Nothing is wrong.
  // The shaft has not been at all angles of a turn; value: sectors of 1/16 turn in which it was.
  BW_WIRING_FAULT_TOO_LITTLE_MOTION = 1,
  BW_WIRING_FAULT_TOO_LITTLE_CURRENT = 2, // The current is too small; value: its root mean square, A.
  // The current vector does not turn with the shaft: wrong phases or sensors, a slipping or multiplied angle, or no
  // field-oriented control; value: the largest coherence.
  BW_WIRING_FAULT_NOT_TURNING = 3,
  // The number of pole pairs is wrong; value: the one that fits, negative if the phases also run against the angle.
  BW_WIRING_FAULT_POLE_PAIRS = 4,
  BW_WIRING_FAULT_PHASE_ORDER = 5, // The phases run against angle and velocity: two are exchanged.
  BW_WIRING_FAULT_ANGLE_DIRECTION = 6, // The angle runs against phases and velocity.
  BW_WIRING_FAULT_VELOCITY_DIRECTION = 7, // The velocity runs against phases and angle.
  // Phases and angle run against each other; there is no velocity to decide which is wrong.
  BW_WIRING_FAULT_PHASE_ORDER_OR_ANGLE = 8,
  // The unit of the velocity or the control rate is wrong; value: integral of the velocity over motion of the angle.
  BW_WIRING_FAULT_RATE_OR_UNIT = 9,
  // The electrical offset is wrong; value: what must be added to it, rad, but for half a turn.
  BW_WIRING_FAULT_OFFSET = 10,
  // Current and angle are not of one instant; value: delay of the current behind the angle, s.
  BW_WIRING_FAULT_DELAY = 11,
  BW_WIRING_FAULT_OTHER = 12, // A fault that this interface does not know.
};

// Lists of numbers behind a verdict.
typedef int BwValues;
enum {
  BW_VALUES_LOG_LIKELIHOODS = 0, // Log-likelihood of each class.
  BW_VALUES_POSTERIORS = 1, // Posterior probability of each class.
  BW_VALUES_EXPECTED_COSTS = 2, // Expected cost of deciding each class.
  BW_VALUES_MISSING = 3, // Whether each feature was missing, 1 or 0.
  // Parameters t, b, g and the constant of the regression, in units of y over units of the signal.
  BW_VALUES_PARAMETERS = 4,
  BW_VALUES_PARAMETER_DEVIATIONS = 5, // Their standard deviations.
  // Terms of the torque balance: J/Kt, B/Kt, Tc/Kt, 1/Kt, offset, load friction, Stribeck friction, drag; NaN for a
  // term that needs a load if the load is not measured.
  BW_VALUES_FRICTION = 6,
  BW_VALUES_FRICTION_DEVIATIONS = 7, // Their standard deviations.
  BW_VALUES_FRICTION_SCORES = 8, // Their distances from healthy in standard deviations.
  BW_VALUES_ORDER_SCORES = 9, // Score of each bearing order: about standard normal without a defect.
  BW_VALUES_ORDER_AMPLITUDES = 10, // Amplitude of each bearing order, A.
  BW_VALUES_ORDER_DEVIATIONS = 11, // Standard deviations of the amplitudes, A.
  BW_VALUES_ORDER_SLIPS = 12, // Relative slip of the cage at which each order is strongest.
  BW_VALUES_MEANS = 13, // Mean of each averaged channel; NaN if it has none.
  BW_VALUES_ROOT_MEAN_SQUARES = 14, // Root mean square of each averaged channel; NaN if it has none.
  // The smallest defect in each rising coordinate of the model, the last ones, that the segment would have shown: a
  // part of the usual friction, or the amplitude at a bearing order, A; infinite if it shows none.
  BW_VALUES_SMALLEST = 15,
  // Amplitude of the weight on an axis and its standard deviation, A; none in a plan without one.
  BW_VALUES_WEIGHT = 16,
};

// The calibration of one drive, in memory of the caller.
typedef struct BwCalibration BwCalibration;

// Records what a front end takes, in memory of the caller.
typedef struct BwRawRecorder BwRawRecorder;

// Records samples of a detector, in memory of the caller.
typedef struct BwRecorder BwRecorder;

// Makes the frames of one line, in memory of the caller.
typedef struct BwTelemetry BwTelemetry;

// The check of one drive, in memory of the caller.
typedef struct BwWiringCheck BwWiringCheck;

// What the model wants.
typedef struct BwInfo {
  uint8_t channels; // Number of channels of a sample.
  uint8_t classes; // Number of classes.
  uint8_t features; // Number of features.
  uint8_t orders; // Number of bearing orders.
  bool needs_angle; // Whether samples need the angle of the shaft.
  float interval_s; // Sampling interval, s; 0 if it is unknown.
  uint32_t block_mean; // Samples averaged into one before the regression.
  uint32_t segment_samples; // Samples of a segment, after averaging.
  // Samples of the next segment within which a segment is to be solved, so that its estimate is the auxiliary
  // model of instrumental variables.
  uint32_t handover;
  BwPark park; // Sign convention of the quadrature current.
} BwInfo;

// What a direction contributes to the alarm.
typedef struct BwContribution {
  uint8_t coordinate; // The coordinate that a defect raises, a place in `BW_MODEL_COORDINATE_NAMES`.
  float deviations; // The mean of the last run less the usual mean of this drive, standard deviations of runs.
  float score; // Largest score of the direction, nats. The alarm is raised where it reaches `BwAlarm::limit`.
  uint32_t since; // Number of the last segment before it rose.
} BwContribution;

// A value with its 90 % interval.
typedef struct BwInterval {
  float value; // The value.
  float low; // Lower end.
  float high; // Upper end.
} BwInterval;

// The size of a defect in a direction, and the time left: an estimate from the past of this drive, and no promise.
typedef struct BwGrowth {
  // By how much the runs exceed the usual mean of this drive, standard deviations of a usual run.
  struct BwInterval size;
  struct BwInterval slope; // Its change in a usual run; divided by `run_hours`, in an hour.
  float named; // The named size, to which the time is left, standard deviations of a usual run.
  // Whether the size grows: the interval of the slope is above zero, the size above four of its deviations, and its
  // lower end above two deviations of a usual run.
  bool growing;
  struct BwInterval runs_left; // Usual runs until the named size, 0 if it is reached; NaN if the size does not grow.
  // The same in hours of segments, not of the time between runs; NaN also if the model has no sampling interval.
  struct BwInterval hours_left;
  float run_hours; // Hours of the segments of a usual run; 0 if the model has no sampling interval.
} BwGrowth;

// What a calibration must look like.
typedef struct BwCalibrationLimits {
  uint16_t samples; // Number of samples, at least 2.
  float lowest_offset_counts; // Lowest plausible offset, counts.
  float highest_offset_counts; // Highest plausible offset, counts.
  // Lowest plausible standard deviation, counts: less noise means a stuck converter; 0 accepts a constant.
  float lowest_deviation_counts;
  float highest_deviation_counts; // Highest plausible standard deviation, counts.
} BwCalibrationLimits;

// A current sensor whose offset was refused.
typedef struct BwRefusedOffset {
  uint8_t phase; // The phase, 0, 1, 2 for a, b, c; 0 for `BW_CODE_CALIBRATION_TOO_FEW`.
  // Standard deviation for `BW_CODE_CALIBRATION_NOISY` and offset for `BW_CODE_CALIBRATION_OUT_OF_BAND`, counts;
  // number of samples for `BW_CODE_CALIBRATION_TOO_FEW`; 0 for `BW_CODE_CALIBRATION_STUCK`.
  float value;
} BwRefusedOffset;

// What a wiring must be like.
typedef struct BwWiringLimits {
  float least_current_a; // Least root mean square of the current vector, A; several times the noise of the sensors.
  float offset_rad; // Largest error of the electrical offset, rad.
  float delay_s; // Largest delay between current and angle, s.
  float velocity_tolerance; // Largest relative difference of velocity and motion of the angle.
  float slowest_rad_s; // Velocity below which it is not compared with the angle, rad/s.
} BwWiringLimits;

// The wiring.
typedef struct BwWiring {
  BwWiringFault fault; // The first fault. After a remedy check again.
  float value; // The value that `BwWiringFault` names, NaN if it names none.
  float coherence; // How well the current turns with the shaft, 1 at best. NaN, like what follows, if there is a fault.
  float offset_rad; // Error of the electrical offset, rad.
  float delay_s; // Delay of the current behind the angle, s; NaN if the shaft turned one way only.
  // Integral of the velocity over motion of the angle; NaN without a velocity: then its sign, its unit and the
  // control rate are not checked.
  float velocity_ratio;
} BwWiring;

// Sends the `size` bytes of a data frame under the identifier of the stream; returns 0 if the bus has taken them.
typedef int32_t (*BwCanSend)(void *context, const uint8_t *data, size_t size);

// Two places in flash for records of one kind, and the functions that reach them. Models and states need places of
// their own. Each function returns 0 if it did what it says.
typedef struct BwFlash {
  void *context; // Passed to the functions.
  // Reads `length` bytes. On a flash that checks its words, an error of a word is an error of this call.
  int32_t (*read)(void *context, uint32_t address, uint8_t *bytes, size_t length);
  // Programs `length` bytes of erased flash.
  int32_t (*write)(void *context, uint32_t address, const uint8_t *bytes, size_t length);
  // Erases every sector that has a byte from `address` on to before `end`.
  int32_t (*erase)(void *context, uint32_t address, uint32_t end);
  uint32_t start; // The address of the first place, at the start of a sector.
  uint32_t place_bytes; // Bytes from the first place to the second one: whole sectors.
} BwFlash;

#if defined(BEARING_WATCH_SIGNATURE)
// A model that an accepted key has signed.
typedef struct BwSigned {
  size_t model_length; // Bytes of the model, for `bw_start`.
  size_t length; // Bytes of model and signature.
  uint32_t counter; // Counter of the model. Once the model has started, keep it as the least one that is accepted.
} BwSigned;
#endif

#if defined(BEARING_WATCH_SIGNATURE)
// A state that was sealed with the key of the drive.
typedef struct BwSealed {
  size_t state_length; // Bytes of the state, for `bw_restore`.
  uint32_t sequence; // Its number.
} BwSealed;
#endif



#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Gives a list of numbers behind the last report, `what` of `BwValues`, and in `count` how many there are: 0 if the
// model does not have this part, or this segment no such result.
//
// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, `BW_CODE_OUT_OF_RANGE` if there is no such list, or
// `BW_CODE_BUFFER_TOO_SMALL`, where `count` is what is needed.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `values` is NULL or has `capacity`
// writable numbers. `count` is NULL or writable.
BwCode bw_values(BwState *state, int32_t what, float *values, size_t capacity, size_t *count);

// Returns the version of the library, a text that ends in a zero byte.
const char *bw_version(void);

// Runs the kernels on numbers whose results are known, and compares every bit. Call it at start, and once in the
// interrupt that calls `bw_collect`, before the power stage is on: interrupts take their floating-point settings from
// the register FPDSCR, not from `main`. It takes some hundred thousand instructions. Later each segment tests these
// settings (`BW_REASON_ARITHMETIC`).
//
// Returns 0, or the first part whose results differ: 1 rounding, 2 subnormal numbers, 3 square root, exponential or
// logarithm, 4 transforms, 5 decimation, 6 the factor of a least-squares problem, 7 its solution.
BW_MUST_CHECK uint32_t bw_known_answer_test(void);

// Gives what the model wants.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `info` is NULL or writable.
BwCode bw_info(const BwState *state, struct BwInfo *info);

// Writes the name of a class, ending in a zero byte, into `text`: 17 bytes are enough for every name.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if there is no such class, or `BW_CODE_BUFFER_TOO_SMALL`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `text` is NULL or has `capacity`
// writable bytes.
BwCode bw_label(const BwState *state, uint8_t class_index, char *text, size_t capacity);

// Checks that a channel of the model has this name and unit, such as `current_a` and `A`. A program that passes its
// channels in a fixed order does so at start.
//
// Returns `BW_CODE_OK`, `BW_CODE_MODEL_CHANNEL`, or `BW_CODE_OUT_OF_RANGE` if there is no such channel.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `name` and `unit` are NULL or
// readable up to a zero byte.
BwCode bw_check_channel(const BwState *state, uint8_t channel, const char *name, const char *unit);

// Checks that the drive samples as the recordings were sampled on which the model was trained, to 1 %.
//
// Returns `BW_CODE_OK`, also if either interval is unknown (0), or `BW_CODE_MODEL_INTERVAL`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BwCode bw_check_interval(const BwState *state, float interval_s);

// Checks that the drive's quadrature current has the sign convention of the recordings, `park` of `BwPark`.
//
// Returns `BW_CODE_OK`, also if the model does not say, `BW_CODE_MODEL_PARK`, or `BW_CODE_OUT_OF_RANGE`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BwCode bw_check_park(const BwState *state, int32_t park);

// Gives what a direction of the model contributes to the alarm at the end of the last run. Directions count from 0.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `contribution` is NULL or writable.
BwCode bw_contribution(BwState *state, uint8_t direction, struct BwContribution *contribution);

// Gives the size of a defect in a direction of the model, its slope, and the time until a single segment would show
// it: four standard deviations of segments of healthy drives. Directions count from 0.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `growth` is NULL or writable.
BwCode bw_growth(BwState *state, uint8_t direction, struct BwGrowth *growth);

// As `bw_growth`, until another named size, such as that of a known full defect: standard deviations of a usual run.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction or the size is not above 0 and
// finite, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `growth` is NULL or writable.
BwCode bw_growth_to(BwState *state, uint8_t direction, float size, struct BwGrowth *growth);

// Makes a calibration without samples in memory of the caller, and gives its address in `calibration`.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the calibration is used no more.
// `limits` is NULL or readable. `calibration` is NULL or writable. No other function works on the calibration.
BwCode bw_calibration_init(void *memory,
                           size_t size,
                           const struct BwCalibrationLimits *limits,
                           struct BwCalibration **calibration);

// Takes the counts of the phases a, b, and c if `phases` is 3 and not 2, in the interrupt of the converter with the
// inverter off.
//
// Returns `BW_CODE_OK`, `BW_CODE_ENOUGH_SAMPLES`, `BW_CODE_OUT_OF_RANGE` for another number of phases, or
// `BW_CODE_BUSY`. Samples beyond the last one are ignored.
//
// # Safety
// `calibration` is NULL, or was given by `bw_calibration_init` or has as many readable bytes. `counts` is NULL or has
// `phases` readable values.
BwCode bw_calibration_push(struct BwCalibration *calibration, const uint16_t *counts, uint8_t phases);

// Puts the measured offsets into constants of a front end; a third phase that was never sampled keeps its own. If
// one is refused, the constants are unchanged, and `refused` names the first one.
//
// Returns `BW_CODE_OK`, `BW_CODE_CALIBRATION_…`, or `BW_CODE_BUSY`.
//
// # Safety
// `calibration` is NULL, or was given by `bw_calibration_init` or has as many readable bytes. `constants` is NULL, or
// readable and writable. `refused` is NULL or writable.
BwCode bw_calibration_finish(struct BwCalibration *calibration,
                             BwFrontEndConstants *constants,
                             struct BwRefusedOffset *refused);

// Makes a check without samples in memory of the caller, and gives its address in `wiring`. Feed it by
// `bw_check_wiring` while the drive moves under current control by a turn or more, best to and fro.
//
// Returns `BW_CODE_OK`, or what is wrong with memory or constants.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the check is used no more.
// `constants` and `limits` are NULL or readable. `wiring` is NULL or writable. No other function works on the check.
BwCode bw_wiring_init(void *memory,
                      size_t size,
                      const BwFrontEndConstants *constants,
                      const struct BwWiringLimits *limits,
                      struct BwWiringCheck **wiring);

// Takes a raw sample at commissioning, for a check of the wiring instead of the detector. `velocity_rad_s` is one of
// the drive's own, NaN if there is none. The times of `bw_clock` count anew behind it.
//
// Returns `BW_CODE_OK`; `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is, or if the state has no
// front end; or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes; likewise `wiring` by `bw_wiring_init`.
// `raw` is NULL or readable.
BwCode bw_check_wiring(BwState *state, const BwRawSample *raw, float velocity_rad_s, struct BwWiringCheck *wiring);

// Gives the wiring, or what is wrong with it.
//
// Returns `BW_CODE_OK`, also if there is a fault, or `BW_CODE_BUSY`.
//
// # Safety
// `wiring` is NULL, or was given by `bw_wiring_init` or has as many readable bytes. `result` is NULL or writable.
BwCode bw_wiring_conclude(struct BwWiringCheck *wiring, struct BwWiring *result);

// Returns a text for a fault of the wiring, `BW_WIRING_FAULT_…`, ending in a zero byte; "unknown fault" for other
// numbers. Never NULL.
const char *bw_wiring_text(int32_t fault);

// Makes a recorder of the samples of a detector in memory of the caller, and gives its address in `recorder`.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the recorder is used no more. `state`
// is NULL, or was given by `bw_start` or has as many readable bytes. `recorder` is NULL or writable. No other function
// works on the recorder.
BwCode bw_recorder_init(void *memory, size_t size, const BwState *state, struct BwRecorder **recorder);

// Takes a sample as `bw_sample` takes it, in the same interrupt; a drive with a front end calls `bw_collect_recorded`
// instead. A complete block waits for `bw_telemetry_samples` in
// the main loop, while the next one is filled.
//
// Returns `BW_CODE_OK`; `BW_CODE_BLOCK` if a complete block waits now; `BW_CODE_RECORDER_FULL` if two blocks are
// complete: the sample is not recorded, and the receiver sees a gap; `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_BUSY`.
//
// # Safety
// `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes. `values` is NULL or has
// `count` readable values.
BwCode bw_recorder_push(struct BwRecorder *recorder, const float *values, size_t count, uint32_t angle);

// As `bw_collect`, and records each sample that the detector takes: a complete block waits for `bw_telemetry_samples`
// in the main loop. What finds both blocks complete is not recorded, and the receiver sees a gap.
//
// # Safety
// As `bw_collect`; `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes.
BwCode bw_collect_recorded(BwState *state, struct BwRecorder *recorder);

// Passes over samples that were not taken, such as those of missed interrupts. What follows `bw_restart` does not
// continue from the samples before: pass over one. A block that has samples is complete.
//
// Returns `BW_CODE_OK`, `BW_CODE_BLOCK` as `bw_recorder_push`, or `BW_CODE_BUSY`.
//
// # Safety
// `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes.
BwCode bw_recorder_skip(struct BwRecorder *recorder, uint32_t samples);

// Makes a recorder of raw samples with so many further channels in memory of the caller, and gives its address in
// `recorder`. A drive that has no model yet records the traces that one is trained with.
//
// Returns `BW_CODE_OK`, `BW_CODE_FRONT_END_CONTROL_RATE`, `BW_CODE_FRONT_END_FURTHER`, or what is wrong with the
// memory.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the recorder is used no more.
// `recorder` is NULL or writable. No other function works on the recorder.
BwCode bw_raw_recorder_init(void *memory,
                            size_t size,
                            float control_rate_hz,
                            uint16_t further,
                            struct BwRawRecorder **recorder);

// Takes a raw sample as `bw_sample_raw` takes it, in the same interrupt. A complete block waits for
// `bw_telemetry_raw` in the main loop, while the next one is filled.
//
// Returns `BW_CODE_OK`; `BW_CODE_BLOCK` if a complete block waits now; `BW_CODE_RECORDER_FULL` if two blocks are
// complete: the sample is not recorded, and the receiver sees a gap; `BW_CODE_WRONG_CHANNEL_COUNT`;
// `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is; or `BW_CODE_BUSY`.
//
// # Safety
// `recorder` is NULL, or was given by `bw_raw_recorder_init` or has as many readable bytes. `raw` is NULL or readable.
// `further` is NULL or has `count` readable values.
BwCode bw_raw_recorder_push(struct BwRawRecorder *recorder, const BwRawSample *raw, const float *further, size_t count);

// Makes a line without frames in memory of the caller, and gives its address in `telemetry`. With a `state` it sends
// its reports and samples, and raw samples; without one, NULL, raw samples only. `model_id` is any number that
// identifies the model, such as `BW_MODEL_ID`; `session` is one that changes with each power-up, such as a count of
// them. After another `bw_start` of the state the line has to be initialised again, too.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the line is used no more. `state`
// is NULL, or was given by `bw_start` or has as many readable bytes, and is there as long as the line. `telemetry`
// is NULL or writable. No other function works on the line.
BwCode bw_telemetry_init(void *memory,
                         size_t size,
                         const BwState *state,
                         uint32_t model_id,
                         uint32_t session,
                         struct BwTelemetry **telemetry);

// Writes a frame with names and constants of the model into `buffer`, and its length into `length`. Send it at the
// start and again every few seconds: a receiver needs it for reports and samples. Raw samples need none.
//
// Returns `BW_CODE_OK`, `BW_CODE_NOT_INITIALISED` if the line has no state, `BW_CODE_BUFFER_TOO_SMALL`, or
// `BW_CODE_BUSY`.
//
// # Safety
// `telemetry` is NULL, or was given by `bw_telemetry_init` or has as many readable bytes. `buffer` is NULL or has
// `capacity` writable bytes. `length` is NULL or writable.
BwCode bw_telemetry_hello(struct BwTelemetry *telemetry, uint8_t *buffer, size_t capacity, size_t *length);

// Writes a frame with the report of the last segment, as `bw_report` and `bw_alarm` give it, and with the values of
// the features into `buffer`, and its length into `length`.
//
// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, `BW_CODE_NOT_INITIALISED` if the line has no state,
// `BW_CODE_BUFFER_TOO_SMALL`, or `BW_CODE_BUSY`.
//
// # Safety
// As `bw_telemetry_hello`.
BwCode bw_telemetry_report(struct BwTelemetry *telemetry, uint8_t *buffer, size_t capacity, size_t *length);

// Writes a frame with the block of samples that waits in a recorder into `buffer`, and its length into `length`. The
// recorder is one of the same state.
//
// Returns `BW_CODE_OK`; `BW_CODE_IDLE` if no block waits; `BW_CODE_NOT_INITIALISED` if the line has no state; or
// `BW_CODE_BUFFER_TOO_SMALL` or `BW_CODE_BUSY`: the block still waits.
//
// # Safety
// As `bw_telemetry_hello`. `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes.
BwCode bw_telemetry_samples(struct BwTelemetry *telemetry,
                            struct BwRecorder *recorder,
                            uint8_t *buffer,
                            size_t capacity,
                            size_t *length);

// Writes a frame with the block of raw samples that waits in a recorder into `buffer`, and its length into `length`.
//
// Returns `BW_CODE_OK`; `BW_CODE_IDLE` if no block waits; or `BW_CODE_BUFFER_TOO_SMALL` or `BW_CODE_BUSY`: the block
// still waits.
//
// # Safety
// As `bw_telemetry_hello`. `recorder` is NULL, or was given by `bw_raw_recorder_init` or has as many readable bytes.
BwCode bw_telemetry_raw(struct BwTelemetry *telemetry,
                        struct BwRawRecorder *recorder,
                        uint8_t *buffer,
                        size_t capacity,
                        size_t *length);

// Writes the last segment, as `bw_report` and `bw_alarm` give it, into the `BW_CAN_FRAME_SIZE` bytes of a CAN frame:
// number, verdict with its reason, alarm with its cause, silence, usable share and distance. Send one after each
// `BW_CODE_REPORT`, under any identifier, and again with `BW_CODE_WITHDRAWN`. `bearing-watch dbc`
// writes the DBC file of the frame, and `bearing-watch listen --can-id` reads it from logs.
//
// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, or `BW_CODE_BUSY`; the bytes are then as before.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `frame` is NULL or has
// `BW_CAN_FRAME_SIZE` writable bytes.
BwCode bw_can_frame(BwState *state, uint8_t *frame);

// Sends a frame that `bw_telemetry_…` has made, in data frames of at most `most` bytes: 8, or 64 for CAN FD, whose
// lengths are then kept. `number` counts them: a byte of yours, 0 at start, that is kept from call to call.
// `bearing-watch listen --can-stream` joins them, and counts lost and doubled ones.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` for another `most`, or `BW_CODE_CAN_FAILED` if `send` has failed: the
// rest of the frame is then not sent, and the receiver counts it as lost.
//
// # Safety
// `number` is NULL, or readable and writable. `frame` is NULL or has `length` readable bytes. `send` may be called
// with `context`.
BwCode bw_can_stream(uint8_t *number, const uint8_t *frame, size_t length, size_t most, BwCanSend send, void *context);

// Erases ahead of the next `bw_flash_save`, which then only writes: at boot or at rest, since a chip that runs from
// the bank that it erases stands still meanwhile, up to seconds for a large sector.
//
// Returns `BW_CODE_OK`, or `BW_CODE_FLASH_…`.
//
// # Safety
// `flash` is NULL or readable, and its functions keep what `BwFlash` says.
BwCode bw_flash_prepare(const struct BwFlash *flash);

// Saves alarm and scores in flash, as `bw_save` does; if power fails on the way, the record before is still
// there. `buffer` has room for `bw_saved_size` bytes.
//
// Returns `BW_CODE_OK`, what `bw_save` returns, or `BW_CODE_FLASH_…`.
//
// # Safety
// `flash` is NULL or readable, and its functions keep what `BwFlash` says. `state` is as for `bw_save`. `buffer` is
// NULL or has `size` writable bytes.
BwCode bw_flash_save(const struct BwFlash *flash, BwState *state, uint8_t *buffer, size_t size);

// Continues from the newest good record of this model in flash, as `bw_restore` does, and from the one before if the
// newest is damaged or of another model. `buffer` has room for `bw_saved_size` bytes.
//
// Returns `BW_CODE_OK`, `BW_CODE_FLASH_NO_RECORD` if there is none, what `bw_restore` returns of the newest record, or
// `BW_CODE_FLASH_…`.
//
// # Safety
// As for `bw_flash_save`.
BwCode bw_flash_restore(const struct BwFlash *flash, BwState *state, uint8_t *buffer, size_t size);

// Stores the bytes of a model, with what follows it such as a signature, in the place of the older one.
//
// Returns `BW_CODE_OK`, or `BW_CODE_FLASH_…`.
//
// # Safety
// `flash` is NULL or readable, and its functions keep what `BwFlash` says. `model` is NULL or has `length` readable
// bytes.
BwCode bw_flash_store_model(const struct BwFlash *flash, const uint8_t *model, size_t length);

// Reads the newest good model of a flash into `buffer`, for `bw_start`, and gives the number of its bytes.
//
// Returns `BW_CODE_OK`, `BW_CODE_FLASH_NO_RECORD`, `BW_CODE_BUFFER_TOO_SMALL`, or another `BW_CODE_FLASH_…`.
//
// # Safety
// As for `bw_flash_store_model`, with `size` writable bytes at `buffer`. `length` is NULL or writable.
BwCode bw_flash_load_model(const struct BwFlash *flash, uint8_t *buffer, size_t size, size_t *length);

#if defined(BEARING_WATCH_SIGNATURE)
// Checks the model that these bytes start with and the signature of `bearing-watch sign` behind it, before `bw_start`;
// what follows both, such as the erased rest of a flash sector, is ignored. `keys` are the public keys that may sign,
// as `bearing-watch sign --key FILE` prints them; without one everything is refused. `least_counter` is the counter of
// the newest model that has run: keep it where an attacker cannot write it back. The bytes must not change until
// `bw_start` has read them. A library that was built without the feature `signature` does not have this function;
// define `BEARING_WATCH_SIGNATURE` before the header to declare it.
//
// Takes about 2 million instructions and 6 kB of stack. It is the one function of which the linker does not prove that
// it cannot panic: the indices of the arithmetic are within their bounds whatever the bytes, but no compiler sees it.
//
// Returns `BW_CODE_OK`, what is wrong with the model, or a `BW_CODE_SIGNATURE_…`; `signed_model` is then unchanged.
//
// # Safety
// `bytes` is NULL or has `length` readable bytes. `keys` is NULL or has `key_count` readable keys. `signed_model` is
// NULL or writable.
BwCode bw_verify_model(const uint8_t *bytes,
                       size_t length,
                       const uint8_t (*keys)[BW_KEY_SIZE],
                       size_t key_count,
                       uint32_t least_counter,
                       struct BwSigned *signed_model);
#endif

#if defined(BEARING_WATCH_SIGNATURE)
// Adds an authentication code (HMAC-SHA-256) to the state that `bw_save` wrote into the first `length` of `capacity`
// bytes; `sealed_length` is then `length + BW_SEAL_SIZE`. `key` has `BW_STATE_KEY_SIZE` random bytes, others in each
// drive. `sequence` is the number of the record, or any that rises.
//
// Returns `BW_CODE_OK`, or `BW_CODE_BUFFER_TOO_SMALL` if the code does not fit; nothing is then written.
//
// # Safety
// `bytes` is NULL or has `capacity` writable bytes. `key` is NULL or readable. `sealed_length` is NULL or writable.
BwCode bw_seal(uint8_t *bytes,
               size_t length,
               size_t capacity,
               const uint8_t (*key)[BW_STATE_KEY_SIZE],
               uint32_t sequence,
               size_t *sealed_length);
#endif

#if defined(BEARING_WATCH_SIGNATURE)
// Checks a state and the code of `bw_seal` behind it, before `bw_restore`; the first `state_length` bytes are then the
// state. `least_sequence` is the number of the newest state that was written, kept where an attacker cannot write it
// back, or 0.
//
// Returns `BW_CODE_OK` or a `BW_CODE_SIGNATURE_…`; `sealed` is then unchanged.
//
// # Safety
// `bytes` is NULL or has `length` readable bytes. `key` is NULL or readable. `sealed` is NULL or writable.
BwCode bw_open(const uint8_t *bytes,
               size_t length,
               const uint8_t (*key)[BW_STATE_KEY_SIZE],
               uint32_t least_sequence,
               struct BwSealed *sealed);
#endif

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BEARING_WATCH_SERVICE_H */
