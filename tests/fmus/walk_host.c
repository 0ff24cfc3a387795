/* Drives many FMU libraries by random inputs and steps; a host for any platform.

   walk_host LIST STEPS
       LIST has a line for each walk: library, token, form (2cs, 3cs, 2me, 3me),
       step or longest step (s), 1 if steps are whole, number of continuous
       states; then groups of value reference and size, each begun by how many
       there are: inputs, outputs, and the start of each input element.
       Prints a line for each walk: a digest of all outputs and states at every
       step, the last output, and with COUNT_ALLOCATIONS how many times memory was
       asked for while stepping. */
#include "fmi2Functions.h"
#include "fmi3Functions.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) {
    return (void *)(uintptr_t)GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

static long allocations;
#ifdef COUNT_ALLOCATIONS
void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *malloc(size_t size) { allocations++; return __libc_malloc(size); }
void *calloc(size_t n, size_t size) { allocations++; return __libc_calloc(n, size); }
void *realloc(void *p, size_t size) { allocations++; return __libc_realloc(p, size); }
#endif

enum { MOST = 512 };
typedef struct {
    unsigned n, size, references[MOST], sizes[MOST], elements[MOST];
} Group;

static void *library, *instance;
static uint64_t noise, digest;

static void fail(const char *what) {
    printf("%s\n", what);
    exit(1);
}

static double uniform(void) {
    noise = noise * 6364136223846793005u + 1442695040888963407u;
    return (double)(noise >> 11) / 9007199254740992.0;
}

static void enter(const double *values, size_t n) {
    const unsigned char *bytes = (const unsigned char *)values;
    for (size_t i = 0; i < n * sizeof(double); i++)
        digest = (digest ^ bytes[i]) * 1099511628211u;
}

static void ok(int status, const char *what) {
    if (status != 0)
        fail(what);
}

static void *function(const char *name) {
    void *found = find(library, name);
    if (!found)
        fail(name);
    return found;
}

#define CALL(name, ...) ok((int)((name##TYPE *)function(#name))(instance, __VA_ARGS__), #name)
#define CALL_NOTHING(name) ok((int)((name##TYPE *)function(#name))(instance), #name)

static Group read_group(FILE *list) {
    Group group;
    memset(&group, 0, sizeof group);
    if (fscanf(list, "%u", &group.n) != 1 || group.n > MOST)
        fail("list");
    for (unsigned i = 0; i < group.n; i++) {
        if (fscanf(list, "%u %u", group.references + i, group.sizes + i) != 2)
            fail("list");
        for (unsigned k = 0; k < group.sizes[i]; k++)
            group.elements[group.size++] = group.references[i] + k;
    }
    return group;
}

static void set(int fmi, const Group *group, const double *values) {
    if (group->n && fmi == 2)
        CALL(fmi2SetReal, group->elements, group->size, values);
    else if (group->n)
        CALL(fmi3SetFloat64, group->references, group->n, values, group->size);
}

static void get(int fmi, const Group *group, double *values) {
    if (group->n && fmi == 2)
        CALL(fmi2GetReal, group->elements, group->size, values);
    else if (group->n)
        CALL(fmi3GetFloat64, group->references, group->n, values, group->size);
}

static void logger2(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status,
                    fmi2String category, fmi2String message, ...) {
    (void)e, (void)name, (void)status, (void)category;
    printf("%s ", message);
}

static void logger3(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category,
                    fmi3String message) {
    (void)e, (void)status, (void)category;
    printf("%s ", message);
}

