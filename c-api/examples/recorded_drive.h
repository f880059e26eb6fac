/* Stands for a drive: `rows.bin`, a recording that `bearing-watch replay --rows` wrote, in place of the converters; the
 * file `state.bin` of the computer in place of a flash sector; `SysTick` in place of the interrupt at the end of the
 * current conversion. A drive replaces all of it. */
#ifndef RECORDED_DRIVE_H
#define RECORDED_DRIVE_H

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The interrupts, written by the program: that of the current loop, and one below it. */
void SysTick_Handler(void);
void PendSV_Handler(void);
void drive_start_interrupts(void);
void drive_request_below(void);

/* What the converters read; false behind the end of the recording. */
bool drive_read(BwReading *now);
/* By a clock that does not come from the interrupt: on a board, another timer than that of the current loop. */
uint32_t drive_milliseconds(void);
/* Whether the recording goes on. */
bool drive_runs(void);

/* The bytes that the run before has stored: their number, 0 if there are none. */
size_t drive_load(uint8_t *bytes, size_t capacity);
/* Stores bytes for the next run; the exit status of the program. On a board: `bw_flash_save`. */
int drive_store(const uint8_t *bytes, size_t length);
/* Tells an error; the exit status. A drive goes into its safe state instead. */
int drive_failed(const char *text);

#ifdef __cplusplus
}
#endif

#endif
