/* The C interface of bearing-watch. Made by cbindgen from c-api/src: do not edit. README.md has an example.
 *
 * Every function may be called with any pointer that is NULL or fulfils its "Safety" section; it returns a code,
 * BW_CODE_OK or above if it did what it says, and below 0 if it did nothing; BwCode names three exceptions. */

#ifndef BEARING_WATCH_H
#define BEARING_WATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Before a function whose result matters: compilers warn where it is not used. */
#if defined(__GNUC__) || defined(__clang__)
#define BW_MUST_CHECK __attribute__((warn_unused_result))
#else
#define BW_MUST_CHECK
#endif

/* What a library for one plan needs is in bearing_watch_plan.h, which export.sh writes beside it. */
#if defined(__has_include)
#if __has_include("bearing_watch_plan.h")
#include "bearing_watch_plan.h"
#endif
#endif
#ifndef BW_PLAN_STATE_SIZE
#define BW_PLAN_STATE_SIZE BW_STATE_SIZE
#define BW_PLAN_FRONT_END_SIZE BW_FRONT_END_SIZE
#endif

// Alignment of the memory of a state, bytes, and of the memory of all other objects.
#define BW_STATE_ALIGN 8

// Bytes of memory that are enough for `bw_start` of a library without a plan of its own; `bw_state_size` returns what
// exactly is needed.
#define BW_STATE_SIZE 23552

// Bytes of memory that are enough for `bw_front_end_init` of a library without a plan of its own;
// `bw_front_end_size` returns what exactly is needed. The memory is aligned to `BW_STATE_ALIGN` bytes.
#define BW_FRONT_END_SIZE 3328

