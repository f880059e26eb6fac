/* A whole drive on a recording: counts of the converters at the control rate, front end, detector, alarm.
 *
 * The recording is the file `rows.bin` of the working directory, which `bearing-watch replay --rows` writes; the model
 * was trained with `--front-end` and exported by `--c model.h`. A drive has its control interrupt where this program
 * reads a row. `cargo xtask c` builds this file as C and as C++, runs it in QEMU, and compares every line with what the
 * Rust example `drive` prints on the host. */
#include "bearing_watch.h"
#include "board.h"
#include "model.h"
#include "print.h"

/* A row of the recording, in the byte order of the chip. */
typedef struct {
    uint32_t number;
    uint16_t counts[3];
    uint16_t flags; /* 1: no position; 2: two phases */
    uint32_t angle;
    float further[BW_FRONT_END_FURTHER];
} Row;

/* The state of detector and front end; uint64_t aligns it. */
static uint64_t detector_memory[BW_STATE_SIZE / sizeof(uint64_t)];
static uint64_t front_end_memory[BW_FRONT_END_SIZE / sizeof(uint64_t)];
static BwState *detector;
static BwFrontEnd *front_end;

/* Whether the angle is known: segments start there, as they do in training. */
static bool started;
static uint32_t lost;
static BwCode failure = BW_CODE_OK;

/* The interrupt of the control loop. */
static void control_interrupt(const Row *row) {
    BwRawSample raw;
    BwCleanSample clean;
    float values[BW_MODEL_CHANNELS];
    memcpy(raw.counts, row->counts, sizeof raw.counts);
    raw.number = row->number;
    raw.phases = row->flags & 2 ? 2 : 3;
    raw.position = row->flags & 1 ? BW_POSITION_MISSING : BW_POSITION_ABSOLUTE;
    raw.angle = row->angle; /* a drive: bw_angle(resolver_counts(), BW_FRONT_END_POSITION_BITS) */
    raw.sin = raw.cos = 0.0f;
    BwCode code = bw_front_end_push(front_end, &raw, row->further, BW_FRONT_END_FURTHER, &clean);
    if (code == BW_CODE_CLEAN_SAMPLE) {
        /* Comparisons with NaN are false. */
        started = started || (clean.velocity_rad_s == clean.velocity_rad_s && clean.current_a == clean.current_a);
        if (!started) {
            return;
        }
        if (clean.found_late) {
            bw_discard(detector, NULL); /* a fault that shows only after a window of samples: those before were wrong */
        }
        bw_front_end_values(&clean, values);
        code = bw_collect(detector, values, BW_MODEL_CHANNELS, clean.angle);
        lost += code == BW_CODE_SEGMENT_LOST;
    }
    if (code < 0 && code != BW_CODE_SEGMENT_LOST) {
        failure = code;
    }
}

/* Not used: the recording stands for the interrupt. */
void SysTick_Handler(void) {}

static void print_report(void) {
    static const char *const verdicts[] = {"class", "novel", "ambiguous", "undetermined"};
    BwReport report;
    BwAlarm alarm;
    float likelihoods[BW_MAX_CLASSES];
    size_t count = 0;
    char label[17];
    bw_report(detector, &report);
    bw_alarm(detector, &alarm);
    bw_label(detector, report.class_index, label, sizeof label);
    const char *verdict = report.verdict == BW_VERDICT_CLASS ? label : verdicts[report.verdict];
    const char *end = alarm.raised && alarm.segment == report.segment ? ", ALARM" : "";
    printf("segment %lu: %lu rows, %s%s\n", (unsigned long)report.segment - 1, (unsigned long)report.rows, verdict, end);
    bw_values(detector, BW_VALUES_LOG_LIKELIHOODS, likelihoods, BW_MAX_CLASSES, &count);
    for (size_t k = 0; k < count; k++) {
        printf("  log-likelihood %u %08lx\n", (unsigned)k, bits(likelihoods[k]));
    }
}

/* One turn of the main loop; returns its code. A drive sends the report instead of printing it. */
static BwCode turn(void) {
    BwCode code = bw_advance(detector);
    if (code == BW_CODE_REPORT) {
        bw_adopt(detector); /* with the interrupt masked */
        print_report();
    }
    return code;
}

static BwCode start(void) {
    BwCode code = bw_init(detector_memory, sizeof detector_memory, bw_model, BW_MODEL_LENGTH, &detector);
    if (code >= 0) {
        code = bw_front_end_init(front_end_memory, sizeof front_end_memory, &bw_front_end, &front_end);
    }
    return code < 0 ? code : bw_check_front_end(detector, &bw_front_end);
}

int main(void) {
    BwCode code = start();
    if (code < 0) {
        return failed("start", code);
    }
    FILE *rows = fopen("rows.bin", "rb");
    uint32_t head[2];
    if (!rows || fread(head, sizeof head, 1, rows) != 1 || memcmp(head, "BWR1", 4) || head[1] != BW_FRONT_END_FURTHER) {
        printf("no recording rows.bin for this model\n");
        return 1;
    }
    Row row;
    while (fread(&row, sizeof row, 1, rows) == 1) {
        control_interrupt(&row);
        code = turn();
        if (code < 0 || failure != BW_CODE_OK) {
            return failed("sampling", code < 0 ? code : failure);
        }
    }
    while (turn() != BW_CODE_IDLE) {
    }
    BwFrontEndFaults faults;
    BwAlarm alarm;
    bw_front_end_faults(front_end, &faults);
    bw_alarm(detector, &alarm);
    printf("%lu segments, %lu lost, front end clear: %s\n", (unsigned long)alarm.segments, (unsigned long)lost,
           faults.clear ? "true" : "false");
    return 0;
}
