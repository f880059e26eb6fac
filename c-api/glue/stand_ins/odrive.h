/* What odrive.cpp uses of the ODrive firmware, with the names and types of fw-v0.5.6. It stands for odrive_main.h, so
 * that the file compiles without the firmware; it is no part of a drive. */
#ifndef STAND_IN_ODRIVE_H
#define STAND_IN_ODRIVE_H

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

using float2D = std::pair<float, float>;

struct Encoder {
    enum Error { ERROR_NONE = 0 };
    struct Config_t {
        int32_t cpr;
        int32_t direction; /* 1 or -1 after calibration */
    };
    Config_t config_;
    Error error_;
    int32_t count_in_cpr_;
};

struct FieldOrientedController {
    std::optional<float2D> Ialpha_beta_measured_; /* A */
    float Iq_measured_;                           /* A */
};

struct Motor {
    bool is_armed_;
    FieldOrientedController current_control_;
};

struct Controller {
    float vel_setpoint_; /* turns a second */
};

struct Axis {
    Encoder &encoder_;
    Controller &controller_;
    Motor &motor_;
};

struct ODrive {
    uint32_t last_update_timestamp_; /* ticks of the processor's clock */
};

extern std::array<Axis, 2> axes;
extern ODrive odrv;

#define TIM_1_8_PERIOD_CLOCKS 3500
#define TIM_1_8_RCR 2
#define CONTROL_TIMER_PERIOD_TICKS (2 * TIM_1_8_PERIOD_CLOCKS * (TIM_1_8_RCR + 1))

extern "C" {
typedef enum { OTG_HS_WKUP_IRQn = 76 } IRQn_Type;
void NVIC_SetPendingIRQ(IRQn_Type irq);
void HAL_NVIC_SetPriority(IRQn_Type irq, uint32_t preemption, uint32_t sub);
void HAL_NVIC_EnableIRQ(IRQn_Type irq);
uint32_t HAL_GetTick(void);
int osDelay(uint32_t milliseconds);
void OTG_HS_WKUP_IRQHandler(void);
}

#endif
