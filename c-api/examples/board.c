/* Start-up of a Cortex-M4F: vectors, floating-point unit, memory; output goes to the debugger by semihosting. */
#include "board.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif
extern uint32_t board_stack_top, board_data_start, board_data_end, board_data_stored, board_bss_start, board_bss_end;
extern void initialise_monitor_handles(void);
int main(void);
void Reset_Handler(void);
void Fault_Handler(void);
void PendSV_Handler(void);
#ifdef __cplusplus
}
#endif

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)

#define ICSR (*(volatile uint32_t *)0xE000ED04u)
#define SHPR3 (*(volatile uint32_t *)0xE000ED20u)

typedef void (*Handler)(void);

/* Initial stack pointer, then the system's exceptions. */
__attribute__((section(".vectors"), used)) static const struct {
    void *stack;
    Handler handlers[15];
} vectors = {
    &board_stack_top,
    {Reset_Handler, Fault_Handler, Fault_Handler, Fault_Handler, Fault_Handler, Fault_Handler, 0, 0, 0, 0,
     Fault_Handler, Fault_Handler, 0, PendSV_Handler, SysTick_Handler},
};

void Reset_Handler(void) {
    CPACR |= 0xFu << 20; /* full access to the floating-point unit */
    __asm__ volatile("dsb\n isb" ::: "memory");
    memcpy(&board_data_start, &board_data_stored, (size_t)((char *)&board_data_end - (char *)&board_data_start));
    memset(&board_bss_start, 0, (size_t)((char *)&board_bss_end - (char *)&board_bss_start));
    initialise_monitor_handles();
    exit(main());
}

void Fault_Handler(void) { _Exit(EXIT_FAILURE); }

/* Programs with an interrupt below that of the samples have one of their own. */
__attribute__((weak)) void PendSV_Handler(void) { Fault_Handler(); }

void board_request_below(void) { ICSR = 1u << 28; }

void board_start_sampling(uint32_t ticks) {
    SHPR3 |= 0xFFu << 16; /* PendSV has the lowest priority */
    SYST_RVR = ticks - 1;
    SYST_CVR = 0;
    SYST_CSR = 7; /* the core's clock, interrupt, on */
}
