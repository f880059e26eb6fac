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

// Alignment of the memory of a state, bytes, and of the memory of all other objects.
#define BW_STATE_ALIGN 8

// Bytes of memory that are enough for `bw_init` of a library without a plan of its own; `bw_state_size` returns what
// exactly is needed.
#define BW_STATE_SIZE 23552

// Every address and length that the functions of a `BwFlash` get is a multiple of this number of bytes, the largest
// word that a microcontroller programs at once.
#define BW_FLASH_UNIT 32

// Bytes of memory that are enough for `bw_front_end_init` of a library without a plan of its own;
// `bw_front_end_size` returns what exactly is needed. The memory is aligned to `BW_STATE_ALIGN` bytes.
#define BW_FRONT_END_SIZE 3328

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

// What a function returns: 0 or above if it did what it says, below 0 if it did nothing. But with
// `BW_CODE_SEGMENT_LOST` the sample is taken, with `BW_CODE_BUFFER_TOO_SMALL` `bw_values` has filled the buffer, and
// with a `BW_CODE_CALIBRATION_…` `bw_calibration_finish` names the refused sensor.
enum BwCode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
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
  // There is no closed segment to solve, or no alarm to deny.
  BW_CODE_IDLE = 4,
  // A clean sample came out of the front end.
  BW_CODE_CLEAN_SAMPLE = 5,
  // The calibration has as many samples as it needs.
  BW_CODE_ENOUGH_SAMPLES = 6,
  // A block of recorded samples is complete and waits to be sent.
  BW_CODE_BLOCK = 7,
  // A pointer is NULL.
  BW_CODE_NULL = -1,
  // A pointer is not aligned: the memory of an object to `BW_STATE_ALIGN` bytes, other pointers to their type.
  BW_CODE_MISALIGNED = -2,
  // The memory has less than `bw_state_size()` bytes, or what another object needs.
  BW_CODE_MEMORY_TOO_SMALL = -3,
  // No state, or other object, was initialised at this address; a copied one does not count.
  BW_CODE_NOT_INITIALISED = -4,
  // The function interrupted another one that works on the same part of the state. A sample is lost.
  BW_CODE_BUSY = -5,
  // The sample closed a segment, but the main loop has not taken the segment before it. The new one is lost.
  BW_CODE_SEGMENT_LOST = -6,
  // There is no report yet, or the next segment is being solved.
  BW_CODE_NO_REPORT = -7,
  // The number of values is not the number of channels of the model, or of further channels of the front end.
  BW_CODE_WRONG_CHANNEL_COUNT = -8,
  // No such thing: an index or a choice is out of range.
  BW_CODE_OUT_OF_RANGE = -9,
  // The buffer has too few elements.
  BW_CODE_BUFFER_TOO_SMALL = -10,
  // The blocks before were not sent: the sample is not recorded.
  BW_CODE_RECORDER_FULL = -11,
  // Four samples wait already: this one is lost, and counts as one with bad values. `bw_collect_waiting` is due.
  BW_CODE_SAMPLE_LOST = -12,
  // The chip, or its settings in this context, computes otherwise than the host of the training.
  BW_CODE_ARITHMETIC = -13,
  // No sample has come for too long: `bw_drive_sample` is not called, or the front end gives none.
  BW_CODE_NO_SAMPLE = -14,
  // Samples wait, but were not collected for too long.
  BW_CODE_NOT_COLLECTED = -15,
  // Samples come, but no segment has closed for too long, or none was taken by the main loop.
  BW_CODE_NO_SEGMENT = -16,
  // No segment has had a verdict for too long: `BwReport` and `BwAlarm` say why.
  BW_CODE_NO_VERDICT = -17,
  // Samples do not come at the rate of the model: no segment has a verdict.
  BW_CODE_WRONG_RATE = -18,
  // The bytes are not a model.
  BW_CODE_NOT_A_MODEL = -20,
  // The model has another format version: a newer one needs a newer library, an older one is trained again.
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
  // The control rate is not within 100 Hz and 1 MHz.
  BW_CODE_FRONT_END_CONTROL_RATE = -40,
  // Offset, gain or usable range of a current sensor is out of range.
  BW_CODE_FRONT_END_SENSOR = -41,
  // Noise, tolerance or window of the sum of the currents is out of range.
  BW_CODE_FRONT_END_BALANCE = -42,
  // Bandwidth, damping, limit or times of the tracking loop are out of range.
  BW_CODE_FRONT_END_TRACKING = -43,
  // The amplitudes of the resolver are out of range.
  BW_CODE_FRONT_END_RESOLVER = -44,
  // A motor has at least one pole pair.
  BW_CODE_FRONT_END_POLE_PAIRS = -45,
  // There are no filters for this factor of decimation, or the plan of this library has another one.
  BW_CODE_FRONT_END_FACTOR = -46,
  // There are more further channels than `BW_MAX_FURTHER`, or not as many as the plan of this library has.
  BW_CODE_FRONT_END_FURTHER = -47,
  // There are not enough samples for the offsets of the current sensors yet.
  BW_CODE_CALIBRATION_TOO_FEW = -50,
  // A current sensor is too noisy: the motor turns, a current flows, or the sensor is broken.
  BW_CODE_CALIBRATION_NOISY = -51,
  // The converter of a current sensor repeats itself.
  BW_CODE_CALIBRATION_STUCK = -52,
  // The offset of a current sensor is not plausible: a current flows, or the sensor is broken.
  BW_CODE_CALIBRATION_OUT_OF_BAND = -53,
  // No signature follows the model.
  BW_CODE_SIGNATURE_MISSING = -60,
  // The signature has another format version or algorithm.
  BW_CODE_SIGNATURE_VERSION = -61,
  // A field of the signature does not fit the model before it.
  BW_CODE_SIGNATURE_FORMAT = -62,
  // The signature is cut short.
  BW_CODE_SIGNATURE_TRUNCATED = -63,
  // The key of the signature is not accepted.
  BW_CODE_SIGNATURE_KEY = -64,
  // The signature is not that of these bytes: they were changed, or signed by somebody else.
  BW_CODE_SIGNATURE_MISMATCH = -65,
  // The model is older than accepted.
  BW_CODE_SIGNATURE_OLDER = -66,
  // A function of the flash has failed; the record before is still there.
  BW_CODE_FLASH_FAILED = -70,
  // The places are not multiples of `BW_FLASH_UNIT`, or have no room for a record.
  BW_CODE_FLASH_PLACES = -71,
  // The record is longer than its place.
  BW_CODE_FLASH_TOO_SMALL = -72,
  // The flash reads back other bytes than were written: it is worn, or was not erased.
  BW_CODE_FLASH_NOT_WRITTEN = -73,
  // Neither place has a good record.
  BW_CODE_FLASH_NO_RECORD = -74,
  // The function that sends over CAN has failed.
  BW_CODE_CAN_FAILED = -80,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwCode BwCode;
