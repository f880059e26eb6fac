/* What the program of the section "Three contexts" of the README calls. Only its compiling is looked at. */
#include <stdint.h>

float quadrature_current_a(void);
float velocity_reference_rad_s(void);
float load_torque_nm(void);
uint32_t milliseconds(void);
void request_lower_interrupt(void);
void show(const char *verdict);
void set_fault_flag(void);
void log_error(const char *text);
