/* An Arduino core whose converters play the recorded traces of the standard rig, each after the one before. */
#include "Arduino.h"

#include "board.h"

#include <stdio.h>

extern const int16_t held_out_start[], held_out_end[];
enum { PINS = 3, RATE_HZ = 500 };

static const int16_t *volatile row = held_out_start;
static void (*sampled)();

extern "C" void SysTick_Handler(void) {
    if (row < held_out_end) {
        sampled();
        row = row + PINS;
    }
}

void analogReadResolution(int) {}
int analogRead(uint32_t pin) { return row[pin] + 32768; }
/* The clock of the recording. */
uint32_t millis() { return 1000u / RATE_HZ * (uint32_t)((row - held_out_start) / PINS); }

void HardwareTimer::setOverflow(uint32_t value, TimerFormat_t) {
    if (value != RATE_HZ) { printf("a rate of %lu Hz\n", (unsigned long)value); }
}
void HardwareTimer::attachInterrupt(void (*callback)()) { sampled = callback; }
/* 3 ms at 168 MHz; the emulator executes only 3.9 instructions in 1 us. */
void HardwareTimer::resume() { board_start_sampling(504000); }

Port Serial;
void Port::begin(unsigned long) {}
void Port::print(const char *text) { printf("%s", text); }
void Port::println(const char *text) { printf("%s\n", text); }

int main() {
    setup();
    while (row < held_out_end) { loop(); }
    for (int k = 0; k < 1000; k++) { loop(); } /* the steps of the last segment */
    return 0;
}