// What a function returns: 0 or above if it did what it says, below 0 if it did nothing. But with
// `BW_CODE_BUFFER_TOO_SMALL` `bw_values` has filled the buffer and `bw_end_run` has ended the run, and with a
// `BW_CODE_CALIBRATION_…` `bw_calibration_finish` names the refused sensor.
typedef int BwCode;
enum {
  BW_CODE_OK = 0, // Done.
  BW_CODE_SEGMENT = 1, // A segment has closed; the main loop can solve it.
  BW_CODE_REPORT = 2, // There is a new report.
  BW_CODE_WITHDRAWN = 3, // The last report has lost its verdict, because a fault was found late.
  BW_CODE_IDLE = 4, // There is no closed segment to solve, or no alarm to deny.
  BW_CODE_COLLECT = 5, // Samples wait: the interrupt of `bw_collect` is to be requested.
  BW_CODE_ENOUGH_SAMPLES = 6, // The calibration has as many samples as it needs.
  BW_CODE_BLOCK = 7, // A block of recorded samples is complete and waits to be sent.
  BW_CODE_NULL = -1, // A pointer is NULL.
  // A pointer is not aligned: the memory of an object to `BW_STATE_ALIGN` bytes, other pointers to their type.
  BW_CODE_MISALIGNED = -2,
  BW_CODE_MEMORY_TOO_SMALL = -3, // The memory has less than `bw_state_size()` bytes, or what another object needs.
  // No state, or other object, was initialised at this address; a copied one does not count.
  BW_CODE_NOT_INITIALISED = -4,
  BW_CODE_BUSY = -5, // The function interrupted another one that works on the same part of the state.
  BW_CODE_NO_REPORT = -7, // There is no report yet, or the next segment is being solved.
  // The number of values is not the number of channels of the model, or of further channels of the front end.
  BW_CODE_WRONG_CHANNEL_COUNT = -8,
  BW_CODE_OUT_OF_RANGE = -9, // No such thing: an index or a choice is out of range.
  BW_CODE_BUFFER_TOO_SMALL = -10, // The buffer has too few elements.
  BW_CODE_RECORDER_FULL = -11, // The blocks before were not sent: the sample is not recorded.
  // The chip, or its settings in this context, computes otherwise than the host of the training.
  BW_CODE_ARITHMETIC = -13,
  BW_CODE_NO_SAMPLE = -14, // No sample has come for too long: `bw_sample` is not called, or the front end gives none.
  BW_CODE_NOT_COLLECTED = -15, // Samples wait, but were not collected for too long.
  BW_CODE_NO_SEGMENT = -16, // Samples come, but no segment has closed for too long, or none was taken by the main loop.
  BW_CODE_NO_VERDICT = -17, // No segment has had a verdict for too long: `BwReport` and `BwAlarm` say why.
  BW_CODE_WRONG_RATE = -18, // Samples do not come at the rate of the model: no segment has a verdict.
  BW_CODE_NOT_A_MODEL = -20, // The bytes are not a model.
  // The model has another format version: a newer one needs a newer library, an older one is trained again.
  BW_CODE_MODEL_VERSION = -21,
  BW_CODE_MODEL_TRUNCATED = -22, // The model has fewer bytes than its header says.
  BW_CODE_MODEL_CHECKSUM = -23, // The checksum does not match: the model is corrupted.
  BW_CODE_MODEL_VALUE = -24, // A value of the model is out of range.
  // The model does not fit the arrays of this library, see `BW_MAX_...`, or is not of the plan it was built for.
  BW_CODE_MODEL_DOES_NOT_FIT = -25,
  BW_CODE_MODEL_CHANNEL = -26, // The model has another name or unit of this channel.
  BW_CODE_MODEL_INTERVAL = -27, // The model was trained on samples with another interval.
  BW_CODE_MODEL_PARK = -28, // The model was trained with the other Park convention.
  BW_CODE_SAVED_STATE = -35, // The bytes are not a saved state of this version and of these sizes, or are corrupted.
  BW_CODE_OTHER_MODEL = -36, // The saved state is that of another model.
  BW_CODE_FRONT_END_CONTROL_RATE = -40, // The control rate is not within 100 Hz and 1 MHz.
  BW_CODE_FRONT_END_SENSOR = -41, // Offset, gain or usable range of a current sensor is out of range.
  BW_CODE_FRONT_END_BALANCE = -42, // Noise, tolerance or window of the sum of the currents is out of range.
  BW_CODE_FRONT_END_TRACKING = -43, // Bandwidth, damping, limit or times of the tracking loop are out of range.
  BW_CODE_FRONT_END_RESOLVER = -44, // The amplitudes of the resolver are out of range.
  BW_CODE_FRONT_END_POLE_PAIRS = -45, // A motor has at least one pole pair.
  // There are no filters for this factor of decimation, or the plan of this library has another one.
  BW_CODE_FRONT_END_FACTOR = -46,
  // There are more further channels than `BW_MAX_FURTHER`, or not as many as the plan of this library has.
  BW_CODE_FRONT_END_FURTHER = -47,
  BW_CODE_CALIBRATION_TOO_FEW = -50, // There are not enough samples for the offsets of the current sensors yet.
  // A current sensor is too noisy: the motor turns, a current flows, or the sensor is broken.
  BW_CODE_CALIBRATION_NOISY = -51,
  BW_CODE_CALIBRATION_STUCK = -52, // The converter of a current sensor repeats itself.
  // The offset of a current sensor is not plausible: a current flows, or the sensor is broken.
  BW_CODE_CALIBRATION_OUT_OF_BAND = -53,
  BW_CODE_SIGNATURE_MISSING = -60, // No signature follows the model.
  BW_CODE_SIGNATURE_VERSION = -61, // The signature has another format version or algorithm.
  BW_CODE_SIGNATURE_FORMAT = -62, // A field of the signature does not fit the model before it.
  BW_CODE_SIGNATURE_TRUNCATED = -63, // The signature is cut short.
  BW_CODE_SIGNATURE_KEY = -64, // The key of the signature is not accepted.
  // The signature is not that of these bytes: they were changed, or signed by somebody else.
  BW_CODE_SIGNATURE_MISMATCH = -65,
  BW_CODE_SIGNATURE_OLDER = -66, // The model is older than accepted.
  BW_CODE_FLASH_FAILED = -70, // A function of the flash has failed; the record before is still there.
  BW_CODE_FLASH_PLACES = -71, // The places are not multiples of `BW_FLASH_UNIT`, or have no room for a record.
  BW_CODE_FLASH_TOO_SMALL = -72, // The record is longer than its place.
  BW_CODE_FLASH_NOT_WRITTEN = -73, // The flash reads back other bytes than were written: it is worn, or was not erased.
  BW_CODE_FLASH_NO_RECORD = -74, // Neither place has a good record.
  BW_CODE_CAN_FAILED = -80, // The function that sends over CAN has failed.
};

// The state of the bearing in one segment.
typedef int BwVerdict;
enum {
  BW_VERDICT_CLASS = 0, // A trained class: see `class_index`.
  BW_VERDICT_NOVEL = 1, // Most like healthy, but farther from it than healthy segments are; or far from every class.
  BW_VERDICT_AMBIGUOUS = 2, // No class is plausible enough.
  BW_VERDICT_UNDETERMINED = 3, // No verdict: see `reason`.
};

