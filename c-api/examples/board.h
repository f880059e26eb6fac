/* The little that the examples need of a board. A CubeMX or Zephyr project brings all of it. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The sampling interrupt: written by the program, called every `ticks` of the core's clock. */
void SysTick_Handler(void);
void board_start_sampling(uint32_t ticks);
/* The interrupt below it, PendSV_Handler of the program: runs once after each request, when no other does. */
void board_request_below(void);

#ifdef __riscv
static inline void board_mask_interrupts(void) { __asm__ volatile("csrci mstatus, 8" ::: "memory"); }
static inline void board_unmask_interrupts(void) { __asm__ volatile("csrsi mstatus, 8" ::: "memory"); }
#else
static inline void board_mask_interrupts(void) { __asm__ volatile("cpsid i" ::: "memory"); }
static inline void board_unmask_interrupts(void) { __asm__ volatile("cpsie i" ::: "memory"); }
#endif

#ifdef __cplusplus
}
#endif

#endif
