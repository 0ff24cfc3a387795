/* An FMU that says what it hears: `text` is "k:" and what `heard` was when step k was
   made, `bytes` are those of `data` and one more, k.  Texts are FMI 2 String and FMI 3
   String, bytes FMI 3 Binary. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3, LONGEST = 4000 };
enum { HEARD, TEXT, DATA, BYTES, K };

typedef struct {
    char heard[LONGEST], text[LONGEST + 20];
    uint8_t data[LONGEST], bytes[LONGEST + 1];
    size_t n_data, n_bytes;
    int k;
} Instance;

static int step(Instance *i) {
    i->k++;
    snprintf(i->text, sizeof i->text, "%d:%s", i->k, i->heard);
    memcpy(i->bytes, i->data, i->n_data);
    i->bytes[i->n_data] = (uint8_t)i->k;
    i->n_bytes = i->n_data + 1;
    return OK;
}

static int get_texts(Instance *i, const unsigned *vr, size_t n, const char **v) {
    for (size_t j = 0; j < n; j++)
        v[j] = vr[j] == HEARD ? i->heard : i->text;
    return OK;
}

static int set_texts(Instance *i, const unsigned *vr, size_t n, const char *const *v) {
    for (size_t j = 0; j < n; j++) {
        if (vr[j] != HEARD || strlen(v[j]) >= LONGEST)
            return ERROR;
        strcpy(i->heard, v[j]);
    }
    return OK;
}

static int get_numbers(Instance *i, size_t n, double *v) {
    for (size_t j = 0; j < n; j++)
        v[j] = i->k;
    return OK;
}

EXPORT int ENTER(void) { return OK; }
EXPORT int EXIT(void *i) { return OK; }
EXPORT int TERMINATE(void *i) { return OK; }
EXPORT void FREE(void *i) { free(i); }

#if FMI == 2
EXPORT void *fmi2Instantiate(void) { return calloc(1, sizeof(Instance)); }
EXPORT int fmi2SetupExperiment(void *i) { return OK; }
EXPORT int fmi2GetString(Instance *i, const unsigned *vr, size_t n, const char **v) {
    return get_texts(i, vr, n, v);
}
EXPORT int fmi2SetString(Instance *i, const unsigned *vr, size_t n,
                         const char *const *v) {
    return set_texts(i, vr, n, v);
}
EXPORT int fmi2GetReal(Instance *i, const unsigned *vr, size_t n, double *v) {
    return get_numbers(i, n, v);
}
EXPORT int fmi2DoStep(Instance *i, double t, double h, int no) { return step(i); }
#else
EXPORT void *fmi3InstantiateCoSimulation(void) { return calloc(1, sizeof(Instance)); }
EXPORT int fmi3GetString(Instance *i, const unsigned *vr, size_t n, const char **v,
                         size_t m) {
    return get_texts(i, vr, n, v);
}
EXPORT int fmi3SetString(Instance *i, const unsigned *vr, size_t n,
                         const char *const *v, size_t m) {
    return set_texts(i, vr, n, v);
}
EXPORT int fmi3GetBinary(Instance *i, const unsigned *vr, size_t n, size_t *sizes,
                         const uint8_t **v, size_t m) {
    for (size_t j = 0; j < n; j++) {
        v[j] = vr[j] == DATA ? i->data : i->bytes;
        sizes[j] = vr[j] == DATA ? i->n_data : i->n_bytes;
    }
    return OK;
}
EXPORT int fmi3SetBinary(Instance *i, const unsigned *vr, size_t n,
                         const size_t *sizes, const uint8_t *const *v, size_t m) {
    for (size_t j = 0; j < n; j++) {
        if (vr[j] != DATA || sizes[j] > LONGEST)
            return ERROR;
        memcpy(i->data, v[j], sizes[j]);
        i->n_data = sizes[j];
    }
    return OK;
}
EXPORT int fmi3GetFloat64(Instance *i, const unsigned *vr, size_t n, double *v,
                          size_t m) {
    return get_numbers(i, n, v);
}
EXPORT int fmi3DoStep(Instance *i, double t, double h, _Bool no, _Bool *event,
                      _Bool *over, _Bool *early, double *reached) {
    *event = *over = *early = 0;
    *reached = t + h;
    return step(i);
}
#endif

ABSENT
