/* Calls the functions of an FMU's sources in random order with random arguments,
   of which many are wrong: other lengths, NULL, unknown references, NaN.

   random_calls CALLS SEED; linked with the sources, FMI defined as 2 or 3.
   Prints how many calls were made and how many returned OK.  Every array has
   exactly the size it is said to have, so that a sanitizer sees a byte beyond. */
#include "model.h"

#if FMI == 2
#include "fmi2Functions.h"
typedef fmi2ValueReference Reference;
typedef fmi2Component Handle;
typedef int Truth;
#else
#include "fmi3Functions.h"
typedef fmi3ValueReference Reference;
typedef fmi3Instance Handle;
typedef _Bool Truth;
#endif

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define M feeddrive_model
#define MANY 3   /* instances and states at a time */
#define LONG 6   /* references in one call, at most */

static unsigned long long seed;
static long fine, messages;

static unsigned below(unsigned n) { /* splitmix64 */
    unsigned long long z = (seed += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (unsigned)((z ^ (z >> 31)) % n);
}

static int rarely(void) {
    return below(20) == 0;
}

static double number(void) {
    static const double wild[] = {NAN, INFINITY, -INFINITY, 1e300, -1e-300, -0.0};
    return rarely() ? wild[below(6)] : ((double)below(2001) - 1000.0) / 500.0;
}

static void *array(size_t n, size_t size) {
    return rarely() ? NULL : malloc(n * size ? n * size : 1);
}

static double *numbers(size_t n) {
    double *values = array(n, sizeof *values);
    for (size_t i = 0; values && i < n; i++)
        values[i] = number();
    return values;
}

/* The length of a step: mostly a few periods, never one that takes minutes. */
static double length(void) {
    static const double odd[] = {0.0, -1e-3, NAN, 1e-12, 1e15, INFINITY};
    double period = M.continuous ? 1e-4 : (double)M.period_num / (double)M.period_den;
    return rarely() ? odd[below(6)] : period * (1 + below(20)) / 4;
}

static struct {
    Handle it;
    double t;
} pool[MANY];
static void *states[MANY];
static unsigned char *bytes;
static size_t n_bytes;

static void heard(const char *format, va_list arguments) {
    char text[4096];
    vsnprintf(text, sizeof text, format, arguments);
    messages += strlen(text) > 0;
}

static Reference references[LONG];
static size_t n_references, n_values;

/* Choose references, existing and not, and how many values they take. */
static const Reference *chosen(void) {
    n_references = below(LONG + 1);
    n_values = 0;
    Reference *copy = array(n_references, sizeof *copy);
    for (size_t i = 0; i < n_references; i++) {
        unsigned reference = below(M.size + 1 + (unsigned)rarely() * 100000);
        n_values += reference < M.size
                        ? M.variables[M.variable_of[reference]].size
                        : 1;
        references[i] = reference;
    }
    if (copy)
        memcpy(copy, references, n_references * sizeof *copy);
    if (rarely())
        n_values = below(9);
    return copy;
}

static size_t some_states(void) {
    return rarely() ? below(9) : M.continuous ? M.n_x : (rarely() ? M.n_x : 0);
}

static void damage(void) {
    if (bytes && n_bytes && below(4) == 0)
        bytes[below((unsigned)n_bytes)] ^= (unsigned char)(1 + below(255));
}

#if FMI == 2
#define F(name) fmi2##name
static void log_message(fmi2ComponentEnvironment environment, fmi2String instance,
                        fmi2Status status, fmi2String category, fmi2String format, ...) {
    va_list arguments;
    va_start(arguments, format);
    heard(format, arguments);
    va_end(arguments);
}

static Handle create(int exchange) {
    static const fmi2CallbackFunctions callbacks = {log_message, NULL, NULL, NULL, NULL};
    return fmi2Instantiate(rarely() ? NULL : "it",
                           exchange ? fmi2ModelExchange : fmi2CoSimulation,
                           rarely() ? "other" : M.token, NULL,
                           rarely() ? NULL : &callbacks, 0, below(2));
}

static int begin(Handle c, unsigned which) {
    switch (which) {
    case 0:
        return fmi2SetupExperiment(c, below(2), number(), rarely() ? number() : 0.0,
                                   rarely(), number());
    case 1:
        return fmi2EnterInitializationMode(c);
    case 2:
        return fmi2EnterEventMode(c);
    default: {
        fmi2EventInfo *info = array(1, sizeof *info);
        int status = fmi2NewDiscreteStates(c, info);
        free(info);
        return status;
    }
    }
}

static int transfer(Handle c, unsigned which) {
    Reference *vr = (Reference *)chosen();
    double *values = numbers(n_references);
    int *truths = array(n_references, sizeof *truths), status;
    for (size_t i = 0; truths && i < n_references; i++)
        truths[i] = (int)below(2);
    switch (which) {
    case 0: status = fmi2SetReal(c, vr, n_references, values); break;
    case 1: status = fmi2GetBoolean(c, vr, n_references, truths); break;
    case 2: status = fmi2SetBoolean(c, vr, n_references, truths); break;
    case 3: status = fmi2GetInteger(c, vr, n_references, truths); break;
    case 4: status = fmi2SetString(c, vr, n_references, NULL); break;
    default: status = fmi2GetReal(c, vr, n_references, values);
    }
    free(vr);
    free(values);
    free(truths);
    return status;
}

static int step(Handle c, double t, double h) {
    return fmi2DoStep(c, t, h, 1);
}

static int ask(Handle c, unsigned which) {
    double *time = array(1, sizeof *time);
    int *ended = array(1, sizeof *ended), status;
    status = which ? fmi2GetRealStatus(c, fmi2LastSuccessfulTime, time)
                   : fmi2GetBooleanStatus(c, fmi2Terminated, ended);
    free(time);
    free(ended);
    return status;
}
#define GET_STATE fmi2GetFMUstate
#define SET_STATE fmi2SetFMUstate
#define FREE_STATE fmi2FreeFMUstate
#define SIZE fmi2SerializedFMUstateSize
#define WRITE(c, s, b, n) fmi2SerializeFMUstate(c, s, (fmi2Byte *)(b), n)
#define READ(c, b, n, s) fmi2DeSerializeFMUstate(c, (const fmi2Byte *)(b), n, s)
#define DERIVATIVES fmi2GetDerivatives
#else
#define F(name) fmi3##name
static void log_message(fmi3InstanceEnvironment environment, fmi3Status status,
                        fmi3String category, fmi3String message) {
    messages += strlen(message) > 0;
}

static Handle create(int exchange) {
    const char *name = rarely() ? NULL : "it", *token = rarely() ? "other" : M.token;
    fmi3LogMessageCallback log = rarely() ? NULL : log_message;
    if (exchange)
        return fmi3InstantiateModelExchange(name, token, NULL, 0, below(2), NULL, log);
    return fmi3InstantiateCoSimulation(name, token, NULL, 0, below(2), below(2), 0, NULL,
                                       rarely(), NULL, log, NULL);
}

static int begin(Handle c, unsigned which) {
    switch (which) {
    case 0: {
        double *x = numbers(1);
        size_t *count = array(1, sizeof *count);
        int status = rarely() ? fmi3GetNumberOfEventIndicators(c, count)
                              : fmi3GetNumberOfContinuousStates(c, count);
        free(x);
        free(count);
        return status;
    }
    case 1:
        return fmi3EnterInitializationMode(c, below(2), number(),
                                           rarely() ? number() : 0.0, rarely(),
                                           number());
    case 2:
        return fmi3EnterEventMode(c);
    default: {
        Truth *told = array(5, sizeof *told);
        int status = rarely()
                         ? fmi3UpdateDiscreteStates(c, NULL, NULL, NULL, NULL, NULL, NULL)
                     : told ? fmi3UpdateDiscreteStates(c, told, told + 1, told + 2,
                                                       told + 3, told + 4, NULL)
                            : fmi3EnterStepMode(c);
        free(told);
        return status;
    }
    }
}

static int transfer(Handle c, unsigned which) {
    Reference *vr = (Reference *)chosen();
    double *values = numbers(n_values), *intervals = numbers(n_references);
    Truth *truths = array(n_values, sizeof *truths);
    Truth *clocks = array(n_references, sizeof *clocks);
    fmi3IntervalQualifier *qualifiers = array(n_references, sizeof *qualifiers);
    fmi3UInt64 *counters = array(n_references, sizeof *counters);
    int status;
    for (size_t i = 0; truths && i < n_values; i++)
        truths[i] = below(2) != 0;
    for (size_t i = 0; clocks && i < n_references; i++)
        clocks[i] = below(2) != 0;
    if (which > 2 && which < 7 && vr && n_references && below(2))
        vr[0] = M.size; /* the clock, where there is one */
    switch (which) {
    case 0: status = fmi3SetFloat64(c, vr, n_references, values, n_values); break;
    case 1: status = fmi3GetBoolean(c, vr, n_references, truths, n_values); break;
    case 2: status = fmi3SetBoolean(c, vr, n_references, truths, n_values); break;
    case 3: status = fmi3SetClock(c, vr, n_references, clocks); break;
    case 4: status = fmi3GetClock(c, vr, n_references, clocks); break;
    case 5:
        status = fmi3GetIntervalDecimal(c, vr, n_references, intervals, qualifiers);
        break;
    case 6:
        status = fmi3GetIntervalFraction(c, vr, n_references, counters, counters,
                                         qualifiers);
        break;
    case 7: status = fmi3GetInt32(c, vr, n_references, NULL, n_values); break;
    case 8: status = fmi3SetBinary(c, vr, n_references, NULL, NULL, n_values); break;
    default: status = fmi3GetFloat64(c, vr, n_references, values, n_values);
    }
    free(vr);
    free(values);
    free(intervals);
    free(truths);
    free(clocks);
    free(qualifiers);
    free(counters);
    return status;
}

static int step(Handle c, double t, double h) {
    Truth event, ends, early;
    double last;
    return rarely() ? fmi3DoStep(c, t, h, 1, NULL, NULL, NULL, NULL)
                    : fmi3DoStep(c, t, h, 1, &event, &ends, &early, &last);
}

static int ask(Handle c, unsigned which) {
    double *values = numbers(n_values);
    int status = which ? fmi3GetEventIndicators(c, values, below(2))
                       : fmi3EnterConfigurationMode(c);
    free(values);
    return status;
}
#define GET_STATE fmi3GetFMUState
#define SET_STATE fmi3SetFMUState
#define FREE_STATE fmi3FreeFMUState
#define SIZE fmi3SerializedFMUStateSize
#define WRITE(c, s, b, n) fmi3SerializeFMUState(c, s, (fmi3Byte *)(b), n)
#define READ(c, b, n, s) fmi3DeserializeFMUState(c, (const fmi3Byte *)(b), n, s)
#define DERIVATIVES fmi3GetContinuousStateDerivatives
#endif

static int exchange(Handle c, unsigned which) {
    const size_t n = some_states();
    double *x = numbers(n);
    Truth *told = array(2, sizeof *told);
    int status;
    switch (which) {
    case 0: status = F(EnterContinuousTimeMode)(c); break;
    case 1: status = F(SetTime)(c, number()); break;
    case 2: status = F(SetContinuousStates)(c, x, n); break;
    case 3: status = F(GetContinuousStates)(c, x, n); break;
    case 4: status = F(GetNominalsOfContinuousStates)(c, x, n); break;
    case 5:
        status = F(CompletedIntegratorStep)(c, 1, told, told ? told + 1 : NULL);
        break;
    default: status = DERIVATIVES(c, x, n);
    }
    free(x);
    free(told);
    return status;
}

static int save(Handle c, unsigned which) {
    void **state = states + below(MANY);
    switch (which) {
    case 0: return GET_STATE(c, rarely() ? NULL : state);
    case 1: return SET_STATE(c, *state);
    case 2: return FREE_STATE(c, rarely() ? NULL : state);
    case 3: {
        size_t size = 0;
        int status = SIZE(c, *state, rarely() ? NULL : &size);
        if (status || !size)
            return status;
        free(bytes);
        n_bytes = rarely() ? size - 1 : size;
        bytes = malloc(n_bytes);
        status = WRITE(c, *state, bytes, n_bytes);
        if (status)
            memset(bytes, 1, n_bytes);
        damage();
        return status;
    }
    default: return READ(c, rarely() ? NULL : bytes, n_bytes, state);
    }
}

static int call(unsigned i) {
    Handle c = pool[i].it;
    if (!c) {
        pool[i].it = create(M.continuous && !M.advance && !M.n_delays && below(2));
        pool[i].t = 0;
        return !pool[i].it;
    }
    switch (below(16)) {
    case 0:
    case 1: return begin(c, below(4));
    case 2: return F(ExitInitializationMode)(c);
    case 3:
    case 4:
    case 5: return transfer(c, below(14));
    case 6:
    case 7: return exchange(c, below(8));
    case 8:
    case 9: return save(c, below(5));
    case 10: return ask(c, below(2));
    case 11:
        if (rarely()) {
            static const char *const known[] = {"logAll", "nothing", NULL};
            return F(SetDebugLogging)(c, below(2), below(4), rarely() ? NULL : known);
        }
        if (below(4))
            return begin(c, 1);
        return below(4) ? F(Reset)(c) : F(Terminate)(c);
    case 12:
        if (below(8))
            return transfer(c, 13);
        F(FreeInstance)(c);
        pool[i].it = NULL;
        return 0;
    default: {
        const double h = length(), t = rarely() ? number() : pool[i].t;
        int status = step(c, t, h);
        if (!status)
            pool[i].t = t + h;
        else if (rarely())
            pool[i].t = 0; /* after a reset it begins there */
        return status;
    }
    }
}

int main(int argc, char **argv) {
    const long calls = argc > 1 ? atol(argv[1]) : 1000;
    seed = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    for (long k = 0; k < calls; k++)
        fine += call(below(MANY)) == 0;
    Handle last = create(0);
    while (!last)
        last = create(0);
    for (unsigned i = 0; i < MANY; i++) {
        FREE_STATE(last, states + i);
        F(FreeInstance)(pool[i].it);
    }
    F(FreeInstance)(last);
    free(bytes);
    printf("%ld calls, %ld OK, %ld messages\n", calls, fine, messages);
    return 0;
}
