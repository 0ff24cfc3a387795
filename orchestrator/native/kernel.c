/* Carries out a timetable on FMU instances at native speed.

   Python makes every structure here, keeps them alive, and calls kernel_run for
   a stretch of instants at a time; nothing is allocated, no state is kept apart
   from the structures.  An operation means exactly what it means to
   orchestrator/master/executor.py, in the same order of additions and products, so that
   both give the same bits:

       STEP     do_step from t - back ticks over h; the FMU's clock shows the start
       READ     get all outputs into raw, refuse what is not finite
       COPY     vector[sink] = gain * vector[source] + offset, 64-bit integers exactly
       RELEASE  publish the oldest row of the latency line, then COPY
       WRITE    set all inputs
       HOLD     put raw into the latency line, publish what is not delayed
       ROW      append time and columns to a table
       INJECT   add the next value of a signal to an input
       FAULT    renew the inputs with faults that the target feeds, or all of them

   kernel_run returns how many instants it finished.  It stops early when a table
   is full (after that instant) or when an operation fails; then kernel->failure
   says how, and Python asks the instance for the message. */

#define _POSIX_C_SOURCE 199309L /* clock_gettime */

#include "calls.h"
#include "kernel.h"

#include <math.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define EXPORT __declspec(dllexport)
#else
#include <time.h>
#define EXPORT __attribute__((visibility("default")))
#endif

enum { STEP, READ, COPY, RELEASE, WRITE, HOLD, ROW, FAULT, INJECT };

static double seconds(const Kernel *kernel, int64_t k) {
    return (double)(k * kernel->tick_num) / (double)kernel->tick_den;
}

/* Rounds, half a one upwards, and keeps the range; 0 if there is nothing to round. */
static int bring_into_range(const Copy *c, double v) {
    double whole = floor(v + 0.5);
    if (c->law == 1) {
        *c->sink = whole < c->low ? c->low : whole > c->high ? c->high : whole;
        return v == v;
    }
    if (!(fabs(whole) < 0x1p53))
        return 0;
    double span = c->high - c->low + 1, over = fmod(whole - c->low, span);
    *c->sink = c->low + (over < 0 ? over + span : over);
    return 1;
}

/* Between a 64-bit integer and another type; returns 0 if digits would be lost that
   no gain or offset asks to be. */
static int retype(const Copy *c) {
    int64_t word;
    double v = *c->source;
    memcpy(&word, c->source, sizeof word);
    int converts = c->gain != 1 || c->offset != 0 || c->law;
    if (!converts && c->from != F64 && c->to != F64) { /* the two integers */
        memcpy(c->sink, &word, sizeof word);
        return word >= 0;
    }
    if (c->from == I64)
        v = (double)word;
    if (c->from == U64)
        v = (double)(uint64_t)word;
    if (!converts && c->from == I64 && !(v < 0x1p63 && (int64_t)v == word))
        return 0;
    if (!converts && c->from == U64 && !(v < 0x1p64 && (uint64_t)v == (uint64_t)word))
        return 0;
    if (converts)
        v = c->gain * v + c->offset;
    if (c->law)
        return bring_into_range(c, v);
    if (c->to == F64) {
        *c->sink = v;
        return 1;
    }
    if (v != trunc(v) || !(c->to == I64 ? v >= -0x1p63 && v < 0x1p63
                                        : v >= 0 && v < 0x1p64))
        return 0;
    word = c->to == I64 ? (int64_t)v : (int64_t)(uint64_t)v;
    memcpy(c->sink, &word, sizeof word);
    return 1;
}

static ALWAYS_INLINE int copy(Kernel *kernel, const Part *p, const Op *op, int64_t k) {
    const Copy *c = p->copies, *exact = c + p->n_exact, *doubles = c + p->n_doubles;
    for (; c < exact; c++)
        memcpy(c->sink, c->source, sizeof *c->sink);
    for (; c < doubles; c++)
        *c->sink = c->gain * *c->source + c->offset;
    for (; c < p->copies + p->n_copies; c++)
        if (!retype(c))
            return fail(kernel, COPY_FAILED, k, op, (size_t)(c - p->copies), 0);
    return 1;
}

static void hold(Part *p) {
    double *row = p->line + p->head * p->n_delayed;
    memcpy(row, p->raw, p->n_delayed * sizeof(double));
    p->head = p->head + 1 == p->latency ? 0 : p->head + 1;
    memcpy(p->published + p->n_delayed, p->raw + p->n_delayed,
           (p->n_read - p->n_delayed) * sizeof(double));
}

static int release(Kernel *kernel, const Part *p, const Op *op, int64_t k) {
    const double *row = p->line + p->head * p->n_delayed;
    memcpy(p->published, row, p->n_delayed * sizeof(double));
    return copy(kernel, p, op, k);
}

static void renew(Kernel *kernel, const Op *op, int64_t k) {
    Faulty *f = kernel->faulty;
    for (; f < kernel->faulty + kernel->n_faulty; f++)
        if (!op->back || f->source == op->target)
            faulty_renew(f, k, op->back != 0);
}

