#include "simulation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define M feeddrive_model

#define SHORTEST 16  /* steps of h_max / 16 fit into a delay line */
#define LONGEST_LINE 1048576.0
#define WHOLE 1e-3 /* of a period: a step this near to n periods is n ticks */

size_t simulation_values(void) {
    return (M.size + M.n_d) * sizeof(double);
}

/* Everything is counted in places of 8 bytes, which pointers fit into. */
static size_t places(unsigned n) {
    return n * sizeof(double);
}

size_t simulation_size(void) {
    size_t size = simulation_values() + places(M.n_u + 5 * M.n_x) +
                  places(2 * M.n_x + M.n_u + M.n_y) + places(M.sz_arg) +
                  places(M.sz_res) + places(M.sz_iw) + places(M.sz_w);
    unsigned i;
    for (i = 0; i < M.n_delays; i++)
        size += sizeof(DelayLine) + M.delays[i].capacity * sizeof(Change);
    return size;
}

void simulation_place(Simulation *s, void *memory) {
    double *next = (double *)memory;
    Change *changes;
    unsigned i;
    s->values = next;
    next += M.size + M.n_d;
    s->u = next;
    next += M.n_u;
    s->x = next;
    next += M.n_x;
    s->k = next;
    next += 4 * M.n_x;
    s->tangent = next;
    next += 2 * M.n_x + M.n_u + M.n_y;
    s->w = next;
    next += M.sz_w;
    s->arg = (const double **)(void *)next;
    next += M.sz_arg;
    s->res = (double **)(void *)next;
    next += M.sz_res;
    s->iw = (long long *)(void *)next;
    next += M.sz_iw;
    changes = (Change *)(void *)next;
    for (i = 0; i < M.n_delays; i++)
        changes += M.delays[i].capacity;
    s->lines = (DelayLine *)(void *)changes;
    changes = (Change *)(void *)next;
    for (i = 0; i < M.n_delays; i++) {
        s->lines[i].changes = changes;
        s->lines[i].capacity = M.delays[i].capacity;
        changes += M.delays[i].capacity;
    }
}

void simulation_free(Simulation *s) {
    unsigned i;
    for (i = 0; i < M.n_delays; i++)
        delay_free(s->lines + i);
}

int simulation_reserve(Simulation *s, unsigned i, double tau) {
    double wanted = ceil(tau / M.h_max * SHORTEST) + 2;
    return delay_reserve(s->lines + i, (size_t)fmin(fmax(wanted, 2), LONGEST_LINE));
}

void simulation_reset(Simulation *s) {
    memset(&s->state, 0, sizeof s->state);
    memset(s->values, 0, simulation_values());
    memcpy(s->values, M.start, M.size * sizeof(double));
    s->state.stop_time = INFINITY;
    s->state.derived_stale = s->state.outputs_stale = 1;
    simulation_begin(s);
}

/* Evaluate equation(x, u, p, d, extra) -> (first, second). */
static void evaluate(Simulation *s, Equation *equation, const double *x,
                     const double *u, const double *extra, double *first,
                     double *second) {
    s->arg[0] = x;
    s->arg[1] = u;
    s->arg[2] = s->values;
    s->arg[3] = s->values + M.size;
    if (extra)
        s->arg[4] = extra;
    s->res[0] = first;
    if (second || !M.continuous)
        s->res[1] = second;
    equation(s->arg, s->res, s->iw, s->w, 0);
}

static void derive(Simulation *s) {
    if (!s->state.derived_stale)
        return;
    s->arg[0] = s->values;
    s->arg[1] = M.continuous ? NULL : s->values + M.T_s;
    s->res[0] = s->values + M.size;
    M.prepare(s->arg, s->res, s->iw, s->w, 0);
    s->state.derived_stale = 0;
}

/* Outputs and derivatives of the present states with inputs u. */
static void compute_outputs(Simulation *s, const double *u) {
    double *v = s->values;
    if (M.continuous) {
        evaluate(s, M.derivative, v + M.x, u, NULL, v + M.der_x, NULL);
        evaluate(s, M.output, v + M.x, u, NULL, v + M.y, NULL);
    } else {
        evaluate(s, M.step, v + M.x, u, v + M.T_s, s->x, v + M.y);
    }
    s->state.outputs_stale = 0;
}

void simulation_refresh(Simulation *s) {
    if (!s->state.outputs_stale)
        return;
    derive(s);
    compute_outputs(s, s->values + M.u);
}

void simulation_tangent(Simulation *s) {
    double *v = s->values, *result = s->tangent + M.n_x + M.n_u;
    derive(s);
    s->arg[0] = v + M.x;
    s->arg[1] = v + M.u;
    s->arg[2] = v;
    s->arg[3] = v + M.size;
    s->arg[4] = M.continuous ? NULL : v + M.T_s;
    s->arg[5] = s->tangent;
    s->arg[6] = s->tangent + M.n_x;
    s->res[0] = result;
    s->res[1] = result + M.n_x;
    M.tangent(s->arg, s->res, s->iw, s->w, 0);
}

void simulation_begin(Simulation *s) {
    for (unsigned i = 0; i < M.n_delays; i++)
        delay_reset(s->lines + i, s->values[M.delays[i].input]);
}

/* x + c k into trial. */
static void ahead(const double *x, double c, const double *k, double *trial) {
    for (unsigned i = 0; i < M.n_x; i++)
        trial[i] = x[i] + c * k[i];
}

