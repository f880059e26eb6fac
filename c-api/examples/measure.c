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

static void init(void) { code = bw_init(memory, sizeof memory, bw_model, BW_MODEL_LENGTH, &detector); }

static void collect(void) {
    float values[BW_MODEL_CHANNELS];
    held_out_values(next_count, values);
    next_count += BW_MODEL_CHANNELS;
    code = bw_collect(detector, values, BW_MODEL_CHANNELS, 0);
}

static void advance(void) { code = bw_advance(detector); }
static void conclude(void) { code = bw_conclude(detector); }

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
    print("instructions of bw_init", instructions_of(init));
    uint32_t longest = 0, first, steps = 1, sum = 0;
    for (uint32_t k = 1; k < BW_MODEL_SEGMENT_SAMPLES; k++) {
        uint32_t own = instructions_of(collect);
        sum += own;
        longest = own > longest ? own : longest;
    }
    print("instructions of bw_collect, mean sample", sum / (BW_MODEL_SEGMENT_SAMPLES - 1));
    print("instructions of bw_collect, longest sample", longest);
    print("instructions of bw_collect, the sample that closes a segment", instructions_of(collect));
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
    print("stack of bw_collect, the sample that closes a segment", stack_of(collect));
    print("instructions of bw_conclude", instructions_of(conclude));
    next_count = held_out_start;
    fill();
    collect();
    print("stack of bw_conclude", stack_of(conclude));
    print("stack of bw_collect, a sample inside a segment", stack_of(collect));
    print("stack of bw_init", stack_of(init));
    return code == BW_CODE_OK ? 0 : 1;
}
