/* Faults on connections: the laws of orchestrator/master/faults.py, for the kernel and
   for W lanes, which all have the same ones.  64-bit integers have only those that
   move a value (stuck, delay, override), which keeps its bits. */
#ifndef FAULTS_H
#define FAULTS_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#ifndef LANES_H
typedef double V;
#define v_floor floor
#endif

enum { STUCK, BIAS, GAIN, QUANTISATION, OVERRIDE, DELAY };

typedef struct {
    int32_t kind, samples;
    int64_t start, end; /* ticks: it acts while start <= k < end */
    double value;       /* of an override on an integer: its bits */
    V *memory;          /* stuck: the last value; delay: samples + 1, oldest first */
} Fault;

/* A number that has faults. */
typedef struct {
    V clean; /* what it would receive */
    V *place;
    const Fault *faults;
    int32_t n, source; /* the part whose copy brings it */
    int32_t converts, _;
    double gain, offset, back_gain, back_offset; /* from our side to the FMU's */
} Faulty;

static inline V faulty_ours(const Faulty *f) {
    return f->converts ? f->back_gain * f->clean + f->back_offset : f->clean;
}

static inline V faulty_law(const Fault *fault, V value, int acts, int published) {
    double given = fault->value;
    V *memory = fault->memory;
    switch (fault->kind) {
    case DELAY:
        if (published)
            memmove(memory, memory + 1, (size_t)fault->samples * sizeof *memory);
        memory[fault->samples] = value;
        return acts ? memory[0] : value;
    case STUCK:
        if (!acts)
            memory[0] = value;
        return memory[0];
    case BIAS: return acts ? value + given : value;
    case GAIN: return acts ? given * value : value;
    case QUANTISATION: return acts ? given * v_floor(value / given + 0.5) : value;
    default: return acts ? (V)given : value;
    }
}

/* Behind the initialisation, which sees no fault. */
static inline void faulty_begin(Faulty *f) {
    f->clean = *f->place;
    for (const Fault *fault = f->faults; fault < f->faults + f->n; fault++)
        for (int32_t i = 0; i <= fault->samples; i++)
            fault->memory[i] = faulty_ours(f);
}

/* At instant k, when a value was published or a window begins or ends. */
static inline void faulty_renew(Faulty *f, int64_t k, int published) {
    int any = 0;
    V value;
    if (published)
        f->clean = *f->place;
    value = faulty_ours(f);
    for (const Fault *fault = f->faults; fault < f->faults + f->n; fault++) {
        int acts = k >= fault->start && k < fault->end;
        any |= acts;
        value = faulty_law(fault, value, acts, published);
    }
    if (!any)
        value = f->clean; /* not rounded there and back */
    else if (f->converts)
        value = f->gain * value + f->offset;
    *f->place = value;
}

#endif
