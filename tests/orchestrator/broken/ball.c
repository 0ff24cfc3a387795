/* A bouncing ball for model exchange, FMI 2.0 and 3.0: state events where it meets
   the floor, a time event at t_kick (its speed grows by kick), a step event never.
   v' = u - g; the floor returns e of the speed. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define EXPORT __attribute__((visibility("default")))

enum { H, V, DER_V, U, E, KICK, T_KICK, BOUNCES, COUNT };

typedef struct {
    double value[COUNT], time;
    int falls, kicked, event_mode;
} Ball;

static void *make(void) {
    Ball *b = calloc(1, sizeof *b);
    b->value[H] = 1;
    b->value[E] = 0.7;
    b->value[T_KICK] = 1e9;
    return b;
}

static double acceleration(const Ball *b) { return b->value[U] - 9.81; }

static int get(Ball *b, const uint32_t *r, size_t n, double *values) {
    b->value[DER_V] = acceleration(b);
    for (size_t k = 0; k < n; k++)
        values[k] = b->value[r[k]];
    return 0;
}

static int set(Ball *b, const uint32_t *r, size_t n, const double *values) {
    for (size_t k = 0; k < n; k++)
        b->value[r[k]] = values[k];
    return 0;
}

/* Returns whether a state jumped; refuses to be called outside event mode. */
static int update(Ball *b) {
    int jumped = 0;
    if (!b->event_mode)
        abort();
    if (b->value[H] <= 0 && b->value[V] < 0) {
        b->value[H] = 0;
        b->value[V] *= -b->value[E];
        b->value[BOUNCES] += 1;
        jumped = 1;
    }
    if (!b->kicked && b->time >= b->value[T_KICK]) {
        b->value[V] += b->value[KICK];
        b->kicked = jumped = 1;
    }
    return jumped;
}

static int event_mode(Ball *b, int on) {
    if (b->event_mode == on)
        abort();
    b->event_mode = on;
    return 0;
}

static int states(Ball *b, double *x) {
    x[0] = b->value[H];
    x[1] = b->value[V];
    return 0;
}
static int set_states(Ball *b, const double *x) {
    b->value[H] = x[0];
    b->value[V] = x[1];
    return 0;
}
static int derivatives(const Ball *b, double *dx) {
    if (b->event_mode)
        abort();
    dx[0] = b->value[V];
    dx[1] = acceleration(b);
    return 0;
}
static int ones(double *x) {
    x[0] = x[1] = 1;
    return 0;
}
static int set_time(Ball *b, double t) {
    if (b->event_mode)
        abort();
    b->time = t;
    return 0;
}

typedef struct {
    int again, over, nominals, values, timed;
    double when;
} Event;

EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT void *fmi2Instantiate(void) { return make(); }
EXPORT void fmi2FreeInstance(Ball *b) { free(b); }
EXPORT int fmi2SetupExperiment(Ball *b) { return 0; }
EXPORT int fmi2EnterInitializationMode(Ball *b) { return 0; }
EXPORT int fmi2ExitInitializationMode(Ball *b) { return event_mode(b, 1); }
EXPORT int fmi2Terminate(Ball *b) { return 0; }
EXPORT int fmi2GetReal(Ball *b, const uint32_t *r, size_t n, double *values) {
    return get(b, r, n, values);
}
EXPORT int fmi2SetReal(Ball *b, const uint32_t *r, size_t n, const double *values) {
    return set(b, r, n, values);
}
EXPORT int fmi2EnterEventMode(Ball *b) { return event_mode(b, 1); }
EXPORT int fmi2EnterContinuousTimeMode(Ball *b) { return event_mode(b, 0); }
EXPORT int fmi2NewDiscreteStates(Ball *b, Event *event) {
    int jumped = update(b);
    *event = (Event){jumped, 0, 0, jumped, !b->kicked, b->value[T_KICK]};
    return 0;
}
EXPORT int fmi2CompletedIntegratorStep(Ball *b, int no, int *event, int *over) {
    *event = *over = 0;
    return 0;
}
EXPORT int fmi2SetTime(Ball *b, double t) { return set_time(b, t); }
EXPORT int fmi2SetContinuousStates(Ball *b, const double *x, size_t n) {
    return set_states(b, x);
}
EXPORT int fmi2GetContinuousStates(Ball *b, double *x, size_t n) { return states(b, x); }
EXPORT int fmi2GetDerivatives(Ball *b, double *dx, size_t n) {
    return derivatives(b, dx);
}
EXPORT int fmi2GetEventIndicators(Ball *b, double *z, size_t n) {
    z[0] = b->value[H] + (b->value[H] == 0 && b->value[V] > 0 ? 1e-12 : 0);
    return 0;
}
EXPORT int fmi2GetNominalsOfContinuousStates(Ball *b, double *x, size_t n) {
    return ones(x);
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT void *fmi3InstantiateModelExchange(void) { return make(); }
EXPORT void fmi3FreeInstance(Ball *b) { free(b); }
EXPORT int fmi3EnterInitializationMode(Ball *b) { return 0; }
EXPORT int fmi3ExitInitializationMode(Ball *b) { return event_mode(b, 1); }
EXPORT int fmi3Terminate(Ball *b) { return 0; }
EXPORT int fmi3GetFloat64(Ball *b, const uint32_t *r, size_t n, double *values,
                          size_t m) {
    return get(b, r, n, values);
}
EXPORT int fmi3SetFloat64(Ball *b, const uint32_t *r, size_t n, const double *values,
                          size_t m) {
    return set(b, r, n, values);
}
EXPORT int fmi3EnterEventMode(Ball *b) { return event_mode(b, 1); }
EXPORT int fmi3EnterContinuousTimeMode(Ball *b) { return event_mode(b, 0); }
EXPORT int fmi3UpdateDiscreteStates(Ball *b, _Bool *again, _Bool *over, _Bool *nominals,
                                    _Bool *values, _Bool *timed, double *when) {
    *again = *values = update(b);
    *over = *nominals = 0;
    *timed = !b->kicked;
    *when = b->value[T_KICK];
    return 0;
}
EXPORT int fmi3CompletedIntegratorStep(Ball *b, _Bool no, _Bool *event, _Bool *over) {
    *event = *over = 0;
    return 0;
}
EXPORT int fmi3SetTime(Ball *b, double t) { return set_time(b, t); }
EXPORT int fmi3SetContinuousStates(Ball *b, const double *x, size_t n) {
    return set_states(b, x);
}
EXPORT int fmi3GetContinuousStates(Ball *b, double *x, size_t n) { return states(b, x); }
EXPORT int fmi3GetContinuousStateDerivatives(Ball *b, double *dx, size_t n) {
    return derivatives(b, dx);
}
EXPORT int fmi3GetEventIndicators(Ball *b, double *z, size_t n) {
    return fmi2GetEventIndicators(b, z, n);
}
EXPORT int fmi3GetNominalsOfContinuousStates(Ball *b, double *x, size_t n) {
    return ones(x);
}
EXPORT int fmi3GetNumberOfContinuousStates(Ball *b, size_t *n) { return *n = 2, 0; }
EXPORT int fmi3GetNumberOfEventIndicators(Ball *b, size_t *n) { return *n = 1, 0; }

/* What FMI prescribes and nobody calls here. */
#define ABSENT(name) EXPORT int name(void) { return 3; }
ABSENT(fmi2SetDebugLogging) ABSENT(fmi2Reset) ABSENT(fmi2GetInteger)
ABSENT(fmi2GetBoolean) ABSENT(fmi2GetString) ABSENT(fmi2SetInteger)
ABSENT(fmi2SetBoolean) ABSENT(fmi2SetString) ABSENT(fmi2GetFMUstate)
ABSENT(fmi2SetFMUstate) ABSENT(fmi2FreeFMUstate) ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate) ABSENT(fmi2DeSerializeFMUstate)
ABSENT(fmi2GetDirectionalDerivative) ABSENT(fmi3SetDebugLogging)
ABSENT(fmi3InstantiateCoSimulation) ABSENT(fmi3InstantiateScheduledExecution)
ABSENT(fmi3Reset) ABSENT(fmi3GetFloat32) ABSENT(fmi3GetInt8) ABSENT(fmi3GetUInt8)
ABSENT(fmi3GetInt16) ABSENT(fmi3GetUInt16) ABSENT(fmi3GetInt32) ABSENT(fmi3GetUInt32)
ABSENT(fmi3GetInt64) ABSENT(fmi3GetUInt64) ABSENT(fmi3GetBoolean) ABSENT(fmi3GetString)
ABSENT(fmi3GetBinary) ABSENT(fmi3GetClock) ABSENT(fmi3SetFloat32) ABSENT(fmi3SetInt8)
ABSENT(fmi3SetUInt8) ABSENT(fmi3SetInt16) ABSENT(fmi3SetUInt16) ABSENT(fmi3SetInt32)
ABSENT(fmi3SetUInt32) ABSENT(fmi3SetInt64) ABSENT(fmi3SetUInt64) ABSENT(fmi3SetBoolean)
ABSENT(fmi3SetString) ABSENT(fmi3SetBinary) ABSENT(fmi3SetClock)
ABSENT(fmi3GetNumberOfVariableDependencies) ABSENT(fmi3GetVariableDependencies)
ABSENT(fmi3GetFMUState) ABSENT(fmi3SetFMUState) ABSENT(fmi3FreeFMUState)
ABSENT(fmi3SerializedFMUStateSize) ABSENT(fmi3SerializeFMUState)
ABSENT(fmi3DeserializeFMUState) ABSENT(fmi3GetDirectionalDerivative)
ABSENT(fmi3GetAdjointDerivative) ABSENT(fmi3EnterConfigurationMode)
ABSENT(fmi3ExitConfigurationMode) ABSENT(fmi3GetIntervalDecimal)
ABSENT(fmi3GetIntervalFraction) ABSENT(fmi3GetShiftDecimal)
ABSENT(fmi3GetShiftFraction) ABSENT(fmi3SetIntervalDecimal)
ABSENT(fmi3SetIntervalFraction) ABSENT(fmi3SetShiftDecimal)
ABSENT(fmi3SetShiftFraction) ABSENT(fmi3EvaluateDiscreteStates)
ABSENT(fmi3EnterStepMode) ABSENT(fmi3GetOutputDerivatives) ABSENT(fmi3DoStep)
ABSENT(fmi3ActivateModelPartition)
