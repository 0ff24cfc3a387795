/* What the other process writes into the memory that both map is what libFuzzer says, at
   every moment at which the master looks there: into any byte, answered or not.  The
   master must end each call with one of the results there are, without a byte out of
   place. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static void seen(void); /* the master reads a number that both share */
#define __atomic_load_n(place, order) (seen(), *(place))
#define sched_yield told_yield
#define syscall told_syscall
#include "../../orchestrator/native/turn.c"
#include "../../orchestrator/native/channel.c"
#undef __atomic_load_n

enum { INPUTS = 2, OUTPUTS = 3, CALLS = 12 };

static const uint8_t *data; /* what is not used yet */
static size_t left;
static unsigned char *shared; /* the Channel, then the values */
static const size_t size = sizeof(Channel) + (INPUTS + OUTPUTS) * sizeof(double);
static double now; /* s */
static Link *link_;

static unsigned next(void) {
    if (!left)
        return 0;
    left--;
    return *data++;
}

static void seen(void) {
    unsigned how = next();
    if (how == 255)
        link_->ended = 1; /* its process has */
    if (how < 200 && how % 4 == 3) {
        Channel *c = (Channel *)shared;
        c->answered.number = c->asked.number;
    }
    for (; how > 200 && how < 250 && left; how -= how > 220 ? 20 : how)
        shared[next() % size] = (unsigned char)next();
    if (how >= 250 && how < 255) {
        static const int64_t wild[] = {INT64_MAX, INT64_MIN, -1, 0x7ff0000000000000};
        memcpy(shared + next() * 8 % size, wild + how % 4, sizeof *wild);
    }
}
double kernel_now(void) {
    return now += 1e-4;
}
int told_yield(void) {
    seen();
    return 0;
}
long told_syscall(long what, ...) {
    (void)what;
    seen();
    errno = next() % 8 == 7 ? EINTR : EAGAIN;
    return -1;
}
int kernel_one(void *kernel, int32_t code, double t, double h) {
    (void)kernel, (void)code, (void)t, (void)h;
    abort(); /* the master has none */
}

int LLVMFuzzerTestOneInput(const uint8_t *given, size_t n) {
    data = given;
    left = n;
    now = 0;
    shared = calloc(size, 1);
    Link ours = {.channel = (Channel *)shared, .values = (double *)(shared + sizeof(Channel)),
                 .n_inputs = INPUTS, .n_outputs = OUTPUTS, .within = 0.01};
    link_ = &ours;
    double *u = calloc(INPUTS, sizeof *u), *y = calloc(OUTPUTS, sizeof *y);
    for (int call = 0; call < CALLS; call++) {
        int how = OK;
        switch (next() % 4) {
        case 0: how = channel_set(&ours, NULL, INPUTS, u); break;
        case 1: how = channel_step(&ours, call, 1, 1); break;
        case 2: how = channel_get(&ours, NULL, OUTPUTS, y); break;
        default: how = channel_ask(&ours, LEAVE); break;
        }
        if (how != OK && how != REFUSED && how != ENDED && how != LATE &&
            how != INTERRUPTED)
            abort();
        if (how == LATE && now < ours.within)
            abort();
    }
    free(u);
    free(y);
    free(shared);
    return 0;
}
