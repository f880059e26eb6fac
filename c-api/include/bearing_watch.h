/* The C interface of bearing-watch. Made by cbindgen from c-api/src: do not edit. README.md has an example.
 *
 * Every function may be called with any pointer that is NULL or fulfils its "Safety" section; it returns a code,
 * BW_CODE_OK or above if it did what it says, and below 0 if it did nothing; BwCode names two exceptions. */

#ifndef BEARING_WATCH_H
#define BEARING_WATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Largest number of channels of a sample.
#define BW_MAX_CHANNELS 8

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

// Largest number of classes.
#define BW_MAX_CLASSES 6

// Largest number of elements of the projection: coordinates times features.
#define BW_MAX_PROJECTION 144

// Largest number of elements of the covariances: Z (Z + 1)/2 for Z coordinates, of a quadratic discriminant for each
// class.
#define BW_MAX_DENSITIES 234

// Bytes of memory that are enough for `bw_init` of a library without a plan of its own; `bw_state_size` returns what
// exactly is needed.
#define BW_STATE_SIZE 20480

// Alignment of that memory, bytes.
#define BW_STATE_ALIGN 8

// What a function returns: 0 or above if it did what it says, below 0 if it did nothing. But with
// `BW_CODE_SEGMENT_LOST` the sample is taken, and with `BW_CODE_BUFFER_TOO_SMALL` `bw_values` has filled the buffer.
enum BwCode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done.
  BW_CODE_OK = 0,
  // The sample closed a segment; the main loop can conclude it.
  BW_CODE_SEGMENT = 1,
  // There is a new report.
  BW_CODE_REPORT = 2,
  // The estimate was not adopted: it came too late, has no use in this model, or is not stable. Not an error.
  BW_CODE_NOT_ADOPTED = 3,
  // There is no closed segment to solve.
  BW_CODE_IDLE = 4,
  // A pointer is NULL.
  BW_CODE_NULL = -1,
  // A pointer is not aligned: the memory of the state to `BW_STATE_ALIGN` bytes, other pointers to their type.
  BW_CODE_MISALIGNED = -2,
  // The memory has less than `bw_state_size()` bytes.
  BW_CODE_MEMORY_TOO_SMALL = -3,
  // No state was initialised at this address; a copied state does not count.
  BW_CODE_NOT_INITIALISED = -4,
  // The function interrupted another one that works on the same part of the state. A sample is lost.
  BW_CODE_BUSY = -5,
  // The sample closed a segment, but the main loop has not taken the segment before it. The new one is lost.
  BW_CODE_SEGMENT_LOST = -6,
  // There is no report yet, or the next segment is being solved.
  BW_CODE_NO_REPORT = -7,
  // The number of values is not the number of channels of the model.
  BW_CODE_WRONG_CHANNEL_COUNT = -8,
  // No such thing: an index or a choice is out of range.
  BW_CODE_OUT_OF_RANGE = -9,
  // The buffer has too few elements.
  BW_CODE_BUFFER_TOO_SMALL = -10,
  // The bytes are not a model.
  BW_CODE_NOT_A_MODEL = -20,
  // The model has another format version: train it again.
  BW_CODE_MODEL_VERSION = -21,
  // The model has fewer bytes than its header says.
  BW_CODE_MODEL_TRUNCATED = -22,
  // The checksum does not match: the model is corrupted.
  BW_CODE_MODEL_CHECKSUM = -23,
  // A value of the model is out of range.
  BW_CODE_MODEL_VALUE = -24,
  // The model does not fit the arrays of this library, see `BW_MAX_...`, or is not of the plan it was built for.
  BW_CODE_MODEL_DOES_NOT_FIT = -25,
  // The model has another name or unit of this channel.
  BW_CODE_MODEL_CHANNEL = -26,
  // The model was trained on samples with another interval.
  BW_CODE_MODEL_INTERVAL = -27,
  // The model was trained with the other Park convention.
  BW_CODE_MODEL_PARK = -28,
  // The bytes are not a saved state of this version and of these sizes, or are corrupted.
  BW_CODE_SAVED_STATE = -35,
  // The saved state is that of another model.
  BW_CODE_OTHER_MODEL = -36,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwCode BwCode;
