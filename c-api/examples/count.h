/* Instructions and stack of a function, counted by the emulator. It executes one instruction in 256 ns of its time,
 * which are 43.008 ticks of the core's clock of 168 MHz. */
#ifndef COUNT_H
#define COUNT_H

#include <stdint.h>
#include <stdio.h>

#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)
#define LARGEST_COUNT 0xFFFFFFu

/* Words of stack that are painted, and words next to the stack pointer that the painting itself uses. */
#define PAINTED 20000
#define OWN 32
#define PAINT 0xA5A5A5A5u

static void start_counting(void) {
    SYST_RVR = LARGEST_COUNT;
    SYST_CVR = 0;
    SYST_CSR = 5; /* the core's clock, no interrupt, on */
}

/* Instructions of a call. */
static uint32_t instructions_of(void (*function)(void)) {
    uint32_t start = SYST_CVR;
    function();
    uint32_t ticks = (start - SYST_CVR) & LARGEST_COUNT;
    return (uint32_t)((uint64_t)ticks * 1000u / 43008u);
}

/* Bytes of stack that a function takes. */
static __attribute__((noinline)) uint32_t stack_of(void (*function)(void)) {
    /* By the register: the compiler knows the bounds of a variable. */
    volatile uint32_t *top;
    __asm__ volatile("mov %0, sp" : "=r"(top));
    uint32_t deepest = OWN;
    for (uint32_t k = OWN; k < PAINTED; k++) {
        *(top - k) = PAINT;
    }
    function();
    for (uint32_t k = OWN; k < PAINTED; k++) {
        if (*(top - k) != PAINT) {
            deepest = k;
        }
    }
    return 4u * deepest;
}

static void print(const char *what, uint32_t number) { printf("%s: %lu\n", what, (unsigned long)number); }

#endif
