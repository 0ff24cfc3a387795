/* Exact dead time of one piecewise-constant input.

   A line keeps the value that has arrived and every later change with the time
   at which it was made.  What arrives is forgotten, so a line is as long as the
   changes within one dead time.  Raising the dead time while changes are under
   way holds the value that has arrived until the next change is due. */
#ifndef DELAY_H
#define DELAY_H

#include "names.h"

#include <stddef.h>

typedef struct {
    double time, value;
} Change;

typedef struct {
    double value; /* what has arrived */
    Change *changes;
    size_t first, count, capacity;
} DelayLine;

/* Empty the line; it delivers value until a change arrives. */
void delay_reset(DelayLine *line, double value);

/* Enter the input's value from time on; only a change is stored.
   Returns 0 if there is no memory for it. */
int delay_enter(DelayLine *line, double time, double value);

/* The change that arrives next, or NULL. */
const Change *delay_next(const DelayLine *line);

/* Let that change arrive. */
void delay_arrive(DelayLine *line);

void delay_free(DelayLine *line);

#endif
