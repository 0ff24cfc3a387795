/* What Python hands to the kernel; orchestrator/native/library.py repeats it. */
#ifndef KERNEL_H
#define KERNEL_H

#include "faults.h"

#include <stddef.h>
#include <stdint.h>

typedef void Function(void); /* of an FMU, called by its true type */

/* Variables of one type.  Those of 8 bytes, doubles and 64-bit integers, lie in the
   vector, and buffer points there. */
typedef struct {
    Function *get, *set;
    const uint32_t *references;
    size_t n_references, size;
    double *values;
    void *buffer;
    double low, high; /* least and greatest value of the type */
    int32_t type, major;
} Group;

/* `from` and `to` are types: F64, I64 or U64.  `law` is for whole numbers from low to
   high: 0 none, 1 saturate, 2 wrap; see orchestrator/fmu/whole.py. */
typedef struct {
    double *sink;
    const double *source;
    double gain, offset;
    int32_t from, to, law;
    double low, high;
} Copy;

/* Some of the values read, all of them doubles. */
typedef struct {
    size_t first, end;
} Span;

/* How the latest step of an FMU ended; `last` after a whole one that ends the run. */
typedef struct {
    double reached; /* s */
    int32_t ended, early, last;
} Outcome;

/* What ticks an FMU by its clock; see orchestrator/instances/clocked.py. */
typedef struct {
    Function *set_clock, *update, *enter_step, *enter_event;
    uint32_t reference;
} Ticker;

typedef struct {
    void *instance;
    Function *do_step;
    double *clock; /* s; read by log callbacks */
    const Group *inputs, *outputs;
    size_t n_inputs, n_outputs;
    const Copy *copies; /* first those of the same bits, then of doubles */
    size_t n_copies, n_exact, n_doubles;
    double *raw, *published;
    size_t n_read, n_delayed;
    const Span *spans; /* of raw, that must be finite */
    size_t n_spans;
    double *line; /* latency rows of n_delayed values, next at head */
    size_t latency, head;
    int32_t major;
    int64_t steps, readings; /* readings of the clock, and s, when profiled */
    double spent;
    Outcome *outcome;
    const Ticker *ticker; /* NULL: do_step ticks */
    int32_t pending;      /* after a tick, until it was moved on */
    double h;
} Part;

typedef struct {
    double *time, *columns; /* column c of row r at columns[c * capacity + r] */
    const double *const *sources;
    size_t n_columns;
    int64_t capacity, *count;
} Table;

typedef struct {
    int32_t code, target; /* a part, a table or an injection */
    int64_t back; /* of a fault: whether its target published */
    double h;
} Op;

typedef struct {
    const Op *ops;
    size_t n;
} Program;

/* values[i mod n], at publication i, added to what `before` holds: the sink itself,
   or what it began with. */
typedef struct {
    double *sink;
    const double *before, *values;
    int64_t n, first, every; /* ticks */
} Injection;

typedef struct {
    Part *parts;
    const Table *tables;
    const Program *programs;
    int64_t tick_num, tick_den; /* s */
    int32_t profiled;
    /* what happened */
    int32_t full, ending, failure, status; /* ending: 1 + the part that ends the run */
    int64_t instant;
    int32_t part, group;
    double h;
    int64_t readings; /* as in Part, for everything that is not in an FMU */
    double spent;
    int32_t *noted; /* NULL, or where part, operation, count are noted */
    const Injection *injections;
    Faulty *faulty;
    size_t n_faulty;
} Kernel;

typedef struct {
    int64_t first, length;
    const int64_t *offsets;
    const int32_t *programs;
    size_t n;
} Stretch;

#endif
