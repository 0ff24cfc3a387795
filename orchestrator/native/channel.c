/* One FMU in a process of its own, reached through memory that both map.

   The master (channel_set, channel_step, channel_get: called like an FMI 2 FMU's
   own functions, with a Link for the instance) writes a request and then adds 1
   to `asked`; the process (channel_serve) carries it out on its FMU, with the
   kernel's operations, and then sets `answered` to the same number.  Whoever does
   not wait owns everything else in the Channel, and the values.

   The master stops waiting when the process has ended, after `within` seconds, or
   when a signal arrives. */

#include "kernel.h"
#include "turn.h"

#include <stddef.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { STEP, EXCHANGE, LEAVE };             /* what is asked */
enum { OK, REFUSED = 3, ENDED = 16, LATE, INTERRUPTED }; /* how it went */
enum { SET, DO_STEP, GET, NOTHING };        /* what the FMU is doing */
enum { STEPPING = 0, READING = 1, WRITING = 4 }; /* operations of kernel.c */

typedef struct {
    Turn asked, answered;
    int32_t what, given, doing, failed;
    double t, h; /* s */
    int64_t steps;
    Outcome outcome;
} Channel;

typedef struct {
    Channel *channel;
    double *values; /* inputs, then outputs, in memory that both map */
    size_t n_inputs, n_outputs;
    double within; /* s */
    int32_t stale; /* outputs in the channel are not those of the FMU now */
    int32_t ended; /* the process is known to have ended */
    Habits habits;
} Link;

double kernel_now(void);
int kernel_one(void *kernel, int32_t code, double t, double h);

static int await_answer(Link *link, uint32_t before) {
    for (double begun = kernel_now();;) {
        int ended = __atomic_load_n(&link->ended, __ATOMIC_ACQUIRE);
        int how = turn_wait(&link->channel->answered, before, &link->habits);
        if (how == CHANGED)
            return OK;
        if (ended)
            return ENDED;
        if (kernel_now() - begun > link->within)
            return LATE;
        if (how == SIGNALLED)
            return INTERRUPTED;
    }
}

/* Hand a request over and wait: EXCHANGE sets inputs and gets outputs without a
   step; LEAVE lets channel_serve return, so that the process listens to its pipe. */
EXPORT int channel_ask(Link *link, int what) {
    Channel *c = link->channel;
    uint32_t before = turn_number(&c->answered);
    c->what = what;
    turn_set(&c->asked, before + 1);
    int how = await_answer(link, before);
    if (how != OK)
        return how;
    link->stale = 0;
    return c->failed ? REFUSED : OK;
}

/* Hand over inputs; they reach the FMU with the next request. */
EXPORT int channel_set(Link *link, const uint32_t *references, size_t n,
                       const double *values) {
    (void)references, (void)n;
    memcpy(link->values, values, link->n_inputs * sizeof(double));
    link->channel->given = link->stale = 1;
    return OK;
}

/* Set inputs if they were handed over, do a step, get all outputs. */
EXPORT int channel_step(Link *link, double t, double h, int unused) {
    (void)unused;
    link->channel->t = t;
    link->channel->h = h;
    link->channel->steps = (int64_t)((uint64_t)link->channel->steps + 1); /* theirs too */
    return channel_ask(link, STEP);
}

/* Outputs of the latest step, or as they are now when inputs were set since. */
EXPORT int channel_get(Link *link, const uint32_t *references, size_t n,
                       double *values) {
    (void)references, (void)n;
    int how = link->stale ? channel_ask(link, EXCHANGE) : OK;
    const double *outputs = link->values + link->n_inputs;
    memcpy(values, outputs, link->n_outputs * sizeof(double));
    return how;
}

static int carry_out(Channel *c, void *kernel) {
    int good = 1;
    if (c->given) {
        c->doing = SET;
        good = kernel_one(kernel, WRITING, c->t, c->h);
        c->given = 0;
    }
    if (good && c->what == STEP) {
        c->doing = DO_STEP;
        good = kernel_one(kernel, STEPPING, c->t, c->h);
    }
    if (good) {
        c->doing = GET;
        good = kernel_one(kernel, READING, c->t, c->h);
    }
    c->doing = NOTHING;
    return good;
}

/* Serve requests until one is to leave (returns 1) or fails (returns 0); then
   Python says why and calls channel_answer. */
EXPORT int channel_serve(Channel *c, void *kernel) {
    Habits habits = {{0, 0}, {0, 0}};
    for (;;) {
        uint32_t answered = turn_number(&c->answered);
        while (turn_wait(&c->asked, answered, &habits) != CHANGED)
            ;
        int leaving = c->what == LEAVE; /* once answered, the channel is not ours */
        c->failed = 0;
        if (!leaving && !carry_out(c, kernel))
            return 0;
        turn_set(&c->answered, answered + 1);
        if (leaving)
            return 1;
    }
}

/* Answer a request that failed. */
EXPORT void channel_answer(Channel *c) {
    c->failed = 1;
    turn_set(&c->answered, turn_number(&c->asked));
}
