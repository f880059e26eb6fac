/* Interrupt and main loop of a drive: the interrupt collects samples, the main loop solves closed segments in steps.
 *
 * The samples are recorded traces of the simulated standard rig, as counts of a converter; the model is trained for
 * them (`bearing-watch train --c model.h`). `cargo xtask c` builds this file as C and as C++, runs it in QEMU, and
 * compares every line with what the Rust example `monitor` prints on the host. */
#include "bearing_watch_service.h"
#include "board.h"
#include "held_out.h"
#include "model.h"
#include "print.h"

/* Ticks between two samples: 3 ms at 168 MHz, in which the emulator executes 11700 instructions. */
#define SAMPLING_TICKS 504000u

static const char *const names[BW_MODEL_CHANNELS] = BW_MODEL_CHANNEL_NAMES;
static const char *const units[BW_MODEL_CHANNELS] = BW_MODEL_CHANNEL_UNITS;

/* The state of the detector; uint64_t aligns it. */
static uint64_t memory[BW_STATE_SIZE / sizeof(uint64_t)];
static BwState *detector;

static const int16_t *volatile next_count = held_out_start;
static volatile uint32_t samples, last_sample, behind;
static volatile BwCode failure = BW_CODE_OK;

void SysTick_Handler(void) {
    float values[BW_MODEL_CHANNELS];
    if (next_count >= held_out_end) {
        /* A closed segment that the main loop could not be given, because it looked for one, comes with the next call. */
        bw_collect(detector);
        behind = behind + 1;
        return;
    }
    held_out_values(next_count, values);
    next_count += BW_MODEL_CHANNELS;
    samples = samples + 1;
    BwCode code = bw_sample(detector, values, BW_MODEL_CHANNELS, 0);
    if (code == BW_CODE_COLLECT) {
        code = bw_collect(detector); /* a drive may do so in an interrupt below this one */
    }
    if (samples % BW_MODEL_SEGMENT_SAMPLES == 0) {
        last_sample = samples;
        /* The next recorded trace does not continue from this one. A running drive would not restart. */
        bw_restart(detector);
    }
    if (code < 0) {
        failure = code;
    }
}

static void print_report(void) {
    static const char *const verdicts[] = {"class", "novel", "ambiguous", "undetermined"};
    BwReport report;
    float parameters[BW_MAX_PARAMETERS], likelihoods[BW_MAX_CLASSES], posteriors[BW_MAX_CLASSES];
    size_t count = 0;
    char label[17];
    bw_report(detector, &report);
    printf("segment ending at sample %lu\n", (unsigned long)last_sample);
    bw_values(detector, BW_VALUES_PARAMETERS, parameters, BW_MAX_PARAMETERS, &count);
    for (size_t k = 0; k < count; k++) {
        printf("  parameter %u  %08lx\n", (unsigned)k, bits(parameters[k]));
    }
    bw_values(detector, BW_VALUES_POSTERIORS, posteriors, BW_MAX_CLASSES, &count);
    bw_values(detector, BW_VALUES_LOG_LIKELIHOODS, likelihoods, BW_MAX_CLASSES, &count);
    for (size_t k = 0; k < count; k++) {
        bw_label(detector, (uint8_t)k, label, sizeof label);
        printf("  %-10s log-likelihood %08lx, posterior %08lx\n", label, bits(likelihoods[k]), bits(posteriors[k]));
    }
    bw_label(detector, report.class_index, label, sizeof label);
    printf("verdict: %s\n", report.verdict == BW_VERDICT_CLASS ? label : verdicts[report.verdict]);
}

int main(void) {
    BwCode code = bw_start(memory, sizeof memory, bw_model, BW_MODEL_LENGTH, NULL, &detector);
    if (code < 0) {
        return failed("bw_start", code);
    }
    /* A model that is read from a flash sector may be newer than this program: check what it wants. */
    for (uint8_t k = 0; k < BW_MODEL_CHANNELS; k++) {
        code = bw_check_channel(detector, k, names[k], units[k]);
        if (code < 0) {
            return failed(names[k], code);
        }
    }
    code = bw_check_interval(detector, 0.002f);
    if (code < 0) {
        return failed("sampling", code);
    }

    board_start_sampling(SAMPLING_TICKS);
    for (;;) {
        if (failure != BW_CODE_OK) {
            return failed("sampling", failure);
        }
        /* Asked before the next step: the last segment is closed by then. */
        int ended = behind > 1;
        code = bw_advance(detector, NULL, NULL);
        if (code < 0) {
            return failed("bw_advance", code);
        }
        if (code == BW_CODE_REPORT) {
            print_report();
        } else if (code == BW_CODE_IDLE && ended) {
            return 0;
        }
        /* The other work of the main loop. */
    }
}
