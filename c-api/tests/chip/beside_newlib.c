/* A program that calls functions of the C library and of the compiler beside those of bearing-watch. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bearing_watch.h"
#include "model.h"

volatile float angle;
volatile double gain;
float results[64];
const float *volatile inputs = results;

static void of_libraries(void) {
    memcpy(results + 8, inputs, sizeof results / 2);
    results[0] = sinf(angle) + cosf(angle);
    results[1] = (float)(gain * 3.0);
}

#ifdef ALONE
static void of_bearing_watch(void) {}
#else
static BwDrive drive;

static void of_bearing_watch(void) {
    BwReading now = {results[4], results[5], results[6]};
    BwReport report;
    BwAlarm alarm;
    if (bw_drive_start(&drive) < 0) {
        return;
    }
    bw_drive_sample(&drive, &now);
    bw_collect(drive.state);
    if (bw_advance(drive.state, &report, &alarm) == BW_CODE_REPORT) {
        results[2] = (float)report.verdict;
    }
}
#endif

/* Codes are printed by %d, without a warning. */
int print_code(char *text, size_t size, BwCode code) {
    return snprintf(text, size, "%d %s: %s", code, bw_code_name(code), bw_error_text(code));
}

int main(void) {
    for (;;) {
        of_libraries();
        of_bearing_watch();
    }
}