#else
typedef int BwCode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The state of the bearing in one segment.
enum BwVerdict
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // A trained class: see `class_index`.
  BW_VERDICT_CLASS = 0,
  // Most like healthy, but farther from it than healthy segments are; or far from every class.
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
typedef int BwVerdict;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Why a segment has no verdict.
enum BwReason
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It has one.
  BW_REASON_NONE = 0,
  // The part `part` had too few usable rows, `reason_rows`.
  BW_REASON_TOO_FEW_ROWS = 1,
  // Less than half of the segment was usable.
  BW_REASON_SHORT_SEGMENT = 2,
  // The shaft hardly moved, or the inputs of the regression hardly changed.
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
  // 5 the load, 6 the velocity, 7 one of them; the velocity against the angle, 8 its sign, 9 its unit or the rate; 10
  // the current follows neither motion nor load; 11 the torque constant; 12 the rate by a clock; 13 the angle is
  // stuck, 14 it makes steps; 15 the wiring is not decided yet, 16 it is wrong.
  // 255: what this interface does not know.
  BW_REASON_IMPLAUSIBLE = 12,
  // The processor does not compute as the host does where the detector runs; `place` is 0 for the rounding, 1 for
  // subnormal numbers. An interrupt has settings of its own (FPDSCR).
  BW_REASON_ARITHMETIC = 13,
  // The segment is that of another model.
  BW_REASON_OTHER_MODEL = 14,
  // A fault that was found after the segment may have begun in it (`bw_discard`).
  BW_REASON_FOUND_LATE = 15,
  // Healthy is most plausible, but the segment would not have shown an acceptable defect (`BW_VALUES_SMALLEST`):
  // `place` is 0 if the shaft turned too little for the bearing orders, 1 if they are too noisy.
  BW_REASON_UNSEEN = 16,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwReason BwReason;
#else
typedef int BwReason;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A part of the detector.
enum BwPart
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
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
typedef int BwPart;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Whether the currents turn with the rotor.
enum BwAlignment
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // No window has told yet: the shaft has not turned with a current. No segment has a verdict.
  BW_ALIGNMENT_UNDECIDED = 0,
  // They do.
  BW_ALIGNMENT_ALIGNED = 1,
  // They do not: no segment has a verdict.
  BW_ALIGNMENT_MISALIGNED = 2,
  // They are not checked: currents or motion are too small, the drive gives a quadrature current of its own, or it has
  // no front end. Segments have verdicts.
  BW_ALIGNMENT_UNKNOWN = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwAlignment BwAlignment;
#else
typedef int BwAlignment;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Why the three currents do not fit each other.
enum BwImbalance
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // They do.
  BW_IMBALANCE_NONE = 0,
  // No current in a phase, and the other two sum to zero: the winding or its lead is open.
  BW_IMBALANCE_OPEN = 1,
  // A sensor reads no current, but the other two do not sum to zero: the sensor or its wire is broken.
  BW_IMBALANCE_SILENT = 2,
  // The gain of a sensor is wrong.
  BW_IMBALANCE_GAIN = 3,
  // The currents do not sum to zero, and no single gain explains it: several sensors, current to earth.
  BW_IMBALANCE_UNNAMED = 4,
  // The offset of a sensor is beyond what is removed from its currents.
  BW_IMBALANCE_OFFSET = 5,
  // The current vector does not turn with the rotor: two phases are exchanged, the angle is reversed, the pole pairs
  // are wrong, or there is no field-oriented control.
  BW_IMBALANCE_MISALIGNED = 6,
  // A phase stays below a level that the other two exceed: its sensor or amplifier is clipped.
  BW_IMBALANCE_CLIPPED = 7,
  // A phase has no current in one direction, which the other two have: a half bridge or a sensor is broken.
  BW_IMBALANCE_HALF_WAVE = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwImbalance BwImbalance;
#else
typedef int BwImbalance;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How far the loop has found the angle of the shaft.
enum BwLock
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // No reading yet, or lost.
  BW_LOCK_SEARCHING = 0,
  // One reading: the next one gives the velocity.
  BW_LOCK_FOUND = 1,
  // The loop follows, but its errors have not been small for long enough.
  BW_LOCK_SETTLING = 2,
  // The loop follows.
  BW_LOCK_LOCKED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwLock BwLock;
#else
typedef int BwLock;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What is wrong with the wiring, or why nothing can be said. The value is that of `BwWiring`.
enum BwWiringFault
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Nothing is wrong.
  BW_WIRING_FAULT_NONE = 0,
  // The shaft has not been at all angles of a turn; value: sectors of 1/16 turn in which it was.
  BW_WIRING_FAULT_TOO_LITTLE_MOTION = 1,
  // The current is too small; value: its root mean square, A.
  BW_WIRING_FAULT_TOO_LITTLE_CURRENT = 2,
  // The current vector does not turn with the shaft: wrong phases or sensors, a slipping or multiplied angle, or no
  // field-oriented control; value: the largest coherence.
  BW_WIRING_FAULT_NOT_TURNING = 3,
  // The number of pole pairs is wrong; value: the one that fits, negative if the phases also run against the angle.
  BW_WIRING_FAULT_POLE_PAIRS = 4,
  // The phases run against angle and velocity: two are exchanged.
  BW_WIRING_FAULT_PHASE_ORDER = 5,
  // The angle runs against phases and velocity.
  BW_WIRING_FAULT_ANGLE_DIRECTION = 6,
  // The velocity runs against phases and angle.
  BW_WIRING_FAULT_VELOCITY_DIRECTION = 7,
  // Phases and angle run against each other; there is no velocity to decide which is wrong.
  BW_WIRING_FAULT_PHASE_ORDER_OR_ANGLE = 8,
  // The unit of the velocity or the control rate is wrong; value: integral of the velocity over motion of the angle.
  BW_WIRING_FAULT_RATE_OR_UNIT = 9,
  // The electrical offset is wrong; value: what must be added to it, rad, but for half a turn.
  BW_WIRING_FAULT_OFFSET = 10,
  // Current and angle are not of one instant; value: delay of the current behind the angle, s.
  BW_WIRING_FAULT_DELAY = 11,
  // A fault that this interface does not know.
  BW_WIRING_FAULT_OTHER = 12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwWiringFault BwWiringFault;
