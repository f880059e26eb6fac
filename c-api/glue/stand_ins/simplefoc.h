/* What simplefoc.cpp uses of SimpleFOC and of the Arduino core, with the names and types of version 2.4.0. It stands
 * for SimpleFOC.h, so that the file compiles without the library; it is no part of a drive. */
#ifndef STAND_IN_SIMPLEFOC_H
#define STAND_IN_SIMPLEFOC_H

#include <cstdint>

enum Direction : int8_t { CW = 1, CCW = -1, UNKNOWN = 0 };
enum MotionControlType : uint8_t { torque = 0, velocity = 1, angle = 2 };
enum TorqueControlType : uint8_t { voltage = 0, dc_current = 1, foc_current = 2 };

struct DQCurrent_s {
    float d, q; /* A */
};

class Sensor {
public:
    virtual float getMechanicalAngle(); /* rad, 0 up to one turn, of the last update */

protected:
    ~Sensor() = default;
};

class FOCMotor {
public:
    float shaft_velocity_sp; /* rad/s */
    DQCurrent_s current;
    int8_t enabled;
    TorqueControlType torque_controller;
    MotionControlType controller;
    Direction sensor_direction;
    Sensor *sensor;
};

unsigned long millis();

#endif