// Why a segment has no verdict.
typedef int BwReason;
enum {
  BW_REASON_NONE = 0, // It has one.
  BW_REASON_TOO_FEW_ROWS = 1, // The part `part` had too few usable rows, `reason_rows`.
  BW_REASON_SHORT_SEGMENT = 2, // Less than half of the segment was usable.
  BW_REASON_AT_REST = 3, // The shaft hardly moved, or the inputs of the regression hardly changed.
  BW_REASON_PARAMETER_NOT_EXCITED = 4, // The data do not excite the parameter `place` of the regression.
  BW_REASON_TERM_NOT_EXCITED = 5, // The motion does not excite the term `place` of the torque balance.
  BW_REASON_WEAK_INSTRUMENTS = 6, // The instruments of `part` hardly follow the output.
  BW_REASON_STUCK = 7, // The sensor of the channel `place` is stuck.
  BW_REASON_LOST_SAMPLES = 8, // More samples of the channel `place` were refused than used.
  BW_REASON_OUT_OF_RANGE = 9, // The covariate `place` is outside the range of the training records.
  BW_REASON_NOT_FINITE = 10, // A result of `part` is not a finite number.
  BW_REASON_OTHER = 11, // A reason that this interface does not know.
  // The signals contradict the model or each other: wrong wiring, unit or sampling rate. `place` says which: the
  // sign of 0 the current, 1 the load, 2 velocity and angle, 3 one of them; the gain, unit or rate of 4 the
  // current, 5 the load, 6 the velocity, 7 one of them; the velocity against the angle, 8 its sign, 9 its unit or
  // the rate; 10 the current follows neither motion nor load; 11 the torque constant; 12 the rate by a clock; 13
  // the angle is stuck, 14 it makes steps; 15 the wiring is not decided yet, 16 it is wrong. 255: what this
  // interface does not know.
  BW_REASON_IMPLAUSIBLE = 12,
  // The processor does not compute as the host does where the detector runs; `place` is 0 for the rounding, 1 for
  // subnormal numbers. An interrupt has settings of its own (FPDSCR).
  BW_REASON_ARITHMETIC = 13,
  BW_REASON_OTHER_MODEL = 14, // The segment is that of another model.
  // A fault that was found after the segment may have begun in it: it has lost its verdict (`BW_CODE_WITHDRAWN`).
  BW_REASON_FOUND_LATE = 15,
  // Healthy is most plausible, but the segment would not have shown an acceptable defect (`BW_VALUES_SMALLEST`):
  // `place` is 0 if the shaft turned too little for the bearing orders, 1 if they are too noisy.
  BW_REASON_UNSEEN = 16,
};

// A part of the detector.
typedef int BwPart;
enum {
  BW_PART_NONE = 0, // No part, or the reason is not about one.
  BW_PART_REGRESSION = 1, // The regression.
  BW_PART_TORQUE_BALANCE = 2, // The torque balance of the shaft.
  BW_PART_ORDERS = 3, // The bearing orders.
  BW_PART_CLASSIFIER = 4, // The classifier.
};

// Whether the currents turn with the rotor.
typedef int BwAlignment;
enum {
  // No window has told yet: the shaft has not turned with a current. No segment has a verdict.
  BW_ALIGNMENT_UNDECIDED = 0,
  BW_ALIGNMENT_ALIGNED = 1, // They do.
  BW_ALIGNMENT_MISALIGNED = 2, // They do not: no segment has a verdict.
  // They are not checked: currents or motion are too small, the drive gives a quadrature current of its own, or it
  // has no front end. Segments have verdicts.
  BW_ALIGNMENT_UNKNOWN = 3,
};

// Why the three currents do not fit each other.
typedef int BwImbalance;
enum {
  BW_IMBALANCE_NONE = 0, // They do.
  BW_IMBALANCE_OPEN = 1, // No current in a phase, and the other two sum to zero: the winding or its lead is open.
  // A sensor reads no current, but the other two do not sum to zero: the sensor or its wire is broken.
  BW_IMBALANCE_SILENT = 2,
  BW_IMBALANCE_GAIN = 3, // The gain of a sensor is wrong.
  // The currents do not sum to zero, and no single gain explains it: several sensors, current to earth.
  BW_IMBALANCE_UNNAMED = 4,
  BW_IMBALANCE_OFFSET = 5, // The offset of a sensor is beyond what is removed from its currents.
  // The current vector does not turn with the rotor: two phases are exchanged, the angle is reversed, the pole pairs
  // are wrong, or there is no field-oriented control.
  BW_IMBALANCE_MISALIGNED = 6,
  // A phase stays below a level that the other two exceed: its sensor or amplifier is clipped.
  BW_IMBALANCE_CLIPPED = 7,
  // A phase has no current in one direction, which the other two have: a half bridge or a sensor is broken.
  BW_IMBALANCE_HALF_WAVE = 8,
};

// How far the loop has found the angle of the shaft.
typedef int BwLock;
enum {
  BW_LOCK_SEARCHING = 0, // No reading yet, or lost.
  BW_LOCK_FOUND = 1, // One reading: the next one gives the velocity.
  BW_LOCK_SETTLING = 2, // The loop follows, but its errors have not been small for long enough.
  BW_LOCK_LOCKED = 3, // The loop follows.
};

// Sign convention of the Park transform.
typedef int BwPark;
enum {
  BW_PARK_UNKNOWN = 0, // The current is not from a Park transform, or the model does not say.
  BW_PARK_STANDARD = 1, // With the angle on the magnet axis, positive q current produces positive torque.
  BW_PARK_THESIS = 2, // The +sin row of the source's Eq. 5.1.
};

