/* Instructions and stack of recorders and frames: samples of the model, and raw samples of three currents, an absolute
 * angle and two further channels. `cargo xtask c` prints the lines. */
#include "bearing_watch_service.h"
#include "board.h"
#include "count.h"
#include "model.h"

/* Samples that are counted. */
#define COUNTED 1000u

static uint64_t detector_memory[BW_STATE_SIZE / sizeof(uint64_t)];
static uint64_t line_memory[BW_TELEMETRY_SIZE / sizeof(uint64_t)];
static uint64_t recorder_memory[BW_RECORDER_SIZE / sizeof(uint64_t)];
static uint64_t raw_memory[BW_RAW_RECORDER_SIZE / sizeof(uint64_t)];
static BwState *detector;
static BwTelemetry *line;
static BwRecorder *recorder;
static BwRawRecorder *raw_recorder;
static BwRawSample raw;
static uint8_t frame[BW_FRAME_SIZE];
static size_t length;
static BwCode code;

void SysTick_Handler(void) {}

static void hello(void) { code = bw_telemetry_hello(line, frame, sizeof frame, &length); }
static void samples(void) { code = bw_telemetry_samples(line, recorder, frame, sizeof frame, &length); }
static void raw_samples(void) { code = bw_telemetry_raw(line, raw_recorder, frame, sizeof frame, &length); }

static void push(void) {
    static const float values[BW_MODEL_CHANNELS] = {0.5f};
    code = bw_recorder_push(recorder, values, BW_MODEL_CHANNELS, 0);
}

static void push_raw(void) {
    static const float further[2] = {0.5f, 0.1f};
    raw.number = raw.number + 1;
    code = bw_raw_recorder_push(raw_recorder, &raw, further, 2);
}

/* Pushes; each complete block is sent. */
static void count(void (*function)(void), void (*send)(void), const char *const names[4]) {
    uint32_t longest = 0, sum = 0, of_frame = 0;
    for (uint32_t k = 0; k < COUNTED; k++) {
        uint32_t own = instructions_of(function);
        sum += own;
        longest = own > longest ? own : longest;
        if (code == BW_CODE_BLOCK) {
            of_frame = instructions_of(send);
        }
    }
    print(names[0], sum / COUNTED);
    print(names[1], longest);
    print(names[2], of_frame);
    print(names[3], (uint32_t)length);
}

int main(void) {
    static const char *const of_samples[4] = {
        "instructions of bw_recorder_push, mean", "instructions of bw_recorder_push, longest",
        "instructions of bw_telemetry_samples", "bytes of its frame"};
    static const char *const of_raw[4] = {
        "instructions of bw_raw_recorder_push, mean", "instructions of bw_raw_recorder_push, longest",
        "instructions of bw_telemetry_raw", "bytes of its frame"};
    start_counting();
    raw.phases = 3;
    raw.position = BW_POSITION_ABSOLUTE;
    if (bw_start(detector_memory, sizeof detector_memory, bw_model, BW_MODEL_LENGTH, NULL, &detector) != BW_CODE_OK) {
        return 1;
    }
    bw_telemetry_init(line_memory, sizeof line_memory, detector, BW_MODEL_ID, 1, &line);
    bw_recorder_init(recorder_memory, sizeof recorder_memory, detector, &recorder);
    bw_raw_recorder_init(raw_memory, sizeof raw_memory, 10000.0f, 2, &raw_recorder);
    count(push, samples, of_samples);
    count(push_raw, raw_samples, of_raw);
    print("instructions of bw_telemetry_hello", instructions_of(hello));
    print("stack of bw_recorder_push", stack_of(push));
    print("stack of bw_raw_recorder_push", stack_of(push_raw));
    print("stack of bw_telemetry_hello", stack_of(hello));
    return code == BW_CODE_OK ? 0 : 1;
}
