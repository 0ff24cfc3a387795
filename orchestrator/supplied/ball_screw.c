/* A ball-screw drive as a supplier might send it: FMI 2.0 co-simulation, written
   by hand, nothing of feeddrive in it.  Two masses on a spring:

     J_1 phi_1'' = -b phi_1' + k (phi_2 - phi_1) + c (phi_2' - phi_1') - motor_voltage
     J_2 phi_2'' =             k (phi_1 - phi_2) + c (phi_1' - phi_2') + table_force

   The motor turns the other way round, positions leave in mm of table travel,
   inertias are in mV s2/rad.  Classical Runge-Kutta with 12.5 us inside. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { VOLTAGE, TORQUE, FORCE, TEMPERATURE, SCREW, TABLE, SCREW_SPEED, TABLE_SPEED,
       INERTIA_MOTOR, INERTIA_TABLE, BEARING, STIFFNESS, NUT, LEAD, COUNT };

static const double START[COUNT] = {
    [TEMPERATURE] = 20.0, [INERTIA_MOTOR] = 1.858, [INERTIA_TABLE] = 0.379,
    [BEARING] = 1.020, [STIFFNESS] = 210.02, [NUT] = 14.0, [LEAD] = 20.0,
};
static const char GUID[] = "{5c1d6b0e-drive-20}";
static const double INSIDE = 12.5e-6;
static const double TURN = 6.283185307179586;

typedef struct {
    double v[COUNT];
    double x[4]; /* both angles (rad), both speeds (rad/s) */
} Drive;

static void derivative(const Drive *d, const double x[4], double dx[4])
{
    const double *v = d->v;
    double nut = v[STIFFNESS] * (x[1] - x[0]) + 1e-3 * v[NUT] * (x[3] - x[2]);
    double drive = -v[VOLTAGE] + v[TORQUE] - 1e-3 * v[BEARING] * x[2];
    dx[0] = x[2];
    dx[1] = x[3];
    dx[2] = (drive + nut) / (1e-3 * v[INERTIA_MOTOR]);
    dx[3] = (v[FORCE] - nut) / (1e-3 * v[INERTIA_TABLE]);
}

static void advance(Drive *d, double h)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double slope[4] = {0}, sum[4] = {0}, x[4];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < 4; i++)
            x[i] = d->x[i] + at[stage] * h * slope[i];
        derivative(d, x, slope);
        for (int i = 0; i < 4; i++)
            sum[i] += weight[stage] * slope[i];
    }
    for (int i = 0; i < 4; i++)
        d->x[i] += h * sum[i];
}

static void outputs(Drive *d)
{
    double travel = d->v[LEAD] / TURN; /* mm/rad */
    for (int i = 0; i < 4; i++)
        d->v[SCREW + i] = travel * d->x[i];
}

static void reset(Drive *d)
{
    for (int i = 0; i < COUNT; i++)
        d->v[i] = START[i];
    for (int i = 0; i < 4; i++)
        d->x[i] = 0.0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                              fmi2String place, const fmi2CallbackFunctions *host,
                              fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)place, (void)host, (void)visible, (void)logging;
    int right = type == fmi2CoSimulation && guid && strcmp(guid, GUID) == 0;
    Drive *d = right ? malloc(sizeof *d) : NULL;
    if (d)
        reset(d);
    return d;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component c)
{
    reset(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       fmi2Real value[])
{
    Drive *d = c;
    outputs(d);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= COUNT)
            return fmi2Error;
        value[i] = d->v[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[])
{
    Drive *d = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= COUNT || (vr[i] >= SCREW && vr[i] <= TABLE_SPEED))
            return fmi2Error;
        d->v[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean keep)
{
    (void)t, (void)keep;
    if (!(h > 0.0))
        return fmi2Error;
    long steps = lround(h / INSIDE);
    if (steps < 1)
        steps = 1;
    for (long i = 0; i < steps; i++)
        advance(c, h / (double)steps);
    return fmi2OK;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance,
    fmi2Real start, fmi2Boolean ends, fmi2Real stop)
{
    (void)c, (void)defined, (void)tolerance, (void)start, (void)ends, (void)stop;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const
    fmi2String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK;
}

/* What it cannot do: it has no other types, no state to keep, no derivatives. */

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
    fmi2Integer value[])
{
    (void)c, (void)vr, (void)n, (void)value;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
    const fmi2Integer value[])
{
    (void)c, (void)vr, (void)n, (void)value;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
    fmi2Boolean value[])
{
    (void)c, (void)vr, (void)n, (void)value;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
    const fmi2Boolean value[])
{
    (void)c, (void)vr, (void)n, (void)value;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
    fmi2String value[])
{
    (void)c, (void)vr, (void)n, (void)value;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const
    fmi2String value[])
{
    (void)c, (void)vr, (void)n, (void)value;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c, (void)state;
    return fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    (void)c, (void)state;
    return fmi2Error;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c, (void)state;
    return fmi2Error;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *n)
{
    (void)c, (void)state, (void)n;
    return fmi2Error;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
    size_t n)
{
    (void)c, (void)state, (void)bytes, (void)n;
    return fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t n,
    fmi2FMUstate *state)
{
    (void)c, (void)bytes, (void)n, (void)state;
    return fmi2Error;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference of[],
    size_t n_of, const fmi2ValueReference by[], size_t n_by, const fmi2Real seed[],
    fmi2Real value[])
{
    (void)c, (void)of, (void)n_of, (void)by, (void)n_by, (void)seed, (void)value;
    return fmi2Error;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
    size_t n, const fmi2Integer order[], const fmi2Real value[])
{
    (void)c, (void)vr, (void)n, (void)order, (void)value;
    return fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
    size_t n, const fmi2Integer order[], fmi2Real value[])
{
    (void)c, (void)vr, (void)n, (void)order, (void)value;
    return fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    (void)c;
    return fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real
    *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer
    *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean
    *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String
    *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
