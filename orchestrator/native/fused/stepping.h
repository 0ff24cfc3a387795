/* How one model of ours moves in time, on numbers of the type V; included once per
   model, between its table and its equations (orchestrator/master/fused/source.py).

   The same operations in the same order as fmus/native/simulation.c and delay.c, on
   values laid out as fmus/native/model.h says, followed by d.  With dead time, all
   lanes must change their inputs at the same instants: else 0 is returned and failure
   says APART, and each member is run for itself. */

#define NAME(x) PASTE(MODEL, x)

static inline void NAME(_derive)(V *v) {
    const V *const arg[2] = {v, v + T_S};
    V *const res[1] = {v + SIZE};
    NAME(_prepare)(arg, res);
}

#if CONTINUOUS

static inline void NAME(_outputs)(V *v, const V *u) {
    const V *const arg[4] = {v + X, u, v, v + SIZE};
    V *const der[1] = {v + DER_X}, *const y[1] = {v + Y};
    NAME(_derivative)(arg, der);
    NAME(_output)(arg, y);
}

static inline void NAME(_substep)(V *v, const V *u, double h) {
    V *x = v + X, trial[N_X + 1];
#ifdef ADVANCE
    const V dt = (V)h, *const arg[5] = {x, u, v, v + SIZE, &dt};
    V *const res[1] = {trial};
    NAME(_advance)(arg, res);
    memcpy(x, trial, N_X * sizeof(V));
#else
    V k1[N_X + 1], k2[N_X + 1], k3[N_X + 1], k4[N_X + 1];
    const V *const here[4] = {x, u, v, v + SIZE}, *const there[4] = {trial, u, v, v + SIZE};
    V *const to1[1] = {k1}, *const to2[1] = {k2}, *const to3[1] = {k3}, *const to4[1] = {k4};
    NAME(_derivative)(here, to1);
    for (int i = 0; i < N_X; i++)
        trial[i] = x[i] + h / 2 * k1[i];
    NAME(_derivative)(there, to2);
    for (int i = 0; i < N_X; i++)
        trial[i] = x[i] + h / 2 * k2[i];
    NAME(_derivative)(there, to3);
    for (int i = 0; i < N_X; i++)
        trial[i] = x[i] + h * k3[i];
    NAME(_derivative)(there, to4);
    for (int i = 0; i < N_X; i++)
        x[i] = x[i] + h / 6 * k1[i] + h / 3 * k2[i] + h / 3 * k3[i] + h / 6 * k4[i];
#endif
}

static inline void NAME(_integrate)(V *v, const V *u, double h) {
    long long n = (long long)fmax(1.0, ceil(h / H_MAX - 1e-6));
    double dt = h / (double)n;
    for (long long i = 0; i < n; i++)
        NAME(_substep)(v, u, dt);
}

STEP int NAME(_step)(Instance *s, double t, double h) {
    V *v = s->values;
#if N_DELAYS
    static const Delayed delays[N_DELAYS] = DELAYS;
    const double near = 1e-9 * h + 4 * DBL_EPSILON * fabs(t);
    V u[N_U + 1];
    for (int i = 0; i < N_DELAYS; i++)
        if (!delay_enter(s->lines + i, t, v[delays[i].input], &s->failure))
            return 0;
    memcpy(u, v + U, N_U * sizeof(V));
    for (double from = 0, to; from < h; from = to) {
        to = h;
        for (int i = 0; i < N_DELAYS; i++) {
            Line *line = s->lines + i;
            double tau = lane(v[delays[i].dead_time], 0), arrival;
            while (line->count && delay_time(line) + tau - t <= from + near)
                delay_arrive(line);
            u[delays[i].input - U] = line->value;
            if (line->count) {
                arrival = delay_time(line) + tau - t;
                to = arrival < to ? arrival : to;
            }
        }
        if (to >= h - near)
            to = h;
        NAME(_integrate)(v, u, to - from);
    }
    NAME(_outputs)(v, u);
#else
    (void)t;
    NAME(_integrate)(v, v + U, h);
    NAME(_outputs)(v, v + U);
#endif
    s->wrong = wrong(v + Y, X + N_X - Y);
    return 1;
}

static void NAME(_begin)(Instance *s) {
    (void)s;
#if N_DELAYS
    static const Delayed delays[N_DELAYS] = DELAYS;
    for (int i = 0; i < N_DELAYS; i++) {
        s->lines[i].value = s->values[delays[i].input];
        s->lines[i].first = s->lines[i].count = 0;
    }
#endif
}

static void NAME(_refresh)(Instance *s) {
    NAME(_outputs)(s->values, s->values + U);
}

#else

STEP int NAME(_step)(Instance *s, double t, double h) {
    V *v = s->values, next[N_X + 1];
    const V *const arg[5] = {v + X, v + U, v, v + SIZE, v + T_S};
    V *const res[2] = {next, v + Y};
    (void)t;
    (void)h;
    NAME(_tick)(arg, res);
    memcpy(v + X, next, N_X * sizeof(V));
    s->wrong = wrong(v + Y, X + N_X - Y);
    return 1;
}

static void NAME(_begin)(Instance *s) {
    (void)s;
}

static void NAME(_refresh)(Instance *s) {
    V *v = s->values;
    const V *const arg[5] = {v + X, v + U, v, v + SIZE, v + T_S};
    V *const res[2] = {NULL, v + Y};
    NAME(_tick)(arg, res);
}

#endif

#undef NAME
