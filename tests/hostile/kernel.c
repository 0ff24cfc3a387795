/* What the calls of an FMU return and hold is what libFuzzer says, in each form in which
   kernel.c can have it: types, FMI 2 and 3, clock, copies, latency, faults.  What the
   kernel says and records must then be one of what there is. */
#include "../../orchestrator/native/kernel.c"

#include <float.h>
#include <stdlib.h>

enum { MANY = 3, ROWS = 6, PERIOD = 2, TYPES = 12 };

static const uint8_t *data; /* what is not used yet */
static size_t left;

static void take(void *place, size_t n) { /* 0 when there is no more */
    size_t taken = n < left ? n : left;
    memset(place, 0, n);
    memcpy(place, data, taken);
    data += taken;
    left -= taken;
}

static unsigned below(unsigned n) {
    uint8_t byte;
    take(&byte, 1);
    return byte % n;
}

static double number(void) { /* often a small one */
    double it;
    int8_t small;
    take(&small, 1);
    if (small != 127)
        return small * 0.25;
    take(&it, sizeof it);
    return it;
}

static double finite(void) { /* as what a scenario says */
    double it = number();
    return isfinite(it) ? it : 1;
}

static int status(void) {
    uint8_t byte;
    take(&byte, 1);
    return byte < 240 ? byte % 2 : (int)byte - 245;
}

static const struct {
    int width;
    double low, high;
} types[TYPES] = { /* in the order of calls.h */
    {8, 0, 0}, {8, 0, 0}, {8, 0, 0}, {4, -FLT_MAX, FLT_MAX}, {1, -128, 127}, {1, 0, 255},
    {2, -32768, 32767}, {2, 0, 65535}, {4, -0x1p31, 0x1p31 - 1}, {4, 0, 0x1p32 - 1},
    {4, 0, 1}, {1, 0, 1},
};
static int type_of_outputs;

static int get2(void *i, const uint32_t *r, size_t n, char *v) {
    (void)i, (void)r;
    if (type_of_outputs == F64)
        for (size_t k = 0; k < n; k++) {
            double it = number();
            memcpy(v + 8 * k, &it, 8);
        }
    else
        take(v, n * (size_t)types[type_of_outputs].width);
    return status();
}
static int get3(void *i, const uint32_t *r, size_t n, char *v, size_t size) {
    (void)n;
    return get2(i, r, size, v);
}
static int set2(void *i, const uint32_t *r, size_t n, const void *v) {
    (void)i, (void)r, (void)n, (void)v;
    return status();
}
static int set3(void *i, const uint32_t *r, size_t n, const void *v, size_t size) {
    (void)i, (void)r, (void)n, (void)v, (void)size;
    return status();
}
static int step2(void *i, double t, double h, int unused) {
    (void)i, (void)t, (void)h, (void)unused;
    return status();
}
static void flag(void *place) { /* mostly 0 */
    uint8_t byte;
    take(&byte, 1);
    *(uint8_t *)place = byte < 200 ? 0 : byte;
}
static int step3(void *i, double t, double h, _Bool no, void *event, void *ended,
                 void *early, double *reached) {
    (void)i, (void)no;
    flag(event);
    flag(ended);
    flag(early);
    *reached = below(4) ? t + h : number();
    return status();
}
static int set_clock(void *i, const uint32_t *r, size_t n, const _Bool *active) {
    (void)i, (void)r, (void)n, (void)active;
    return status();
}
static int update(void *i, void *more, void *terminates, void *a, void *b, void *c,
                  double *next) {
    (void)i;
    flag(more);
    flag(terminates);
    flag(a);
    flag(b);
    flag(c);
    *next = number();
    return status();
}
static int enter(void *i) {
    (void)i;
    return status();
}

static void must(int so) {
    if (!so)
        abort();
}