static void inject(const Injection *i, int64_t k) {
    *i->sink = *i->before + i->values[(k - i->first) / i->every % i->n];
}

static ALWAYS_INLINE void record(Kernel *kernel, const Table *table, double t) {
    int64_t row = (*table->count)++;
    double *place = table->columns + row;
    table->time[row] = t;
    for (size_t c = 0; c < table->n_columns; c++, place += table->capacity)
        memcpy(place, table->sources[c], sizeof *place);
    if (*table->count == table->capacity)
        kernel->full = 1;
}

/* Instant k and the one before, with their times: a division each is saved. */
typedef struct {
    int64_t k, last_k;
    double t, last_t; /* s */
} Now;

static ALWAYS_INLINE double start_of(const Kernel *kernel, const Now *now,
                                     const Op *op) {
    int64_t k = now->k - op->back;
    return k == now->last_k ? now->last_t : k == now->k ? now->t : seconds(kernel, k);
}

/* Returns 0 if the operation fails. */
static ALWAYS_INLINE int carry_out(Kernel *kernel, const Op *op, const Now *now) {
    int64_t k = now->k;
    Part *p;
    if (op->code == INJECT) {
        inject(kernel->injections + op->target, k);
        return 1;
    }
    p = kernel->parts + op->target;
    if (kernel->noted) {
        kernel->noted[0] = op->target;
        kernel->noted[1] = op->code;
        kernel->noted[2] = (int32_t)((uint32_t)kernel->noted[2] + 1);
    }
    switch (op->code) {
    case STEP: return step(kernel, p, op, k, start_of(kernel, now, op));
    case READ: return get_outputs(kernel, p, op, k);
    case COPY: return copy(kernel, p, op, k);
    case RELEASE: return release(kernel, p, op, k);
    case WRITE: return set_inputs(kernel, p, op, k);
    case HOLD: hold(p); return 1;
    case FAULT: renew(kernel, op, k); return 1;
    default: record(kernel, kernel->tables + op->target, now->t); return 1;
    }
}

/* What follows the initialisation of all parts. */
EXPORT void kernel_begin(Kernel *kernel) {
    for (size_t i = 0; i < kernel->n_faulty; i++)
        faulty_begin(kernel->faulty + i);
}

/* Carry out one operation on the only part, for channel.c; returns 0 if it fails. */
int kernel_one(Kernel *kernel, int32_t code, double t, double h) {
    Op op = {code, 0, 0, h};
    const Now now = {0, 0, t, t};
    kernel->failure = NONE;
    return carry_out(kernel, &op, &now);
}

/* Seconds of a clock that only counts up. */
EXPORT double kernel_now(void) {
#ifdef _WIN32
    LARGE_INTEGER count, rate;
    QueryPerformanceCounter(&count);
    QueryPerformanceFrequency(&rate);
    return (double)count.QuadPart / (double)rate.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
}

/* What one reading of the clock takes (s). */
EXPORT double kernel_reading(void) {
    enum { N = 10000 };
    double begun = kernel_now(), now = begun;
    for (int i = 0; i < N; i++)
        now = kernel_now();
    return (now - begun) / N;
}

/* As carry_out, adding the time it takes to the part's or the master's. */
static int carry_out_timed(Kernel *kernel, const Op *op, const Now *now,
                           double *last) {
    int done = carry_out(kernel, op, now);
    double read = kernel_now(), spent = read - *last;
    *last = read;
    if (op->code == STEP || op->code == READ || op->code == WRITE) {
        kernel->parts[op->target].spent += spent;
        kernel->parts[op->target].readings++;
    } else {
        kernel->spent += spent;
        kernel->readings++;
    }
    return done;
}

/* Carry out instants from..from + count - 1 of the stretch, counted over all of
   its repetitions; returns how many were finished. */
EXPORT int64_t kernel_run(Kernel *kernel, const Stretch *stretch, int64_t from,
                          int64_t count) {
    size_t i = (size_t)from % stretch->n;
    int64_t begin = stretch->first + from / (int64_t)stretch->n * stretch->length;
    double last = kernel->profiled ? kernel_now() : 0;
    Now now = {-1, -1, 0, 0};
    kernel->full = kernel->failure = 0;
    for (int64_t done = 0; done < count; done++) {
        const Program *program = kernel->programs + stretch->programs[i];
        const Op *op = program->ops, *end = op + program->n;
        now.last_k = now.k;
        now.last_t = now.t;
        now.k = begin + stretch->offsets[i];
        now.t = seconds(kernel, now.k);
        if (kernel->profiled) {
            for (; op < end; op++)
                if (!carry_out_timed(kernel, op, &now, &last))
                    return done;
        } else {
            for (; op < end; op++)
                if (!carry_out(kernel, op, &now))
                    return done;
        }
        if (kernel->ending) {
            kernel->failure = ENDED;
            kernel->part = kernel->ending - 1;
        }
        if (kernel->full || kernel->ending)
            return done + 1;
        if (++i == stretch->n) {
            i = 0;
            begin += stretch->length;
        }
    }
    return count;
}
