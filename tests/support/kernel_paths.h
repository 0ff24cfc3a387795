/* The FMU of kernel_paths.c, whose calls return what they are told to, and the kernel
   around it. */
#include "../../orchestrator/native/kernel.c"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

static int wrong;

#define wanted(condition)                                                      \
    do {                                                                       \
        if (!(condition)) {                                                    \
            fprintf(stderr, "line %d: not so: %s\n", __LINE__, #condition);    \
            wrong = 1;                                                         \
        }                                                                      \
    } while (0)

enum { ERROR = 3, MANY = 4 };

/* What the FMU holds, and what its calls return. */
static struct {
    char values[8 * MANY];
    size_t width; /* bytes of a value */
    int get, set, step, clock, update, enter_step, enter_event;
    _Bool ended, early, terminates;
    double part_of_step; /* done by a step */
    int updates;         /* asked for after a tick */
} fmu;

static int get2(void *i, const uint32_t *r, size_t n, void *v) {
    (void)i, (void)r;
    memcpy(v, fmu.values, n * fmu.width);
    return fmu.get;
}
static int set2(void *i, const uint32_t *r, size_t n, void *v) {
    (void)i, (void)r;
    memcpy(fmu.values, v, n * fmu.width);
    return fmu.set;
}
static int get3(void *i, const uint32_t *r, size_t n, void *v, size_t size) {
    (void)i, (void)r, (void)n;
    memcpy(v, fmu.values, size * fmu.width);
    return fmu.get;
}
static int set3(void *i, const uint32_t *r, size_t n, void *v, size_t size) {
    (void)i, (void)r, (void)n;
    memcpy(fmu.values, v, size * fmu.width);
    return fmu.set;
}
static int step2(void *i, double t, double h, int unused) {
    (void)i, (void)t, (void)h, (void)unused;
    return fmu.step;
}
static int step3(void *i, double t, double h, _Bool unused, _Bool *event, _Bool *ended,
                 _Bool *early, double *reached) {
    (void)i, (void)unused;
    *event = 0;
    *ended = fmu.ended;
    *early = fmu.early;
    *reached = t + fmu.part_of_step * h;
    return fmu.step;
}
static int set_clock(void *i, const uint32_t *r, size_t n, const _Bool *active) {
    (void)i, (void)r, (void)n;
    wanted(*active);
    return fmu.clock;
}
static int update(void *i, _Bool *more, _Bool *terminates, _Bool *nominals,
                  _Bool *values, _Bool *defined, double *next) {
    (void)i;
    *more = fmu.updates-- > 0;
    *terminates = fmu.terminates;
    *nominals = *values = *defined = 0;
    *next = 0;
    return fmu.update;
}
static int enter_step(void *i) { (void)i; return fmu.enter_step; }
static int enter_event(void *i) { (void)i; return fmu.enter_event; }

static const uint32_t references[MANY] = {0, 1, 2, 3};
static double vector[3 * MANY], line[2 * MANY], columns[MANY], times[2];
static double clock_, buffer[MANY];
static int64_t rows;
static Outcome outcome;
static const Ticker ticker = {(Function *)set_clock, (Function *)update,
                              (Function *)enter_step, (Function *)enter_event, 7};
static const Span spans[] = {{0, 1}, {2, 3}};
static const double *const sources[] = {vector};
static const Table table = {times, columns, sources, 1, 2, &rows};
static Group in, out;
static Part part;
static Kernel kernel;

static void anew(int major) {
    memset(&fmu, 0, sizeof fmu);
    fmu.width = sizeof(double);
    fmu.part_of_step = 1;
    memset(vector, 0, sizeof vector);
    outcome = (Outcome){0, 0, 0, 0};
    rows = 0;
    in = (Group){.get = (Function *)(major == 2 ? (void (*)(void))get2
                                                : (void (*)(void))get3),
                 .set = (Function *)(major == 2 ? (void (*)(void))set2
                                                : (void (*)(void))set3),
                 .references = references, .n_references = MANY, .size = MANY,
                 .values = vector, .buffer = vector, .type = F64, .major = major};
    out = in;
    out.values = out.buffer = vector + MANY;
    part = (Part){.do_step = major == 2 ? (Function *)step2 : (Function *)step3,
                  .clock = &clock_, .inputs = &in, .outputs = &out, .n_inputs = 1,
                  .n_outputs = 1, .raw = vector + MANY, .published = vector + 2 * MANY,
                  .n_read = MANY, .n_delayed = MANY - 1, .spans = spans, .n_spans = 2,
                  .line = line, .latency = 2, .major = major, .outcome = &outcome};
    kernel = (Kernel){.parts = &part, .tables = &table, .tick_num = 1, .tick_den = 8};
}

/* Runs operations at each of n instants; returns how many were finished. */
static int64_t run(const Op *ops, size_t n_ops, int64_t n) {
    static const int64_t offsets[2] = {0, 3};
    static const int32_t numbers[2] = {0, 0};
    const Program program = {ops, n_ops};
    const Stretch stretch = {0, 5, offsets, numbers, 2};
    kernel.programs = &program;
    return kernel_run(&kernel, &stretch, 0, n);
}

static int does(int code) {
    return kernel_one(&kernel, code, 0.5, 0.25);
}
