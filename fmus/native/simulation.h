/* One instance of the model: its numbers and how they move in time.

   Continuous: doStep integrates with n = max(1, ceil(h/h_max - 1e-6)) equal
   Runge-Kutta substeps (or the model's advance), cut where a delayed input
   changes; outputs and derivatives are then those at the new time with the
   inputs of the step.  Sampled: a step within 1e-3 T_s of n periods runs n
   ticks, by count.  In any other step tick j runs if the step ends after
   start + j*T_s + 1e-6*T_s; several may fall into one step, or none.  With a clock
   in use, none ever does.

   Outside stepping, outputs follow whatever is set, computed when asked for:
   those of output(), or of step() with the state left as it is.  Everything an
   FMU state must hold is in State and in the delay lines. */
#ifndef SIMULATION_H
#define SIMULATION_H

#include "delay.h"
#include "model.h"

typedef struct {
    double start_time, stop_time; /* s; stop_time is infinite if undefined */
    double elapsed, excess;       /* sum of all steps (s), and its rounding */
    double ahead;                 /* what the caller's clock is ahead of that (s) */
    long long tick;               /* the next one to run */
    int phase;                    /* of the component's state machine */
    int derived_stale;            /* prepare must run before the next equation */
    int outputs_stale;            /* outputs and derivatives are to be computed */
    int ticking;                  /* the clock is active */
} State;

typedef struct {
    State state;
    double *values;           /* as in model.h, followed by d */
    int clocked;              /* ticks are asked for in event mode */
    DelayLine *lines;         /* one per model.delays */
    double *u, *x, *k;        /* delayed inputs, trial states, 4 slopes */
    double *tangent;          /* changes of x and u, then of derivatives and y */
    const double **arg;
    double **res;
    long long *iw;
    double *w;
} Simulation;

/* Bytes of memory beside a Simulation; zeroed memory of that size is put to use. */
size_t simulation_size(void);
void simulation_place(Simulation *s, void *memory);
void simulation_free(Simulation *s);

/* Bytes of the values and of d. */
size_t simulation_values(void);

/* Make room in delay line i for a dead time of tau (s), at steps down to a
   sixteenth of h_max; returns 0 if there is no memory. */
int simulation_reserve(Simulation *s, unsigned i, double tau);

/* Put every value back to its start. */
void simulation_reset(Simulation *s);

/* Compute derived values, outputs and derivatives if something was set. */
void simulation_refresh(Simulation *s);

/* Begin stepping: delayed inputs have always had their present value. */
void simulation_begin(Simulation *s);

/* Activate or deactivate the clock; run the tick of an active one. */
void simulation_activate(Simulation *s, int active);
void simulation_tick(Simulation *s);

/* Number of substeps or ticks a step of h takes, as a double: may be huge. */
double simulation_effort(double h);

/* Evaluate the model's tangent at the present values. */
void simulation_tangent(Simulation *s);

/* Step from t to t + h; returns 0 if a delay line is full. */
int simulation_step(Simulation *s, double t, double h);

/* Reference of the first state or output that is not finite, or model.size. */
unsigned simulation_not_finite(const Simulation *s);

/* Index of the first delay whose dead time is negative, or model.n_delays. */
unsigned simulation_bad_delay(const Simulation *s);

#endif