// What a raw sample has of the position sensor.
typedef int BwPosition;
enum {
  BW_POSITION_MISSING = 0, // No reading, or one that the sensor says is wrong.
  BW_POSITION_ABSOLUTE = 1, // The angle from a converter or an absolute encoder.
  BW_POSITION_RESOLVER = 2, // Demodulated sine and cosine of a resolver, or of a sine/cosine encoder.
};

// The front end of one drive, in memory of the caller.
typedef struct BwFrontEnd BwFrontEnd;

// The diagnosis of one drive, in memory of the caller.
typedef struct BwState BwState;

// What the drive reads at one instant of its control loop.
typedef struct BwRawSample {
  // Number of the sampling instant: one more each time, with wrap-around. A missed interrupt shows as a gap.
  uint32_t number;
  uint16_t counts[3]; // Converter counts of the currents of phases a, b, c; c is not used with two phases.
  // Number of measured phases, 2 or 3. With two, the third current is minus the sum, and nothing checks the sensors
  // against each other. 1 stands for `current_a` in the place of counts. A library for one plan takes only what that
  // was trained with: counts, or a current.
  uint8_t phases;
  uint8_t position; // What there is of the position, `BW_POSITION_…`.
  uint32_t angle; // Mechanical angle of the shaft as `bw_angle` returns it, for `BW_POSITION_ABSOLUTE`.
  float sin; // Amplitude times sine, for `BW_POSITION_RESOLVER`, in the unit of `resolver_lowest_amplitude`.
  float cos; // Amplitude times cosine.
  // With `phases` of 1, the quadrature current that the control of the drive makes itself, A; NaN if it is missing.
  float current_a;
} BwRawSample;

// The verdict on one segment.
typedef struct BwReport {
  uint32_t segment; // Number of the segment since `bw_start` or `bw_reset`; the first is 1.
  BwVerdict verdict; // The state of the bearing.
  uint8_t class_index; // The class of least expected cost, for any verdict but undetermined: `bw_label` gives its name.
  uint8_t place; // Parameter, term, channel, covariate or error of the reason.
  // Segments in a row, before this one, whose estimate could not serve as auxiliary model; 0 by least squares.
  uint8_t refused;
  uint8_t missing; // Number of features that were missing.
  BwReason reason; // Why there is no verdict.
  BwPart part; // The part of the reason.
  uint32_t reason_rows; // Rows of the reason.
  uint32_t rows; // Rows of the regression; in a model without one, usable samples.
  uint32_t rejected; // Samples with a channel beyond its limit or not a number.
  uint32_t saturated; // Samples with a saturated sensor and no rejected channel.
  uint32_t resting; // Rows that fading memory ignored because the inputs hardly changed.
  uint32_t stuck; // Channels that were stuck at some time of the segment, bit k for channel k.
  uint32_t lost_samples; // Samples lost since `bw_start` because `bw_collect` came too late.
  uint32_t lost_segments; // Segments lost since `bw_start` because `bw_advance` came too late.
  float distance; // Distance from the healthy class in its standard deviations; 0 without a healthy class or a verdict.
  float surprise; // -ln of the probability that a healthy segment is at least so unusual, nats; likewise.
  // The coordinate that departs most from the healthy class, or that of a strong bearing order: a place in
  // `BW_MODEL_COORDINATE_NAMES` of the model's header; 255 without a healthy class or a verdict.
  uint8_t most;
  bool falls; // Whether that one is below its usual value: no bearing defect, but a lost load or belt, or a sensor.
  BwAlignment alignment; // Whether the currents turn with the rotor; `BW_ALIGNMENT_UNKNOWN`: the wiring is not checked.
} BwReport;

// The alarm, and what leads to it.
typedef struct BwAlarm {
  bool raised; // Whether there is an alarm. It stays until `bw_reset`.
  bool known; // Whether its cause is a trained defect, `class_index`.
  uint8_t class_index; // The defect that caused it.
  uint32_t segment; // Number of the segment that raised it; the first is 1.
  uint32_t segments; // Segments observed.
  uint32_t undetermined; // Of these, segments without a verdict.
  float score; // Evidence of the runs that have ended, nats.
  float limit; // The score that raises the alarm, nats; infinite if the model has none.
  // Whether no segment has had a verdict for too long (`bw_limit_silence`): the diagnosis is lost. False again with
  // the next verdict.
  bool silent;
  uint8_t silent_place; // Parameter, term, channel, covariate or error of `silent_reason`, as in `BwReport`.
  uint32_t silent_segments; // Segments without a verdict since the last verdict, if `silent`.
  BwReason silent_reason; // The most frequent reason of them.
  bool risen; // Whether the alarm names what has risen above what is usual for this drive.
  bool fallen; // Whether the alarm names what has fallen below it: the load or a sensor, and no bearing defect.
  uint8_t coordinate; // The coordinate that has risen or fallen, a place in `BW_MODEL_COORDINATE_NAMES`.
  float deviations; // By how many standard deviations of runs.
  uint32_t since; // Number of the last segment before it rose.
} BwAlarm;