#else
typedef int BwWiringFault;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Sign convention of the Park transform.
enum BwPark
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
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
typedef int BwPark;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Lists of numbers behind a verdict.
enum BwValues
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
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
  // The smallest defect in each rising coordinate of the model, the last ones, that the segment would have shown: a
  // part of the usual friction, or the amplitude at a bearing order, A; infinite if it shows none.
  BW_VALUES_SMALLEST = 15,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwValues BwValues;
#else
typedef int BwValues;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What a raw sample has of the position sensor.
enum BwPosition
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // No reading, or one that the sensor says is wrong.
  BW_POSITION_MISSING = 0,
  // The angle from a converter or an absolute encoder.
  BW_POSITION_ABSOLUTE = 1,
  // Demodulated sine and cosine of a resolver, or of a sine/cosine encoder.
  BW_POSITION_RESOLVER = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BwPosition BwPosition;
#else
typedef int BwPosition;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The calibration of one drive, in memory of the caller.
typedef struct BwCalibration BwCalibration;

// The front end of one drive, in memory of the caller.
typedef struct BwFrontEnd BwFrontEnd;

// Records what a front end takes, in memory of the caller.
typedef struct BwRawRecorder BwRawRecorder;

// Records samples of a detector, in memory of the caller.
typedef struct BwRecorder BwRecorder;

// A detector of one drive, in memory of the caller.
typedef struct BwState BwState;

// Makes the frames of one line, in memory of the caller.
typedef struct BwTelemetry BwTelemetry;

// The check of one drive, in memory of the caller.
typedef struct BwWiringCheck BwWiringCheck;

#if defined(BEARING_WATCH_SIGNATURE)
// A model that an accepted key has signed.
typedef struct BwSigned {
  // Bytes of the model, for `bw_init`.
  size_t model_length;
  // Bytes of model and signature.
  size_t length;
  // Counter of the model. Once the model has started, keep it as the least one that is accepted.
  uint32_t counter;
} BwSigned;
#endif

#if defined(BEARING_WATCH_SIGNATURE)
// A state that was sealed with the key of the drive.
typedef struct BwSealed {
  // Bytes of the state, for `bw_restore`.
  size_t state_length;
  // Its number.
  uint32_t sequence;
} BwSealed;
#endif

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
  // Segments in a row, before this one, whose estimate could not serve as auxiliary model; 0 by least squares.
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
  // The coordinate that departs most from the healthy class, or that of a strong bearing order: a place in
  // `BW_MODEL_COORDINATE_NAMES` of the model's header; 255 without a healthy class or a verdict.
  uint8_t most;
  // Whether that one is below its usual value: no bearing defect, but a lost load or belt, or a sensor.
  bool falls;
  // Whether the currents turn with the rotor; `BW_ALIGNMENT_UNKNOWN`: nobody has checked the wiring.
  BwAlignment alignment;
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
  // Whether no segment has had a verdict for too long (`bw_limit_silence`): the diagnosis is lost. False again with
  // the next verdict.
  bool silent;
  // Parameter, term, channel, covariate or error of `silent_reason`, as in `BwReport`.
  uint8_t silent_place;
  // Segments without a verdict since the last verdict, if `silent`.
  uint32_t silent_segments;
  // The most frequent reason of them.
  BwReason silent_reason;
  // Whether the alarm names what has risen above what is usual for this drive.
  bool risen;
  // Whether the alarm names what has fallen below it: the load or a sensor, and no bearing defect.
  bool fallen;
  // The coordinate that has risen or fallen, a place in `BW_MODEL_COORDINATE_NAMES`.
  uint8_t coordinate;
  // By how many standard deviations of runs.
  float deviations;
  // Number of the last segment before it rose.
  uint32_t since;
} BwAlarm;

// What a direction contributes to the alarm.
typedef struct BwContribution {
  // The coordinate that a defect raises, a place in `BW_MODEL_COORDINATE_NAMES`.
  uint8_t coordinate;
  // The mean of the last run less the usual mean of this drive, standard deviations of runs.
  float deviations;
  // Largest score of the direction, nats. The alarm is raised where it reaches `BwAlarm::limit`.
  float score;
  // Number of the last segment before it rose.
  uint32_t since;
} BwContribution;

// A value with its 90 % interval.
typedef struct BwInterval {
  // The value.
  float value;
  // Lower end.
  float low;
  // Upper end.
  float high;
} BwInterval;

// The size of a defect in a direction, and the time left: an estimate from the past of this drive, and no promise.
typedef struct BwGrowth {
  // By how much the runs exceed the usual mean of this drive, standard deviations of a usual run.
  struct BwInterval size;
  // Its change in a usual run; divided by `run_hours`, in an hour.
  struct BwInterval slope;
  // The named size, to which the time is left, standard deviations of a usual run.
  float named;
  // Whether the size grows: the interval of the slope is above zero, the size above four of its deviations, and its
  // lower end above two deviations of a usual run.
  bool growing;
  // Usual runs until the named size, 0 if it is reached; NaN if the size does not grow.
  struct BwInterval runs_left;
  // The same in hours of segments, not of the time between runs; NaN also if the model has no sampling interval.
  struct BwInterval hours_left;
  // Hours of the segments of a usual run; 0 if the model has no sampling interval.
  float run_hours;
} BwGrowth;

