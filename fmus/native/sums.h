/* Bits of a double, and sums of two doubles that keep what rounding takes.

   The order of operations is the definition: nothing may be contracted. */
#ifndef SUMS_H
#define SUMS_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

#define OWN_MAGIC 6755399441055744.0      /* 1.5 * 2^52: adding it rounds */

/* An unevaluated sum: hi carries the value, lo what rounding took from it. */
typedef struct {
    double hi, lo;
} OwnSum;

static inline uint64_t own_bits(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double own_double(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* 2^n for an integer n in -1022..1023. */
static inline double own_power(double n) {
    return own_double((own_bits(n + OWN_MAGIC) + 1023) << 52);
}

static inline double own_round(double x) {
    return (x + OWN_MAGIC) - OWN_MAGIC;
}

static inline double own_with_sign(double magnitude, double x) {
    const uint64_t sign = (uint64_t)1 << 63;
    return own_double((own_bits(magnitude) & ~sign) | (own_bits(x) & sign));
}

static inline OwnSum own_sum(double hi, double lo) {
    OwnSum sum;
    sum.hi = hi;
    sum.lo = lo;
    return sum;
}

/* a + b exactly, for |a| >= |b| or a = 0. */
static inline OwnSum own_fast_add(double a, double b) {
    double s = a + b;
    return own_sum(s, (a - s) + b);
}

/* a + b exactly (Knuth). */
static inline OwnSum own_add(double a, double b) {
    double s = a + b, t = s - a;
    return own_sum(s, (a - (s - t)) + (b - t));
}

/* a b exactly (Dekker), for |a|, |b| < 2^996. */
static inline OwnSum own_multiply(double a, double b) {
    double s = 134217729.0 * a, t = 134217729.0 * b;
    double a1 = s - (s - a), a2 = a - a1, b1 = t - (t - b), b2 = b - b1, p = a * b;
    return own_sum(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2);
}

/* a / b, good to about 2^-100. */
static inline OwnSum own_divide(OwnSum a, OwnSum b) {
    double inverse = 1.0 / b.hi, q = a.hi * inverse;
    OwnSum p = own_multiply(q, b.hi);
    double rest = ((a.hi - p.hi) - p.lo) + (a.lo - q * b.lo);
    return own_fast_add(q, rest * inverse);
}

static inline OwnSum own_product(OwnSum a, OwnSum b) {
    OwnSum p = own_multiply(a.hi, b.hi);
    return own_fast_add(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline OwnSum own_total(OwnSum a, OwnSum b) {
    OwnSum s = own_add(a.hi, b.hi);
    return own_fast_add(s.hi, s.lo + (a.lo + b.lo));
}

/* x between the bounds; NaN stays. */
static inline double own_clamp(double x, double low, double high) {
    x = x < low ? low : x;
    return x > high ? high : x;
}

static inline double own_scaled(double m, double n) {
    double half = own_round(0.5 * n);
    return m * own_power(half) * own_power(n - half);
}

#endif
