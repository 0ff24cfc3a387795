/* Calls on one FMU instance, of either FMI version, for the operations of kernel.c:
   step it, get all its outputs, set all its inputs.  Inline, for speed.

   Each returns 0 if it fails; then kernel->failure and the rest say how. */
#ifndef CALLS_H
#define CALLS_H

#include "kernel.h"

#include <math.h>

enum {
    NONE, STEP_FAILED, GET_FAILED, SET_FAILED, NOT_FINITE, DOES_NOT_FIT, TICK_FAILED,
    COPY_FAILED, ENDED
};
enum { WARNING = 1 };

/* A negative status is none of FMI's, and no success. */
static inline int good(int status) {
    return 0 <= status && status <= WARNING;
}
enum { F64, I64, U64, F32, I8, U8, I16, U16, I32, U32, BOOL32, BOOL8 };
#define IN_PLACE(type) ((type) <= U64)

#if defined(__GNUC__)
#define ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define ALWAYS_INLINE inline
#endif

static ALWAYS_INLINE int call(const Group *g, Function *function, void *instance) {
    if (g->major == 2)
        return ((int (*)(void *, const uint32_t *, size_t, void *))function)(
            instance, g->references, g->n_references, g->buffer);
    return ((int (*)(void *, const uint32_t *, size_t, void *, size_t))function)(
        instance, g->references, g->n_references, g->buffer, g->size);
}

#define EACH(T, expression)                                                    \
    {                                                                          \
        T *b = g->buffer;                                                      \
        for (size_t i = 0; i < g->size; i++)                                   \
            expression;                                                        \
    }                                                                          \
    break

static void from_buffer(const Group *g) {
    double *v = g->values;
    switch (g->type) {
    case F32: EACH(float, v[i] = b[i]);
    case I8: EACH(int8_t, v[i] = b[i]);
    case U8: EACH(uint8_t, v[i] = b[i]);
    case I16: EACH(int16_t, v[i] = b[i]);
    case U16: EACH(uint16_t, v[i] = b[i]);
    case I32: EACH(int32_t, v[i] = b[i]);
    case U32: EACH(uint32_t, v[i] = b[i]);
    case BOOL32: EACH(int32_t, v[i] = b[i] != 0); /* what is not 0 is true */
    case BOOL8: EACH(uint8_t, v[i] = b[i] != 0);
    default: break;
    }
}

/* Returns 0 if a value does not fit into the type. */
static int to_buffer(const Group *g) {
    const double *v = g->values;
    for (size_t i = 0; i < g->size; i++)
        if (!(v[i] >= g->low && v[i] <= g->high) ||
            (g->type != F32 && v[i] != trunc(v[i])))
            return 0;
    switch (g->type) {
    case F32: EACH(float, b[i] = (float)v[i]);
    case I8: EACH(int8_t, b[i] = (int8_t)v[i]);
    case U8: EACH(uint8_t, b[i] = (uint8_t)v[i]);
    case I16: EACH(int16_t, b[i] = (int16_t)v[i]);
    case U16: EACH(uint16_t, b[i] = (uint16_t)v[i]);
    case I32: EACH(int32_t, b[i] = (int32_t)v[i]);
    case U32: EACH(uint32_t, b[i] = (uint32_t)v[i]);
    case BOOL32: EACH(int32_t, b[i] = v[i] != 0);
    case BOOL8: EACH(uint8_t, b[i] = v[i] != 0);
    default: break;
    }
    return 1;
}

/* What an FMU takes for a _Bool and may fill with anything, which no _Bool may hold. */
typedef unsigned char Flag;

static int fail(Kernel *kernel, int failure, int64_t k, const Op *op, size_t group,
                int status) {
    kernel->failure = failure;
    kernel->instant = k;
    kernel->part = op->target;
    kernel->group = (int32_t)group;
    kernel->status = status;
    kernel->h = op->h;
    return 0;
}

