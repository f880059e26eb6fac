/* The recording of `held_out.s`: traces of the standard rig, one 16-bit count a channel and sample. */
#ifndef HELD_OUT_H
#define HELD_OUT_H

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif
extern const int16_t held_out_start[], held_out_end[];
#ifdef __cplusplus
}
#endif

/* Counts of a converter, which spans the limits of the model's channels, as physical values. */
static inline void held_out_values(const int16_t *counts, float *values) {
    static const float limits[BW_MODEL_CHANNELS] = BW_MODEL_CHANNEL_LIMITS;
    for (uint32_t k = 0; k < BW_MODEL_CHANNELS; k++) {
        values[k] = (float)counts[k] * (limits[k] / 32768.0f);
    }
}

#endif