// Two places in flash for records of one kind, and the functions that reach them. Models and states need places of
// their own. Each function returns 0 if it did what it says.
typedef struct BwFlash {
  // Passed to the functions.
  void *context;
  // Reads `length` bytes. On a flash that checks its words, an error of a word is an error of this call.
  int32_t (*read)(void *context, uint32_t address, uint8_t *bytes, size_t length);
  // Programs `length` bytes of erased flash.
  int32_t (*write)(void *context, uint32_t address, const uint8_t *bytes, size_t length);
  // Erases every sector that has a byte from `address` on to before `end`.
  int32_t (*erase)(void *context, uint32_t address, uint32_t end);
  // The address of the first place, at the start of a sector.
  uint32_t start;
  // Bytes from the first place to the second one: whole sectors.
  uint32_t place_bytes;
} BwFlash;

// One current sensor with its converter.
typedef struct BwPhaseSensor {
  // Counts at no current; `bw_calibration_finish` measures them.
  float offset_counts;
  // Amperes a count; negative if the sensor counts against the direction into the motor.
  float gain_a;
  // Lowest usable count; below it sensor or converter is saturated.
  uint16_t lowest_counts;
  // Highest usable count.
  uint16_t highest_counts;
} BwPhaseSensor;

// What a front end is made of. `bearing-watch train --front-end … --c model.h` writes it as `bw_front_end`.
typedef struct BwFrontEndConstants {
  // Rate of the raw samples, Hz: 100 … 1e6.
  float control_rate_hz;
  // Number of raw samples per clean sample: 1, 2, 4, 8, 16, 32, 6, 12, 24, 48, 10, 20 or 40.
  uint16_t factor;
  // Number of further channels, at most `BW_MAX_FURTHER`.
  uint16_t further;
  // Current sensors of phases a, b, c; with two sensors the third is not used, but must be valid.
  struct BwPhaseSensor sensors[3];
  // Equal counts in a row that mean a stuck converter; 0 if a quiet converter may repeat itself for ever.
  uint16_t stuck_samples;
  // Samples in a window of the sum of three currents, at least 16: sixteen are an electrical turn.
  uint16_t balance_window_samples;
  // Noise of the sum of the three currents, its standard deviation, A.
  float balance_noise_a;
  // Largest offset of a sensor, and of the sum of the three, that is removed, A.
  float balance_offset_a;
  // Tolerated relative error of a gain.
  float balance_gain_tolerance;
  // Bandwidth of the loop that follows the shaft angle, Hz: 1/2000 … 1/10 of the control rate.
  float tracking_bandwidth_hz;
  // Its damping, 0.5 … 1.
  float tracking_damping;
  // Largest error of the locked loop, rad: 0.001 … 0.5.
  float tracking_error_limit_rad;
  // Samples in a row, missing or beyond the limit, after which the loop searches again; at least 1.
  uint16_t tracking_lost_samples;
  // Samples in a row below half of the limit that make the lock; at least 1.
  uint16_t tracking_settle_samples;
  // Lowest amplitude of resolver signals, in their unit; valid, but not used, for absolute angles.
  float resolver_lowest_amplitude;
  // Highest amplitude.
  float resolver_highest_amplitude;
  // Largest relative difference of the amplitudes of sine and cosine, noise included.
  float resolver_mismatch;
  // Pole pairs of the motor.
  uint32_t pole_pairs;
  // Electrical angle of the magnet axis when the shaft angle is zero; 2^32 is one turn. A negative angle wraps.
  uint32_t electrical_offset_turn32;
  // Sign convention of the quadrature current, `BW_PARK_STANDARD` or `BW_PARK_THESIS`.
  int32_t park;
} BwFrontEndConstants;

// What the drive reads at one instant of its control loop.
typedef struct BwRawSample {
  // Number of the sampling instant: one more each time, with wrap-around. A missed interrupt shows as a gap.
  uint32_t number;
  // Converter counts of the currents of phases a, b, c; c is not used with two phases.
  uint16_t counts[3];
  // Number of measured phases, 2 or 3. With two, the third current is minus the sum, and nothing checks the sensors
  // against each other. 1 stands for `current_a` in the place of counts. A library for one plan takes only what that
  // was trained with: counts, or a current.
  uint8_t phases;
  // What there is of the position, `BW_POSITION_…`.
  uint8_t position;
  // Mechanical angle of the shaft as `bw_angle` returns it, for `BW_POSITION_ABSOLUTE`.
  uint32_t angle;
  // Amplitude times sine, for `BW_POSITION_RESOLVER`, in the unit of `resolver_lowest_amplitude`.
  float sin;
  // Amplitude times cosine.
  float cos;
  // With `phases` of 1, the quadrature current that the control of the drive makes itself, A; NaN if it is missing.
  float current_a;
} BwRawSample;

// All signals at one instant, some raw samples ago.
typedef struct BwCleanSample {
  // Quadrature current, A; NaN if missing.
  float current_a;
  // Mechanical velocity, rad/s; NaN if missing.
  float velocity_rad_s;
  // Mechanical angle as `bw_collect` takes it, 2^32 is one turn; without meaning if the velocity is NaN.
  uint32_t angle;
  // The further channels, NaN if missing; those that are not in use are 0.
  float further[BW_MAX_FURTHER];
  // 1 if a fault was found since the clean sample before that shows only after a window of samples (a stuck
  // converter, currents that do not fit each other, unequal gains of a resolver): samples before were wrong. Call
  // `bw_discard`.
  uint8_t found_late;
  // Whether the currents turn with the rotor, `BW_ALIGNMENT_…`. Pass it to `bw_tell_alignment`.
  uint8_t alignment;
} BwCleanSample;

