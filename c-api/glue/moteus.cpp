/* bearing-watch in the firmware of mjbots moteus, version 1.0.0 (tag firmware/v1.0.0).
 *
 *     bearing_start              main() of fw/moteus.cc, before moteus_controller.Start()
 *     bearing_control_interrupt  BldcServo::Impl::ISR_DoTimerLowerPriority of fw/bldc_servo.cc, behind ISR_DoControl,
 *                                as bearing_control_interrupt(status_, position_, *motor_position_config());
 *                                30 kHz, or servo.pwm_rate_hz if that is lower
 *     collect                    an interrupt below it, here that of the FMAC, which this firmware does not use
 *     bearing_main_loop          the endless loop of main(), as bearing_main_loop(timer.ms_since_boot());
 *
 * The user writes bearing_alarm and bearing_error, which run in main(). */
#ifdef BEARING_WATCH_STAND_IN
#include "stand_ins/moteus.h"
#else
#include "fw/bldc_servo_structs.h"
#include "fw/motor_position.h"
#include "mbed.h"
#endif
#include "bearing.h"

#include <cmath>

static BwDrive drive;

static void collect() { bw_collect(drive.state); }

void bearing_start() {
    const BwCode code = bw_drive_start(&drive, &bw_front_end);
    if (code < 0) { bearing_error(bw_error_text(code)); }
    NVIC_SetVector(FMAC_IRQn, static_cast<uint32_t>(reinterpret_cast<uintptr_t>(&collect)));
    HAL_NVIC_SetPriority(FMAC_IRQn, 7, 0); /* the control runs in PendSV, priority 6 */
    NVIC_EnableIRQ(FMAC_IRQn);
    NVIC_SetPendingIRQ(FMAC_IRQn); /* the first call tests the arithmetic, which takes milliseconds */
}

/* The number of the control period by the clock of the processor: the firmware drops a period that begins too late.
 * Needs another clock if MOTEUS_PERFORMANCE_MEASURE is defined, which sets this one back. */
static uint32_t period_number(uint32_t period_cycles) {
    static uint32_t number, last_cycles;
    const uint32_t cycles = DWT->CYCCNT;
    if (period_cycles != 0) { number += (cycles - last_cycles + period_cycles / 2) / period_cycles; }
    last_cycles = cycles;
    return number;
}

void bearing_control_interrupt(const moteus::BldcServoStatus &status, const moteus::MotorPosition::Status &position,
                               const moteus::MotorPosition::Config &config) {
    static uint8_t last_nonce;
    const auto &source = position.sources[config.commutation_source];
    const float turns = source.compensated_value / static_cast<float>(config.sources[config.commutation_source].cpr);
    const float sign = config.output.sign < 0 ? -1.0f : 1.0f; /* of q_A and of the reference against the rotor */
    const bool controlled = status.mode == moteus::kCurrent || status.mode == moteus::kPosition ||
                            status.mode == moteus::kZeroVelocity || status.mode == moteus::kStayWithinBounds;

    BwReading now = {};
    now.number = period_number(status.total_timer);
    now.current_a = controlled ? status.q_A : NAN;
    now.position_missing = source.nonce == last_nonce; /* no new value: a repeated one would be a wrong angle */
    last_nonce = source.nonce;
    now.position = bearing_angle(sign * turns); /* of the rotor, before the firmware's own filter */
    now.velocity_ref_rad_s =
        status.control_velocity ? 6.2831853f * *status.control_velocity / config.rotor_to_output_ratio : NAN;
    if (bw_drive_sample(&drive, &now) == BW_CODE_COLLECT) {
        NVIC_SetPendingIRQ(FMAC_IRQn);
    }
}

void bearing_main_loop(uint32_t milliseconds) { bearing_advance(&drive, milliseconds); }