// What a drive can tell beside verdicts and alarms.
typedef struct BwStatus {
  uint32_t samples; // Samples that the detector took, with wrap-around.
  uint32_t lost_samples; // Samples that were lost because `bw_collect` came too late.
  uint32_t lost_segments; // Segments that were lost because `bw_advance` came too late.
  // What the context of `bw_collect` computes otherwise than the host: as `bw_known_answer_test`, 0 if nothing.
  uint32_t failed;
  BwAlignment alignment; // Whether the currents turn with the rotor; `BW_ALIGNMENT_UNKNOWN`: the wiring is not checked.
} BwStatus;

// What a front end has refused since the start or `bw_clear_faults`, in samples where nothing else is said, and what
// is wrong now.
typedef struct BwFrontEndFaults {
  bool clear; // Whether the angle is known, and nothing was refused.
  uint8_t imbalance_phase; // The phase of the imbalance: 0, 1, 2 for a, b, c.
  BwImbalance imbalance; // Why the currents are missing now.
  float gain_error; // Relative error of the gain, for `BW_IMBALANCE_GAIN`; for `BW_IMBALANCE_OFFSET` the offset, A.
  uint32_t unbalanced_windows; // Number of windows in which the currents did not fit.
  // Offsets of phases a, b, c that were found while the shaft turned and are removed, A; not a refusal.
  float offsets_a[3];
  uint32_t saturated[3]; // Counts of phases a, b, c outside the usable range.
  uint32_t stuck[3]; // Counts of phases a, b, c that repeated too often.
  uint32_t position_missing; // `BW_POSITION_MISSING`.
  uint32_t position_strayed; // Errors of the locked loop beyond its limit.
  uint32_t lock_losses; // Number of times that the lock was lost.
  // Readings of the angle that repeat the one before although the shaft turns; they are missing.
  uint32_t position_stale;
  // Steps of the angle that are no motion: the sensor has slipped on the shaft, or lost or gained counts.
  uint32_t position_slipped;
  // Windows in which angle and sample were not of one instant, by more than a tenth of an interval.
  uint32_t position_unsteady;
  // Bits of the converter's reading, of 2⁻³² turn, that do not change while those beside them do.
  uint32_t position_stuck_bits;
  uint32_t resolver_lost; // Resolver signals with too low an amplitude, or not a number.
  uint32_t resolver_too_high; // Resolver signals with too high an amplitude.
  uint32_t resolver_mismatched; // Resolver signals while the gains of sine and cosine differed too much.
  BwLock lock; // Whether the angle is known now.
  uint32_t gaps; // Number of gaps in the numbers of the samples.
  BwAlignment alignment; // Whether the currents turn with the rotor.
} BwFrontEndFaults;

// One current sensor with its converter.
typedef struct BwPhaseSensor {
  float offset_counts; // Counts at no current; `bw_calibration_finish` measures them.
  float gain_a; // Amperes a count; negative if the sensor counts against the direction into the motor.
  uint16_t lowest_counts; // Lowest usable count; below it sensor or converter is saturated.
  uint16_t highest_counts; // Highest usable count.
} BwPhaseSensor;

// What a front end is made of. `bearing-watch train --front-end … --c model.h` writes it as `bw_front_end`.
typedef struct BwFrontEndConstants {
  float control_rate_hz; // Rate of the raw samples, Hz: 100 … 1e6.
  uint16_t factor; // Number of raw samples per clean sample: 1, 2, 4, 8, 16, 32, 6, 12, 24, 48, 10, 20 or 40.
  uint16_t further; // Number of further channels, at most `BW_MAX_FURTHER`.
  // Current sensors of phases a, b, c; with two sensors the third is not used, but must be valid.
  struct BwPhaseSensor sensors[3];
  // Equal counts in a row that mean a stuck converter; 0 if a quiet converter may repeat itself for ever.
  uint16_t stuck_samples;
  // Samples in a window of the sum of three currents, at least 16: sixteen are an electrical turn.
  uint16_t balance_window_samples;
  float balance_noise_a; // Noise of the sum of the three currents, its standard deviation, A.
  float balance_offset_a; // Largest offset of a sensor, and of the sum of the three, that is removed, A.
  float balance_gain_tolerance; // Tolerated relative error of a gain.
  // Bandwidth of the loop that follows the shaft angle, Hz: 1/2000 … 1/10 of the control rate.
  float tracking_bandwidth_hz;
  float tracking_damping; // Its damping, 0.5 … 1.
  float tracking_error_limit_rad; // Largest error of the locked loop, rad: 0.001 … 0.5.
  // Samples in a row, missing or beyond the limit, after which the loop searches again; at least 1.
  uint16_t tracking_lost_samples;
  uint16_t tracking_settle_samples; // Samples in a row below half of the limit that make the lock; at least 1.
  // Lowest amplitude of resolver signals, in their unit; valid, but not used, for absolute angles.
  float resolver_lowest_amplitude;
  float resolver_highest_amplitude; // Highest amplitude.
  float resolver_mismatch; // Largest relative difference of the amplitudes of sine and cosine, noise included.
  uint32_t pole_pairs; // Pole pairs of the motor.
  // Electrical angle of the magnet axis when the shaft angle is zero; 2^32 is one turn. A negative angle wraps.
  uint32_t electrical_offset_turn32;
  int32_t park; // Sign convention of the quadrature current, `BW_PARK_STANDARD` or `BW_PARK_THESIS`.
} BwFrontEndConstants;

