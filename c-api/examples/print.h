/* What the examples print alike. */
#ifndef PRINT_H
#define PRINT_H

#include "bearing_watch.h"

#include <stdio.h>
#include <string.h>

static inline int failed(const char *what, BwCode code) {
    printf("%s: %s\n", what, bw_error_text(code));
    return 1;
}

/* The bits of a number. */
static inline unsigned long bits(float x) {
    uint32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

#endif
