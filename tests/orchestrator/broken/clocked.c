/* FMI 3.0 co-simulation that somebody else's clock ticks (config.h).  In step mode
   z integrates u; a tick of the clock, in event mode, adds 1 to n and u to y, and w is
   z at that tick.  Without event mode it makes no instance. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3 };
enum { N, Y, W, Z, U, COUNT };
enum { CLOCK = 9 };

typedef struct {
    double v[COUNT];
    _Bool events, active;
} Fmu;

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *resources, _Bool visible,
                                         _Bool logging, _Bool events, _Bool early,
                                         const uint32_t *wanted, size_t n,
                                         void *environment, void *log, void *update) {
    Fmu *m = events ? calloc(1, sizeof *m) : NULL;
    if (m)
        m->events = 1;
    return m;
}
EXPORT int ENTER(Fmu *m, _Bool a, double b, double c, _Bool d, double e) { return OK; }
EXPORT int EXIT(Fmu *m) { return OK; }
EXPORT int TERMINATE(Fmu *m) { return OK; }
EXPORT void FREE(Fmu *m) { free(m); }

EXPORT int fmi3SetClock(Fmu *m, const uint32_t *r, size_t n, const _Bool *active) {
    if (!m->events || n != 1 || r[0] != CLOCK)
        return ERROR;
    m->active = active[0];
    return OK;
}
EXPORT int fmi3UpdateDiscreteStates(Fmu *m, _Bool *again, _Bool *ends, _Bool *a, _Bool *b,
                                    _Bool *next, double *time) {
    *again = *ends = *a = *b = *next = 0;
    if (m->active) {
        m->v[N] += 1;
        m->v[Y] += m->v[U];
        m->v[W] = m->v[Z];
    }
    m->active = 0;
    return OK;
}
EXPORT int fmi3EnterStepMode(Fmu *m) {
    m->events = 0;
    return OK;
}
EXPORT int fmi3EnterEventMode(Fmu *m) {
    m->events = 1;
    return OK;
}
EXPORT int fmi3DoStep(Fmu *m, double t, double h, _Bool no, _Bool *event, _Bool *ends,
                      _Bool *early, double *reached) {
    *event = *ends = *early = 0;
    *reached = t + h;
    if (m->events)
        return ERROR;
    m->v[Z] += h * m->v[U];
    return OK;
}
EXPORT int fmi3GetFloat64(Fmu *m, const uint32_t *r, size_t n, double *v, size_t size) {
    for (size_t i = 0; i < n; i++)
        v[i] = m->v[r[i]];
    return OK;
}
EXPORT int fmi3SetFloat64(Fmu *m, const uint32_t *r, size_t n, const double *v,
                          size_t size) {
    for (size_t i = 0; i < n; i++)
        m->v[r[i]] = v[i];
    return OK;
}
ABSENT
