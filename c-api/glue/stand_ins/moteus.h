/* What moteus.cpp uses of the moteus firmware, with the names and types of firmware/v1.0.0. It stands for
 * fw/bldc_servo_structs.h, fw/motor_position.h and mbed.h, so that the file compiles without the firmware; it is no
 * part of a drive. */
#ifndef STAND_IN_MOTEUS_H
#define STAND_IN_MOTEUS_H

#include <array>
#include <cstdint>
#include <optional>

namespace moteus {

enum BldcServoMode {
    kStopped = 0,
    kCurrent = 9,
    kPosition = 10,
    kZeroVelocity = 12,
    kStayWithinBounds = 13,
};

struct BldcServoStatus {
    BldcServoMode mode;
    float q_A;                             /* A, with the sign of the output */
    std::optional<float> control_velocity; /* turns of the output a second */
    uint32_t total_timer;                  /* ticks of a control period, at the clock of the processor */
};

struct MotorPosition {
    struct SourceConfig {
        uint32_t cpr;
    };
    struct Config {
        struct Output {
            int8_t sign;
        };
        std::array<SourceConfig, 3> sources;
        int8_t commutation_source;
        Output output;
        float rotor_to_output_ratio;
    };
    struct SourceStatus {
        uint8_t nonce;           /* changes with every new value */
        float compensated_value; /* 0 up to cpr */
    };
    struct Status {
        std::array<SourceStatus, 3> sources;
    };
};

} // namespace moteus

typedef enum { FMAC_IRQn = 101 } IRQn_Type;
struct DWT_Type {
    volatile uint32_t CYCCNT;
};
extern DWT_Type *const DWT;
void NVIC_SetVector(IRQn_Type irq, uint32_t vector);
void NVIC_EnableIRQ(IRQn_Type irq);
void NVIC_SetPendingIRQ(IRQn_Type irq);
void HAL_NVIC_SetPriority(IRQn_Type irq, uint32_t preemption, uint32_t sub);

#endif