// A counter of an encoder that counts on over turns without an end. Zero it, as a static is.
typedef struct BwTurnCounter {
  int32_t last; // The last reading.
  int32_t within; // Its counts within the turn.
} BwTurnCounter;



#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns the number of bytes of memory that `bw_start` needs: with a plan of its own a library needs less.
size_t bw_state_size(void);

// Starts the diagnosis of a drive in memory of the caller, by a model as `bearing-watch train --model` or `--c`
// writes it, and gives the address of its state in `state`. `front_end` is that of `bw_front_end_init` for a drive
// that gives raw counts to `bw_sample_raw`, and belongs to the state from here on; NULL for one that gives signals
// of its own to `bw_sample`. What follows the model, such as the erased rest of a flash sector, is ignored. The
// bytes of the model are not needed afterwards. Needs about three times the memory of a model on the stack. Call it
// before the interrupts run, or behind `bw_stop`: another model and other constants need no reboot.
//
// Returns `BW_CODE_OK`; or what is wrong with memory or model; `BW_CODE_MODEL_INTERVAL` or `BW_CODE_MODEL_PARK` if the
// model was trained with another front end, `BW_CODE_FRONT_END_FURTHER` if it has other channels;
// `BW_CODE_ARITHMETIC` (`bw_known_answer_test`); or `BW_CODE_BUSY` if a state runs in this memory. Nothing is changed
// then, and nothing runs that did not run before: a start with a right model may follow.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the state is used no more. `model`
// is NULL or has `length` readable bytes. `front_end` is NULL, or was given by `bw_front_end_init` or has as many
// writable bytes. `state` is NULL or writable. No other function works on the state.
BW_MUST_CHECK
BwCode bw_start(void *memory,
                size_t size,
                const uint8_t *model,
                size_t length,
                struct BwFrontEnd *front_end,
                struct BwState **state);

// As `bw_start`, with the model that the library was built with (`BEARING_WATCH_PLAN=model.rs`), whose number in the
// model's header is `id`. No model is read or checked when it runs: the compiler has done that. It needs less memory
// than `bw_start`, little stack, and half of the flash.
//
// Returns what `bw_start` does, or `BW_CODE_MODEL_DOES_NOT_FIT` if the library was built with another model or with
// none.
//
// # Safety
// As `bw_start`.
BW_MUST_CHECK
BwCode bw_start_own(void *memory,
                    size_t size,
                    uint32_t id,
                    struct BwFrontEnd *front_end,
                    struct BwState **state);

// Ends the diagnosis, so that `bw_start` can follow in the same memory; the front end is to be initialised again, too.
// Save what `bw_end_run` writes before. In the main loop; the interrupts may go on, and are refused.
//
// Returns `BW_CODE_OK`, or `BW_CODE_BUSY` if another context is in a call: nothing is changed then.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BW_MUST_CHECK BwCode bw_stop(struct BwState *state);

// Takes a sample of signals that the drive has itself, at the sampling rate of the model, into a queue of four for
// `bw_collect`. `values` are the channels in the order of the model, in the unit that each name says; `angle` is the
// shaft's (`bw_angle`), 0 if the model needs none. Bad values, such as NaN, are counted and left out. A sample that
// finds the queue full takes the place of the one before the queue, which counts as one with bad values
// (`BwStatus::lost_samples`).
//
// Returns `BW_CODE_COLLECT` if samples wait: request the interrupt of `bw_collect`. `BW_CODE_OK` if it interrupted
// another function of this state; `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_OUT_OF_RANGE` if the state has a front
// end.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `values` is NULL or has `count` readable
// values.
BwCode bw_sample(struct BwState *state, const float *values, size_t count, uint32_t angle);

// Takes what the current loop has read, at its rate, in its interrupt. `further` are the further channels of the
// front end in their order and units, NaN if missing; it may be NULL if `count`, their number, is 0. Wrong counts,
// angles and values are counted, and are missing from the samples: their channels are NaN.
//
// Returns `BW_CODE_COLLECT` if samples wait: request the interrupt of `bw_collect`; `BW_CODE_OK`;
// `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is, or if the state
// has no front end. A sample that is not taken is a gap in the numbers.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `raw` is NULL or readable. `further` is
// NULL or has `count` readable values.
BwCode bw_sample_raw(struct BwState *state, const struct BwRawSample *raw, const float *further, size_t count);

