/* An FMU that does all that the standard lets it do, and bears nothing that it
   forbids: whoever goes on after an Error, or after the end it announced, meets
   abort().  KIND says what it is besides:

   0 a first-order lag y' = u - y, and arrays s = a u of the length n; an Error ends
     an instance, structural parameters are set in configuration mode only, b is
     Binary (FMI 3)
   1 ends the run by itself after 0.0203 s
   2 is unstable and overflows: y' = 3000 y
   3 is chaotic: Lorenz's equations, y the first of three
   4 wants a stop time
   5 never returns from a step, 6 waits for ever in one
   and two that are not so correct:
   7 counts its steps in y and loses one when a time is 1e-13 too small
   8 always steps by 0.001 s, whatever it is asked for

   Value references: 0 input u, 1 output y, 2 parameter a, 3 output s (FMI 3: arrays),
   4 structural parameter n, 5 parameter b (FMI 3); from 100 on MORE parameters that
   start at 0 (FMI 2).  config.h as for foreign.c. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))
#define LONGEST 8

enum { OK, WARNS, DISCARD, ERROR };
enum { INSTANTIATED = 1, CONFIGURING = 2, INITIALISING = 4, STEPPING = 8, ENDED = 16,
       OVER = 32, FAILED = 64 };

typedef void Logger(void);

typedef struct {
    int phase;
    double u, y, z[2], t;
    double a[LONGEST], more[MORE + 1];
    uint64_t n;
    unsigned char b[2];
    char name[80];
    Logger *logger;
    void *environment;
} Instance;

static int refuse(Instance *s, const char *why) {
#if FMI == 2
    if (s->logger)
        ((void (*)(void *, const char *, int, const char *, const char *, ...))
             s->logger)(s->environment, s->name, ERROR, "logStatusError", why);
#else
    if (s->logger)
        ((void (*)(void *, int, const char *, const char *))s->logger)(
            s->environment, ERROR, "logStatusError", why);
#endif
    s->phase = FAILED;
    return ERROR;
}

/* Whoever calls on after an Error or after the end gets what he deserves. */
static int may(Instance *s, int phases) {
    if (s->phase == FAILED || (s->phase == ENDED && !(phases & ENDED)))
        abort();
    return s->phase & phases;
}

static void start(Instance *s) {
    s->phase = INSTANTIATED;
    s->u = 1.0;
    s->y = KIND == 3 ? 1.0 : 0.5;
    s->z[0] = s->z[1] = 1.0;
    s->t = 0.0;
    s->n = 3;
    for (int i = 0; i < LONGEST; i++)
        s->a[i] = i + 1.0;
    memset(s->more, 0, sizeof s->more);
    s->b[0] = 0x0a;
    s->b[1] = 0x1b;
}

static Instance *create(const char *name, const char *token, Logger *logger,
                        void *environment) {
    Instance *s = calloc(1, sizeof *s);
    start(s);
    s->logger = logger;
    s->environment = environment;
    if (name)
        strncpy(s->name, name, sizeof s->name - 1);
    if (name && *name && token && !strcmp(token, "x"))
        return s;
    refuse(s, "no such name or token");
    free(s);
    return NULL;
}

static void lorenz(double h, double *x, double *y, double *z) {
    const int many = 20;
    for (int i = 0; i < many; i++) {
        double dx = 10 * (*y - *x), dy = *x * (28 - *z) - *y, dz = *x * *y - 8.0 / 3 * *z;
        *x += h / many * dx;
        *y += h / many * dy;
        *z += h / many * dz;
    }
}

static int advance(Instance *s, double t, double h) {
    if (!may(s, STEPPING))
        return refuse(s, "a step now");
    if (!(h > 0) || fabs(t - s->t) > 1e-9)
        return refuse(s, "a step that does not go on");
    if (KIND == 1 && t + h > 0.0203) {
        s->phase = ENDED;
        return DISCARD;
    }
    if (KIND == 5)
        for (volatile int i = 0;; i++)
            ;
    if (KIND == 6)
        for (;;)
            pause();
    if (KIND == 2)
        s->y *= exp(3000 * h);
    else if (KIND == 3)
        lorenz(h, &s->y, s->z, s->z + 1);
    else if (KIND == 7)
        s->y += t + h > (s->y + 0.5) * 1e-3 * (1 - 1e-14) ? 1 : 0;
    else
        s->y = s->u + (s->y - s->u) * exp(KIND == 8 ? -1e-3 : -h);
    s->t = t + h;
    return OK;
}

EXPORT int EXIT(Instance *s) {
    if (!may(s, INITIALISING))
        return refuse(s, "no initialisation to leave");
    s->phase = STEPPING;
    return OK;
}

EXPORT int TERMINATE(Instance *s) {
    if (!may(s, STEPPING | ENDED))
        return refuse(s, "nothing to terminate");
    s->phase = OVER;
    return OK;
}

EXPORT void FREE(Instance *s) {
    free(s);
}

#if FMI == 2
#include "correct_fmi2.h"
#else
#include "correct_fmi3.h"
#endif

ABSENT
