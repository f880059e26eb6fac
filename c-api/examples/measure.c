/* Instructions and stack of the C functions, counted by the emulator. It executes one instruction in 256 ns of its
 * time, which are 43.008 ticks of the core's clock of 168 MHz. `cargo xtask c` prints the lines. */
#include "bearing_watch.h"
#include "board.h"
#include "model.h"

#include <stdint.h>
#include <stdio.h>

#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)
#define LARGEST_COUNT 0xFFFFFFu

/* Words of stack that are painted, and words next to the stack pointer that the painting itself uses. */
#define PAINTED 20000
#define OWN 32
#define PAINT 0xA5A5A5A5u

extern const int16_t held_out_start[];

static const float limits[BW_MODEL_CHANNELS] = BW_MODEL_CHANNEL_LIMITS;
static uint64_t memory[BW_STATE_SIZE / sizeof(uint64_t)];
static BwState *detector;
static const int16_t *next_count;
static BwCode code;

void SysTick_Handler(void) {}

static uint32_t instructions_since(uint32_t start) {
    uint32_t ticks = (start - SYST_CVR) & LARGEST_COUNT;
    return (uint32_t)((uint64_t)ticks * 1000u / 43008u);
}

static void init(void) { code = bw_init(memory, sizeof memory, bw_model, BW_MODEL_LENGTH, &detector); }

static void collect(void) {
    float values[BW_MODEL_CHANNELS];
    for (size_t k = 0; k < BW_MODEL_CHANNELS; k++) {
        values[k] = (float)*next_count++ * (limits[k] / 32768.0f);
    }
    code = bw_collect(detector, values, BW_MODEL_CHANNELS, 0);
}

static void advance(void) { code = bw_advance(detector); }
static void conclude(void) { code = bw_conclude(detector); }

/* Bytes of stack that a function takes. */
static __attribute__((noinline)) uint32_t stack_of(void (*function)(void)) {
    /* By the register: the compiler knows the bounds of a variable. */
    volatile uint32_t *top;
    __asm__ volatile("mov %0, sp" : "=r"(top));
    uint32_t deepest = OWN;
    for (uint32_t k = OWN; k < PAINTED; k++) {
        *(top - k) = PAINT;
    }
    function();
    for (uint32_t k = OWN; k < PAINTED; k++) {
        if (*(top - k) != PAINT) {
            deepest = k;
        }
    }
    return 4u * deepest;
}

/* Instructions of a call. */
static uint32_t instructions_of(void (*function)(void)) {
    uint32_t start = SYST_CVR;
    function();
    return instructions_since(start);
}

static void print(const char *what, uint32_t number) { printf("%s: %lu\n", what, (unsigned long)number); }

/* Samples up to the one that closes a segment. */
static void fill(void) {
    for (uint32_t k = 1; k < BW_MODEL_SEGMENT_SAMPLES; k++) {
        collect();
    }
}

int main(void) {
    SYST_RVR = LARGEST_COUNT;
    SYST_CVR = 0;
    SYST_CSR = 5; /* the core's clock, no interrupt, on */
    next_count = held_out_start;
    print("bytes of state", (uint32_t)bw_state_size());
    print("instructions of bw_init", instructions_of(init));
    uint32_t longest = 0, first, pieces = 1, sum = 0;
    for (uint32_t k = 1; k < BW_MODEL_SEGMENT_SAMPLES; k++) {
        uint32_t own = instructions_of(collect);
        sum += own;
        longest = own > longest ? own : longest;
    }
    print("instructions of bw_collect, mean sample", sum / (BW_MODEL_SEGMENT_SAMPLES - 1));
    print("instructions of bw_collect, longest sample", longest);
    print("instructions of bw_collect, the sample that closes a segment", instructions_of(collect));
    first = instructions_of(advance);
    for (longest = 0; code == BW_CODE_OK; pieces++) {
        uint32_t own = instructions_of(advance);
        longest = own > longest && code == BW_CODE_OK ? own : longest;
        if (code == BW_CODE_REPORT) {
            print("instructions of bw_advance, last piece", own);
        }
    }
    print("instructions of bw_advance, first piece", first);
    print("instructions of bw_advance, longest piece between", longest);
    print("number of pieces", pieces);
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