// Takes all samples that wait into the detector, in an interrupt below the current loop, up to three samples late, or
// behind `bw_sample` in the same one. The first call tests the arithmetic of its context (`bw_known_answer_test`), in
// some hundred thousand instructions: call it once before the power stage is on. If the test fails, no segment closes,
// and `bw_clock` says so.
//
// Returns `BW_CODE_SEGMENT` if a segment has closed, for a main loop that sleeps, or `BW_CODE_OK`, also if it
// interrupted another function: the samples then wait for the next call.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BwCode bw_collect(struct BwState *state);

// Starts the open segment afresh, for a stream that does not continue from the last sample: after a pause, or at
// power-up of the motor. Samples that wait are dropped; a closed segment, report and alarm remain. In the interrupt of
// `bw_collect`, or while the interrupts are stopped.
//
// Returns `BW_CODE_OK` or `BW_CODE_BUSY`.
//
// # Safety
// As `bw_collect`.
BwCode bw_restart(struct BwState *state);

// Does the next step of the solve of a closed segment, of bounded cost; call it again and again in the main loop. The
// last step writes the report and the alarm that stands; either may be NULL.
//
// Returns `BW_CODE_REPORT` with the last step; `BW_CODE_WITHDRAWN` if the last report has lost its verdict because a
// fault was found late (`BW_REASON_FOUND_LATE`): report and alarm are those without it; `BW_CODE_OK` if there is
// more to do; `BW_CODE_IDLE` if there is no closed segment; or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `report` and `alarm` are NULL or
// writable.
BwCode bw_advance(struct BwState *state, struct BwReport *report, struct BwAlarm *alarm);

// Compares what was done so far with a clock, in milliseconds with wrap-around, which the timer of the samples does
// not make. Call it in the main loop, as often as you like: the times count from the first call, and anew from
// `bw_restart` and from the last sample of `bw_check_wiring`.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the interval of the model is not known, `BW_CODE_BUSY`, or why the
// drive is not watched as it should be, each reason once until it is right again: `BW_CODE_NO_SAMPLE`,
// `BW_CODE_NOT_COLLECTED` or `BW_CODE_ARITHMETIC` if no sample was taken for three seconds; `BW_CODE_NO_SEGMENT` if
// no segment has closed for three of its durations and three seconds; `BW_CODE_NO_VERDICT` if none has had a verdict
// for 24 hours; `BW_CODE_WRONG_RATE` if over ten seconds samples did not come at the rate of the model, to two per
// cent. While they do not, no segment has a verdict (`BW_REASON_IMPLAUSIBLE`), and what the first ten seconds have
// added to the alarm is taken out again. Rows that come twice, held or interpolated, are found by nothing else.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BW_MUST_CHECK BwCode bw_clock(struct BwState *state, uint32_t milliseconds);

// Sets other times than those of `bw_clock`, within which samples, segments and verdicts must come, in seconds;
// `INFINITY` for never. The times count anew.
//
// # Safety
// As `bw_clock`.
BwCode bw_limit_liveness(struct BwState *state, float sample_s, float segment_s, float verdict_s);

// Gives what was lost or refused.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `status` is NULL or writable.
BwCode bw_status(struct BwState *state, struct BwStatus *status);

// Gives what the front end has refused, as of the end of the last segment, and of `bw_clear_faults`.
//
// Returns `BW_CODE_OK`, or `BW_CODE_OUT_OF_RANGE` if the state has no front end.
//
// # Safety
// As `bw_clock`; `faults` is NULL or writable.
BwCode bw_faults(struct BwState *state, struct BwFrontEndFaults *faults);

// Counts what the front end refuses from zero, from the next raw sample on; what is wrong now stays. In the main loop.
//
// # Safety
// As `bw_clock`.
BwCode bw_clear_faults(struct BwState *state);

// Gives the report of the segment that was solved last. It is there until the solve of the next segment starts.
//
// Returns `BW_CODE_OK`, or `BW_CODE_NO_REPORT`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `report` is NULL or writable.
BwCode bw_report(struct BwState *state, struct BwReport *report);

// Gives the alarm.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `alarm` is NULL or writable.
BwCode bw_alarm(struct BwState *state, struct BwAlarm *alarm);

// Sets how long verdicts may be missing before `bw_alarm` calls the diagnosis lost: a number of segments in a row, and
// hours by the sampling interval of the model; 0 for no such limit. `bw_start` sets 10000 segments and 24 hours.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the hours are negative or not a number, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BwCode bw_limit_silence(struct BwState *state, uint32_t segments, float hours);

// Denies the alarm, because the bearing was inspected and is sound: scores start afresh, and what raised the alarm
// must be 1.5 times as large to raise the next one, for three alarms at most. `BW_CODE_IDLE` without an alarm.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BwCode bw_deny(struct BwState *state);

// Starts afresh, as after a repair: open and closed segment, report, alarm and scores. In the main loop while the
// interrupts are stopped. `BW_CODE_BUSY` if another function works on the state: call it again.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
BwCode bw_reset(struct BwState *state);