// What was refused since the start or `bw_front_end_clear_faults`, in samples where nothing else is said, and what is
// wrong now.
typedef struct BwFrontEndFaults {
  // Whether the angle is known, and nothing was refused.
  bool clear;
  // The phase of the imbalance: 0, 1, 2 for a, b, c.
  uint8_t imbalance_phase;
  // Why the currents are missing now.
  BwImbalance imbalance;
  // Relative error of the gain, for `BW_IMBALANCE_GAIN`; for `BW_IMBALANCE_OFFSET` the offset, A.
  float gain_error;
  // Number of windows in which the currents did not fit.
  uint32_t unbalanced_windows;
  // Offsets of phases a, b, c that were found while the shaft turned and are removed, A; not a refusal.
  float offsets_a[3];
  // Counts of phases a, b, c outside the usable range.
  uint32_t saturated[3];
  // Counts of phases a, b, c that repeated too often.
  uint32_t stuck[3];
  // `BW_POSITION_MISSING`.
  uint32_t position_missing;
  // Errors of the locked loop beyond its limit.
  uint32_t position_strayed;
  // Number of times that the lock was lost.
  uint32_t lock_losses;
  // Readings of the angle that repeat the one before although the shaft turns; they are missing.
  uint32_t position_stale;
  // Steps of the angle that are no motion: the sensor has slipped on the shaft, or lost or gained counts.
  uint32_t position_slipped;
  // Windows in which angle and sample were not of one instant, by more than a tenth of an interval.
  uint32_t position_unsteady;
  // Bits of the converter's reading, of 2⁻³² turn, that do not change while those beside them do.
  uint32_t position_stuck_bits;
  // Resolver signals with too low an amplitude, or not a number.
  uint32_t resolver_lost;
  // Resolver signals with too high an amplitude.
  uint32_t resolver_too_high;
  // Resolver signals while the gains of sine and cosine differed too much.
  uint32_t resolver_mismatched;
  // Whether the angle is known now.
  BwLock lock;
  // Number of gaps in the numbers of the samples.
  uint32_t gaps;
  // Whether the currents turn with the rotor.
  BwAlignment alignment;
} BwFrontEndFaults;

// What a calibration must look like.
typedef struct BwCalibrationLimits {
  // Number of samples, at least 2.
  uint16_t samples;
  // Lowest plausible offset, counts.
  float lowest_offset_counts;
  // Highest plausible offset, counts.
  float highest_offset_counts;
  // Lowest plausible standard deviation, counts: less noise means a stuck converter; 0 accepts a constant.
  float lowest_deviation_counts;
  // Highest plausible standard deviation, counts.
  float highest_deviation_counts;
} BwCalibrationLimits;

// A current sensor whose offset was refused.
typedef struct BwRefusedOffset {
  // The phase, 0, 1, 2 for a, b, c; 0 for `BW_CODE_CALIBRATION_TOO_FEW`.
  uint8_t phase;
  // Standard deviation for `BW_CODE_CALIBRATION_NOISY` and offset for `BW_CODE_CALIBRATION_OUT_OF_BAND`, counts;
  // number of samples for `BW_CODE_CALIBRATION_TOO_FEW`; 0 for `BW_CODE_CALIBRATION_STUCK`.
  float value;
} BwRefusedOffset;

// What a wiring must be like.
typedef struct BwWiringLimits {
  // Least root mean square of the current vector, A; several times the noise of the sensors.
  float least_current_a;
  // Largest error of the electrical offset, rad.
  float offset_rad;
  // Largest delay between current and angle, s.
  float delay_s;
  // Largest relative difference of velocity and motion of the angle.
  float velocity_tolerance;
  // Velocity below which it is not compared with the angle, rad/s.
  float slowest_rad_s;
} BwWiringLimits;

// The wiring.
typedef struct BwWiring {
  // The first fault. After a remedy check again.
  BwWiringFault fault;
  // The value that `BwWiringFault` names, NaN if it names none.
  float value;
  // How well the current turns with the shaft, 1 at best. NaN, like what follows, if there is a fault.
  float coherence;
  // Error of the electrical offset, rad.
  float offset_rad;
  // Delay of the current behind the angle, s; NaN if the shaft turned one way only.
  float delay_s;
  // Integral of the velocity over motion of the angle; NaN without a velocity: then its sign, its unit and the
  // control rate are not checked.
  float velocity_ratio;
} BwWiring;

// Sends the `size` bytes of a data frame under the identifier of the stream; returns 0 if the bus has taken them.
typedef int32_t (*BwCanSend)(void *context, const uint8_t *data, size_t size);

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

#if defined(BEARING_WATCH_SIGNATURE)
// Checks the model that these bytes start with and the signature of `bearing-watch sign` behind it, before `bw_init`;
// what follows both, such as the erased rest of a flash sector, is ignored. `keys` are the public keys that may sign,
// as `bearing-watch sign --key FILE` prints them; without one everything is refused. `least_counter` is the counter of
// the newest model that has run: keep it where an attacker cannot write it back. The bytes must not change until
// `bw_init` has read them. A library that was built without the feature `signature` does not have this function;
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
BW_MUST_CHECK BwCode bw_init(void *memory, size_t size, const uint8_t *model, size_t length, struct BwState **state);

// Makes a state with the model that the library was built with (`BEARING_WATCH_PLAN=model.rs`), whose `BW_MODEL_ID`
// is `id`, and gives its address in `state`. Nothing is read or checked when it runs: the compiler has done that. It
// needs less memory than `bw_init`, little stack, and half of the flash.
//
// Returns `BW_CODE_OK`, `BW_CODE_MODEL_DOES_NOT_FIT` if the library was built with another model or with none, or what
// is wrong with the memory.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the state is used no more. `state` is
// NULL or writable. No other function works on the state.
BW_MUST_CHECK BwCode bw_init_own(void *memory, size_t size, uint32_t id, struct BwState **state);

// Takes one sample in the sampling interrupt, in time that hardly depends on the data. `values` are the channels in
// the order of the model, in the unit that each name says; `angle` is the shaft's (`bw_angle`), 0 if the model needs
// none. Bad values, such as NaN, are counted and left out.
//
// Returns `BW_CODE_OK`; `BW_CODE_SEGMENT` with the sample that closes a segment, which the main loop then concludes by
// `bw_advance` or `bw_conclude`; `BW_CODE_SEGMENT_LOST` if it has not done so with the segment before; or
// `BW_CODE_BUSY` if the interrupt came during `bw_adopt`, `bw_discard`, `bw_restart`, `bw_pending`, `bw_step` or
// `bw_reset`. The sample is then lost, and counts as one with bad values.
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
// power-up of the motor. Samples that wait for `bw_collect_waiting` are dropped; a closed segment, report and alarm
// remain. In the interrupt, or with the interrupt masked; that of `bw_put` is masked or stopped too.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_restart(struct BwState *state);

// Discards what the open segment has taken, which was found to be wrong after it was taken: `found_late` of
// `BwCleanSample`. The segment closes where it would have, and has a verdict if half of it follows this call and is
// usable. `before_in_doubt` gets 1 if less than half of the segment had passed: the fault may have begun in the
// segment before; NULL if that is not wanted. The report of that segment is then withdrawn: it is undetermined by
// `BW_REASON_FOUND_LATE`, and the alarm is as if it had been from the start, also if it had been given before. In the
// interrupt, or with the interrupt masked.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `before_in_doubt` is NULL or writable.
BwCode bw_discard(struct BwState *state, uint8_t *before_in_doubt);

