/* What vesc.c uses of the VESC firmware and of ChibiOS, with the names and types of release_7_00. It stands for ch.h,
 * hal.h, timer.h, mc_interface.h, mcpwm_foc.h and encoder/encoder.h, so that the file compiles without the firmware; it
 * is no part of a drive. */
#ifndef STAND_IN_VESC_H
#define STAND_IN_VESC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum { MC_STATE_OFF = 0, MC_STATE_DETECTING, MC_STATE_RUNNING } mc_state;
typedef enum { CONTROL_MODE_DUTY = 0, CONTROL_MODE_SPEED } mc_control_mode;
typedef enum { ENCODER_TYPE_NONE = 0 } encoder_type_t;
typedef struct {
    bool foc_encoder_inverted;
    float foc_encoder_ratio; /* electrical turns a turn of the encoder */
} mc_configuration;

const volatile mc_configuration *mc_interface_get_configuration(void);
void mc_interface_set_pwm_callback(void (*p_func)(void));
int mcpwm_foc_isr_motor(void);
mc_state mcpwm_foc_get_state(void);
mc_control_mode mcpwm_foc_control_mode(void);
float mcpwm_foc_get_iq(void);            /* A */
float mcpwm_foc_get_pid_speed_set(void); /* electrical turns a minute */
float mcpwm_foc_get_sampling_frequency_now(void);
float encoder_read_deg(void);
encoder_type_t encoder_is_configured(void);
uint32_t timer_time_now(void);
float timer_seconds_elapsed_since(uint32_t time);

/* ChibiOS */
#define CH_CFG_ST_FREQUENCY 10000
#define LOWPRIO 2
#define NORMALPRIO 64
#define BSEMAPHORE_DECL(name, taken) binary_semaphore_t name = {taken}
#define THD_WORKING_AREA(name, bytes) uint64_t name[(bytes) / 8]
#define THD_FUNCTION(name, argument) void name(void *argument)
typedef struct {
    bool taken;
} binary_semaphore_t;
typedef struct thread thread_t;
thread_t *chThdCreateStatic(void *area, size_t size, uint32_t priority, void (*function)(void *), void *argument);
void chThdSleepMilliseconds(uint32_t milliseconds);
uint32_t chVTGetSystemTimeX(void);
void chSysLockFromISR(void);
void chSysUnlockFromISR(void);
void chBSemSignalI(binary_semaphore_t *semaphore);
int32_t chBSemWait(binary_semaphore_t *semaphore);

#endif
