/* bearing-watch in the firmware of the ODrive v3, versions 0.5.2 to 0.5.6 (tags fw-v0.5.2 to fw-v0.5.6), axis 0.
 *
 *     bearing_start             main(), before osKernelStart(): on the main stack, before the control loop runs
 *     bearing_control_loop      ControlLoop_IRQHandler of Board/v3/board.cpp, last statement, 8 kHz
 *     OTG_HS_WKUP_IRQHandler    the interrupt below the control loop; nothing else in this firmware uses the vector
 *     bearing_thread            a thread of osPriorityLow, which main() creates behind bearing_start
 *
 * The user writes bearing_alarm and bearing_error, which run in the thread and before the scheduler. */
#ifdef BEARING_WATCH_STAND_IN
#include "stand_ins/odrive.h"
#else
#include "odrive_main.h"
#endif
#include "bearing.h"

#include <cmath>

static BwDrive drive;

void bearing_start() {
    const BwCode code = bw_drive_start(&drive, &bw_front_end);
    if (code < 0) { bearing_error(bw_error_text(code)); }
    /* Below the control loop, whose priority is 5, and below all communication, 6 to 10. */
    HAL_NVIC_SetPriority(OTG_HS_WKUP_IRQn, 12, 0);
    HAL_NVIC_EnableIRQ(OTG_HS_WKUP_IRQn);
    NVIC_SetPendingIRQ(OTG_HS_WKUP_IRQn); /* the first call tests the arithmetic, which takes milliseconds */
}

/* Behind pwm_update_cb: only then current and count are those of the same period. Behind the test of the deadline: this
 * call never delays the PWM. */
void bearing_control_loop() {
    static uint32_t number, last_timestamp;
    const Axis &axis = axes[0];
    const Motor &motor = axis.motor_;
    const Encoder &encoder = axis.encoder_;
    /* The timestamp also advances where the interrupt was missed. Unsigned: its wrap-around does not matter. */
    const uint32_t timestamp = odrv.last_update_timestamp_;
    number += (timestamp - last_timestamp) / CONTROL_TIMER_PERIOD_TICKS;
    last_timestamp = timestamp;

    BwReading now = {};
    now.number = number;
    /* A disarmed motor keeps its last current. Positive is what accelerates in the direction of the counts. */
    const bool controlled = motor.is_armed_ && motor.current_control_.Ialpha_beta_measured_.has_value();
    const float direction = static_cast<float>(encoder.config_.direction);
    now.current_a = controlled ? direction * motor.current_control_.Iq_measured_ : NAN;
    now.position_missing = encoder.error_ != Encoder::ERROR_NONE;
    /* `counts_per_turn` of front_end.toml is config_.cpr. With the recordings of `bearing-watch listen` it is
     * `bits = 32`, and this is bw_angle_from_cpr(encoder.count_in_cpr_, encoder.config_.cpr). */
    now.position = encoder.count_in_cpr_;
    now.velocity_ref_rad_s = 6.2831853f * axis.controller_.vel_setpoint_; /* from turns a second */
    if (bw_drive_sample(&drive, &now) == BW_CODE_COLLECT) {
        NVIC_SetPendingIRQ(OTG_HS_WKUP_IRQn);
    }
}

extern "C" void OTG_HS_WKUP_IRQHandler(void) { bw_collect(drive.state); }

void bearing_thread(void *) {
    for (;;) {
        bearing_advance(&drive, HAL_GetTick()); /* by TIM14, not by the timer of the control loop */
        osDelay(1);
    }
}
