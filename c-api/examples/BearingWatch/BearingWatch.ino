// Watches the bearings of a drive: a timer samples, loop() concludes.
//
// model.h is what `bearing-watch train --c model.h` writes; the one beside this sketch is that of a simulated drive,
// sampled at 500 Hz. The board needs a processor with a floating-point unit, as an STM32F4, STM32G4 or STM32H7.
#include <bearing_watch.h>

#include "model.h"

static BwDrive drive;  // memory of the detector; all zero
static HardwareTimer timer(TIM3);

// Yours: the signals of the motor's control, such as motor.current.q and motor.shaft_velocity_sp of SimpleFOC. Here
// they are read from three pins whose ranges are those of the channels.
static float channel_value(uint32_t pin, unsigned channel) {
  static const float limits[BW_MODEL_CHANNELS] = BW_MODEL_CHANNEL_LIMITS;
  return (analogRead(pin) / 32768.0f - 1.0f) * limits[channel];
}

static void sample() {  // in the interrupt of the timer
  BwReading now = {};
  now.current_a = channel_value(A0, BW_MODEL_CHANNEL_CURRENT_A);
  now.velocity_ref_rad_s = channel_value(A1, BW_MODEL_CHANNEL_VELOCITY_REF_RAD_S);
  now.load_torque_nm = channel_value(A2, BW_MODEL_CHANNEL_LOAD_TORQUE_NM);
  bw_drive_sample(&drive, &now);
  bw_collect(drive.state);
}

void setup() {
  Serial.begin(115200);
  analogReadResolution(16);
  BwCode code = bw_drive_start(&drive);
  if (code < 0) {
    Serial.println(bw_error_text(code));
    return;
  }
  timer.setOverflow((uint32_t)(1.0f / BW_MODEL_INTERVAL_S + 0.5f), HERTZ_FORMAT);
  timer.attachInterrupt(sample);
  timer.resume();
}

void loop() {
  BwReport report;
  BwAlarm alarm;
  BwCode code = bw_clock(drive.state, millis());
  if (code < 0) {  // once, until the drive is watched again
    Serial.println(bw_error_text(code));
  }
  if (bw_advance(drive.state, &report, &alarm) == BW_CODE_REPORT) {  // once in ten seconds
    Serial.print("verdict: ");
    Serial.println(bw_drive_verdict(&report));
    if (alarm.raised) {
      Serial.println("ALARM");
    }
  }
}
