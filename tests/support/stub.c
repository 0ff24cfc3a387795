/* An FMU of any names: of each type the k-th output is the k-th input plus the k-th
   parameter, at once.  Value references: inputs from 0, parameters from 1000, outputs
   from 2000.  config.h defines what is absent. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3, SIZE = 1000, LONGEST = 64 };

typedef struct {
    double Real[3 * SIZE];
    int Integer[3 * SIZE], Boolean[3 * SIZE];
    char String[2 * SIZE][LONGEST];
} Instance;

static int compute(Instance *s) {
    for (int k = 0; k < SIZE; k++) {
        s->Real[2 * SIZE + k] = s->Real[k] + s->Real[SIZE + k];
        s->Integer[2 * SIZE + k] = s->Integer[k] + s->Integer[SIZE + k];
        s->Boolean[2 * SIZE + k] = s->Boolean[k] || s->Boolean[SIZE + k];
    }
    return OK;
}

#define ACCESS(Name, T)                                                          \
    EXPORT int fmi2Get##Name(Instance *s, const unsigned *vr, size_t n, T *v) {  \
        compute(s);                                                              \
        for (size_t i = 0; i < n; i++)                                           \
            v[i] = s->Name[vr[i]];                                               \
        return OK;                                                               \
    }                                                                            \
    EXPORT int fmi2Set##Name(Instance *s, const unsigned *vr, size_t n,          \
                             const T *v) {                                       \
        for (size_t i = 0; i < n; i++)                                           \
            s->Name[vr[i]] = v[i];                                               \
        return OK;                                                               \
    }
ACCESS(Real, double)
ACCESS(Integer, int)
ACCESS(Boolean, int)

EXPORT int fmi2GetString(Instance *s, const unsigned *vr, size_t n, const char **v) {
    for (size_t i = 0; i < n; i++)
        v[i] = s->String[vr[i]];
    return OK;
}

EXPORT int fmi2SetString(Instance *s, const unsigned *vr, size_t n,
                         const char *const *v) {
    for (size_t i = 0; i < n; i++)
        strncpy(s->String[vr[i]], v[i], LONGEST - 1);
    return OK;
}

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *place, const void *callbacks, int visible,
                             int logging) {
    return calloc(1, sizeof(Instance));
}
EXPORT void FREE(void *s) { free(s); }
EXPORT int ENTER(void *s) { return OK; }
EXPORT int EXIT(void *s) { return OK; }
EXPORT int TERMINATE(void *s) { return OK; }
EXPORT int fmi2SetupExperiment(void *s, int tolerant, double tolerance, double start,
                               int stops, double stop) {
    return OK;
}
EXPORT int fmi2DoStep(Instance *s, double t, double h, int final) { return compute(s); }
ABSENT
