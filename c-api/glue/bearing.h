/* What the glue for every firmware shares: the hooks that the user writes, the main loop, and the angle of a float. */
#ifndef BEARING_H
#define BEARING_H

#include "bearing_watch_service.h"
#include "model.h"

/* In the context of the main loop. `name` is the class that caused the alarm, or "unknown". */
void bearing_alarm(const char *name);
/* At boot: the monitor does not start; later: the drive is not watched. */
void bearing_error(const char *text);

/* One bounded step of the main loop; the timer of the control does not make `milliseconds`. */
static inline void bearing_advance(BwDrive *drive, uint32_t milliseconds) {
    static bool told = false;
    BwReport report;
    BwAlarm alarm;
    char label[17];
    const BwCode code = bw_clock(drive->state, milliseconds);
    if (code < 0) { bearing_error(bw_error_text(code)); } /* once, until the drive is watched again */
    const BwCode now = bw_advance(drive->state, &report, &alarm);
    if (now != BW_CODE_REPORT && now != BW_CODE_WITHDRAWN) { return; }
    if (alarm.raised && !told) {
        bool named = alarm.known && bw_label(drive->state, alarm.class_index, label, sizeof label) >= 0;
        bearing_alarm(named ? label : "unknown");
    }
    told = alarm.raised; /* latched until bw_reset, unless the report that raised it is withdrawn */
}

/* The angle as bw_angle returns it, of turns below 128 in both directions: a float has 24 bits of one turn. */
static inline uint32_t bearing_angle(float turns) { return (uint32_t)(int32_t)(turns * 16777216.0f) << 8; }

#endif
