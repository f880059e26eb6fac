#include "recorded_drive.h"

#include "board.h"

#include <stdio.h>
#include <string.h>

/* A row of the recording, in the byte order of the chip. */
typedef struct {
    uint32_t number;
    uint16_t counts[3];
    uint16_t flags; /* 1: no position */
    uint32_t angle; /* as a fraction of 2^32 */
    float further[BW_FRONT_END_FURTHER];
} Row;

/* Of `rows.s`: a head, rows, and their end. */
extern const uint8_t rows_start[], rows_end[];
enum { HEAD = 8 };

/* The rate of the recording. */
enum { ROWS_A_MILLISECOND = 10 };
/* Clock cycles between two interrupts: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 us, so the
 * recording of 10 kHz is played at 2 kHz. */
enum { CYCLES = 84000 };
/* Rows without a new reading behind the end: the main loop concludes the last segment. */
enum { REST = 200 };

static volatile uint32_t played;

static uint32_t rows(void) { return (uint32_t)(rows_end - rows_start - HEAD) / sizeof(Row); }

bool drive_read(BwReading *now) {
    Row row;
    uint32_t number = played;
    played = number + 1;
    if (number >= rows()) { return false; }
    memcpy(&row, rows_start + HEAD + number * sizeof row, sizeof row);
    now->number = row.number; /* of the PWM period: a missed interrupt leaves a gap */
    memcpy(now->phases, row.counts, sizeof now->phases);
    now->position_missing = (row.flags & 1) != 0;
    now->position = row.angle >> (32 - BW_FRONT_END_POSITION_BITS);
    now->load_torque_nm = row.further[BW_FRONT_END_FURTHER_LOAD_TORQUE_NM];
    now->velocity_ref_rad_s = row.further[BW_FRONT_END_FURTHER_VELOCITY_REF_RAD_S];
    return true;
}

uint32_t drive_milliseconds(void) { return played / ROWS_A_MILLISECOND; }

bool drive_runs(void) { return played < rows() + REST; }

void drive_start_interrupts(void) { board_start_sampling(CYCLES); }

void drive_request_below(void) { board_request_below(); }

size_t drive_load(uint8_t *bytes, size_t capacity) {
    FILE *file = fopen("state.bin", "rb");
    if (!file) { return 0; }
    size_t length = fread(bytes, 1, capacity, file);
    fclose(file);
    return length;
}

int drive_store(const uint8_t *bytes, size_t length) {
    FILE *file = fopen("state.bin", "wb");
    bool stored = file && fwrite(bytes, 1, length, file) == length && fclose(file) == 0;
    return stored ? 0 : drive_failed("state.bin cannot be written");
}

int drive_failed(const char *text) {
    printf("%s\n", text);
    return 1;
}
