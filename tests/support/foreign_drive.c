/* A drive as suppliers hand them out, in 32-bit integers: a position loop of gain K,
   n' = K (n_r - n), solved exactly over each step; n runs over.

   MODE 402: control word 0, target position 1; status word 10, position 11 (CSP).
   MODE 105: STW1 0, NSOLL 1, XERR 2, KPC 3; ZSW1 10, NIST 11, XIST1 12.
   Real parameters: 0 K (1/s), 1 where the drive stands at first (increments). */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3 };

typedef struct {
    double parameters[2], n; /* n: unwrapped, from where it stood */
    int words[20];
    int begun;
} Instance;

static int32_t over(double n) { return (int32_t)(uint32_t)(int64_t)floor(n + 0.5); }

static void show(Instance *s) { s->words[MODE == 402 ? 11 : 12] = over(s->n); }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *place, const void *callbacks, int visible,
                             int logging) {
    Instance *s = calloc(1, sizeof *s);
    s->parameters[0] = 100;
    s->words[10] = MODE == 402 ? 0x240 : 0x201;
    return s;
}
EXPORT void FREE(void *s) { free(s); }
EXPORT int ENTER(Instance *s) {
    s->n = s->parameters[1];
    show(s);
    return OK;
}
EXPORT int EXIT(void *s) { return OK; }
EXPORT int TERMINATE(void *s) { return OK; }
EXPORT int fmi2SetupExperiment(void *s, int tolerant, double tolerance, double start,
                               int stops, double stop) {
    return OK;
}
EXPORT int fmi2SetReal(Instance *s, const unsigned *vr, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++)
        s->parameters[vr[i]] = v[i];
    return OK;
}
EXPORT int fmi2GetReal(Instance *s, const unsigned *vr, size_t n, double *v) {
    for (size_t i = 0; i < n; i++)
        v[i] = s->parameters[vr[i]];
    return OK;
}
EXPORT int fmi2SetInteger(Instance *s, const unsigned *vr, size_t n, const int *v) {
    for (size_t i = 0; i < n; i++)
        s->words[vr[i]] = v[i];
    return OK;
}
EXPORT int fmi2GetInteger(Instance *s, const unsigned *vr, size_t n, int *v) {
    for (size_t i = 0; i < n; i++)
        v[i] = s->words[vr[i]];
    return OK;
}

#if MODE == 402
/* A state further per step, where the control word asks for it. */
static int follows(Instance *s) {
    int asked = s->words[0] & 0xF, *status = s->words + 10;
    int is_enabled = (*status & 0x6F) == 0x27;
    if ((*status & 0x4F) == 0x40 && asked == 0x6)
        *status = 0x221;
    else if ((*status & 0x6F) == 0x21 && asked == 0x7)
        *status = 0x223;
    else if ((*status & 0x6F) == 0x23 && asked == 0xF)
        *status = 0x227;
    else if (is_enabled && asked != 0xF)
        *status = 0x221;
    return is_enabled && asked == 0xF;
}

static double error(Instance *s) {
    double whole = floor(s->n + 0.5);
    int32_t rest = (int32_t)((uint32_t)s->words[1] - (uint32_t)over(s->n));
    return rest + (whole - s->n);
}
#else
static int follows(Instance *s) {
    int is_on = (s->words[0] & 0x47F) == 0x47F, was = s->words[10] & 4;
    s->words[10] = is_on ? 0x207 : 0x201;
    return is_on && was;
}

static double error(Instance *s) { return s->words[2]; }
#endif

EXPORT int fmi2DoStep(Instance *s, double t, double h, int final) {
    if (follows(s)) {
        double gain = MODE == 402 ? s->parameters[0] : s->words[3] / 1000.0;
        s->n += -expm1(-gain * h) * error(s);
    }
    show(s);
    return OK;
}
ABSENT