#else
typedef int32_t BwCode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The state of the bearing in one segment.
enum BwVerdict
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // A trained class: see `class_index`.
  BW_VERDICT_CLASS = 0,
  // Most like healthy, but farther from it than healthy segments are.
  BW_VERDICT_NOVEL = 1,
  // No class is plausible enough.
  BW_VERDICT_AMBIGUOUS = 2,
  // No verdict: see `reason`.
  BW_VERDICT_UNDETERMINED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwVerdict BwVerdict;
#else
typedef int32_t BwVerdict;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Why a segment has no verdict.
enum BwReason
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It has one.
  BW_REASON_NONE = 0,
  // The part `part` had too few usable rows, `reason_rows`.
  BW_REASON_TOO_FEW_ROWS = 1,
  // Less than half of the segment was usable.
  BW_REASON_SHORT_SEGMENT = 2,
  // The inputs of the regression hardly changed.
  BW_REASON_AT_REST = 3,
  // The data do not excite the parameter `place` of the regression.
  BW_REASON_PARAMETER_NOT_EXCITED = 4,
  // The motion does not excite the term `place` of the torque balance.
  BW_REASON_TERM_NOT_EXCITED = 5,
  // The instruments of `part` hardly follow the output.
  BW_REASON_WEAK_INSTRUMENTS = 6,
  // The sensor of the channel `place` is stuck.
  BW_REASON_STUCK = 7,
  // More samples of the channel `place` were refused than used.
  BW_REASON_LOST_SAMPLES = 8,
  // The covariate `place` is outside the range of the training records.
  BW_REASON_OUT_OF_RANGE = 9,
  // A result of `part` is not a finite number.
  BW_REASON_NOT_FINITE = 10,
  // A reason that this interface does not know.
  BW_REASON_OTHER = 11,
  // The signals contradict the model or each other: wrong wiring, unit or sampling rate. `place` says which: the
  // sign of 0 the current, 1 the load, 2 velocity and angle, 3 one of them; the gain, unit or rate of 4 the current,
  // 5 the load, 6 the velocity, 7 one of them; the velocity against the angle, 8 its sign, 9 its unit or the rate.
  // 255: what this interface does not know.
  BW_REASON_IMPLAUSIBLE = 12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwReason BwReason;
#else
typedef int32_t BwReason;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A part of the detector.
enum BwPart
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // No part, or the reason is not about one.
  BW_PART_NONE = 0,
  // The regression.
  BW_PART_REGRESSION = 1,
  // The torque balance of the shaft.
  BW_PART_TORQUE_BALANCE = 2,
  // The bearing orders.
  BW_PART_ORDERS = 3,
  // The classifier.
  BW_PART_CLASSIFIER = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwPart BwPart;
#else
typedef int32_t BwPart;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Sign convention of the Park transform.
enum BwPark
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The current is not from a Park transform, or the model does not say.
  BW_PARK_UNKNOWN = 0,
  // With the angle on the magnet axis, positive q current produces positive torque.
  BW_PARK_STANDARD = 1,
  // The +sin row of the source's Eq. 5.1.
  BW_PARK_THESIS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwPark BwPark;
#else
typedef int32_t BwPark;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Lists of numbers behind a verdict.
enum BwValues
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Log-likelihood of each class.
  BW_VALUES_LOG_LIKELIHOODS = 0,
  // Posterior probability of each class.
  BW_VALUES_POSTERIORS = 1,
  // Expected cost of deciding each class.
  BW_VALUES_EXPECTED_COSTS = 2,
  // Whether each feature was missing, 1 or 0.
  BW_VALUES_MISSING = 3,
  // Parameters t, b, g and the constant of the regression, in units of y over units of the signal.
  BW_VALUES_PARAMETERS = 4,
  // Their standard deviations.
  BW_VALUES_PARAMETER_DEVIATIONS = 5,
  // Terms of the torque balance: J/Kt, B/Kt, Tc/Kt, 1/Kt, offset, load friction, Stribeck friction, drag; NaN for a
  // term that needs a load if the load is not measured.
  BW_VALUES_FRICTION = 6,
  // Their standard deviations.
  BW_VALUES_FRICTION_DEVIATIONS = 7,
  // Their distances from healthy in standard deviations.
  BW_VALUES_FRICTION_SCORES = 8,
  // Score of each bearing order: about standard normal without a defect.
  BW_VALUES_ORDER_SCORES = 9,
  // Amplitude of each bearing order, A.
  BW_VALUES_ORDER_AMPLITUDES = 10,
  // Standard deviations of the amplitudes, A.
  BW_VALUES_ORDER_DEVIATIONS = 11,
  // Relative slip of the cage at which each order is strongest.
  BW_VALUES_ORDER_SLIPS = 12,
  // Mean of each averaged channel; NaN if it has none.
  BW_VALUES_MEANS = 13,
  // Root mean square of each averaged channel; NaN if it has none.
  BW_VALUES_ROOT_MEAN_SQUARES = 14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwValues BwValues;
