/* The main loop of the README on a drive that is simulated here. The lower interrupt is requested by the code of
 * bw_drive_sample alone. By the word of the command line
 *
 *     blocked     it does not run for 12 ms, as a thread that holds a lock, or a longer interrupt, makes it
 *     flushed     its processor flushes subnormal numbers to zero
 *     exchanged   two phases are exchanged */
#include "model.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

static BwDrive drive;
static const char *word = "";

/* The lower interrupt. */
static void below(void) {
#ifdef __SSE__
    const unsigned settings = _mm_getcsr();
    if (!strcmp(word, "flushed")) { _mm_setcsr(settings | 0x8040u); }
#endif
    bw_collect(drive.state);
#ifdef __SSE__
    _mm_setcsr(settings);
#endif
}

#ifdef BW_FRONT_END_FACTOR
enum { RATE_KHZ = 10, BLOCKED_FROM = 4001, BLOCKED_TO = 4001 + 12 * RATE_KHZ, ROWS = 150000 };

/* 40 rad to and fro with a current of 3 A and more; six pole pairs, counts of 25 mA, 14 bits of angle. */
static BwCode sample(uint32_t number) {
    static const double turn = 6.283185307179586;
    BwReading now = {0};
    double t = number / 10000.0, angle = 40.0 * sin(turn * 0.5 * t), q = 3.0 + 0.5 * sin(turn * 11.0 * t);
    for (int k = 0; k < 3; k++) {
        now.phases[k] = (uint16_t)(2048.5 - q / 0.025 * sin(6.0 * angle - k * turn / 3.0) + (number >> k) % 2);
    }
    if (!strcmp(word, "exchanged")) {
        uint16_t b = now.phases[1];
        now.phases[1] = now.phases[2];
        now.phases[2] = b;
    }
    now.number = number;
    now.position = (uint32_t)(int32_t)floor(angle / turn * 16384.0) & 16383u;
    now.velocity_ref_rad_s = (float)cos(turn * 5.0 * t);
    return bw_drive_sample(&drive, &now);
}

static BwCode start(void) { return bw_drive_start(&drive, &bw_front_end); }
#else
/* Of 1 kHz by its clock: a wrong rate. */
enum { RATE_KHZ = 1, BLOCKED_FROM = 4001, BLOCKED_TO = 4013, ROWS = 15100 };

static BwCode sample(uint32_t number) {
    BwReading now = {0};
    now.current_a = (float)sin(0.01 * number);
    now.velocity_ref_rad_s = (float)(40.0 * cos(0.01 * number));
    now.load_torque_nm = 0.1f;
    return bw_drive_sample(&drive, &now);
}

static BwCode start(void) { return bw_drive_start(&drive); }
#endif

int main(int count, char **words) {
    BwReport report;
    BwAlarm alarm;
    bool pending = false;
    uint32_t reports = 0;
    BwCode code = start();
    word = count > 1 ? words[1] : "";
    memset(&report, 0, sizeof report);
    if (code < 0) {
        printf("%s\n", bw_error_text(code));
        return 1;
    }
    for (uint32_t number = 0; number < ROWS; number++) {
        if (sample(number) == BW_CODE_COLLECT) { pending = true; }
        if (pending) {
            pending = false;
            if (strcmp(word, "blocked") || number < BLOCKED_FROM || number >= BLOCKED_TO) { below(); }
        }
        code = bw_clock(drive.state, number / RATE_KHZ);
        if (code < 0) { printf("%s\n", bw_error_text(code)); }
        if (bw_advance(drive.state, &report, &alarm) == BW_CODE_REPORT) { reports++; }
    }
    printf("%lu reports, %lu lost, alignment %d, reason %d %u\n", (unsigned long)reports,
           (unsigned long)report.lost_samples, (int)report.alignment, (int)report.reason, (unsigned)report.place);
    return 0;
}
