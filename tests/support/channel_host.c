/* A master and the process of an FMU as two threads over one channel: STEPS requests,
   one of which the FMU refuses; the values lie at the ends of their allocations. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "../../orchestrator/native/channel.c"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEPS = 20000, REFUSES = 7000, SIZE = 3 };
enum { F64 = 0 }; /* as in calls.h */

typedef struct {
    double real[2 * SIZE];
    int steps;
} Fmu;

static int get_real(Fmu *fmu, const uint32_t *r, size_t n, double *values) {
    for (size_t i = 0; i < n; i++)
        values[i] = fmu->real[r[i]];
    return 0;
}
static int set_real(Fmu *fmu, const uint32_t *r, size_t n, const double *values) {
    for (size_t i = 0; i < n; i++)
        fmu->real[r[i]] = values[i];
    return 0;
}
static int do_step(Fmu *fmu, double t, double h, int unused) {
    for (int i = 0; i < SIZE; i++)
        fmu->real[SIZE + i] = fmu->real[i] + t + h;
    return ++fmu->steps == REFUSES ? 3 : 0;
}

typedef struct {
    Channel *channel;
    Kernel *kernel;
} Server;

static void *serve(void *given) {
    Server *server = given;
    while (!channel_serve(server->channel, server->kernel))
        channel_answer(server->channel);
    return NULL;
}

static void wanted(int found, const char *what) {
    if (!found) {
        fprintf(stderr, "not so: %s\n", what);
        exit(1);
    }
}

int main(void) {
    static const uint32_t references[2 * SIZE] = {0, 1, 2, 3, 4, 5};
    Channel *channel = calloc(1, sizeof *channel);
    double *values = calloc(2 * SIZE, sizeof *values), clock = 0;
    Fmu fmu = {{0}, 0};
    Group in = {.set = (Function *)set_real, .references = references,
                .n_references = SIZE, .size = SIZE, .values = values,
                .buffer = values, .type = F64, .major = 2};
    Group out = in;
    out.get = (Function *)get_real;
    out.references = references + SIZE;
    out.values = out.buffer = values + SIZE;
    Part part = {.instance = &fmu, .do_step = (Function *)do_step, .clock = &clock,
                 .inputs = &in, .outputs = &out, .n_inputs = 1, .n_outputs = 1,
                 .outcome = &channel->outcome, .major = 2};
    Kernel kernel = {.parts = &part};
    Link link = {.channel = channel, .values = values, .n_inputs = SIZE,
                 .n_outputs = SIZE, .within = 60};
    Server server = {channel, &kernel};
    pthread_t thread;
    wanted(!pthread_create(&thread, NULL, serve, &server), "a thread");
    for (int k = 0; k < STEPS; k++) {
        double u[SIZE] = {k, -k, 0.5 * k}, y[SIZE], t = 1e-3 * k;
        channel_set(&link, NULL, 0, u);
        int how = channel_step(&link, t, 1e-3, 1);
        wanted(how == (k + 1 == REFUSES ? REFUSED : 0), "the status of a step");
        wanted(!channel_get(&link, NULL, 0, y), "outputs");
        for (int i = 0; i < SIZE && !how; i++)
            wanted(y[i] == u[i] + t + 1e-3, "what the FMU computes");
    }
    wanted(!channel_ask(&link, LEAVE), "to leave");
    pthread_join(thread, NULL);
    free(values);
    free(channel);
    printf("%d steps\n", fmu.steps);
}
