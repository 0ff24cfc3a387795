/* Every way through kernel.c, calls.h and faults.h on an FMU of a few lines, whose calls
   return what they are told to: each type, each failure of each call, each law of copies
   and faults, clocks that tick, refuse and never settle.  Says what is not so. */
#include "kernel_paths.h"

static const struct {
    int type, width, major;
    double low, high;
} types[] = {
    {F32, 4, 3, -FLT_MAX, FLT_MAX}, {I8, 1, 3, -128, 127},   {U8, 1, 3, 0, 255},
    {I16, 2, 3, -32768, 32767},     {U16, 2, 3, 0, 65535},   {BOOL8, 1, 3, 0, 1},
    {I32, 4, 2, -0x1p31, 0x1p31 - 1}, {U32, 4, 3, 0, 0x1p32 - 1}, {BOOL32, 4, 2, 0, 1},
    {F64, 8, 3, 0, 0},
};

static void of_types(void) {
    for (size_t k = 0; k < sizeof types / sizeof *types; k++) {
        int small = types[k].type != F64;
        anew(types[k].major);
        fmu.width = (size_t)types[k].width;
        in.type = out.type = types[k].type;
        in.low = types[k].low;
        in.high = types[k].high;
        if (small)
            in.buffer = out.buffer = buffer;
        for (int i = 0; i < MANY; i++)
            vector[i] = i % 2 ? in.high : in.low;
        wanted(does(WRITE) && does(READ));
        wanted(!memcmp(vector, vector + MANY, MANY * sizeof(double)));
        for (double *bad = vector; small && bad == vector; bad++) {
            const double values[] = {in.low - 1, in.high * 2 + 1, NAN, 0.5};
            for (int i = 0; i < (types[k].type == F32 ? 3 : 4); i++) {
                *bad = values[i];
                wanted(types[k].type == F32 && i == 0 /* the same float */
                           ? does(WRITE)
                           : !does(WRITE) && kernel.failure == DOES_NOT_FIT);
            }
        }
        vector[0] = in.low;
        fmu.set = WARNING;
        wanted(does(WRITE));
        for (int status = -1; status <= ERROR; status += 1 + ERROR) {
            fmu.set = fmu.get = status;
            wanted(!does(WRITE) && kernel.failure == SET_FAILED);
            wanted(!does(READ) && kernel.failure == GET_FAILED);
            wanted(kernel.status == status && kernel.part == 0 && kernel.group == 0);
        }
    }
    anew(2);
    for (int i = 0; i < MANY; i++) { /* of the second value nobody asks */
        ((double *)fmu.values)[i] = i == 1 ? NAN : 1;
        wanted(does(READ) || i > 1);
    }
    ((double *)fmu.values)[2] = INFINITY;
    wanted(!does(READ) && kernel.failure == NOT_FINITE);
}

typedef union {
    double number;
    int64_t word;
} Bits;

static int copied(Copy copy, Bits from, Bits *to) {
    copy.source = &from.number;
    copy.sink = &to->number;
    part.copies = &copy;
    part.n_copies = 1;
    part.n_exact = part.n_doubles = 0;
    return does(COPY);
}

