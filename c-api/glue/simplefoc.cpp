/* bearing-watch with the library SimpleFOC (Arduino-FOC), versions 2.3.4 and 2.4.0, on a processor with a
 * single-precision floating-point unit that links libbearing_watch.a: STM32F4 and STM32G4.
 *
 *     bearing_start              setup(), behind motor.initFOC() and before the timer starts
 *     bearing_control_interrupt  the callback of a hardware timer, behind motor.loopFOC(), as
 *                                bearing_control_interrupt(motor); at the control rate of front_end.toml, such as 5 kHz
 *     bearing_lower_interrupt    loop(), if each turn of it is shorter than three clean samples; else a timer below the
 *                                one of the control
 *     bearing_main_loop          loop()
 *
 * The examples of SimpleFOC call motor.loopFOC() from loop(), at no fixed rate. Samples that a timer takes of its
 * variables then repeat and skip periods; so the timer has to call motor.loopFOC(), too. motor.move() stays in loop().
 *
 * The user writes bearing_alarm and bearing_error, which run in setup() and loop(). */
#ifdef BEARING_WATCH_STAND_IN
#include "stand_ins/simplefoc.h"
#else
#include <SimpleFOC.h>
#endif
#include "bearing.h"

#include <cmath>

static BwDrive drive;

void bearing_start() {
    BwCode code = bw_drive_start(&drive, &bw_front_end);
    if (code >= 0) { code = bw_collect(drive.state); } /* the first call tests the arithmetic */
    if (code < 0) { bearing_error(bw_error_text(code)); }
}

void bearing_control_interrupt(const FOCMotor &motor) {
    static uint32_t number; /* a timer interrupt that is missed leaves no gap: bw_clock finds it */
    /* loopFOC measures the quadrature current in this mode only, and leaves the last value if the motor is disabled. */
    const bool controlled = motor.enabled && motor.torque_controller == TorqueControlType::foc_current;
    const bool commanded =
        motor.controller == MotionControlType::velocity || motor.controller == MotionControlType::angle;

    BwReading now = {};
    now.number = number++;
    now.current_a = controlled ? motor.current.q : NAN;
    now.position_missing = motor.sensor == nullptr || motor.sensor_direction == Direction::UNKNOWN;
    if (!now.position_missing) { /* in the direction in which a positive current accelerates */
        const float angle_rad = static_cast<float>(motor.sensor_direction) * motor.sensor->getMechanicalAngle();
        now.position = bearing_angle(angle_rad / 6.2831853f);
    }
    now.velocity_ref_rad_s = commanded ? motor.shaft_velocity_sp : NAN;
    bw_drive_sample(&drive, &now);
}

void bearing_lower_interrupt() { bw_collect(drive.state); }

void bearing_main_loop() { bearing_advance(&drive, millis()); }
