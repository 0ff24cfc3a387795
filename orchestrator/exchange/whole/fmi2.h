/* FMI 2.0 co-simulation around a fused loop; included behind the generated tables.

   Leaving initialisation carries out instant 0, doStep(t, h) all instants in
   (t, t + h].  Steps are counted in ticks: |h/tick - n| < 1e-3 is exactly n, so that a
   master that counts nanoseconds loses none. */
#include "fmi2Functions.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

enum { SETTING, INITIALISING, RUNNING };

typedef struct {
    Memory memory;
    int64_t now, repeat; /* ticks; of the stretch */
    size_t stretch, entry;
    int32_t mode, fresh, aligned;
    int32_t stops, _;
    double start, stop; /* s */
} State;

typedef struct {
    State state;
    const fmi2CallbackFunctions *callbacks;
    char name[256];
    int logging;
} Slave;

static fmi2Status fail(const Slave *s, const char *text, const char *detail) {
    if (s->logging && s->callbacks && s->callbacks->logger)
        s->callbacks->logger(s->callbacks->componentEnvironment, s->name, fmi2Error,
                             "logStatusError", "%s%s", text, detail);
    return fmi2Error;
}

static fmi2Status failed(const Slave *s) {
    const Engine *e = &s->state.memory.e;
    char text[400];
    const char *why = e->failure == LINE_FULL
                          ? "a delayed input changed too often within its dead time"
                      : e->failure == UNSETTLED
                          ? "an initial circle has no solution that is found"
                          : "a value that is not finite";
    snprintf(text, sizeof text, "%s at t = %.9g s: %s", part_names[e->part],
             seconds_of(e, e->instant), why);
    return fail(s, text, "");
}

/* Carries out what is due up to a tick. */
static int run_to(State *s, int64_t target) {
    Engine *e = &s->memory.e;
    while (s->stretch < N_STRETCHES) {
        const Stretch *here = stretches + s->stretch;
        int64_t k = here->first + s->repeat * here->length + here->offsets[s->entry];
        if (k > target)
            break;
        if (!carry_out_program(e, here->programs[s->entry], k, seconds_of(e, k)))
            return 0;
        if (++s->entry < here->n)
            continue;
        s->entry = 0;
        if (++s->repeat == here->repeats) {
            s->repeat = 0;
            s->stretch++;
        }
    }
    s->now = target;
    return 1;
}

static void begin(Slave *s) {
    memset(&s->state, 0, sizeof s->state);
    start_values(&s->state.memory);
    bind_memory(&s->state.memory);
    s->state.aligned = 1;
}

/* Computes what outputs are in initialisation. */
static int initialised(Slave *s) {
    if (s->state.fresh)
        return 1;
    s->state.fresh = 1;
    s->state.memory.e.failure = FINE;
    return engine_start(&s->state.memory.e);
}

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                                           const fmi2String categories[]) {
    (void)n, (void)categories;
    ((Slave *)c)->logging = on != 0;
    return fmi2OK;
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type,
                                          fmi2String guid, fmi2String place,
                                          const fmi2CallbackFunctions *callbacks,
                                          fmi2Boolean visible, fmi2Boolean logging) {
    Slave *s = calloc(1, sizeof *s);
    (void)place, (void)visible;
    if (!s)
        return NULL;
    s->callbacks = callbacks;
    s->logging = 1; /* why there is no instance is always told */
    snprintf(s->name, sizeof s->name, "%s", name ? name : "");
    if (type != fmi2CoSimulation || !guid || strcmp(guid, GUID) != 0) {
        fail(s, "this FMU is for co-simulation, and its guid is ", GUID);
        free(s);
        return NULL;
    }
    if (!*s->name) {
        fail(s, "an instance needs a name", "");
        free(s);
        return NULL;
    }
    s->logging = logging != 0;
    begin(s);
    return s;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c) { free(c); }

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerant,
                                           fmi2Real tolerance, fmi2Real start,
                                           fmi2Boolean stops, fmi2Real stop) {
    State *s = &((Slave *)c)->state;
    (void)tolerant, (void)tolerance;
    s->start = start;
    s->stops = stops != 0;
    s->stop = stop;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ((Slave *)c)->state.mode = INITIALISING;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Slave *s = c;
    if (!initialised(s) || !run_to(&s->state, 0))
        return failed(s);
    s->state.mode = RUNNING;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Terminate(fmi2Component c) { return c ? fmi2OK : fmi2Error; }

FMI2_Export fmi2Status fmi2Reset(fmi2Component c) {
    begin(c);
    return fmi2OK;
}

static double *place_of(Slave *s, const Variable *v) {
    return (double *)((char *)&s->state.memory + v->place);
}

static fmi2Status get(Slave *s, fmi2ValueReference vr, int boolean, double *value) {
    if (vr >= N_VARIABLES || variables[vr].boolean != boolean)
        return fail(s, "no variable of this type has the value reference asked for", "");
    if (s->state.mode == INITIALISING && variables[vr].kind == OUTPUT && !initialised(s))
        return failed(s);
    const Variable *v = variables + vr;
    double held = *place_of(s, v);
    if (v->kind == OUTPUT)
        *value = v->converts ? v->gain * held + v->offset : held;
    else
        *value = v->converts ? (held - v->offset) / v->gain : held;
    return fmi2OK;
}

static fmi2Status set(Slave *s, fmi2ValueReference vr, int boolean, double value) {
    if (vr >= N_VARIABLES || variables[vr].boolean != boolean)
        return fail(s, "no variable of this type has the value reference given", "");
    const Variable *v = variables + vr;
    if (v->kind == OUTPUT || (v->kind == PARAMETER && s->state.mode == RUNNING))
        return fail(s, "an output, or a parameter after initialisation, cannot be set",
                    "");
    if (value - value != 0)
        return fail(s, "a value that is not finite cannot be set", "");
    *place_of(s, v) = v->converts ? v->gain * value + v->offset : value;
    if (s->state.mode == INITIALISING)
        s->state.fresh = 0;
    return fmi2OK;
}

#define ACCESS(Name, T, boolean)                                                       \
    FMI2_Export fmi2Status fmi2Get##Name(fmi2Component c,                              \
                                         const fmi2ValueReference vr[], size_t n,      \
                                         T values[]) {                                 \
        for (size_t i = 0; i < n; i++) {                                               \
            double value;                                                              \
            if (get(c, vr[i], boolean, &value) != fmi2OK)                              \
                return fmi2Error;                                                      \
            values[i] = (T)value;                                                      \
        }                                                                              \
        return fmi2OK;                                                                 \
    }                                                                                  \
    FMI2_Export fmi2Status fmi2Set##Name(fmi2Component c,                              \
                                         const fmi2ValueReference vr[], size_t n,      \
                                         const T values[]) {                           \
        for (size_t i = 0; i < n; i++)                                                 \
            if (set(c, vr[i], boolean, values[i]) != fmi2OK)                           \
                return fmi2Error;                                                      \
        return fmi2OK;                                                                 \
    }
