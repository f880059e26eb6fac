/* Two motors on one chip, with two models: the first one gives raw counts to a front end, the second one has signals of
 * its own. By the word of the command line `both` of them run, or the `first` or the `second` alone; each prints the same
 * lines then. */
#include "model.h" /* of the actuator */
#include "rig.h"   /* `train --c rig.h --c-name rig` */
#include <math.h>
#include <stdio.h>
#include <string.h>

static BwDrive first;
static BwRigDrive second;

/* 40 rad to and fro with a current of 3 A and more; six pole pairs, counts of 25 mA, 14 bits of angle. */
static BwReading of_first(uint32_t number) {
    static const double turn = 6.283185307179586;
    double t = number / 10000.0, angle = 40.0 * sin(turn * 0.5 * t), q = 3.0 + 0.5 * sin(turn * 11.0 * t);
    BwReading now;
    memset(&now, 0, sizeof now);
    for (int k = 0; k < 3; k++) {
        now.phases[k] = (uint16_t)(2048.5 - q / 0.025 * sin(6.0 * angle - k * turn / 3.0) + (number >> k) % 2);
    }
    now.number = number;
    now.position = (uint32_t)(int32_t)floor(angle / turn * 16384.0) & 16383u;
    now.velocity_ref_rad_s = (float)cos(turn * 5.0 * t);
    return now;
}

static BwRigReading of_second(uint32_t number) {
    BwRigReading now;
    now.current_a = (float)sin(0.01 * number);
    now.velocity_ref_rad_s = (float)(40.0 * cos(0.01 * number));
    now.load_torque_nm = 0.1f;
    return now;
}

static void main_loop(const char *name, BwState *state, const char *(*verdict)(const BwReport *)) {
    BwReport report;
    const BwCode code = bw_advance(state, &report, NULL);
    if (code == BW_CODE_REPORT || code == BW_CODE_WITHDRAWN) {
        printf("%s: %s, %lu rows, reason %d %u\n", name, verdict(&report), (unsigned long)report.rows, (int)report.reason,
               (unsigned)report.place);
    }
}

int main(int count, char **words) {
    const char *word = count > 1 ? words[1] : "both";
    const bool has_first = strcmp(word, "second") != 0, has_second = strcmp(word, "first") != 0;
    BwCode code = has_first ? bw_drive_start(&first, &bw_front_end) : BW_CODE_OK;
    if (code >= 0 && has_second) { code = bw_rig_drive_start(&second); }
    if (code < 0) {
        printf("%s\n", bw_error_text(code));
        return 1;
    }
    /* At 10 kHz, and the second motor at 500 Hz. */
    for (uint32_t number = 0; number < 250000; number++) {
        if (has_first) {
            const BwReading now = of_first(number);
            if (bw_drive_sample(&first, &now) == BW_CODE_COLLECT) { bw_collect(first.state); }
            main_loop("first", first.state, bw_drive_verdict);
        }
        if (has_second && number % 20 == 0) {
            const BwRigReading now = of_second(number / 20);
            if (bw_rig_drive_sample(&second, &now) == BW_CODE_COLLECT) { bw_collect(second.state); }
            main_loop("second", second.state, bw_rig_drive_verdict);
        }
    }
    return 0;
}