#else
typedef int32_t BwValues;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A detector of one drive, in memory of the caller.
typedef struct BwState BwState;

// The verdict on one segment.
typedef struct BwReport {
  // Number of the segment since `bw_init` or `bw_reset`; the first is 1.
  uint32_t segment;
  // The state of the bearing.
  BwVerdict verdict;
  // The class of least expected cost, for any verdict but undetermined: `bw_label` gives its name.
  uint8_t class_index;
  // Parameter, term, channel, covariate or error of the reason.
  uint8_t place;
  // Segments in a row, before this one, whose estimate could not serve as auxiliary model.
  uint8_t refused;
  // Number of features that were missing.
  uint8_t missing;
  // Why there is no verdict.
  BwReason reason;
  // The part of the reason.
  BwPart part;
  // Rows of the reason.
  uint32_t reason_rows;
  // Rows of the regression; in a model without one, usable samples.
  uint32_t rows;
  // Samples with a channel beyond its limit or not a number.
  uint32_t rejected;
  // Samples with a saturated sensor and no rejected channel.
  uint32_t saturated;
  // Rows with a reduced weight because their residual was large.
  uint32_t downweighted;
  // Rows that fading memory ignored because the inputs hardly changed.
  uint32_t resting;
  // Channels that were stuck at some time of the segment, bit k for channel k.
  uint32_t stuck;
  // Samples lost since `bw_init` because a function was busy.
  uint32_t lost_samples;
  // Segments lost since `bw_init` because the one before was not taken.
  uint32_t lost_segments;
  // Distance from the healthy class in its standard deviations; 0 without a healthy class or a verdict.
  float distance;
  // -ln of the probability that a healthy segment is at least so unusual, nats; likewise.
  float surprise;
} BwReport;

// The alarm, and what leads to it.
typedef struct BwAlarm {
  // Whether there is an alarm. It stays until `bw_reset`.
  bool raised;
  // Whether its cause is a trained defect, `class_index`.
  bool known;
  // The defect that caused it.
  uint8_t class_index;
  // Number of the segment that raised it; the first is 1.
  uint32_t segment;
  // Segments observed.
  uint32_t segments;
  // Of these, segments without a verdict.
  uint32_t undetermined;
  // Evidence of the runs that have ended, nats.
  float score;
  // The score that raises the alarm, nats; infinite if the model has none.
  float limit;
  // Trend of the distance from healthy, standard deviations a segment; NaN with fewer than four decided segments.
  float slope;
  // Lower end of its 95 % interval: above zero the distance grows.
  float slope_low;
  // Upper end.
  float slope_high;
} BwAlarm;

// What the model wants.
typedef struct BwInfo {
  // Number of channels of a sample.
  uint8_t channels;
  // Number of classes.
  uint8_t classes;
  // Number of features.
  uint8_t features;
  // Number of bearing orders.
  uint8_t orders;
  // Whether samples need the angle of the shaft.
  bool needs_angle;
  // Sampling interval, s; 0 if it is unknown.
  float interval_s;
  // Samples averaged into one before the regression.
  uint32_t block_mean;
  // Samples of a segment, after averaging.
  uint32_t segment_samples;
  // Samples of a segment within which `bw_adopt` must come.
  uint32_t handover;
  // Sign convention of the quadrature current.
  BwPark park;
} BwInfo;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns a text for a code, ending in a zero byte; "unknown code" for other numbers. Never NULL.
const char *bw_error_text(int32_t code);