static int tick(const Part *p) {
    enum { UPDATES = 100, DISCARD = 2 };
    const Ticker *c = p->ticker;
    const _Bool active = 1;
    Flag flags[5] = {0};
    double next;
    int status = ((int (*)(void *, const uint32_t *, size_t, const _Bool *))
                      c->set_clock)(p->instance, &c->reference, 1, &active);
    for (int i = 0; i < UPDATES && good(status); i++) {
        status = ((int (*)(void *, Flag *, Flag *, Flag *, Flag *, Flag *,
                           double *))c->update)(p->instance, flags, flags + 1,
                                                flags + 2, flags + 3, flags + 4, &next);
        if (good(status) && flags[1])
            return DISCARD;
        if (!flags[0])
            break;
    }
    return status;
}

/* Returns 0 if the step fails, or ends the run before it is whole. */
static ALWAYS_INLINE int do_step(const Part *p, double t, double h, int *status) {
    const double whole = 1 - 1e-9; /* as in ending.py */
    double reached = t + h;
    Flag event, ended = 0, early = 0;
    if (p->major == 2) {
        *status = ((int (*)(void *, double, double, int))p->do_step)(p->instance, t, h,
                                                                     1);
        return good(*status);
    }
    *status = ((int (*)(void *, double, double, _Bool, Flag *, Flag *, Flag *,
                        double *))p->do_step)(p->instance, t, h, 1, &event, &ended,
                                              &early, &reached);
    if (good(*status) && !ended && !early)
        return 1;
    *p->outcome = (Outcome){reached, ended != 0, early != 0, 0};
    p->outcome->last = good(*status) && ended && reached >= t + h * whole;
    return p->outcome->last;
}

/* From the tick just done to the next, in event mode at both. */
static int move_on(Kernel *kernel, Part *p, const Op *op, int64_t k) {
    int (*enter_step)(void *) = (int (*)(void *))p->ticker->enter_step;
    int (*enter_event)(void *) = (int (*)(void *))p->ticker->enter_event;
    int status = enter_step(p->instance);
    p->pending = 0;
    if (good(status) && do_step(p, *p->clock, p->h, &status)) {
        if (p->outcome->last) {
            kernel->ending = 1 + op->target;
            return 1;
        }
        status = enter_event(p->instance);
        if (good(status))
            return 1;
    }
    fail(kernel, STEP_FAILED, k, op, 0, status);
    kernel->h = p->h;
    return 0;
}

static ALWAYS_INLINE int step(Kernel *kernel, Part *p, const Op *op, int64_t k,
                              double t) {
    int status;
    *p->clock = t;
    p->steps++;
    if (p->ticker) {
        status = tick(p);
        if (!good(status))
            return fail(kernel, TICK_FAILED, k, op, 0, status);
        p->pending = 1;
        p->h = op->h;
        return p->n_outputs ? 1 : move_on(kernel, p, op, k);
    }
    if (!do_step(p, t, op->h, &status))
        return fail(kernel, STEP_FAILED, k, op, 0, status);
    if (p->outcome->last)
        kernel->ending = 1 + op->target;
    return 1;
}

static ALWAYS_INLINE int get_outputs(Kernel *kernel, Part *p, const Op *op,
                                     int64_t k) {
    for (size_t i = 0; i < p->n_outputs; i++) {
        const Group *g = p->outputs + i;
        int status = call(g, g->get, p->instance);
        if (!good(status))
            return fail(kernel, GET_FAILED, k, op, i, status);
        if (!IN_PLACE(g->type))
            from_buffer(g);
    }
    if (p->pending && !move_on(kernel, p, op, k))
        return 0;
    for (const Span *s = p->spans; s < p->spans + p->n_spans; s++)
        for (size_t i = s->first; i < s->end; i++)
            if (!isfinite(p->raw[i]))
                return fail(kernel, NOT_FINITE, k, op, 0, 0);
    return 1;
}

static ALWAYS_INLINE int set_inputs(Kernel *kernel, const Part *p, const Op *op, int64_t k) {
    for (size_t i = 0; i < p->n_inputs; i++) {
        const Group *g = p->inputs + i;
        if (!IN_PLACE(g->type) && !to_buffer(g))
            return fail(kernel, DOES_NOT_FIT, k, op, i, 0);
        int status = call(g, g->set, p->instance);
        if (!good(status))
            return fail(kernel, SET_FAILED, k, op, i, status);
    }
    return 1;
}

#endif
