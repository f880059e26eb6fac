/* The frames of a monitor, for `bearing-watch listen`: names of the model, samples, and reports.
 *
 * The samples are recorded traces of the simulated standard rig, as counts of a converter; the model is trained for
 * them (`bearing-watch train --c model.h`). A drive calls `sample` in its interrupt and sends frames by a serial port;
 * this program prints each frame as hexadecimal digits on a line of its own. `cargo xtask c` builds this file as C and
 * as C++, runs it in QEMU, and compares every line with what the Rust example `telemetry` prints on the host. */
#include "bearing_watch_service.h"
#include "board.h"
#include "held_out.h"
#include "model.h"
#include "print.h"

/* Samples of a recorded trace. */
#define TRACE_SAMPLES 5000u

/* Detector, line and recorder; uint64_t aligns them. */
static uint64_t detector_memory[BW_STATE_SIZE / sizeof(uint64_t)];
static uint64_t line_memory[BW_TELEMETRY_SIZE / sizeof(uint64_t)];
static uint64_t recorder_memory[BW_RECORDER_SIZE / sizeof(uint64_t)];
static BwState *detector;
static BwTelemetry *line;
static BwRecorder *recorder;

/* The frame that was written last, and its length. */
static uint8_t frame[BW_FRAME_SIZE];
static size_t length;

/* Not used: the recording stands for the interrupt. */
void SysTick_Handler(void) {}

/* A drive hands the bytes to its serial port. */
static void send(void) {
    for (size_t k = 0; k < length; k++) {
        printf("%02x", frame[k]);
    }
    printf("\n");
}

static BwCode start(void) {
    BwCode code = bw_start(detector_memory, sizeof detector_memory, bw_model, BW_MODEL_LENGTH, NULL, &detector);
    if (code >= 0) {
        /* The number of the model is BW_MODEL_ID; here it is that of the Rust example. A drive counts its power-ups. */
        code = bw_telemetry_init(line_memory, sizeof line_memory, detector, 1, 1, &line);
    }
    return code < 0 ? code : bw_recorder_init(recorder_memory, sizeof recorder_memory, detector, &recorder);
}

/* What the contexts do with a sample; returns whether it closed a segment, which was solved. */
static BwCode sample(const int16_t *counts) {
    float values[BW_MODEL_CHANNELS];
    held_out_values(counts, values);
    BwCode code = bw_sample(detector, values, BW_MODEL_CHANNELS, 0);
    if (code == BW_CODE_COLLECT) {
        code = bw_collect_recorded(detector, recorder);
    }
    if (code == BW_CODE_SEGMENT) {
        while ((code = bw_advance(detector, NULL, NULL)) == BW_CODE_OK) {
        }
    }
    return code;
}

int main(void) {
    BwCode code = start();
    if (code < 0) {
        return failed("start", code);
    }
    const int16_t *counts = held_out_start;
    for (uint32_t number = 0; counts < held_out_end; number++, counts += BW_MODEL_CHANNELS) {
        if (number % TRACE_SAMPLES == 0) {
            /* The recordings do not continue each other; a drive's samples do. */
            bw_recorder_skip(recorder, number > 0);
            if (bw_telemetry_hello(line, frame, sizeof frame, &length) == BW_CODE_OK) {
                send();
            }
        }
        code = sample(counts);
        if (code < 0) {
            return failed("sampling", code);
        }
        if (bw_telemetry_samples(line, recorder, frame, sizeof frame, &length) == BW_CODE_OK) {
            send();
        }
        if (code == BW_CODE_REPORT) {
            if (bw_telemetry_report(line, frame, sizeof frame, &length) == BW_CODE_OK) {
                send();
            }
            bw_restart(detector);
        }
    }
    return 0;
}