static void runge_kutta(Simulation *s, const double *u, double h) {
    double *x = s->values + M.x, *trial = s->x;
    double *k1 = s->k, *k2 = k1 + M.n_x, *k3 = k2 + M.n_x, *k4 = k3 + M.n_x;
    evaluate(s, M.derivative, x, u, NULL, k1, NULL);
    ahead(x, h / 2, k1, trial);
    evaluate(s, M.derivative, trial, u, NULL, k2, NULL);
    ahead(x, h / 2, k2, trial);
    evaluate(s, M.derivative, trial, u, NULL, k3, NULL);
    ahead(x, h, k3, trial);
    evaluate(s, M.derivative, trial, u, NULL, k4, NULL);
    for (unsigned i = 0; i < M.n_x; i++)
        x[i] = x[i] + h / 6 * k1[i] + h / 3 * k2[i] + h / 3 * k3[i] +
               h / 6 * k4[i];
}

static double substeps(double h) {
    return fmax(1.0, ceil(h / M.h_max - 1e-6));
}

static void integrate(Simulation *s, const double *u, double h) {
    long long n = (long long)substeps(h);
    double dt = h / (double)n, *x = s->values + M.x;
    for (long long i = 0; i < n; i++) {
        if (M.advance) {
            evaluate(s, M.advance, x, u, &dt, s->x, NULL);
            memcpy(x, s->x, M.n_x * sizeof(double));
        } else {
            runge_kutta(s, u, dt);
        }
    }
}

/* Deliver what arrives at or before now (relative to t) to the delayed inputs;
   return when the next change arrives, or end if none does before. */
static double deliver(Simulation *s, double t, double now, double end) {
    for (unsigned i = 0; i < M.n_delays; i++) {
        DelayLine *line = s->lines + i;
        double tau = s->values[M.delays[i].dead_time];
        const Change *next;
        while ((next = delay_next(line, 0)) && next->time + tau - t <= now)
            delay_arrive(line);
        s->u[M.delays[i].input - M.u] = line->value;
        if (next)
            end = fmin(end, next->time + tau - t);
    }
    return end;
}

/* Integrate from one arrival of a delayed input to the next.  Times nearer to
   an end of the step than rounding count as that end; what arrives at the end
   acts from the next step on, as an input set there would. */
static int continuous_step(Simulation *s, double t, double h) {
    const double *v = s->values, *u = v + M.u;
    const double near = 1e-9 * h + 4 * DBL_EPSILON * fabs(t);
    for (unsigned i = 0; i < M.n_delays; i++)
        if (!delay_enter(s->lines + i, t, v[M.delays[i].input]))
            return 0;
    if (M.n_delays) {
        memcpy(s->u, u, M.n_u * sizeof(double));
        u = s->u;
    }
    for (double from = 0, to; from < h; from = to) {
        to = deliver(s, t, from + near, h);
        if (to >= h - near)
            to = h;
        integrate(s, u, to - from);
    }
    compute_outputs(s, u);
    return 1;
}

static void add_time(State *state, double h) {
    double part = h - state->excess, sum = state->elapsed + part;
    state->excess = (sum - state->elapsed) - part; /* Kahan */
    state->elapsed = sum;
}

void simulation_activate(Simulation *s, int active) {
    s->state.ticking = active != 0;
    s->state.outputs_stale = s->state.outputs_stale || active;
}

/* One evaluation of step. */
static void tick(Simulation *s) {
    double *v = s->values;
    evaluate(s, M.step, v + M.x, v + M.u, v + M.T_s, s->x, v + M.y);
    memcpy(v + M.x, s->x, M.n_x * sizeof(double));
    s->state.tick++;
}

void simulation_tick(Simulation *s) {
    derive(s);
    tick(s);
    s->state.ticking = s->state.outputs_stale = 0;
}

/* Between whole steps, the end is by the caller's clock or by the sum of all steps,
   whichever is earlier: t += h runs ahead by more than 1e-6 T_s in seconds. */
static void sampled_step(Simulation *s, double t, double h) {
    State *state = &s->state;
    double T_s = s->values[M.T_s], periods = h / T_s, n = floor(periods + 0.5), end;
    if (n >= 1 && fabs(periods - n) < WHOLE) {
        add_time(state, n * T_s);
        state->ahead += h - n * T_s;
        for (; n > 0; n--)
            tick(s);
        return;
    }
    add_time(state, h);
    end = fmin(t + h - state->ahead, state->start_time + state->elapsed) - 1e-6 * T_s;
    while (state->start_time +
               (double)(state->tick * M.period_num) / (double)M.period_den <
           end)
        tick(s);
}

double simulation_effort(double h) {
    return M.continuous
               ? substeps(h)
               : h * (double)M.period_den / (double)M.period_num;
}

int simulation_step(Simulation *s, double t, double h) {
    derive(s);
    if (M.continuous) {
        if (!continuous_step(s, t, h))
            return 0;
    } else if (!s->clocked) {
        sampled_step(s, t, h);
    }
    s->values[M.size - 1] = t + h;
    return 1;
}

unsigned simulation_not_finite(const Simulation *s) {
    const double *v = s->values;
    for (unsigned i = M.y; i < M.x + M.n_x; i++)
        if (!isfinite(v[i]))
            return i;
    return M.size;
}

unsigned simulation_bad_delay(const Simulation *s) {
    unsigned i = 0;
    while (i < M.n_delays && s->values[M.delays[i].dead_time] >= 0)
        i++;
    return i;
}
