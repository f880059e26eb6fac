/* The library on a host: classes of recorded traces, as counts of a converter that spans the limits of the channels.
 *
 *     records < held_out.bin          16-bit counts, one a channel and sample, of traces of one segment each
 *
 * `cargo xtask release` builds it by pkg-config and by CMake from the unpacked archive of the library, and compares its
 * lines with those of the Rust example `monitor`. */
#include "bearing_watch_service.h"
#include "model.h"
#include "print.h"

static uint64_t memory[BW_STATE_SIZE / sizeof(uint64_t)]; /* uint64_t: aligned to BW_STATE_ALIGN */

int main(void) {
    static const char *const verdicts[] = {"class", "novel", "ambiguous", "undetermined"};
    static const float limits[BW_MODEL_CHANNELS] = BW_MODEL_CHANNEL_LIMITS;
    unsigned char bytes[2 * BW_MODEL_CHANNELS];
    float values[BW_MODEL_CHANNELS];
    BwState *detector;
    BwCode code = bw_start(memory, sizeof memory, bw_model, BW_MODEL_LENGTH, NULL, &detector);
    if (code < 0) {
        return failed("bw_start", code);
    }
    while (fread(bytes, sizeof bytes, 1, stdin) == 1) {
        for (size_t k = 0; k < BW_MODEL_CHANNELS; k++) {
            unsigned count = bytes[2 * k] | (unsigned)bytes[2 * k + 1] << 8;
            values[k] = ((float)count - (count < 32768u ? 0.0f : 65536.0f)) * (limits[k] / 32768.0f);
        }
        code = bw_sample(detector, values, BW_MODEL_CHANNELS, 0);
        if (code < 0) {
            return failed("bw_sample", code);
        }
        if (bw_collect(detector) == BW_CODE_SEGMENT) {
            while ((code = bw_advance(detector, NULL, NULL)) == BW_CODE_OK) {
            }
        }
        if (code == BW_CODE_REPORT) {
            BwReport report;
            char label[17];
            bw_report(detector, &report);
            bw_label(detector, report.class_index, label, sizeof label);
            printf("verdict: %s\n", report.verdict == BW_VERDICT_CLASS ? label : verdicts[report.verdict]);
            bw_restart(detector); /* the next trace does not continue from this one */
        }
    }
    return 0;
}
