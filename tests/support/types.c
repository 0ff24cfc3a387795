/* An FMU with every type of FMI 2.0 or 3.0 (config.h): for the i-th of them an input
   i, a fixed parameter 50 + i, and an output 100 + i, which is the input. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3, PLACES = 100, LONGEST = 200 };

typedef struct {
    unsigned char values[PLACES][LONGEST];
    size_t sizes[PLACES]; /* of texts */
} Instance;

static unsigned place(unsigned vr) { return vr < PLACES ? vr : vr - PLACES; }

static int get(Instance *s, const unsigned *vr, size_t n, void *to, size_t size) {
    for (size_t i = 0; i < n; i++)
        memcpy((char *)to + i * size, s->values[place(vr[i])], size);
    return OK;
}

static int set(Instance *s, const unsigned *vr, size_t n, const void *from,
               size_t size) {
    for (size_t i = 0; i < n; i++)
        memcpy(s->values[vr[i]], (const char *)from + i * size, size);
    return OK;
}

/* True has all its bits set, as in some languages. */
static int get_truth(Instance *s, const unsigned *vr, size_t n, void *to, size_t size) {
    get(s, vr, n, to, size);
    for (size_t i = 0; i < n; i++)
        memset((char *)to + i * size, s->values[place(vr[i])][0] ? 0xff : 0, size);
    return OK;
}

static int keep(Instance *s, unsigned vr, const void *from, size_t size) {
    if (size >= LONGEST)
        return ERROR;
    memcpy(s->values[vr], from, size);
    s->values[vr][size] = 0;
    s->sizes[vr] = size;
    return OK;
}

/* All numbers begin at 0, the enumerations at 1. */
static Instance *make(void) {
    const unsigned enumeration = FMI == 2 ? 4 : 13;
    Instance *s = calloc(1, sizeof *s);
    s->values[enumeration][0] = s->values[50 + enumeration][0] = 1;
    return s;
}

EXPORT int ENTER(void) { return OK; }
EXPORT int EXIT(void *s) { return OK; }
EXPORT int TERMINATE(void *s) { return OK; }
EXPORT void FREE(void *s) { free(s); }

#if FMI == 2

#define ACCESS(Name, T, GET)                                                     \
    EXPORT int fmi2Get##Name(Instance *s, const unsigned *vr, size_t n, T *v) {  \
        return GET(s, vr, n, v, sizeof *v);                                      \
    }                                                                            \
    EXPORT int fmi2Set##Name(Instance *s, const unsigned *vr, size_t n,          \
                             const T *v) {                                       \
        return set(s, vr, n, v, sizeof *v);                                      \
    }
ACCESS(Real, double, get)
ACCESS(Integer, int, get)
ACCESS(Boolean, int, get_truth)
EXPORT int fmi2GetString(Instance *s, const unsigned *vr, size_t n, const char **v) {
    for (size_t i = 0; i < n; i++)
        v[i] = (const char *)s->values[place(vr[i])];
    return OK;
}
EXPORT int fmi2SetString(Instance *s, const unsigned *vr, size_t n,
                         const char *const *v) {
    for (size_t i = 0; i < n; i++)
        if (keep(s, vr[i], v[i], strlen(v[i])) != OK)
            return ERROR;
    return OK;
}
EXPORT void *fmi2Instantiate(void) { return make(); }
EXPORT int fmi2SetupExperiment(void *s) { return OK; }
EXPORT int fmi2DoStep(void *s, double t, double h, int no) { return OK; }

#else

#define ACCESS(Name, T, GET)                                                     \
    EXPORT int fmi3Get##Name(Instance *s, const unsigned *vr, size_t n, T *v,    \
                             size_t m) {                                         \
        return GET(s, vr, n, v, sizeof *v);                                      \
    }                                                                            \
    EXPORT int fmi3Set##Name(Instance *s, const unsigned *vr, size_t n,          \
                             const T *v, size_t m) {                             \
        return set(s, vr, n, v, sizeof *v);                                      \
    }
ACCESS(Float64, double, get)
ACCESS(Float32, float, get)
ACCESS(Int8, int8_t, get)
ACCESS(UInt8, uint8_t, get)
ACCESS(Int16, int16_t, get)
ACCESS(UInt16, uint16_t, get)
ACCESS(Int32, int32_t, get)
ACCESS(UInt32, uint32_t, get)
ACCESS(Int64, int64_t, get)
ACCESS(UInt64, uint64_t, get)
ACCESS(Boolean, _Bool, get_truth)
EXPORT int fmi3GetString(Instance *s, const unsigned *vr, size_t n, const char **v,
                         size_t m) {
    for (size_t i = 0; i < n; i++)
        v[i] = (const char *)s->values[place(vr[i])];
    return OK;
}
EXPORT int fmi3SetString(Instance *s, const unsigned *vr, size_t n,
                         const char *const *v, size_t m) {
    for (size_t i = 0; i < n; i++)
        if (keep(s, vr[i], v[i], strlen(v[i])) != OK)
            return ERROR;
    return OK;
}
EXPORT int fmi3GetBinary(Instance *s, const unsigned *vr, size_t n, size_t *sizes,
                         const uint8_t **v, size_t m) {
    for (size_t i = 0; i < n; i++) {
        v[i] = s->values[place(vr[i])];
        sizes[i] = s->sizes[place(vr[i])];
    }
    return OK;
}
EXPORT int fmi3SetBinary(Instance *s, const unsigned *vr, size_t n,
                         const size_t *sizes, const uint8_t *const *v, size_t m) {
    for (size_t i = 0; i < n; i++)
        if (keep(s, vr[i], v[i], sizes[i]) != OK)
            return ERROR;
    return OK;
}
EXPORT void *fmi3InstantiateCoSimulation(void) { return make(); }
EXPORT int fmi3DoStep(void *s, double t, double h, _Bool no, _Bool *event, _Bool *over,
                      _Bool *early, double *reached) {
    *event = *over = *early = 0;
    *reached = t + h;
    return OK;
}

#endif

ABSENT
