#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

typedef struct {
    void *(*instantiate)(const char *, int, const char *, const char *, void *, int,
                         int);
    int (*setup)(void *, int, double, double, int, double);
    int (*enter)(void *), (*exit)(void *);
    int (*step)(void *, double, double, int);
    int (*get)(void *, const unsigned *, size_t, double *);
    int (*set)(void *, const unsigned *, size_t, const double *);
    int (*set_boolean)(void *, const unsigned *, size_t, const int *);
} Fmu;

static void quiet(void) {}
static struct {
    void (*logger)(void);
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void *finished, *environment;
} callbacks = {quiet, calloc, free, NULL, NULL};

#define CHECK(call)                                                              \
    do {                                                                         \
        if ((call) > 1) {                                                        \
            fprintf(stderr, "%s failed\n", #call);                               \
            exit(1);                                                             \
        }                                                                        \
    } while (0)

static void load(Fmu *fmu, const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    *(void **)&fmu->instantiate = dlsym(library, "fmi2Instantiate");
    *(void **)&fmu->setup = dlsym(library, "fmi2SetupExperiment");
    *(void **)&fmu->enter = dlsym(library, "fmi2EnterInitializationMode");
    *(void **)&fmu->exit = dlsym(library, "fmi2ExitInitializationMode");
    *(void **)&fmu->step = dlsym(library, "fmi2DoStep");
    *(void **)&fmu->get = dlsym(library, "fmi2GetReal");
    *(void **)&fmu->set = dlsym(library, "fmi2SetReal");
    *(void **)&fmu->set_boolean = dlsym(library, "fmi2SetBoolean");
}

static FILE *file;
static int filled;

static void flush(const double *times, const double *rows, int columns) {
    fwrite(times, sizeof *times, (size_t)filled, file);
    for (int c = 0; c < columns; c++)
        fwrite(rows + 4096 * c, sizeof *rows, (size_t)filled, file);
    fflush(file);
    filled = 0;
}