// Returns the number of bytes of memory that `bw_init` needs: with a plan of its own a library needs less.
size_t bw_state_size(void);

// Makes a state in memory of the caller from a model as `bearing-watch train --model` or `--c` writes it, and gives
// its address in `state`. What follows the model, such as the erased rest of a flash sector, is ignored. The bytes of
// the model are not needed afterwards. In case of an error the memory is unchanged. A state can be initialised again,
// for another model, while no other function works on it. Needs about three times the memory of a model on the stack.
//
// Returns `BW_CODE_OK`, or what is wrong with memory or model.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the state is used no more. `model` is
// NULL or has `length` readable bytes. `state` is NULL or writable. No other function works on the state.
BwCode bw_init(void *memory, size_t size, const uint8_t *model, size_t length, struct BwState **state);

// Takes one sample in the sampling interrupt, in time that hardly depends on the data. `values` are the channels in
// the order of the model, in the unit that each name says; `angle` is the shaft's (`bw_angle`), 0 if the model needs
// none. Bad values, such as NaN, are counted and left out.
//
// Returns `BW_CODE_OK`; `BW_CODE_SEGMENT` with the sample that closes a segment, which the main loop then concludes by
// `bw_advance` or `bw_conclude`; `BW_CODE_SEGMENT_LOST` if it has not done so with the segment before; or
// `BW_CODE_BUSY` if the interrupt came during `bw_adopt`, `bw_restart`, `bw_pending`, `bw_step` or `bw_reset`. The
// sample is then lost, and counts as one with bad values.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `values` is NULL or has `count`
// readable values.
BwCode bw_collect(struct BwState *state, const float *values, size_t count, uint32_t angle);

// Takes one sample, as `bw_collect`, and solves at once when it closes a segment: for programs without interrupts. The
// alarm takes account of the report.
//
// Returns `BW_CODE_OK`, `BW_CODE_REPORT` with the sample that closes a segment, or `BW_CODE_BUSY` as `bw_collect` does,
// and while a segment of `bw_collect` is not concluded.
//
// # Safety
// As `bw_collect`.
BwCode bw_step(struct BwState *state, const float *values, size_t count, uint32_t angle);

// Starts the open segment afresh, for a stream that does not continue from the last sample: after a pause, or at
// power-up of the motor. A closed segment, report and alarm remain. In the interrupt, or with the interrupt masked.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_restart(struct BwState *state);

// Gives the number of samples in the open segment, after averaging. In the interrupt, or with the interrupt masked.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `samples` is NULL or writable.
BwCode bw_pending(struct BwState *state, uint32_t *samples);

// Returns the angle of a converter with `resolution_bits` bits a turn as the fraction of a turn that `bw_collect`
// takes: 2^32 is one turn.
uint32_t bw_angle(uint32_t counts, uint32_t resolution_bits);

// Does a bounded piece of the solve of the closed segment; call it again and again in the main loop. The first piece
// takes the segment, so that the interrupt can close the next one. The alarm takes account of the report.
//
// Returns `BW_CODE_OK` if there is more to do, `BW_CODE_REPORT` with the last piece, or `BW_CODE_IDLE` if there is no
// closed segment.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_advance(struct BwState *state);

// Solves the closed segment as a whole, or what `bw_advance` has left of it, with the same bits.
//
// Returns `BW_CODE_REPORT`, or `BW_CODE_IDLE` if there is no closed segment.
//
// # Safety
// As `bw_advance`.
BwCode bw_conclude(struct BwState *state);

// Makes the estimate of the report the auxiliary model of instrumental variables, or of least squares with less weight
// for outliers (`train --huber`); other models need no call. It must come before `handover` samples (`bw_info`) of the
// next segment have been taken, with the interrupt masked. A model whose `handover` is 0 adopts by `bw_step` only.
//
// Returns `BW_CODE_OK`, `BW_CODE_NOT_ADOPTED`, or `BW_CODE_NO_REPORT`.
//
// # Safety
// As `bw_advance`.
BwCode bw_adopt(struct BwState *state);

