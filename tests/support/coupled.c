/* An FMU whose output depends directly on its input, and whose state can be taken back.

   y = a u + b + s, where s is the sum of h u over all steps; n counts the steps.  It
   refuses a step of which the importer said that it is never taken back while a state
   is kept to come back to. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3 };
enum { U, A, B, Y, N, COUNT };

typedef struct {
    double v[COUNT], s;
    int kept;
} Instance;

static int step(Instance *i, double h, int never_back) {
    if (never_back && i->kept)
        return ERROR;
    i->s += h * i->v[U];
    i->v[N] += 1;
    return OK;
}

static int get(Instance *i, const unsigned *vr, size_t n, double *to) {
    i->v[Y] = i->v[A] * i->v[U] + i->v[B] + i->s;
    for (size_t k = 0; k < n; k++)
        to[k] = i->v[vr[k]];
    return OK;
}

static int set(Instance *i, const unsigned *vr, size_t n, const double *from) {
    for (size_t k = 0; k < n; k++)
        i->v[vr[k]] = from[k];
    return OK;
}

static int keep(Instance *i, void **state) {
    if (!*state)
        *state = malloc(sizeof *i);
    memcpy(*state, i, sizeof *i);
    i->kept++;
    return OK;
}

static int back(Instance *i, void *state) {
    const int kept = i->kept;
    memcpy(i, state, sizeof *i);
    i->kept = kept;
    return OK;
}

static int drop(Instance *i, void **state) {
    free(*state);
    *state = NULL;
    i->kept--;
    return OK;
}

EXPORT int ENTER(void) { return OK; }
EXPORT int EXIT(void *i) { return OK; }
EXPORT int TERMINATE(void *i) { return OK; }
EXPORT void FREE(void *i) { free(i); }

#if FMI == 2
EXPORT void *fmi2Instantiate(void) { return calloc(1, sizeof(Instance)); }
EXPORT int fmi2SetupExperiment(void *i) { return OK; }
EXPORT int fmi2GetReal(Instance *i, const unsigned *vr, size_t n, double *v) {
    return get(i, vr, n, v);
}
EXPORT int fmi2SetReal(Instance *i, const unsigned *vr, size_t n, const double *v) {
    return set(i, vr, n, v);
}
EXPORT int fmi2DoStep(Instance *i, double t, double h, int never_back) {
    return step(i, h, never_back);
}
EXPORT int fmi2GetFMUstate(Instance *i, void **s) { return keep(i, s); }
EXPORT int fmi2SetFMUstate(Instance *i, void *s) { return back(i, s); }
EXPORT int fmi2FreeFMUstate(Instance *i, void **s) { return drop(i, s); }
#else
/* Refused if anything is asked for that happens inside a step. */
EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *place, _Bool visible, _Bool logging,
                                         _Bool events, _Bool early, const unsigned *needed,
                                         size_t n, void *environment, void *log,
                                         void (*intermediate)(void)) {
    return early || n || intermediate ? NULL : calloc(1, sizeof(Instance));
}
EXPORT int fmi3GetFloat64(Instance *i, const unsigned *vr, size_t n, double *v,
                          size_t m) {
    return get(i, vr, n, v);
}
EXPORT int fmi3SetFloat64(Instance *i, const unsigned *vr, size_t n, const double *v,
                          size_t m) {
    return set(i, vr, n, v);
}
EXPORT int fmi3DoStep(Instance *i, double t, double h, _Bool never_back, _Bool *event,
                      _Bool *over, _Bool *early, double *reached) {
    *event = *over = *early = 0;
    *reached = t + h;
    return step(i, h, never_back);
}
EXPORT int fmi3GetFMUState(Instance *i, void **s) { return keep(i, s); }
EXPORT int fmi3SetFMUState(Instance *i, void *s) { return back(i, s); }
EXPORT int fmi3FreeFMUState(Instance *i, void **s) { return drop(i, s); }
#endif

ABSENT
