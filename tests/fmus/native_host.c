/* Loads an FMI 2.0 co-simulation library and steps it: a host without Python.

   native_host LIBRARY TOKEN steps N NUM DEN WRITE READ...
       steps N times by NUM/DEN s, WRITE set to the number of the step before
       each; prints the values READ after each step (references)
   native_host LIBRARY TOKEN count N NUM DEN NOISE READ MINIMUM MAXIMUM
       steps N times and checks that the counter READ goes up by MINIMUM to
       MAXIMUM in every step; prints its last value.  NOISE: exact (t = k h),
       sum (t += h), more and less (h (1 +- 1e-12), t summed), jitter (t = k h,
       h more or less by turns), difference (h = t_next - t), nanoseconds (h and
       t whole ones), long and short (h (1 +- 1e-5), t summed), half (two steps
       of h/2 are one of the N; t summed)
   native_host LIBRARY TOKEN churn N
       creates, steps and frees N instances; prints the growth of memory in
       pages after the first tenth

   The environment variable RESOURCES is the URI of the resources, if any. */
#include "fmi2Functions.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *library;

static void *find(const char *name) {
    void *function = dlsym(library, name);
    if (!function) {
        fprintf(stderr, "no %s\n", name);
        exit(1);
    }
    return function;
}

#define FIND(name) ((name##TYPE *)find(#name))

static void check(fmi2Status status, const char *what) {
    if (status != fmi2OK) {
        fprintf(stderr, "%s: status %d\n", what, (int)status);
        exit(1);
    }
}

static void logger(fmi2ComponentEnvironment environment, fmi2String name,
                   fmi2Status status, fmi2String category, fmi2String message, ...) {
    va_list arguments;
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    fprintf(stderr, "\n");
    va_end(arguments);
}

static fmi2Component start(const char *token) {
    static fmi2CallbackFunctions callbacks = {logger, NULL, NULL, NULL, NULL};
    fmi2Component c = FIND(fmi2Instantiate)("host", fmi2CoSimulation, token,
                                            getenv("RESOURCES"), &callbacks, 0, 1);
    if (!c)
        exit(1);
    check(FIND(fmi2SetupExperiment)(c, 0, 0, 0, 0, 0), "setup");
    check(FIND(fmi2EnterInitializationMode)(c), "enter");
    check(FIND(fmi2ExitInitializationMode)(c), "exit");
    return c;
}

static void steps(fmi2Component c, char **a, int n_read) {
    long n = atol(a[0]), num = atol(a[1]), den = atol(a[2]);
    fmi2ValueReference write = (fmi2ValueReference)atol(a[3]);
    for (long k = 0; k < n; k++) {
        double value = (double)k;
        check(FIND(fmi2SetReal)(c, &write, 1, &value), "set");
        check(FIND(fmi2DoStep)(c, (double)(k * num) / den, (double)num / den, 1),
              "step");
        for (int i = 0; i < n_read; i++) {
            fmi2ValueReference read = (fmi2ValueReference)atol(a[4 + i]);
            check(FIND(fmi2GetReal)(c, &read, 1, &value), "get");
            printf("%.17g ", value);
        }
        printf("\n");
    }
}

static void count(fmi2Component c, char **a) {
    long n = atol(a[0]), num = atol(a[1]), den = atol(a[2]);
    const char *noise = a[3];
    fmi2ValueReference read = (fmi2ValueReference)atol(a[4]);
    double minimum = atof(a[5]), maximum = atof(a[6]), before = 0, after = 0;
    int exact = !strcmp(noise, "exact"), jitter = !strcmp(noise, "jitter"),
        difference = !strcmp(noise, "difference");
    double h = (double)num / den, t = 0;
    if (!strcmp(noise, "more"))
        h *= 1 + 1e-12;
    if (!strcmp(noise, "less"))
        h *= 1 - 1e-12;
    if (!strcmp(noise, "long"))
        h *= 1 + 1e-5;
    if (!strcmp(noise, "short"))
        h *= 1 - 1e-5;
    long nanoseconds = strcmp(noise, "nanoseconds") ? 0 : (long)(h * 1e9 + 0.5);
    if (nanoseconds)
        h = nanoseconds / 1e9;
    int half = !strcmp(noise, "half");
    if (half)
        h /= 2;
    fmi2DoStepTYPE *step = FIND(fmi2DoStep);
    fmi2GetRealTYPE *get = FIND(fmi2GetReal);
    check(get(c, &read, 1, &before), "get");
    for (long k = 0; k < n; k++) {
        double now = h;
        if (exact || jitter || difference)
            t = (double)(k * num) / den;
        if (jitter)
            now = h * (k % 2 ? 1 + 1e-12 : 1 - 1e-12);
        if (difference)
            now = (double)((k + 1) * num) / den - t;
        if (nanoseconds)
            t = (double)(k * nanoseconds) / 1e9;
        if (half) {
            check(step(c, t, now, 1), "half a step");
            t += h;
        }
        check(step(c, t, now, 1), "step");
        check(get(c, &read, 1, &after), "get");
        if (after - before < minimum || after - before > maximum) {
            fprintf(stderr, "step %ld: %g after %g\n", k, after, before);
            exit(1);
        }
        before = after;
        t += h;
    }
    printf("%.0f\n", after);
}

static long pages(void) {
    long total, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &total, &resident) != 2)
        exit(1);
    fclose(file);
    return resident;
}

static void churn(const char *token, long n) {
    long first = 0;
    for (long k = 0; k < n; k++) {
        fmi2Component c = start(token);
        fmi2FMUstate state = NULL, copy = NULL;
        size_t size;
        for (int i = 0; i < 20; i++)
            check(FIND(fmi2DoStep)(c, i * 1e-4, 1e-4, 1), "step");
        check(FIND(fmi2GetFMUstate)(c, &state), "get state");
        check(FIND(fmi2GetFMUstate)(c, &state), "get state again");
        check(FIND(fmi2SerializedFMUstateSize)(c, state, &size), "size");
        fmi2Byte *bytes = malloc(size);
        check(FIND(fmi2SerializeFMUstate)(c, state, bytes, size), "serialise");
        check(FIND(fmi2DeSerializeFMUstate)(c, bytes, size, &copy), "deserialise");
        check(FIND(fmi2SetFMUstate)(c, copy), "set state");
        check(FIND(fmi2FreeFMUstate)(c, &state), "free state");
        check(FIND(fmi2FreeFMUstate)(c, &copy), "free state");
        free(bytes);
        if (k % 2)
            check(FIND(fmi2Terminate)(c), "terminate");
        FIND(fmi2FreeInstance)(c);
        if (k == n / 10)
            first = pages();
    }
    printf("%ld\n", pages() - first);
}

int main(int argc, char **argv) {
    if (argc < 5)
        return 2;
    library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    if (!strcmp(argv[3], "churn")) {
        churn(argv[2], atol(argv[4]));
        return 0;
    }
    fmi2Component c = start(argv[2]);
    if (!strcmp(argv[3], "steps"))
        steps(c, argv + 4, argc - 8);
    else
        count(c, argv + 4);
    check(FIND(fmi2Terminate)(c), "terminate");
    FIND(fmi2FreeInstance)(c);
    return 0;
}
