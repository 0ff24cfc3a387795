/* An FMI 2.0 co-simulation FMU that misbehaves in the way `mode` says, in the step
   that begins at `at` or later; HANG_WHEN_FREED when it is freed, WANT_EQUAL_STEPS in
   a step that is not as long as the first.  Until then y = u + t. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { U, Y, AT, MODE };
enum { OK, WARNING, DISCARD, ERROR, FATAL };
enum {
    WELL, SEGFAULT, HANG, RETURN_ERROR, RETURN_FATAL, RETURN_DISCARD, NOT_A_NUMBER,
    EXIT, LEAVE_THREAD, TAKE_MEMORY, ABORT, HANG_WHEN_FREED, WANT_EQUAL_STEPS,
    NEGATIVE, SEVEN, NEGATIVE_GET, NEGATIVE_SET, NEGATIVE_START
};

typedef void Logger(void *, const char *, int, const char *, const char *, ...);

typedef struct {
    Logger *logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *step_finished, *environment;
} Callbacks;

typedef struct {
    double real[3], first;
    int mode, begun;
    char name[64];
    Logger *logger;
} Instance;

extern int pthread_create(unsigned long *, const void *, void *(*)(void *), void *);

static volatile double counted;

static void *count(void *nothing) {
    for (;;)
        counted += 1;
    return nothing;
}

static void take_memory(void) {
    for (;;) {
        const size_t size = 1 << 24;
        char *taken = malloc(size);
        if (!taken)
            abort();
        for (size_t k = 0; k < size; k += 4096)
            ((volatile char *)taken)[k] = 1;
    }
}

EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *resources, const Callbacks *callbacks,
                             int visible, int logging) {
    Instance *i = calloc(1, sizeof *i);
    strncpy(i->name, name, sizeof i->name - 1);
    i->logger = callbacks->logger;
    i->real[AT] = 1e9;
    return i;
}

EXPORT void fmi2FreeInstance(Instance *i) {
    while (i->mode == HANG_WHEN_FREED)
        ;
    free(i);
}

EXPORT int fmi2SetupExperiment(void *i, int a, double b, double c, int d, double e) {
    return OK;
}
EXPORT int fmi2EnterInitializationMode(Instance *i) {
    return i->mode == NEGATIVE_START ? -1 : OK;
}
EXPORT int fmi2ExitInitializationMode(void *i) { return OK; }
EXPORT int fmi2Terminate(void *i) { return OK; }
EXPORT int fmi2Reset(void *i) { return OK; }

EXPORT int fmi2GetReal(Instance *i, const unsigned *r, size_t n, double *values) {
    for (size_t k = 0; k < n; k++)
        values[k] = i->real[r[k]];
    return i->begun && i->mode == NEGATIVE_GET ? -1 : OK;
}
EXPORT int fmi2SetReal(Instance *i, const unsigned *r, size_t n, const double *values) {
    for (size_t k = 0; k < n; k++)
        i->real[r[k]] = values[k];
    return i->begun && i->mode == NEGATIVE_SET ? -1 : OK;
}
EXPORT int fmi2GetInteger(Instance *i, const unsigned *r, size_t n, int *values) {
    for (size_t k = 0; k < n; k++)
        values[k] = i->mode;
    return OK;
}
EXPORT int fmi2SetInteger(Instance *i, const unsigned *r, size_t n, const int *values) {
    for (size_t k = 0; k < n; k++)
        i->mode = values[k];
    return OK;
}

/* What FMI prescribes and nobody calls here. */
#define ABSENT(name) EXPORT int name(void) { return ERROR; }
ABSENT(fmi2SetDebugLogging) ABSENT(fmi2GetBoolean) ABSENT(fmi2SetBoolean)
ABSENT(fmi2GetString) ABSENT(fmi2SetString) ABSENT(fmi2GetFMUstate)
ABSENT(fmi2SetFMUstate) ABSENT(fmi2FreeFMUstate) ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate) ABSENT(fmi2DeSerializeFMUstate)
ABSENT(fmi2GetDirectionalDerivative) ABSENT(fmi2SetRealInputDerivatives)
ABSENT(fmi2GetRealOutputDerivatives) ABSENT(fmi2CancelStep) ABSENT(fmi2GetStatus)
ABSENT(fmi2GetRealStatus) ABSENT(fmi2GetIntegerStatus) ABSENT(fmi2GetBooleanStatus)
ABSENT(fmi2GetStringStatus)

EXPORT int fmi2DoStep(Instance *i, double t, double h, int no_set_state) {
    unsigned long thread;
    i->real[Y] = i->real[U] + t + h;
    if (!i->first)
        i->first = h;
    if (t < i->real[AT])
        return OK;
    i->begun = 1;
    switch (i->mode) {
    case NEGATIVE: return -1;
    case SEVEN: return 7;
    case SEGFAULT: *(volatile int *)8 = 1; break;
    case HANG: for (volatile int n = 0;; n++) ;
    case RETURN_ERROR:
    case RETURN_FATAL:
    case RETURN_DISCARD: {
        int status = i->mode == RETURN_ERROR   ? ERROR
                     : i->mode == RETURN_FATAL ? FATAL
                                               : DISCARD;
        i->logger(NULL, i->name, status, "logStatus", "the motor is on fire");
        return status;
    }
    case NOT_A_NUMBER: i->real[Y] = 0.0 / (t - t); break;
    case EXIT: exit(7);
    case LEAVE_THREAD:
        i->real[AT] = 1e9;
        pthread_create(&thread, NULL, count, NULL);
        break;
    case TAKE_MEMORY: take_memory(); break;
    case ABORT: abort();
    case WANT_EQUAL_STEPS: return h == i->first ? OK : DISCARD;
    default: break;
    }
    return OK;
}