/* A vector of inputs, what was read, what is published, each of MANY values. */
int LLVMFuzzerTestOneInput(const uint8_t *given, size_t n) {
    static const uint32_t references[MANY] = {4, 0, 9};
    static const Ticker ticker = {(Function *)set_clock, (Function *)update,
                                  (Function *)enter, (Function *)enter, 1};
    data = given;
    left = n;
    int from = (int)below(TYPES), to = (int)below(TYPES), major = 2 + (int)below(2);
    int clocked = major == 3 && below(2);
    type_of_outputs = from;
    double *v = calloc(3 * MANY, sizeof *v), clock;
    double *line = calloc(2 * MANY, sizeof *line), *memory = calloc(3, sizeof *memory);
    double *time = calloc(ROWS, sizeof *time), *columns = calloc(ROWS * MANY, sizeof *v);
    void *inputs = to <= U64 ? (void *)v : calloc(MANY, (size_t)types[to].width);
    void *outputs = from <= U64 ? (void *)(v + MANY) : calloc(MANY, (size_t)types[from].width);
    int64_t rows = 0;
    Group in = {.set = (Function *)(major == 2 ? (Function *)set2 : (Function *)set3),
                .references = references, .n_references = MANY, .size = MANY,
                .values = v, .buffer = inputs, .low = types[to].low,
                .high = types[to].high, .type = to, .major = major};
    Group out = in;
    out.get = major == 2 ? (Function *)get2 : (Function *)get3;
    out.values = v + MANY;
    out.buffer = outputs;
    out.type = from;
    Copy copies[MANY];
    int kind_from = from <= U64 ? from : F64, kind_to = to <= U64 ? to : F64;
    size_t exact = kind_from == F64 && kind_to == F64 ? below(MANY + 1) : 0;
    for (size_t i = 0; i < MANY; i++) {
        copies[i] = (Copy){v + i, v + 2 * MANY + i, 1, 0, kind_from, kind_to, 0, 0, 0};
        if (i >= exact && below(2)) {
            copies[i].gain = finite();
            copies[i].offset = finite();
        }
    }
    size_t doubles = kind_from == F64 && kind_to == F64 ? exact + below(MANY + 1 - exact)
                                                         : exact;
    for (size_t i = doubles; i < MANY && kind_to == F64; i++)
        if (to > F32 && below(2)) {
            copies[i].law = 1 + (int)below(2);
            copies[i].low = in.low;
            copies[i].high = in.high;
        }
    const Span span = {0, from == F64 || from == F32 ? MANY : 0};
    Outcome outcome = {0};
    size_t latency = below(3);
    Part part = {.do_step = major == 2 ? (Function *)step2 : (Function *)step3,
                 .clock = &clock, .inputs = &in, .outputs = &out, .n_inputs = 1,
                 .n_outputs = 1, .copies = copies, .n_copies = MANY, .n_exact = exact,
                 .n_doubles = doubles, .raw = v + MANY, .published = v + 2 * MANY,
                 .n_read = MANY, .n_delayed = latency ? 1 + below(MANY) : 0,
                 .spans = &span, .n_spans = 1, .line = line,
                 .latency = latency ? latency : 1, .major = major, .outcome = &outcome,
                 .ticker = clocked ? &ticker : NULL};
    const double *sources[MANY] = {v, v + MANY, v + 2 * MANY};
    const Table table = {time, columns, sources, MANY, ROWS, &rows};
    Fault fault = {(int32_t)below(6), 2, 1, 4, 0.5, memory};
    Faulty faulty = {0, v, &fault, kind_to == F64, 0, (int32_t)below(2), 0, 2, 1, 0.5, -0.5};
    const Op all[] = {{RELEASE, 0, 0, 0}, {WRITE, 0, 0, 0}, {STEP, 0, PERIOD, 0.25},
                      {READ, 0, 0, 0},    {HOLD, 0, 0, 0},  {COPY, 0, 0, 0},
                      {FAULT, 0, 1, 0},   {ROW, 0, 0, 0}};
    const Program program = {all, sizeof all / sizeof *all};
    const int64_t offsets[2] = {0, 1};
    const int32_t numbers[2] = {0, 0};
    const Stretch stretch = {0, PERIOD, offsets, numbers, 2};
    Kernel kernel = {.parts = &part, .tables = &table, .programs = &program,
                     .tick_num = 1, .tick_den = 8, .profiled = (int32_t)below(2),
                     .faulty = &faulty, .n_faulty = 1};
    kernel_begin(&kernel);
    int64_t done = kernel_run(&kernel, &stretch, 0, ROWS);
    must(done >= 0 && done <= ROWS && rows >= done && rows <= done + 1);
    must(kernel.failure >= NONE && kernel.failure <= ENDED);
    must(kernel.failure || done == ROWS);
    must(kernel.failure != ENDED || outcome.last);
    for (int64_t row = 0; row < rows; row++) {
        double read = columns[ROWS + row];
        if (kind_from != F64)
            continue;
        must(isfinite(read));
        must(from <= F32 || (read >= types[from].low && read <= types[from].high));
    }
    if (inputs != v)
        free(inputs);
    if (outputs != v + MANY)
        free(outputs);
    free(columns);
    free(time);
    free(memory);
    free(line);
    free(v);
    return 0;
}
