/* Instructions and stack of the functions of the front end: three currents, an absolute angle, and the further channels
 * and the factor of the model. `cargo xtask c` prints the lines. */
#include "bearing_watch.h"
#include "board.h"
#include "count.h"
#include "model.h"

/* Samples before the filters and the loop have settled, and samples that are counted. */
#define SETTLE 1000u
#define COUNTED 1000u
/* A turn of the shaft in 128 samples. */
#define SPEED (1u << 25)

static uint64_t memory[BW_FRONT_END_SIZE / sizeof(uint64_t)];
static uint64_t state_memory[BW_STATE_SIZE / sizeof(uint64_t)];
static BwFrontEnd *front_end;
static BwState *state;
static BwRawSample raw;
static const float further[BW_FRONT_END_FURTHER] = {0.5f};
static BwCode code;

void SysTick_Handler(void) {}

static void init(void) { code = bw_front_end_init(memory, sizeof memory, &bw_front_end, &front_end); }

static void push(void) { code = bw_sample_raw(state, &raw, further, BW_FRONT_END_FURTHER); }

/* The next sample: balanced currents that change, at constant velocity. */
static void next(void) {
    uint16_t ripple = (uint16_t)(raw.number % 50u);
    raw.number = raw.number + 1;
    raw.angle = raw.angle + SPEED;
    raw.counts[0] = (uint16_t)(2048u + 2u * ripple);
    raw.counts[1] = raw.counts[2] = (uint16_t)(2048u - ripple);
}

int main(void) {
    start_counting();
    raw.phases = 3;
    raw.position = BW_POSITION_ABSOLUTE;
    print("bytes of the front end", (uint32_t)bw_front_end_size());
    print("instructions of bw_front_end_init", instructions_of(init));
    code = bw_start(state_memory, sizeof state_memory, bw_model, BW_MODEL_LENGTH, front_end, &state);
    if (code != BW_CODE_OK) {
        return 1;
    }
    for (uint32_t k = 0; k < SETTLE; k++) {
        next();
        push();
        bw_collect(state);
    }
    uint32_t longest = 0, sum = 0, outputs = 0;
    for (uint32_t k = 0; k < COUNTED; k++) {
        next();
        uint32_t own = instructions_of(push);
        sum += own;
        longest = own > longest ? own : longest;
        outputs += code == BW_CODE_COLLECT;
        bw_collect(state);
    }
    print("instructions of bw_sample_raw, mean", sum / COUNTED);
    print("instructions of bw_sample_raw, longest", longest);
    next();
    print("stack of bw_sample_raw", stack_of(push));
    print("stack of bw_front_end_init", stack_of(init));
    return outputs == COUNTED / BW_FRONT_END_FACTOR && code == BW_CODE_OK ? 0 : 1;
}