ACCESS(Real, fmi2Real, 0)
ACCESS(Boolean, fmi2Boolean, 1)
ACCESS(Integer, fmi2Integer, 2) /* there are none */

FMI2_Export fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[],
                                     size_t n, fmi2String values[]) {
    (void)vr, (void)values;
    return n ? fail(c, "there are no texts", "") : fmi2OK;
}

FMI2_Export fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[],
                                     size_t n, const fmi2String values[]) {
    (void)vr, (void)values;
    return n ? fail(c, "there are no texts", "") : fmi2OK;
}

FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h,
                                  fmi2Boolean final) {
    Slave *s = c;
    const Engine *e = &s->state.memory.e;
    double tick = (double)e->tick_num / (double)e->tick_den, ticks = h / tick;
    int64_t n = (int64_t)floor(ticks + 0.5), target;
    (void)final;
    if (s->state.mode != RUNNING || !(h > 0))
        return fail(s, "doStep takes a positive step, after initialisation", "");
    if (s->state.aligned && n > 0 && fabs(ticks - (double)n) < 1e-3)
        target = s->state.now + n;
    else {
        s->state.aligned = 0;
        target = (int64_t)floor((t - s->state.start + h) / tick + 1e-3);
    }
    if (s->state.stops &&
        (double)target > (s->state.stop - s->state.start) / tick + 1e-3)
        return fail(s, "the step goes past the stop time", "");
    if (target > LAST)
        return fail(s, "the timetable of this FMU ends before that time", "");
    return run_to(&s->state, target) ? fmi2OK : failed(s);
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component c) {
    return fail(c, "no step is under way", "");
}

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    const Slave *s = c;
    if (!*state && !(*state = malloc(sizeof(State))))
        return fail(s, "there is no memory", "");
    memcpy(*state, &s->state, sizeof(State));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Slave *s = c;
    memcpy(&s->state, state, sizeof(State));
    bind_memory(&s->state.memory);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state,
                                                  size_t *size) {
    (void)c, (void)state;
    *size = sizeof(State) + sizeof GUID;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state,
                                             fmi2Byte bytes[], size_t size) {
    if (size < sizeof(State) + sizeof GUID)
        return fail(c, "the place for the state is too small", "");
    memcpy(bytes, GUID, sizeof GUID);
    memcpy(bytes + sizeof GUID, state, sizeof(State));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[],
                                               size_t size, fmi2FMUstate *state) {
    if (size != sizeof(State) + sizeof GUID || memcmp(bytes, GUID, sizeof GUID) != 0)
        return fail(c, "these bytes are no state of this FMU", "");
    if (!*state && !(*state = malloc(sizeof(State))))
        return fail(c, "there is no memory", "");
    memcpy(*state, bytes + sizeof GUID, sizeof(State));
    return fmi2OK;
}

#define ABSENT(name, ...)                                                              \
    FMI2_Export fmi2Status name(fmi2Component c, __VA_ARGS__) {                        \
        return fail(c, #name " is not offered", "");                                   \
    }
#pragma GCC diagnostic ignored "-Wunused-parameter"
ABSENT(fmi2GetDirectionalDerivative, const fmi2ValueReference z[], size_t nz,
       const fmi2ValueReference v[], size_t nv, const fmi2Real dv[], fmi2Real dz[])
ABSENT(fmi2SetRealInputDerivatives, const fmi2ValueReference vr[], size_t n,
       const fmi2Integer order[], const fmi2Real values[])
ABSENT(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n,
       const fmi2Integer order[], fmi2Real values[])
ABSENT(fmi2GetStatus, const fmi2StatusKind kind, fmi2Status *value)
ABSENT(fmi2GetRealStatus, const fmi2StatusKind kind, fmi2Real *value)
ABSENT(fmi2GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
ABSENT(fmi2GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
ABSENT(fmi2GetStringStatus, const fmi2StatusKind kind, fmi2String *value)
