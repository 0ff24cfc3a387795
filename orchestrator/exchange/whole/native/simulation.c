/* One instance of a composition, in place of fmus/native/simulation.c.

   Leaving initialisation carries out instant 0, doStep(t, h) all instants in
   (t, t + h].  Steps within 1e-3 of n ticks are n ticks, by count.  In event mode
   the sampled parts due at the end of a step wait for the clock. */
#include "component.h"
#include "whole.h"

#include <math.h>
#include <string.h>

#define M feeddrive_model
#define WHOLE_STEP 1e-3

size_t simulation_values(void) {
    return (M.size + M.n_d) * sizeof(double);
}

size_t simulation_size(void) {
    return simulation_values() + M.n_d * sizeof(double) +
           M.n_delays * sizeof(DelayLine) + whole_loaded();
}

static double *inside(const Simulation *s) {
    return s->values + M.size;
}

void simulation_place(Simulation *s, void *memory) {
    s->values = (double *)memory;
    s->x = s->values + M.size + M.n_d; /* to try things out */
    s->lines = (DelayLine *)(void *)(s->x + M.n_d); /* empty: the loop has its own */
    s->k = (double *)(void *)(s->lines + M.n_delays); /* FMUs of others */
}

void simulation_free(Simulation *s) {
    whole_free(s->k);
}

int simulation_reserve(Simulation *s, unsigned i, double tau) {
    (void)s;
    return whole_fits(i, tau);
}

void simulation_reset(Simulation *s) {
    memset(&s->state, 0, sizeof s->state);
    memset(s->values, 0, simulation_values());
    memcpy(s->values, M.start, M.size * sizeof(double));
    s->state.stop_time = INFINITY;
    s->state.derived_stale = s->state.outputs_stale = 1;
}

static double *tried(Simulation *s) {
    return (double *)memcpy(s->x, inside(s), M.n_d * sizeof(double));
}

/* In initialisation instant 0 is tried, so that leaving it can tell what fails. */
void simulation_refresh(Simulation *s) {
    double *trial;
    if (!s->state.outputs_stale)
        return;
    s->state.outputs_stale = s->state.derived_stale = 0;
    if (s->state.phase == EVENT) {
        trial = tried(s);
        whole_finish(trial, s->values, s->k);
        whole_read(trial, s->values, 0);
    } else if (whole_start(inside(s), s->values, s->k)) {
        whole_read(inside(s), s->values, 0);
        trial = tried(s);
        if (s->state.phase == INITIALIZING && !whole_run(trial, s->values, s->k, 0, WHOLE))
            memcpy(inside(s), trial, M.n_d * sizeof(double));
    }
}

void simulation_begin(Simulation *s) {
    whole_run(inside(s), s->values, s->k, 0, s->clocked ? HALF : WHOLE);
    whole_read(inside(s), s->values, 1);
}

static void add_time(State *state, double h) {
    double part = h - state->excess, sum = state->elapsed + part;
    state->excess = (sum - state->elapsed) - part; /* Kahan */
    state->elapsed = sum;
}

/* The last tick of a step: by count, or by the caller's clock or the sum of all
   steps, whichever is earlier. */
static int64_t target_of(State *state, double t, double h) {
    double tick = (double)whole_tick_num / (double)whole_tick_den;
    double ticks = h / tick, n = floor(ticks + 0.5), end;
    int64_t target;
    if (n >= 1 && fabs(ticks - n) < WHOLE_STEP) {
        add_time(state, n * tick);
        state->ahead += h - n * tick;
        return state->tick + (int64_t)n;
    }
    add_time(state, h);
    end = fmin(t - state->start_time + h - state->ahead, state->elapsed);
    target = (int64_t)floor(end / tick + WHOLE_STEP);
    return target < state->tick ? state->tick : target;
}

int simulation_step(Simulation *s, double t, double h) {
    int64_t target = target_of(&s->state, t, h);
    unsigned place;
    int done = whole_run(inside(s), s->values, s->k, target, s->clocked ? HALF : WHOLE);
    s->state.tick = target;
    s->values[M.size - 1] = t + h;
    whole_read(inside(s), s->values, 1);
    return done || whole_failure(inside(s), &place, &t) != WHOLE_LINE_FULL;
}

void simulation_activate(Simulation *s, int active) {
    s->state.ticking = active != 0;
    s->state.outputs_stale = s->state.outputs_stale || active;
}

void simulation_tick(Simulation *s) {
    whole_finish(inside(s), s->values, s->k);
    whole_read(inside(s), s->values, 1);
    s->state.ticking = s->state.outputs_stale = 0;
}

double simulation_effort(double h) {
    return h * (double)whole_tick_den / (double)whole_tick_num;
}

void simulation_tangent(Simulation *s) {
    (void)s; /* component_direction_begin has refused it */
}

unsigned simulation_not_finite(const Simulation *s) {
    unsigned place;
    double t;
    if (whole_failure(inside(s), &place, &t) != WHOLE_NOT_FINITE)
        return M.size;
    s->values[place] = NAN;
    s->values[M.size - 1] = s->state.start_time + t;
    return place;
}

unsigned simulation_bad_delay(const Simulation *s) {
    unsigned i = 0;
    while (i < M.n_delays && s->values[M.delays[i].dead_time] >= 0)
        i++;
    return i;
}
