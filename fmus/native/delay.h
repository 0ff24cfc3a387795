/* Exact dead time of one piecewise-constant input.

   A line keeps the value that has arrived and every later change with the time
   at which it was made.  What arrives is forgotten, so a line is as long as the
   changes within one dead time; how many it can hold is fixed before stepping.
   Raising the dead time while changes are under way holds the value that has
   arrived until the next change is due. */
#ifndef DELAY_H
#define DELAY_H

#include "names.h"

#include <stddef.h>

typedef struct {
    double time, value;
} Change;

typedef struct {
    double value;    /* what has arrived */
    Change *changes; /* a ring */
    Change *grown;   /* the same if it is of the heap, or NULL */
    size_t first, count, capacity;
} DelayLine;

/* Empty the line; it delivers value until a change arrives. */
void delay_reset(DelayLine *line, double value);

/* Make room for capacity changes in all; returns 0 if there is no memory. */
int delay_reserve(DelayLine *line, size_t capacity);

/* Enter the input's value from time on; only a change is stored.
   Returns 0 if the line is full. */
int delay_enter(DelayLine *line, double time, double value);

/* The change that arrives as the nth from now (0: next), or NULL. */
const Change *delay_next(const DelayLine *line, size_t n);

/* Let the next change arrive. */
void delay_arrive(DelayLine *line);

void delay_free(DelayLine *line);

#endif