// Gives the number of samples in the open segment, after averaging. In the interrupt, or with the interrupt masked.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `samples` is NULL or writable.
BwCode bw_pending(struct BwState *state, uint32_t *samples);

// Puts a sample into a queue of four in the interrupt of the current loop, for `bw_collect_waiting` in an interrupt
// below it, which may come up to three samples late. `values` and `angle` are those of `bw_collect`; `found_late` is
// that of `BwCleanSample`.
//
// Returns `BW_CODE_OK`, `BW_CODE_WRONG_CHANNEL_COUNT`, or `BW_CODE_SAMPLE_LOST` if four samples wait: this one then
// counts as one with bad values. Request the interrupt below after both `BW_CODE_OK` and `BW_CODE_SAMPLE_LOST`, or a
// full queue stays full.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `values` is NULL or has `count` readable
// values. Only one context calls this function.
BwCode bw_put(struct BwState *state, const float *values, size_t count, uint32_t angle, bool found_late);

// Takes all samples that wait, as `bw_collect` and `bw_discard` do, in an interrupt below the current loop or in the
// same one. The first call tests the arithmetic of its context (`bw_known_answer_test`): call it once before the power
// stage is on. If the test fails, the samples stay, and no segment closes.
//
// Returns `BW_CODE_OK`, `BW_CODE_SEGMENT` or `BW_CODE_SEGMENT_LOST` as `bw_collect` does, `BW_CODE_ARITHMETIC`, or
// `BW_CODE_BUSY` if it interrupted `bw_adopt`, `bw_restart` or the like: the samples then wait for the next call.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. Only one context calls this function.
BwCode bw_collect_waiting(struct BwState *state);

// Returns the angle of a converter with `resolution_bits` bits a turn as the fraction of a turn that `bw_collect`
// takes: 2^32 is one turn.
uint32_t bw_angle(uint32_t counts, uint32_t resolution_bits);

// Returns the angle of an encoder with `counts_per_turn` counts a turn, four times its lines, as `bw_angle` does. The
// counter may count on over turns in both directions, or be reset at each. 0 if a turn has no counts, or more than
// 2^24 - 1.
uint32_t bw_angle_from_cpr(int32_t counts, uint32_t counts_per_turn);

// Does the next step of the solve of the closed segment, of bounded cost; call it again and again in the main loop.
// The first step takes the segment, so that the interrupt can close the next one. The alarm takes account of the
// report, unless `bw_discard` has withdrawn it.
//
// Returns `BW_CODE_OK` if there is more to do, `BW_CODE_REPORT` with the last step, or `BW_CODE_IDLE` if there is no
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

// Makes the estimate of the report the auxiliary model of instrumental variables; other models need no call. It must
// come before `handover` samples (`bw_info`) of the next segment have been taken, with the interrupt masked. A model
// whose `handover` is 0 adopts by `bw_step` only.
//
// Returns `BW_CODE_OK`, `BW_CODE_NOT_ADOPTED`, or `BW_CODE_NO_REPORT`.
//
// # Safety
// As `bw_advance`.
BwCode bw_adopt(struct BwState *state);

// Compares what was done so far with a clock, in milliseconds, which the timer of the samples does not make. `samples`
// is the number of samples that `bw_put` or `bw_collect` was given; both may wrap. Call it in the main loop, as often as
// you like, from the end of a commissioning on: the times count from the first call, and anew from `bw_restart`.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the interval of the model is not known, `BW_CODE_BUSY`, or why the
// drive is not watched as it should be, each reason once until it is right again: `BW_CODE_NO_SAMPLE`,
// `BW_CODE_NOT_COLLECTED` or `BW_CODE_ARITHMETIC` if no sample was taken for three seconds; `BW_CODE_NO_SEGMENT` if no
// segment has closed for three of its durations and three seconds; `BW_CODE_NO_VERDICT` if none has had a verdict for 24
// hours; `BW_CODE_WRONG_RATE` if over ten seconds samples did not come at the rate of the model, to two per cent. While
// they do not, no segment has a verdict (`BW_REASON_IMPLAUSIBLE`), and what the first ten seconds have added to the
// alarm is taken out again. Rows that come twice, held or interpolated, are found by nothing else.
//
// # Safety
// As `bw_advance`.
BW_MUST_CHECK
BwCode bw_clock(struct BwState *state,
                uint32_t samples,
                uint32_t milliseconds);

// Sets other times than those of `bw_clock`, within which samples, segments and verdicts must come, in seconds;
// `INFINITY` for never. The times count anew.
//
// # Safety
// As `bw_advance`.
BwCode bw_limit_liveness(struct BwState *state, float sample_s, float segment_s, float verdict_s);

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

// Sets how long verdicts may be missing before `bw_alarm` calls the diagnosis lost: a number of segments in a row, and
// hours by the sampling interval of the model; 0 for no such limit. `bw_init` sets 10000 segments and 24 hours.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the hours are negative or not a number, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_limit_silence(struct BwState *state, uint32_t segments, float hours);

// Ends a run (from power-up to power-up, a session), whose segments depend on each other. Call it at power-down or
// where a session ends, unless the model was trained with `--segments-a-run`. A segment that is being solved is
// concluded first, and belongs to the run; `bw_discard` withdraws no report after it.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_end_run(struct BwState *state);

// Denies the alarm, because the bearing was inspected and is sound: scores start afresh, and what raised the alarm
// must be 1.5 times as large to raise the next one, for three alarms at most. `BW_CODE_IDLE` without an alarm.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_deny(struct BwState *state);

// Starts afresh, as after a repair: open and closed segment, report, alarm and scores. With the interrupt
// masked. `BW_CODE_BUSY` if another function works on the state; nothing is then changed.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_reset(struct BwState *state);

// Gives what a direction of the model contributes to the alarm at the end of the last run. Directions count from 0.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `contribution` is NULL or writable.
BwCode bw_contribution(struct BwState *state, uint8_t direction, struct BwContribution *contribution);

