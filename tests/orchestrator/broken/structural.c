/* FMI 3.0 with an array v of n inputs (reference 1), n a structural parameter
   (reference 0, UInt64, set in configuration mode only), and its sum (2). */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3, MOST = 100 };

typedef struct {
    uint64_t n;
    double v[MOST];
    int configuring;
} Instance;

EXPORT int ENTER(void *s) { return OK; }
EXPORT int EXIT(void *s) { return OK; }
EXPORT int TERMINATE(void *s) { return OK; }
EXPORT void FREE(void *s) { free(s); }
EXPORT void *fmi3InstantiateCoSimulation(void) {
    Instance *s = calloc(1, sizeof *s);
    s->n = 2;
    return s;
}
EXPORT int fmi3EnterConfigurationMode(Instance *s) { return s->configuring = 1, OK; }
EXPORT int fmi3ExitConfigurationMode(Instance *s) { return s->configuring = 0, OK; }
EXPORT int fmi3SetUInt64(Instance *s, const uint32_t *r, size_t k, const uint64_t *v,
                         size_t m) {
    if (!s->configuring || *v > MOST)
        return ERROR;
    s->n = *v;
    return OK;
}
EXPORT int fmi3GetUInt64(Instance *s, const uint32_t *r, size_t k, uint64_t *v,
                         size_t m) {
    return *v = s->n, OK;
}
EXPORT int fmi3SetFloat64(Instance *s, const uint32_t *r, size_t k, const double *v,
                          size_t m) {
    if (m != s->n)
        return ERROR;
    for (size_t i = 0; i < m; i++)
        s->v[i] = v[i];
    return OK;
}
EXPORT int fmi3GetFloat64(Instance *s, const uint32_t *r, size_t k, double *v,
                          size_t m) {
    if (m != (*r == 2 ? 1 : s->n))
        return ERROR;
    for (size_t i = 0; i < m; i++)
        v[i] = *r == 2 ? 0 : s->v[i];
    for (size_t i = 0; *r == 2 && i < s->n; i++)
        v[0] += s->v[i];
    return OK;
}
EXPORT int fmi3DoStep(void *s, double t, double h, _Bool no, _Bool *event, _Bool *over,
                      _Bool *early, double *reached) {
    *event = *over = *early = 0;
    return *reached = t + h, OK;
}

ABSENT