static void begin(int fmi, int exchange, const char *token) {
    static const fmi2CallbackFunctions callbacks = {logger2, 0, 0, 0, 0};
    if (fmi == 2) {
        instance = ((fmi2InstantiateTYPE *)function("fmi2Instantiate"))(
            "walk", exchange ? fmi2ModelExchange : fmi2CoSimulation, token, "",
            &callbacks, 0, 1);
        if (!instance)
            fail("fmi2Instantiate");
        CALL(fmi2SetupExperiment, 0, 0, 0, 0, 0);
        CALL_NOTHING(fmi2EnterInitializationMode);
        CALL_NOTHING(fmi2ExitInitializationMode);
        if (exchange)
            CALL_NOTHING(fmi2EnterContinuousTimeMode);
        return;
    }
    if (exchange)
        instance = ((fmi3InstantiateModelExchangeTYPE *)function(
            "fmi3InstantiateModelExchange"))("walk", token, "", 0, 1, 0, logger3);
    else
        instance = ((fmi3InstantiateCoSimulationTYPE *)function(
            "fmi3InstantiateCoSimulation"))("walk", token, "", 0, 1, 0, 0, 0, 0, 0,
                                            logger3, 0);
    if (!instance)
        fail("fmi3Instantiate");
    CALL(fmi3EnterInitializationMode, 0, 0, 0, 0, 0);
    CALL_NOTHING(fmi3ExitInitializationMode);
    if (exchange)
        CALL_NOTHING(fmi3EnterContinuousTimeMode);
}

static void step(int fmi, double t, double h) {
    fmi3Boolean event, over, early;
    double reached;
    if (fmi == 2)
        CALL(fmi2DoStep, t, h, 1);
    else
        CALL(fmi3DoStep, t, h, 1, &event, &over, &early, &reached);
}

/* One step of Euler's method. */
static void exchange_step(int fmi, double t, double h, unsigned n) {
    double x[MOST], slope[MOST];
    if (fmi == 2) {
        CALL(fmi2SetTime, t);
        CALL(fmi2GetContinuousStates, x, n);
        CALL(fmi2GetDerivatives, slope, n);
    } else {
        CALL(fmi3SetTime, t);
        CALL(fmi3GetContinuousStates, x, n);
        CALL(fmi3GetContinuousStateDerivatives, slope, n);
    }
    for (unsigned i = 0; i < n; i++)
        x[i] = x[i] + h * slope[i];
    enter(x, n);
    if (fmi == 2)
        CALL(fmi2SetContinuousStates, x, n);
    else
        CALL(fmi3SetContinuousStates, x, n);
}

int main(int argc, char **argv) {
    char path[1024], token[256], form[8];
    double h, start[MOST], u[MOST], y[MOST];
    int whole, steps = argc > 2 ? atoi(argv[2]) : 0;
    unsigned n_x;
    FILE *list = argc > 2 ? fopen(argv[1], "r") : NULL;
    if (!list)
        fail("walk_host LIST STEPS");
    while (fscanf(list, "%1023s %255s %7s %lf %d %u", path, token, form, &h, &whole,
                  &n_x) == 6) {
        int fmi = form[0] - '0', exchange = form[1] == 'm';
        Group inputs = read_group(list), outputs = read_group(list);
        double t = 0;
        long before;
        for (unsigned i = 0; i < inputs.size; i++)
            if (fscanf(list, "%lf", start + i) != 1)
                fail("list");
        noise = 42;
        digest = 14695981039346656037u;
        library = load(path);
        if (!library)
            fail(path);
        begin(fmi, exchange, token);
        before = allocations;
#ifdef COUNT_ALLOCATIONS
        if (!before)
            fail("nothing is counted");
#endif
        for (int k = 0; k < steps; k++) {
            double now = h * (whole ? 1 + (int)(3 * uniform()) : 0.1 + uniform());
            for (unsigned i = 0; i < inputs.size; i++)
                if (k % 5 == 0 || i % 2)
                    u[i] = start[i] + (2 * uniform() - 1) *
                                          (start[i] != 0 ? 0.2 * start[i] : 0.1);
            set(fmi, &inputs, u);
            if (exchange)
                exchange_step(fmi, t, now, n_x);
            else
                step(fmi, t, now);
            t += now;
            get(fmi, &outputs, y);
            enter(y, outputs.size);
        }
        printf("%016llx %.17g %ld\n", (unsigned long long)digest,
               outputs.size ? y[outputs.size - 1] : 0.0, allocations - before);
        fflush(stdout);
        if (fmi == 2)
            ((fmi2FreeInstanceTYPE *)function("fmi2FreeInstance"))(instance);
        else
            ((fmi3FreeInstanceTYPE *)function("fmi3FreeInstance"))(instance);
    }
    return 0;
}
