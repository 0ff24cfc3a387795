/* What the fused loop works on; orchestrator/master/fused/library.py repeats it.

   Python makes every structure and keeps it alive; nothing is allocated here. */
#ifndef ENGINE_H
#define ENGINE_H

#include "lanes.h"

#include "faults.h"

#include <float.h>
#include <stddef.h>

#define PASTE(a, b) PASTE_(a, b)
#define PASTE_(a, b) a##b
#define NEVER_INLINE __attribute__((noinline))
#define ONCE static __attribute__((noinline, optnone))
#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

enum { FINE, NOT_FINITE_STEP, APART, LINE_FULL, UNSETTLED };

/* An input's value on its way through a dead time. */
typedef struct {
    V value, *values; /* what acts now; those under way */
    double *times;    /* s; when each was given */
    size_t first, count, capacity;
} Line;

typedef struct {
    unsigned input, dead_time; /* references */
} Delayed;

/* One component of ours. */
typedef struct {
    V *values;
    Line *lines; /* one per delayed input */
    V *held;     /* latency line, rows of what is delayed */
    size_t head;
    V wrong; /* NaN in the lanes whose latest step gave what is not finite */
    int32_t failure, _;
} Instance;

/* Values added to an input: to itself, or to what it `began` with. */
typedef struct {
    V began;
    const double *values;
    int64_t n, first, every; /* ticks */
} Injected;

static inline double injected_at(const Injected *i, int64_t k) {
    return i->values[(k - i->first) / i->every % i->n];
}

/* Rows of one period: column c of row r of lane i at values[(r * n + c) * W + i]. */
typedef struct {
    V *values;
    int64_t count;
} Rows;

typedef struct {
    V *vector;
    Instance *parts;
    Faulty *faults;
    Rows *rows;
    Injected *injections;
    void *kernel; /* of kernel.h, for FMUs that stay calls; else NULL */
    int64_t tick_num, tick_den; /* s */
    V alive;                    /* 1 in the lanes that go on */
    /* what happened: per lane, or to all of them */
    int32_t failed_part[W];
    int64_t failed_at[W];
    int32_t failure, part;
    int64_t instant;
} Engine;

static inline size_t next_of(const Line *line, size_t n) {
    return (line->first + n) % line->capacity;
}

/* Returns 0, and why, if the lanes part company or the line is full. */
static inline int delay_enter(Line *line, double time, V value, int32_t *why) {
    V last = line->count ? line->values[next_of(line, line->count - 1)] : line->value;
    int differ = lanes_differ(value, last);
    size_t place;
    if (!differ)
        return 1;
    if (differ < W || line->count == line->capacity) {
        *why = differ < W ? APART : LINE_FULL;
        return 0;
    }
    place = next_of(line, line->count++);
    line->times[place] = time;
    line->values[place] = value;
    return 1;
}

static inline double delay_time(const Line *line) {
    return line->times[line->first];
}

static inline void delay_arrive(Line *line) {
    line->value = line->values[line->first];
    line->first = next_of(line, 1);
    line->count--;
}

static inline double seconds_of(const Engine *e, int64_t k) {
    return (double)(k * e->tick_num) / (double)e->tick_den;
}

/* After a step: remember the lanes that gave what is not finite; 0 if none goes on. */
static inline int go_on(Engine *e, V wrong, int32_t part, int64_t k) {
    V marks = given(e->alive, wrong);
    int left = 0;
    if (!lanes_differ(marks, (V)0.0))
        return 1;
    for (int i = 0; i < W; i++) {
        if (lane(marks, i) != 0) { /* NaN differs from 0 */
            e->alive = with_lane(e->alive, i, 0.0);
            e->failed_part[i] = part;
            e->failed_at[i] = k;
        }
        left += lane(e->alive, i) != 0;
    }
    if (!left) {
        e->failure = NOT_FINITE_STEP;
        e->part = part;
        e->instant = k;
    }
    return left;
}

static int stopped(Engine *e, int32_t failure, int32_t part, int64_t k) {
    e->failure = failure;
    e->part = part;
    e->instant = k;
    return 0;
}

#endif
