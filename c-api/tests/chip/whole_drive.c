/* A whole drive by the functions of model.h, beside functions of the C library and of the compiler that every program
 * has. Only its size is looked at. */
#include <math.h>
#include <string.h>

#include "bearing_watch.h"
#include "model.h"

volatile float angle;
volatile double gain;
float results[64];
const float *volatile inputs = results;

#ifdef ALONE
static void watch(void) {}
#else
static BwDrive drive;
volatile uint32_t number, counts, position, milliseconds;

static void watch(void) {
    BwReading now;
    BwReport report;
    BwAlarm alarm;
    memset(&now, 0, sizeof now);
    now.number = number;
    now.phases[0] = (uint16_t)counts;
    now.position = position;
    now.load_torque_nm = results[4];
    if (bw_drive_start(&drive, &bw_front_end) < 0) { return; }
    bw_drive_sample(&drive, &now);
    bw_collect(drive.state);
    if (bw_clock(drive.state, milliseconds) < 0) { return; }
    bw_advance(drive.state, &report, &alarm);
    results[2] = (float)report.verdict + (float)alarm.raised;
}
#endif

int main(void) {
    for (;;) {
        memcpy(results + 8, inputs, sizeof results / 2);
        results[0] = sinf(angle) + cosf(angle);
        results[1] = (float)(gain * 3.0);
        watch();
    }
}
