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

/* What the stages of a substep hand on. */
typedef struct {
    V trial[N_X + 1], k[4][N_X + 1];
} NAME(_Stages);

#ifdef ADVANCE
enum { NAME(_STAGES) = 1 };
static inline void NAME(_here)(NAME(_Stages) *r, int i) {
    (void)i;
    for (int j = 0; j < N_X; j++)
        HERE(r->trial[j]);
}
static inline void NAME(_stage)(NAME(_Stages) *r, V *v, const V *u, double h, int i) {
    const V dt = (V)h, *const arg[5] = {v + X, u, v, v + SIZE, &dt};
    V *const res[1] = {r->trial};
    (void)i;
    NAME(_advance)(arg, res);
    memcpy(v + X, r->trial, N_X * sizeof(V));
}
#else
enum { NAME(_STAGES) = 4 };
static inline void NAME(_here)(NAME(_Stages) *r, int i) {
    for (int j = 0; j < N_X; j++)
        HERE(r->k[i][j]);
}
static inline void NAME(_stage)(NAME(_Stages) *r, V *v, const V *u, double h, int i) {
    V *x = v + X, *const res[1] = {r->k[i]};
    const V *const arg[4] = {i ? r->trial : x, u, v, v + SIZE};
    NAME(_derivative)(arg, res);
    for (int j = 0; j < N_X; j++)
        if (i < 2)
            r->trial[j] = x[j] + h / 2 * r->k[i][j];
        else if (i == 2)
            r->trial[j] = x[j] + h * r->k[i][j];
        else
            x[j] = x[j] + h / 6 * r->k[0][j] + h / 3 * r->k[1][j] + h / 3 * r->k[2][j] +
                   h / 6 * r->k[3][j];
}
#endif

static inline void NAME(_substep)(V *v, const V *u, double h) {
    NAME(_Stages) r;
    for (int i = 0; i < NAME(_STAGES); i++)
        NAME(_stage)(&r, v, u, h, i);
}

static inline void NAME(_integrate)(V *v, const V *u, double h) {
    long long n = (long long)fmax(1.0, ceil(h / H_MAX - 1e-6));
    double dt = h / (double)n;
    for (long long i = 0; i < n; i++)
        NAME(_substep)(v, u, dt);
}

/* What follows the substeps; u are the inputs that act. */
static inline void NAME(_ended)(Instance *s, const V *u) {
    NAME(_outputs)(s->values, u);
    s->wrong = wrong(s->values + Y, X + N_X - Y);
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
    NAME(_ended)(s, u);
#else
    (void)t;
    NAME(_integrate)(v, v + U, h);
    NAME(_ended)(s, v + U);
#endif
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

/* What follows the equations: the state they gave becomes the one there is. */
static inline void NAME(_ended)(Instance *s, const V *next) {
    memcpy(s->values + X, next, N_X * sizeof(V));
    s->wrong = wrong(s->values + Y, X + N_X - Y);
}

STEP int NAME(_step)(Instance *s, double t, double h) {
    V *v = s->values, next[N_X + 1];
    const V *const arg[5] = {v + X, v + U, v, v + SIZE, v + T_S};
    V *const res[2] = {next, v + Y};
    (void)t;
    (void)h;
    NAME(_tick)(arg, res);
    NAME(_ended)(s, next);
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