// Gives the size of a defect in a direction of the model, its slope, and the time until a single segment would show
// it: four standard deviations of segments of healthy drives. Directions count from 0.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `growth` is NULL or writable.
BwCode bw_growth(struct BwState *state, uint8_t direction, struct BwGrowth *growth);

// As `bw_growth`, until another named size, such as that of a known full defect: standard deviations of a usual run.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction or the size is not above 0 and
// finite, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `growth` is NULL or writable.
BwCode bw_growth_to(struct BwState *state, uint8_t direction, float size, struct BwGrowth *growth);

// Gives the number of bytes that `bw_save` writes for the model of this state.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `length` is NULL or writable.
BwCode bw_saved_size(const struct BwState *state, size_t *length);

// Writes alarm and scores into `bytes`, to be stored where they survive power-off. Call `bw_end_run` before, at
// power-down where a run is from power-up to power-up. The open segment is not saved.
//
// Returns `BW_CODE_OK`, `BW_CODE_BUFFER_TOO_SMALL` if `capacity` is less than `bw_saved_size` gives, or
// `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `bytes` is NULL or has `capacity` writable
// bytes.
BW_MUST_CHECK BwCode bw_save(struct BwState *state, uint8_t *bytes, size_t capacity);

// Continues from the alarm and scores that `bw_save` wrote, for this model; there is no report then, and a
// segment that was being solved is left out. In case of an error nothing changes.
//
// Returns `BW_CODE_OK`, `BW_CODE_SAVED_STATE` if the bytes are not a saved state of this version or are corrupted,
// `BW_CODE_OTHER_MODEL` if they are that of another model, or `BW_CODE_BUSY`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `bytes` is NULL or has `length` readable
// bytes.
BW_MUST_CHECK BwCode bw_restore(struct BwState *state, const uint8_t *bytes, size_t length);

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
BwCode bw_flash_save(const struct BwFlash *flash, struct BwState *state, uint8_t *buffer, size_t size);

// Continues from the newest good record of this model in flash, as `bw_restore` does, and from the one before if the
// newest is damaged or of another model. `buffer` has room for `bw_saved_size` bytes.
//
// Returns `BW_CODE_OK`, `BW_CODE_FLASH_NO_RECORD` if there is none, what `bw_restore` returns of the newest record, or
// `BW_CODE_FLASH_…`.
//
// # Safety
// As for `bw_flash_save`.
BwCode bw_flash_restore(const struct BwFlash *flash, struct BwState *state, uint8_t *buffer, size_t size);

// Stores the bytes of a model, with what follows it such as a signature, in the place of the older one.
//
// Returns `BW_CODE_OK`, or `BW_CODE_FLASH_…`.
//
// # Safety
// `flash` is NULL or readable, and its functions keep what `BwFlash` says. `model` is NULL or has `length` readable
// bytes.
BwCode bw_flash_store_model(const struct BwFlash *flash, const uint8_t *model, size_t length);

// Reads the newest good model of a flash into `buffer`, for `bw_init`, and gives the number of its bytes.
//
// Returns `BW_CODE_OK`, `BW_CODE_FLASH_NO_RECORD`, `BW_CODE_BUFFER_TOO_SMALL`, or another `BW_CODE_FLASH_…`.
//
// # Safety
// As for `bw_flash_store_model`, with `size` writable bytes at `buffer`. `length` is NULL or writable.
BwCode bw_flash_load_model(const struct BwFlash *flash, uint8_t *buffer, size_t size, size_t *length);

// Returns the number of bytes of memory that `bw_front_end_init` needs: with a plan of its own a library needs less.
size_t bw_front_end_size(void);

// Makes a front end without samples in memory of the caller, and gives its address in `front_end`. The constants are
// not needed afterwards. In case of an error the memory is unchanged. A front end can be initialised again, to start
// afresh, while no other function works on it.
//
// Returns `BW_CODE_OK`, or what is wrong with memory or constants: `BW_CODE_FRONT_END_…`, or `BW_CODE_OUT_OF_RANGE` for
// `park`.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the front end is used no more.
// `constants` is NULL or readable. `front_end` is NULL or writable. No other function works on the front end.
BW_MUST_CHECK
BwCode bw_front_end_init(void *memory,
                         size_t size,
                         const struct BwFrontEndConstants *constants,
                         struct BwFrontEnd **front_end);

// Takes a raw sample in the interrupt of the control loop. `further` are the further channels in their order and units,
// NaN if missing; it may be NULL if `count`, their number, is 0. One in `factor` calls gives a clean sample once the
// filters are filled: pass it to `bw_collect`. Wrong counts, angles and values are counted, and are missing from the
// clean samples: their channels are NaN.
//
// Returns `BW_CODE_OK`; `BW_CODE_CLEAN_SAMPLE` if `clean` was written; `BW_CODE_WRONG_CHANNEL_COUNT`;
// `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is; or `BW_CODE_BUSY` if the interrupt came during
// another function of this front end. A sample that is not taken is a gap in the numbers.
//
// # Safety
// `front_end` is NULL, or was given by `bw_front_end_init` or has as many readable bytes. `raw` is NULL or readable.
// `further` is NULL or has `count` readable values. `clean` is NULL or writable.
BwCode bw_front_end_push(struct BwFrontEnd *front_end,
                         const struct BwRawSample *raw,
                         const float *further,
                         size_t count,
                         struct BwCleanSample *clean);

// Takes a raw sample at commissioning, for a check of the wiring instead of the filters. `velocity_rad_s` is one of the
// drive's own, NaN if there is none.
//
// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is, or `BW_CODE_BUSY`.
//
// # Safety
// `front_end` is NULL, or was given by `bw_front_end_init` or has as many readable bytes; likewise `wiring` by
// `bw_wiring_init`. `raw` is NULL or readable.
BwCode bw_front_end_check_wiring(struct BwFrontEnd *front_end,
                                 const struct BwRawSample *raw,
                                 float velocity_rad_s,
                                 struct BwWiringCheck *wiring);

