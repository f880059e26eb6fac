/* bearing-watch in the VESC firmware (vedderb/bldc), version 7.00 (branch release_7_00), motor 1 with field-oriented
 * control and an encoder on its shaft.
 *
 *     bearing_start      main() of main.c, behind app_set_configuration(appconf)
 *     control_interrupt  the PWM callback, which mcpwm_foc_adc_int_handler calls at the end of each control period, at
 *                        foc_f_zv / 2, 12.5 kHz by default; at foc_f_zv with phase shunts and the sampling mode V0_V7
 *     collect            a thread above NORMALPRIO in the place of a lower interrupt
 *     report             a thread of LOWPRIO in the place of a main loop
 *
 * The user writes bearing_alarm and bearing_error, which run in the thread of LOWPRIO. */
#ifdef BEARING_WATCH_STAND_IN
#include "stand_ins/vesc.h"
#else
#include "ch.h"
#include "encoder/encoder.h"
#include "hal.h"
#include "mc_interface.h"
#include "mcpwm_foc.h"
#include "timer.h"
#endif
#include "bearing.h"

#include <math.h>

void bearing_start(void);

static BwDrive drive;
static BSEMAPHORE_DECL(samples_wait, true);
/* bw_drive_start takes 9 kB of this stack with a library for one plan, the only one that suits this memory. */
static THD_WORKING_AREA(report_area, 12288);
static THD_WORKING_AREA(collect_area, 2048);

/* The callback comes behind the current control: the current is that of this period, and the angle is read later by the
 * run time of the handler. */
static void control_interrupt(void) {
    static uint32_t number, last_ticks;
    if (mcpwm_foc_isr_motor() != 1) { return; } /* of two motors */
    const volatile mc_configuration *conf = mc_interface_get_configuration();
    const float sign = conf->foc_encoder_inverted ? -1.0f : 1.0f;
    const float angle_deg = encoder_read_deg();
    BwReading now = {0};

    /* By a clock of its own: a period that was missed leaves a gap. */
    number += (uint32_t)(timer_seconds_elapsed_since(last_ticks) * bw_front_end.control_rate_hz + 0.5f);
    last_ticks = timer_time_now();
    now.number = number;
    now.current_a = mcpwm_foc_get_state() == MC_STATE_RUNNING ? mcpwm_foc_get_iq() : NAN;
    /* An angle that is no number fails both comparisons. */
    now.position_missing = !(encoder_is_configured() != ENCODER_TYPE_NONE && angle_deg >= 0.0f && angle_deg <= 360.0f);
    if (!now.position_missing) { /* in the direction in which a positive current accelerates */
        now.position = bearing_angle(sign * angle_deg / 360.0f);
    }
    /* From electrical turns a minute, before the firmware's ramp. */
    now.velocity_ref_rad_s = mcpwm_foc_control_mode() == CONTROL_MODE_SPEED
                                 ? mcpwm_foc_get_pid_speed_set() * 0.104719755f / conf->foc_encoder_ratio
                                 : NAN;
    if (bw_drive_sample(&drive, &now) == BW_CODE_COLLECT) {
        chSysLockFromISR();
        chBSemSignalI(&samples_wait);
        chSysUnlockFromISR();
    }
}

static THD_FUNCTION(collect, argument) {
    (void)argument;
    for (;;) {
        bw_collect(drive.state); /* the first call tests the arithmetic, which takes milliseconds */
        chBSemWait(&samples_wait);
    }
}

/* Milliseconds of the system timer, which wrap as those of bw_clock do. */
static uint32_t milliseconds(void) {
    static uint32_t sum_ms, last_ticks;
    const uint32_t per_ms = CH_CFG_ST_FREQUENCY / 1000;
    const uint32_t elapsed_ms = (chVTGetSystemTimeX() - last_ticks) / per_ms;
    last_ticks += elapsed_ms * per_ms;
    return sum_ms += elapsed_ms;
}

static THD_FUNCTION(report, argument) {
    BwCode code = bw_drive_start(&drive, &bw_front_end);
    const float rate_hz = bw_front_end.control_rate_hz;
    (void)argument;
    if (code >= 0 && fabsf(mcpwm_foc_get_sampling_frequency_now() - rate_hz) > 1e-3f * rate_hz) {
        code = BW_CODE_MODEL_INTERVAL;
    }
    if (code < 0) {
        bearing_error(bw_error_text(code));
        return;
    }
    chThdCreateStatic(collect_area, sizeof collect_area, NORMALPRIO + 10, collect, NULL);
    mc_interface_set_pwm_callback(control_interrupt);
    for (;; chThdSleepMilliseconds(1)) { bearing_advance(&drive, milliseconds()); }
}

void bearing_start(void) { chThdCreateStatic(report_area, sizeof report_area, LOWPRIO, report, NULL); }
