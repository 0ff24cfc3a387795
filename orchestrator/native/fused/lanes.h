/* Numbers of the type V: one double (W = 1), or W of them, one member of a sweep in
   each lane.  Every operation is what C does to each double alone, in the same order,
   so that a lane has the bits of a run of its own (compile with -ffp-contract=off).

   A truth is 1.0 or 0.0, as in the equations that fmus/equations.py writes. */
#ifndef LANES_H
#define LANES_H

#include "elementary.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#if W == 1

typedef double V;
#define truth(condition) ((V)(condition))
#define PER_LANE(f) f

static inline V given(V c, V x) { return c != 0 ? x : 0; }
static inline V negated(V a) { return a == 0; }
static inline V both(V a, V b) { return a != 0 && b != 0; }
static inline V either(V a, V b) { return a != 0 || b != 0; }
static inline V v_fabs(V a) { return fabs(a); }
static inline V v_floor(V a) { return floor(a); }
static inline V v_ceil(V a) { return ceil(a); }
static inline V v_sqrt(V a) { return sqrt(a); }
static inline V v_sign(V a) { return a < 0 ? -1 : a > 0 ? 1 : a; }
static inline V v_fmin(V a, V b) { return own_fmin(a, b); }
static inline V v_fmax(V a, V b) { return own_fmax(a, b); }
#define ONE(f) static inline V v_##f(V a) { return own_##f(a); }
#define NEAR(f) ONE(f)
static inline V v_pow(V a, V b) { return own_pow(a, b); }
static inline int lanes_differ(V a, V b) { return a != b ? 1 : 0; }
static inline double lane(V a, int i) { (void)i; return a; }
static inline V with_lane(V a, int i, double x) { (void)a; (void)i; return x; }

#else

typedef double V __attribute__((ext_vector_type(W)));
typedef int64_t Mask __attribute__((ext_vector_type(W)));

static inline V of_bits(Mask m) { V v; memcpy(&v, &m, sizeof v); return v; }
static inline Mask bits_of(V v) { Mask m; memcpy(&m, &v, sizeof m); return m; }
static inline V choose(Mask c, V a, V b) {
    return of_bits((c & bits_of(a)) | (~c & bits_of(b)));
}

#define truth(condition) of_bits((condition) & (int64_t)0x3ff0000000000000)
static inline V given(V c, V x) { return of_bits((c != 0) & bits_of(x)); }
static inline V negated(V a) { return truth(a == 0); }
static inline V both(V a, V b) { return truth((a != 0) & (b != 0)); }
static inline V either(V a, V b) { return truth((a != 0) | (b != 0)); }
static inline V v_fabs(V a) { return __builtin_elementwise_abs(a); }
static inline V v_floor(V a) { return __builtin_elementwise_floor(a); }
static inline V v_ceil(V a) { return __builtin_elementwise_ceil(a); }
static inline V v_sqrt(V a) { return __builtin_elementwise_sqrt(a); }
static inline V v_sign(V a) { return choose(a < 0, (V)(-1.0), choose(a > 0, (V)1.0, a)); }
static inline V v_fmin(V a, V b) { return choose((a < b) | (a != a), a, b); }
static inline V v_fmax(V a, V b) { return choose((a > b) | (a != a), a, b); }

#define EACH_LANE(out, f, in)                                                  \
    _Pragma("clang loop vectorize(enable) interleave(disable)")                \
    for (int i = 0; i < W; i++)                                                \
        out[i] = f(in[i]);
#define ONE(f)                                                                 \
    static inline V v_##f(V a) {                                               \
        double in[W], out[W];                                                  \
        memcpy(in, &a, sizeof a);                                              \
        EACH_LANE(out, own_##f, in)                                            \
        memcpy(&a, out, sizeof a);                                             \
        return a;                                                              \
    }
/* A function whose argument is reduced without integers up to OWN_NEAR. */
#define NEAR(f)                                                                \
    static inline V v_##f(V a) {                                               \
        double in[W], out[W];                                                  \
        int near = 1;                                                          \
        memcpy(in, &a, sizeof a);                                              \
        for (int i = 0; i < W; i++)                                            \
            near &= fabs(in[i]) <= OWN_NEAR;                                   \
        if (near) {                                                            \
            EACH_LANE(out, own_##f##_near, in)                                 \
        } else {                                                               \
            for (int i = 0; i < W; i++)                                        \
                out[i] = own_##f(in[i]);                                       \
        }                                                                      \
        memcpy(&a, out, sizeof a);                                             \
        return a;                                                              \
    }
static inline V v_pow(V a, V b) {
    for (int i = 0; i < W; i++)
        a[i] = own_pow(a[i], b[i]);
    return a;
}
/* How many lanes differ. */
static inline int lanes_differ(V a, V b) {
    Mask unlike = a != b;
    int n = 0;
    if (!__builtin_reduce_or(unlike))
        return 0;
    for (int i = 0; i < W; i++)
        n += unlike[i] != 0;
    return n;
}
static inline double lane(V a, int i) { return a[i]; }
static inline V with_lane(V a, int i, double x) { a[i] = x; return a; }

#endif

/* A number computed by here and used from here on: the compiler keeps the order of
   these; vectors have enough to do at once. */
#if W == 1 && defined(__x86_64__)
#define HERE(x) __asm__ volatile("" : "+x"(x))
#elif W == 1 && defined(__aarch64__)
#define HERE(x) __asm__ volatile("" : "+w"(x))
#else
#define HERE(x) (void)(x)
#endif

ONE(exp)
ONE(expm1)
ONE(log)
ONE(tanh)
ONE(sinh)
ONE(cosh)
ONE(tan)
ONE(atan)
NEAR(sin)
NEAR(cos)

/* Zero in the lanes where all is finite, NaN in the others. */
static inline V wrong(const V *values, size_t n) {
    V sum = (V)0.0;
    for (size_t i = 0; i < n; i++)
        sum += values[i] - values[i];
    return sum;
}

#endif
