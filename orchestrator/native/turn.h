/* A number that two processes share: one sets it, the other waits for it to change. */
#ifndef TURN_H
#define TURN_H

#include <stdint.h>

typedef struct {
    uint32_t number;
    uint32_t slept_on; /* somebody sleeps until it changes */
    char _[56];        /* a cache line of its own */
} Turn;

/* What waiting has taught: how many waits to go without a means that failed. */
typedef struct {
    int32_t rest, next_rest;
} Habit;

typedef struct {
    Habit spinning, yielding;
} Habits;

enum { CHANGED, UNCHANGED, SIGNALLED };

uint32_t turn_number(const Turn *turn);
void turn_set(Turn *turn, uint32_t number);

/* Waits for another number than `known`, a hundredth of a second or so at most. */
int turn_wait(Turn *turn, uint32_t known, Habits *habits);

#endif
