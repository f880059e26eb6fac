/* Instructions and stack of the functions of the detector. `cargo xtask c` prints the lines. */
#include "bearing_watch.h"
#include "board.h"
#include "count.h"
#include "held_out.h"
#include "model.h"

static uint64_t memory[BW_STATE_SIZE / sizeof(uint64_t)];
static BwState *detector;
static const int16_t *next_count;
static BwCode code;

void SysTick_Handler(void) {}

static void init(void) { code = bw_start(memory, sizeof memory, bw_model, BW_MODEL_LENGTH, NULL, &detector); }

static void collect(void) {
    float values[BW_MODEL_CHANNELS];
    held_out_values(next_count, values);
    next_count += BW_MODEL_CHANNELS;
    bw_sample(detector, values, BW_MODEL_CHANNELS, 0);
    code = bw_collect(detector);
}

static void advance(void) { code = bw_advance(detector, NULL, NULL); }
static void conclude(void) {
    while ((code = bw_advance(detector, NULL, NULL)) == BW_CODE_OK) {
    }
}

/* Samples up to the one that closes a segment. */
static void fill(void) {
    for (uint32_t k = 1; k < BW_MODEL_SEGMENT_SAMPLES; k++) {
        collect();
    }
}

int main(void) {
    start_counting();
    next_count = held_out_start;
    print("bytes of state", (uint32_t)bw_state_size());
    print("instructions of bw_start", instructions_of(init));
    print("instructions of the first bw_collect, which tests the arithmetic", instructions_of(collect));
    uint32_t longest = 0, first, steps = 1, sum = 0;
    for (uint32_t k = 2; k < BW_MODEL_SEGMENT_SAMPLES; k++) {
        uint32_t own = instructions_of(collect);
        sum += own;
        longest = own > longest ? own : longest;
    }
    print("instructions of bw_sample and bw_collect, mean sample", sum / (BW_MODEL_SEGMENT_SAMPLES - 2));
    print("instructions of bw_sample and bw_collect, longest sample", longest);
    print("instructions of bw_sample and bw_collect, the sample that closes a segment", instructions_of(collect));
    first = instructions_of(advance);
    for (longest = 0; code == BW_CODE_OK; steps++) {
        uint32_t own = instructions_of(advance);
        longest = own > longest && code == BW_CODE_OK ? own : longest;
        if (code == BW_CODE_REPORT) {
            print("instructions of bw_advance, last step", own);
        }
    }
    print("instructions of bw_advance, first step", first);
    print("instructions of bw_advance, longest step between", longest);
    print("number of steps", steps);
    fill();
    print("stack of bw_sample and bw_collect, the sample that closes a segment", stack_of(collect));
    print("instructions of bw_advance, all steps", instructions_of(conclude));
    next_count = held_out_start;
    fill();
    collect();
    print("stack of bw_advance", stack_of(conclude));
    print("stack of bw_sample and bw_collect, a sample inside a segment", stack_of(collect));
    if (bw_stop(detector) != BW_CODE_OK) {
        return 1;
    }
    print("stack of bw_start", stack_of(init));
    return code == BW_CODE_OK ? 0 : 1;
}
