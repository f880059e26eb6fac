/* A whole drive on a recording: counts of the converters at the control rate, front end, detector, alarm.
 *
 * The recording is the file `rows.bin` of the working directory, which `bearing-watch replay --rows` writes; the model
 * was trained with `--front-end` and exported by `--c model.h`. A drive has its control interrupt where this program
 * reads a row. `cargo xtask c` builds this file as C and as C++, runs it in QEMU, and compares every line with what the
 * Rust example `drive` prints on the host. */
#include "bearing_watch_service.h"
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

static BwDrive drive;
static BwCode failure = BW_CODE_OK;

/* The interrupt of the control loop. */
static void control_interrupt(const Row *row) {
    BwReading reading;
    reading.number = row->number;
    memcpy(reading.phases, row->counts, sizeof reading.phases);
    reading.position_missing = (row->flags & 1) != 0;
    reading.position = row->angle >> (32 - BW_FRONT_END_POSITION_BITS); /* a drive: the counts of its converter */
    reading.load_torque_nm = row->further[BW_FRONT_END_FURTHER_LOAD_TORQUE_NM];
    reading.velocity_ref_rad_s = row->further[BW_FRONT_END_FURTHER_VELOCITY_REF_RAD_S];
    BwCode code = bw_drive_sample(&drive, &reading);
    if (code == BW_CODE_COLLECT) {
        /* A drive requests the interrupt below this one, which makes this call. */
        code = bw_collect(drive.state);
    }
    if (code < 0) {
        failure = code;
    }
}

/* Not used: the recording stands for the interrupt. */
void SysTick_Handler(void) {}

static void print_report(const BwReport *report, const BwAlarm *alarm) {
    float likelihoods[BW_MAX_CLASSES];
    size_t count = 0;
    char label[17];
    bw_label(drive.state, report->class_index, label, sizeof label);
    const char *verdict = report->verdict == BW_VERDICT_CLASS ? label : bw_verdict_name(report->verdict);
    const char *end = alarm->raised && alarm->segment == report->segment ? ", ALARM" : "";
    printf("segment %lu: %lu rows, %s%s\n", (unsigned long)report->segment - 1, (unsigned long)report->rows, verdict, end);
    bw_values(drive.state, BW_VALUES_LOG_LIKELIHOODS, likelihoods, BW_MAX_CLASSES, &count);
    for (size_t k = 0; k < count; k++) {
        printf("  log-likelihood %u %08lx\n", (unsigned)k, bits(likelihoods[k]));
    }
}

/* One turn of the main loop; returns its code. A drive sends the report instead of printing it. */
static BwCode turn(void) {
    BwReport report;
    BwAlarm alarm;
    BwCode code = bw_advance(drive.state, &report, &alarm);
    if (code == BW_CODE_REPORT) {
        print_report(&report, &alarm);
    }
    return code;
}

int main(void) {
    BwCode code = bw_drive_start(&drive, &bw_front_end);
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
    BwStatus status;
    bw_status(drive.state, &status);
    bw_faults(drive.state, &faults);
    bw_alarm(drive.state, &alarm);
    printf("%lu segments, %lu lost, front end clear: %s\n", (unsigned long)alarm.segments, (unsigned long)status.lost_segments,
           faults.clear ? "true" : "false");
    return 0;
}