// Gives the report of the segment that was solved last. It is there until the solve of the next segment starts.
//
// Returns `BW_CODE_OK`, or `BW_CODE_NO_REPORT`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `report` is NULL or writable.
BwCode bw_report(struct BwState *state, struct BwReport *report);

// Gives a list of numbers behind the last report, `what` of `BwValues`, and in `count` how many there are: 0 if the
// model does not have this part, or this segment no such result.
//
// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, `BW_CODE_OUT_OF_RANGE` if there is no such list, or
// `BW_CODE_BUFFER_TOO_SMALL`, where `count` is what is needed.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `values` is NULL or has `capacity`
// writable numbers. `count` is NULL or writable.
BwCode bw_values(struct BwState *state, int32_t what, float *values, size_t capacity, size_t *count);

// Gives the alarm.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `alarm` is NULL or writable.
BwCode bw_alarm(struct BwState *state, struct BwAlarm *alarm);

// Ends a run (from power-up to power-up, a session), whose segments depend on each other. Call it at power-down or
// where a session ends, unless the model was trained with `--segments-a-run`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_end_run(struct BwState *state);

// Starts afresh, as after a repair: open and closed segment, report, alarm, scores and trend. With the interrupt
// masked. `BW_CODE_BUSY` if another function works on the state; nothing is then changed.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_reset(struct BwState *state);

// Gives the number of bytes that `bw_save` writes for the model of this state.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `length` is NULL or writable.
BwCode bw_saved_size(const struct BwState *state, size_t *length);

// Writes alarm, scores and trend into `bytes`, to be stored where they survive power-off. Call `bw_end_run` before, at
// power-down where a run is from power-up to power-up. The open segment is not saved.
//
// Returns `BW_CODE_OK`, `BW_CODE_BUFFER_TOO_SMALL` if `capacity` is less than `bw_saved_size` gives, or
// `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `bytes` is NULL or has `capacity` writable
// bytes.
BwCode bw_save(struct BwState *state, uint8_t *bytes, size_t capacity);

// Continues from the alarm, scores and trend that `bw_save` wrote, for this model. In case of an error nothing
// changes.
//
// Returns `BW_CODE_OK`, `BW_CODE_SAVED_STATE` if the bytes are not a saved state of this version or are corrupted,
// `BW_CODE_OTHER_MODEL` if they are that of another model, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `bytes` is NULL or has `length` readable
// bytes.
BwCode bw_restore(struct BwState *state, const uint8_t *bytes, size_t length);

// Returns the version of the library, a text that ends in a zero byte.
const char *bw_version(void);

// Gives what the model wants.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `info` is NULL or writable.
BwCode bw_info(const struct BwState *state, struct BwInfo *info);

// Writes the name of a class, ending in a zero byte, into `text`: 17 bytes are enough for every name.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if there is no such class, or `BW_CODE_BUFFER_TOO_SMALL`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `text` is NULL or has `capacity`
// writable bytes.
BwCode bw_label(const struct BwState *state, uint8_t class_index, char *text, size_t capacity);

// Checks that a channel of the model has this name and unit, such as `current_a` and `A`. A program that passes its
// channels in a fixed order does so at start.
//
// Returns `BW_CODE_OK`, `BW_CODE_MODEL_CHANNEL`, or `BW_CODE_OUT_OF_RANGE` if there is no such channel.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `name` and `unit` are NULL or
// readable up to a zero byte.
BwCode bw_check_channel(const struct BwState *state, uint8_t channel, const char *name, const char *unit);

// Checks that the drive samples as the recordings were sampled on which the model was trained, to 1 %.
//
// Returns `BW_CODE_OK`, also if either interval is unknown (0), or `BW_CODE_MODEL_INTERVAL`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_check_interval(const struct BwState *state, float interval_s);

// Checks that the drive's quadrature current has the sign convention of the recordings, `park` of `BwPark`.
//
// Returns `BW_CODE_OK`, also if the model does not say, `BW_CODE_MODEL_PARK`, or `BW_CODE_OUT_OF_RANGE`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_check_park(const struct BwState *state, int32_t park);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BEARING_WATCH_H */
