/* The board of `c-api/examples` on QEMU's machine `virt` with a RISC-V core: the machine timer samples. The C library,
 * picolibc, brings start-up code and output by semihosting. */
#include "board.h"

/* CLINT: the timer counts at 10 MHz. */
#define MTIME (*(volatile uint32_t *)0x0200BFF8u)
#define MTIMECMP ((volatile uint32_t *)0x02004000u)

/* The ticks of `board_start_sampling` are of 168 MHz. */
enum { CORE_MHZ = 168, TIMER_MHZ = 10 };

static uint32_t interval;

/* Compares with the low word; the high word is 0 for the seven minutes in which the low one does not wrap. */
static void next(uint32_t time) {
    MTIMECMP[1] = 0;
    MTIMECMP[0] = time + interval;
}

__attribute__((interrupt, aligned(4))) static void timer_interrupt(void) {
    next(MTIMECMP[0]);
    SysTick_Handler();
}

void board_start_sampling(uint32_t ticks) {
    interval = ticks / CORE_MHZ * TIMER_MHZ;
    next(MTIME);
    __asm__ volatile("csrw mtvec, %0\n csrs mie, %1\n csrsi mstatus, 8" ::"r"(timer_interrupt), "r"(1u << 7) : "memory");
}