// Gives the number of bytes that `bw_save` writes for the model of this state.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `length` is NULL or writable.
BwCode bw_saved_size(const struct BwState *state, size_t *length);

// Ends a run (from power-up to power-up, a session), whose segments depend on each other, and writes alarm and scores
// into `bytes` and their number into `length`, to be stored where they survive power-off; the next start gives them to
// `bw_restore`. Call it at power-down or where a session ends, unless the model was trained with `--segments-a-run`.
// `bytes` may be NULL: nothing is written then, and `length` is not used. A segment that is being solved is concluded
// first, and belongs to the run; the open segment is not saved.
//
// Returns `BW_CODE_OK`, `BW_CODE_BUFFER_TOO_SMALL` if `capacity` is less than `bw_saved_size` gives (the run has
// ended), or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `bytes` is NULL or has `capacity`
// writable bytes. `length` is NULL or writable.
BwCode bw_end_run(struct BwState *state, uint8_t *bytes, size_t capacity, size_t *length);

// Writes alarm and scores of a run that goes on into `bytes`, for a power-off that comes without a warning. The open
// segment is not saved.
//
// Returns `BW_CODE_OK`, `BW_CODE_BUFFER_TOO_SMALL` if `capacity` is less than `bw_saved_size` gives, or
// `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `bytes` is NULL or has `capacity`
// writable bytes.
BW_MUST_CHECK BwCode bw_save(struct BwState *state, uint8_t *bytes, size_t capacity);

// Continues from the alarm and scores that `bw_save` wrote, for this model; there is no report then, and a
// segment that was being solved is left out. In case of an error nothing changes.
//
// Returns `BW_CODE_OK`, `BW_CODE_SAVED_STATE` if the bytes are not a saved state of this version or are corrupted,
// `BW_CODE_OTHER_MODEL` if they are that of another model, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `bytes` is NULL or has `length` readable
// bytes.
BW_MUST_CHECK BwCode bw_restore(struct BwState *state, const uint8_t *bytes, size_t length);

// Returns the number of bytes of memory that `bw_front_end_init` needs: with a plan of its own a library needs less.
size_t bw_front_end_size(void);

// Makes a front end without samples in memory of the caller, for `bw_start`, and gives its address in `front_end`. The
// constants are not needed afterwards. In case of an error the memory is unchanged.
//
// Returns `BW_CODE_OK`, or what is wrong with memory or constants: `BW_CODE_FRONT_END_…`, or `BW_CODE_OUT_OF_RANGE`
// for `park`.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the front end is used no more, also
// by the state that has it. `constants` is NULL or readable. `front_end` is NULL or writable. No other function
// works on the front end.
BW_MUST_CHECK
BwCode bw_front_end_init(void *memory,
                         size_t size,
                         const struct BwFrontEndConstants *constants,
                         struct BwFrontEnd **front_end);

// Returns the angle of a converter with `resolution_bits` bits a turn as the fraction of a turn that `bw_sample`
// takes: 2^32 is one turn.
uint32_t bw_angle(uint32_t counts, uint32_t resolution_bits);

// Returns the angle of an encoder with `counts_per_turn` counts a turn, four times its lines, as `bw_angle` does. The
// counter may count on over turns in both directions, or be reset at each; one that may reach its end, 2^31 counts,
// passes `bw_within_turn` before. 0 if a turn has no counts, or more than
// 2^24 - 1.
uint32_t bw_angle_from_cpr(int32_t counts, uint32_t counts_per_turn);

// Takes a reading of a counter of 32 bits; returns the counts within the turn, from 0 on, for the reading of a drive
// or for `bw_angle_from_cpr`. The counter may wrap: what counts are its differences. 0 if a turn has no counts, or
// more than 2^24 - 1, or if `counter` is NULL or not aligned.
//
// # Safety
// `counter` is NULL or readable and writable. Only one context calls this function for it.
int32_t bw_within_turn(struct BwTurnCounter *counter, int32_t counts, uint32_t counts_per_turn);

// Returns the word for a verdict of `BwVerdict`, such as "novel"; for a class `bw_label` gives its name. "unknown" for
// other numbers. Never NULL, ends in a zero byte.
const char *bw_verdict_name(int32_t verdict);

// Returns a text for a reason of `BwReason`; `place`, `part` and `reason_rows` of the report say which one and how
// many. "unknown" for other numbers. Never NULL, ends in a zero byte.
const char *bw_reason_name(int32_t reason);

// Returns the name of a code in this header, such as `BW_CODE_OK`; `bw_error_text` gives its text. "unknown" for other
// numbers. Never NULL, ends in a zero byte.
const char *bw_code_name(int32_t code);

// Returns a text for a code, ending in a zero byte; "unknown code" for other numbers. Never NULL.
const char *bw_error_text(int32_t code);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BEARING_WATCH_H */