// Checks that a front end gives samples like those on which the model was trained: the interval, to 1 %, and the sign
// convention of the quadrature current. From here on no segment has a verdict before `bw_tell_alignment` has said what
// the front end knows of the wiring (`BW_REASON_IMPLAUSIBLE`).
//
// Returns `BW_CODE_OK`, also if the model does not say, `BW_CODE_MODEL_INTERVAL`, `BW_CODE_MODEL_PARK`, or what is wrong
// with the constants.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `constants` is NULL or readable.
BwCode bw_check_front_end(const struct BwState *state,
                          const struct BwFrontEndConstants *constants);

// Says whether the currents turn with the rotor, `BW_ALIGNMENT_…`, as each `BwCleanSample` has it: while that is not
// decided, and where they do not, no segment has a verdict (`BW_REASON_IMPLAUSIBLE`). In any context.
//
// Returns `BW_CODE_OK`, or `BW_CODE_OUT_OF_RANGE`.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
BwCode bw_tell_alignment(const struct BwState *state, uint8_t alignment);

// Gives what was refused, and what is wrong now. In the interrupt, or with the interrupt masked.
//
// # Safety
// `front_end` is NULL, or was given by `bw_front_end_init` or has as many readable bytes. `faults` is NULL or
// writable.
BwCode bw_front_end_faults(struct BwFrontEnd *front_end, struct BwFrontEndFaults *faults);

// Counts refusals from zero; what is wrong now stays. In the interrupt, or with the interrupt masked.
//
// # Safety
// `front_end` is NULL, or was given by `bw_front_end_init` or has as many readable bytes.
BwCode bw_front_end_clear_faults(struct BwFrontEnd *front_end);

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

// Puts the measured offsets into constants of a front end; a third phase that was never sampled keeps its own. If one is
// refused, the constants are unchanged, and `refused` names the first one.
//
// Returns `BW_CODE_OK`, `BW_CODE_CALIBRATION_…`, or `BW_CODE_BUSY`.
//
// # Safety
// `calibration` is NULL, or was given by `bw_calibration_init` or has as many readable bytes. `constants` is NULL, or
// readable and writable. `refused` is NULL or writable.
BwCode bw_calibration_finish(struct BwCalibration *calibration,
                             struct BwFrontEndConstants *constants,
                             struct BwRefusedOffset *refused);

// Makes a check without samples in memory of the caller, and gives its address in `wiring`. Feed it by
// `bw_front_end_check_wiring` while the drive moves under current control by a turn or more, best to and fro.
//
// Returns `BW_CODE_OK`, or what is wrong with memory or constants.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the check is used no more.
// `constants` and `limits` are NULL or readable. `wiring` is NULL or writable. No other function works on the check.
BwCode bw_wiring_init(void *memory,
                      size_t size,
                      const struct BwFrontEndConstants *constants,
                      const struct BwWiringLimits *limits,
                      struct BwWiringCheck **wiring);

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
// is NULL, or was given by `bw_init` or has as many readable bytes. `recorder` is NULL or writable. No other function
// works on the recorder.
BwCode bw_recorder_init(void *memory, size_t size, const struct BwState *state, struct BwRecorder **recorder);

// Takes a sample as `bw_collect` takes it, in the same interrupt. A complete block waits for `bw_telemetry_samples` in
// the main loop, while the next one is filled.
//
// Returns `BW_CODE_OK`; `BW_CODE_BLOCK` if a complete block waits now; `BW_CODE_RECORDER_FULL` if two blocks are
// complete: the sample is not recorded, and the receiver sees a gap; `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_BUSY`.
//
// # Safety
// `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes. `values` is NULL or has
// `count` readable values.
BwCode bw_recorder_push(struct BwRecorder *recorder, const float *values, size_t count, uint32_t angle);

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

// Takes a raw sample as `bw_front_end_push` takes it, in the same interrupt. A complete block waits for
// `bw_telemetry_raw` in the main loop, while the next one is filled.
//
// Returns `BW_CODE_OK`; `BW_CODE_BLOCK` if a complete block waits now; `BW_CODE_RECORDER_FULL` if two blocks are
// complete: the sample is not recorded, and the receiver sees a gap; `BW_CODE_WRONG_CHANNEL_COUNT`;
// `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is; or `BW_CODE_BUSY`.
//
// # Safety
// `recorder` is NULL, or was given by `bw_raw_recorder_init` or has as many readable bytes. `raw` is NULL or readable.
// `further` is NULL or has `count` readable values.
BwCode bw_raw_recorder_push(struct BwRawRecorder *recorder,
                            const struct BwRawSample *raw,
                            const float *further,
                            size_t count);

// Makes a line without frames in memory of the caller, and gives its address in `telemetry`. With a `state` it sends
// its reports and samples, and raw samples; without one, NULL, raw samples only. `model_id` is any number that
// identifies the model, such as `BW_MODEL_ID`; `session` is one that changes with each power-up, such as a count of
// them. After another `bw_init` of the state the line has to be initialised again, too.
//
// # Safety
// `memory` is NULL or has `size` writable bytes, which nothing else writes until the line is used no more. `state` is
// NULL, or was given by `bw_init` or has as many readable bytes, and is there as long as the line. `telemetry` is NULL
// or writable. No other function works on the line.
BwCode bw_telemetry_init(void *memory,
                         size_t size,
                         const struct BwState *state,
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
// `BW_CODE_REPORT`, under any identifier, and again if `bw_discard` has withdrawn the report. `bearing-watch dbc`
// writes the DBC file of the frame, and `bearing-watch listen --can-id` reads it from logs.
//
// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, or `BW_CODE_BUSY`; the bytes are then as before.
//
// # Safety
// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `frame` is NULL or has
// `BW_CAN_FRAME_SIZE` writable bytes.
BwCode bw_can_frame(struct BwState *state, uint8_t *frame);

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

// Returns the word for a verdict of `BwVerdict`, such as "novel"; for a class `bw_label` gives its name. "unknown" for
// other numbers. Never NULL, ends in a zero byte.
const char *bw_verdict_name(int32_t verdict);

// Returns a text for a reason of `BwReason`; `place`, `part` and `reason_rows` of the report say which one and how
// many. "unknown" for other numbers. Never NULL, ends in a zero byte.
const char *bw_reason_name(int32_t reason);

// Returns the name of a code in this header, such as `BW_CODE_OK`; `bw_error_text` gives its text. "unknown" for other
// numbers. Never NULL, ends in a zero byte.
const char *bw_code_name(int32_t code);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BEARING_WATCH_H */