static void of_copies(void) {
    enum { REFUSED = -1 };
    const int64_t big = INT64_C(1) << 53;
    const struct {
        int from, to;
        double gain, offset, number;
        int64_t word; /* of an integer */
        double expected;
        int64_t expected_word;
        int fits;
    } cases[] = {
        {I64, U64, 1, 0, 0, 5, 0, 5, 1},
        {I64, U64, 1, 0, 0, -5, 0, 0, 0},
        {U64, I64, 1, 0, 0, INT64_MIN, 0, 0, 0}, /* 2^63 */
        {I64, F64, 1, 0, 0, -7, -7, 0, 1},
        {I64, F64, 1, 0, 0, big + 1, 0, 0, 0},
        {I64, F64, 1, 0, 0, INT64_MAX, 0, 0, 0},
        {U64, F64, 1, 0, 0, 9, 9, 0, 1},
        {U64, F64, 1, 0, 0, big + 1, 0, 0, 0},
        {U64, F64, 1, 0, 0, -1, 0, 0, 0}, /* 2^64 - 1 */
        {I64, F64, 0.5, 0, 0, 3, 1.5, 0, 1},
        {U64, F64, 1, 0.25, 0, -1, 0x1p64, 0, 1},
        {I64, I64, 2, 0, 0, -4, 0, -8, 1},
        {F64, I64, 1, 0, -0x1p63, 0, 0, INT64_MIN, 1},
        {F64, I64, 1, 0, 0x1p63, 0, 0, 0, 0},
        {F64, I64, 1, 0, -0x1p64, 0, 0, 0, 0},
        {F64, I64, 1, 0, 1.5, 0, 0, 0, 0},
        {F64, U64, 1, 0, 0x1p63, 0, 0, INT64_MIN, 1},
        {F64, U64, 1, 0, -1, 0, 0, 0, 0},
        {F64, U64, 1, 0, 0x1p64, 0, 0, 0, 0},
        {F64, I64, 2, 0, 1.5, 0, 0, 3, 1},
    };
    anew(3);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        Copy copy = {.gain = cases[k].gain, .offset = cases[k].offset,
                     .from = cases[k].from, .to = cases[k].to};
        Bits from = {.number = cases[k].number}, to = {0};
        if (copy.from != F64)
            from.word = cases[k].word;
        int done = copied(copy, from, &to);
        wanted(done == cases[k].fits);
        wanted(done || kernel.failure == COPY_FAILED);
        if (done && copy.to == F64)
            wanted(to.number == cases[k].expected);
        if (done && copy.to != F64)
            wanted(to.word == cases[k].expected_word);
    }
    const double given[] = {-3.4, 0.5, 1.49, 12, NAN, 0x1p60, -131},
                 saturated[] = {-3, 1, 1, 4, NAN, 4, -4},
                 wrapped[] = {-3, 1, 1, 3, NAN, NAN, 4};
    for (int k = 0; k < 7; k++) {
        Copy copy = {.gain = 1, .low = -4, .high = 4, .law = 1};
        Bits from = {.number = given[k]}, to = {0};
        wanted(copied(copy, from, &to) == (given[k] == given[k]));
        wanted(given[k] != given[k] || to.number == saturated[k]);
        copy.law = 2;
        wanted(copied(copy, from, &to) == (wrapped[k] == wrapped[k]));
        wanted(wrapped[k] != wrapped[k] || to.number == wrapped[k]);
    }
    Copy three[] = {{vector + 4, vector, 1, 0, F64, F64, 0, 0, 0},
                    {vector + 5, vector, 2, 1, F64, F64, 0, 0, 0},
                    {vector + 6, vector, 1, 0, F64, F64, 0, 0, 0}};
    part.copies = three;
    part.n_exact = 1;
    part.n_doubles = 2;
    part.n_copies = 3;
    vector[0] = 0.75;
    three[2].from = I64, three[2].to = F64;
    vector[1] = 0; /* the bits of 0 */
    three[2].source = vector + 1;
    wanted(does(COPY) && vector[4] == 0.75 && vector[5] == 2.5 && vector[6] == 0);
}

static void of_steps(void) {
    const Op now = {STEP, 0, 0, 0.125}, since[] = {{STEP, 0, 3, 0.125}},
             long_ago[] = {{STEP, 0, 2, 0.125}};
    anew(3);
    wanted(run(&now, 1, 2) == 2 && clock_ == 0.375 && part.steps == 2);
    wanted(run(since, 1, 2) == 2 && clock_ == 0); /* the instant before */
    wanted(run(long_ago, 1, 2) == 2 && clock_ == 0.125);
    fmu.early = 1;
    wanted(!does(STEP) && kernel.failure == STEP_FAILED && outcome.early);
    fmu.early = 0, fmu.ended = 1, fmu.part_of_step = 0.5;
    wanted(!does(STEP) && outcome.ended && !outcome.last);
    fmu.step = ERROR;
    wanted(!does(STEP) && kernel.status == ERROR);
    fmu.step = -1, fmu.ended = 0;
    wanted(!does(STEP) && kernel.status == -1);
    fmu.step = 0, fmu.ended = 1, fmu.part_of_step = 1;
    wanted(run(&now, 1, 2) == 1 && kernel.failure == ENDED && kernel.part == 0);
    anew(2);
    wanted(run(&now, 1, 5) == 5);
    fmu.step = ERROR;
    wanted(run(&now, 1, 5) == 0 && kernel.failure == STEP_FAILED && kernel.h == 0.125);
}

static void of_clocks(void) {
    anew(3);
    part.ticker = &ticker;
    wanted(does(STEP) && part.pending && does(READ) && !part.pending);
    fmu.updates = 3;
    wanted(does(STEP) && fmu.updates == -1);
    fmu.updates = 1000; /* it never settles, and is taken as it is */
    wanted(does(STEP) && fmu.updates == 900);
    fmu.updates = 0, fmu.terminates = 1;
    wanted(!does(STEP) && kernel.failure == TICK_FAILED && kernel.status == 2);
    fmu.terminates = 0, fmu.update = ERROR;
    wanted(!does(STEP) && kernel.status == ERROR);
    fmu.update = 0, fmu.clock = ERROR;
    wanted(!does(STEP) && kernel.failure == TICK_FAILED);
    fmu.clock = 0, fmu.enter_step = ERROR;
    wanted(does(STEP) && !does(READ) && kernel.failure == STEP_FAILED);
    fmu.enter_step = 0, fmu.step = ERROR;
    wanted(does(STEP) && !does(READ) && kernel.status == ERROR);
    fmu.step = 0, fmu.enter_event = ERROR;
    wanted(does(STEP) && !does(READ) && kernel.status == ERROR);
    fmu.enter_event = 0, part.n_outputs = 0;
    wanted(does(STEP) && !part.pending);
    fmu.ended = 1;
    wanted(does(STEP) && kernel.ending == 1);
}

