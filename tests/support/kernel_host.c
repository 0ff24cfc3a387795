/* Runs kernel.c on an FMU linked into this program: 1000 times create, initialise,
   run 50 instants with a latency line and a table, free.  TOKEN is the FMU's;
   with CLOCKED every fourth instance is ticked by its clock. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "../../orchestrator/native/kernel.c"

#include "fmi2Functions.h"
#include "fmi3Functions.h"

#include <stdio.h>
#include <stdlib.h>

enum { INSTANTS = 50, LATENCY = 2 };

static void die(const char *what) {
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}

static void quiet2(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c,
                   fmi2String m, ...) {
}

static void quiet3(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String m) {
    fprintf(stderr, "%s\n", m);
}

static void *create(int major, int clocked) {
    static const fmi2CallbackFunctions callbacks = {quiet2, NULL, NULL, NULL, NULL};
    void *it;
    if (major == 2) {
        it = fmi2Instantiate("it", fmi2CoSimulation, TOKEN, NULL, &callbacks, 0, 1);
        if (!it || fmi2SetupExperiment(it, 0, 0, 0, 0, 0) ||
            fmi2EnterInitializationMode(it) || fmi2ExitInitializationMode(it))
            die("FMI 2");
        return it;
    }
    it = fmi3InstantiateCoSimulation("it", TOKEN, NULL, 0, 1, clocked, 0, NULL, 0, NULL,
                                     quiet3, NULL);
    if (!it || fmi3EnterInitializationMode(it, 0, 0, 0, 0, 0) ||
        fmi3ExitInitializationMode(it))
        die("FMI 3");
    return it;
}

static void run(int major, int clocked) {
    /* references of the first input and output of the test models */
    uint32_t input = INPUT_REFERENCE, output = OUTPUT_REFERENCE;
    double *v = calloc(3, sizeof *v), clock = 0; /* input, raw, published */
    double *line = calloc(LATENCY, sizeof *line);
    double *rows = malloc(2 * INSTANTS * sizeof *rows);
    int64_t count = 0;
    void *it = create(major, clocked);
    Group in = {.references = &input, .n_references = 1, .size = 1, .values = v,
                .buffer = v, .type = F64, .major = major};
    Group out = in;
    out.references = &output;
    out.values = out.buffer = v + 1;
    in.set = major == 2 ? (Function *)fmi2SetReal : (Function *)fmi3SetFloat64;
    out.get = major == 2 ? (Function *)fmi2GetReal : (Function *)fmi3GetFloat64;
    Ticker ticker = {(Function *)fmi3SetClock, (Function *)fmi3UpdateDiscreteStates,
                     (Function *)fmi3EnterStepMode, (Function *)fmi3EnterEventMode,
                     CLOCK_REFERENCE};
    Copy copy = {v, v + 2, 0.5, 1.0, F64, F64};
    Span span = {0, 1};
    Outcome outcome = {0};
    Part part = {.instance = it, .outcome = &outcome,
                 .do_step = major == 2 ? (Function *)fmi2DoStep : (Function *)fmi3DoStep,
                 .clock = &clock, .inputs = &in, .outputs = &out, .n_inputs = 1,
                 .n_outputs = 1, .copies = &copy, .n_copies = 1, .n_doubles = 1,
                 .raw = v + 1, .spans = &span, .n_spans = 1,
                 .published = v + 2, .n_read = 1, .n_delayed = 1, .line = line,
                 .latency = LATENCY, .major = major,
                 .ticker = clocked ? &ticker : NULL};
    const double *source = v + 2;
    Table table = {rows, rows + INSTANTS, &source, 1, INSTANTS, &count};
    Op ops[] = {{RELEASE, 0, 0, 0}, {WRITE, 0, 0, 0}, {STEP, 0, 0, 1e-3},
                {READ, 0, 0, 0},    {HOLD, 0, 0, 0},  {ROW, 0, 0, 0}};
    Program program = {ops, sizeof ops / sizeof *ops};
    int64_t offset = 0;
    int32_t number = 0;
    Stretch stretch = {0, 1, &offset, &number, 1};
    Kernel kernel = {.parts = &part, .tables = &table, .programs = &program,
                     .tick_num = 1, .tick_den = 1000, .profiled = clocked};
    if (kernel_run(&kernel, &stretch, 0, INSTANTS) != INSTANTS || kernel.failure ||
        !kernel.full || count != INSTANTS)
        die("kernel_run");
    if (major == 2) {
        fmi2Terminate(it);
        fmi2FreeInstance(it);
    } else {
        fmi3Terminate(it);
        fmi3FreeInstance(it);
    }
    free(v);
    free(line);
    free(rows);
}

int main(void) {
    for (int i = 0; i < 1000; i++)
        run(i % 2 ? 2 : 3, CLOCKED && i % 4 == 2);
    printf("1000 instances\n");
    return 0;
}