static void of_lines_rows_and_signals(void) {
    const double signal[] = {0.5, -2};
    const Injection injections[] = {{vector, vector, signal, 2, 0, 1},
                                    {vector + 1, vector + 3, signal, 2, 0, 3}};
    const Op ops[] = {{RELEASE, 0, 0, 0}, {HOLD, 0, 0, 0},   {INJECT, 0, 0, 0},
                      {INJECT, 1, 0, 0},  {ROW, 0, 0, 0}};
    const Op failing[] = {{HOLD, 0, 0, 0}, {READ, 0, 0, 0}, {WRITE, 0, 0, 0},
                          {STEP, 0, 0, 0.125}};
    int32_t noted[3] = {-1, -1, -1};
    for (int profiled = 0; profiled < 2; profiled++) {
        anew(2);
        memset(line, 0, sizeof line);
        part.head = 0;
        kernel.injections = injections;
        kernel.profiled = profiled;
        kernel.noted = noted;
        vector[3] = 1;
        for (int i = 0; i < MANY; i++)
            vector[MANY + i] = i + 1;
        wanted(run(ops, 5, 9) == 2 && kernel.full && rows == 2);
        wanted(columns[0] == 0.5 && columns[1] == -1.5 && times[1] == 0.375);
        wanted(vector[1] == -1 && vector[2 * MANY] == 0 && vector[3 * MANY - 1] == 4);
        rows = 0;
        wanted(run(ops, 5, 2) == 2 && vector[2 * MANY] == 1); /* two samples later */
        wanted(noted[0] == 0 && noted[1] == ROW);
        wanted(run(failing, 4, 3) == 3);
        fmu.step = ERROR;
        wanted(run(failing, 4, 3) == 0);
        wanted(!profiled || (part.readings && kernel.readings && part.spent >= 0));
    }
    wanted(kernel_reading() >= 0);
}

static double renewed(Faulty *f, Fault *fault, int64_t k, double given, int back) {
    const Op op = {FAULT, 0, back, 0};
    const Now now = {k, -1, 0, 0};
    f->faults = fault;
    f->n = fault != NULL;
    *f->place = given;
    wanted(carry_out(&kernel, &op, &now));
    return *f->place;
}

static void of_faults(void) {
    double memory[3], place;
    const struct {
        int kind;
        double value, acting, resting;
    } laws[] = {{STUCK, 0, 2, 5},         {BIAS, 0.5, 5.5, 5}, {GAIN, 3, 15, 5},
                {QUANTISATION, 2, 6, 5}, {OVERRIDE, -1, -1, 5}};
    anew(3);
    for (size_t i = 0; i < sizeof laws / sizeof *laws; i++)
        for (int converts = 0; converts < 2; converts++) {
            Fault fault = {laws[i].kind, 0, 10, 20, laws[i].value, memory};
            Faulty f = {.place = &place, .faults = &fault, .n = 1, .converts = converts,
                        .gain = 2, .offset = 1, .back_gain = 0.5, .back_offset = -0.5};
            double acting = converts ? 2 * laws[i].acting + 1 : laws[i].acting;
            double five = converts ? 11 : 5, two = converts ? 5 : 2;
            kernel.faulty = &f;
            kernel.n_faulty = 1;
            place = two;
            kernel_begin(&kernel);
            wanted(f.clean == two && memory[0] == 2);
            wanted(renewed(&f, &fault, 10, five, 1) == acting); /* its first instant */
            wanted(renewed(&f, &fault, 20, five, 1) == five);   /* it is over */
            wanted(renewed(&f, &fault, 9, five, 1) == five);
            f.source = 1; /* another publishes: nothing is renewed */
            wanted(renewed(&f, &fault, 10, 77, 1) == 77);
            wanted(renewed(&f, NULL, 10, 77, 0) == five);
        }
    Fault late = {DELAY, 2, 0, 100, 0, memory};
    Faulty f = {.place = &place, .faults = &late, .n = 1};
    kernel.faulty = &f;
    place = 1;
    kernel_begin(&kernel);
    wanted(memory[0] == 1 && memory[2] == 1);
    wanted(renewed(&f, &late, 1, 2, 1) == 1 && renewed(&f, &late, 2, 3, 1) == 1);
    wanted(renewed(&f, &late, 3, 4, 1) == 2);
    wanted(renewed(&f, &late, 3, 9, 0) == 2); /* renewed without a publication */
    wanted(renewed(&f, &late, 100, 5, 1) == 5);
    kernel.n_faulty = 0;
    kernel_begin(&kernel);
}

int main(void) {
    of_types();
    of_copies();
    of_steps();
    of_clocks();
    of_lines_rows_and_signals();
    of_faults();
    if (!wrong)
        printf("every way\n");
    return wrong;
}
