/* Elementary functions with the same bits everywhere.

   C libraries differ in the last bit of exp, sin or tanh, and some choose by
   processor.  These use additions, multiplications, divisions and the bits of a
   double alone, in one order, so that any compiler that contracts nothing gives
   the same results, for one number or in a vector of any width.  At most 1 ulp
   from the true value (docs/decisions/0012-elementary-functions.md).

   Loops over own_exp, own_expm1, own_log, own_tanh, own_cosh, own_fmin and
   own_fmax become vector code as they stand, with the same bits; so do
   own_sin_near and own_cos_near, which are own_sin and own_cos for |x| up to
   OWN_NEAR (beyond it the argument is reduced by integers). */
#ifndef ELEMENTARY_H
#define ELEMENTARY_H

#include "angles.h"
#include "sums.h"

#define OWN_LN2_HI 0.6931471805601177     /* 40 bits */
#define OWN_LN2_LO (-1.7239444525614835e-13)

/* exp(x) - 1 = r + q, x = n ln 2 + r; |r| <= 0.3466, q of order r^2 / 2. */
static inline double own_exponent(double x) {
    return own_round(x * 1.4426950408889634);
}

static inline OwnSum own_exp_parts(double x, double x_lo, double n) {
    double hi = x - n * OWN_LN2_HI, lo = n * OWN_LN2_LO - x_lo, r = hi - lo;
    double c = (hi - r) - lo, z = r * r, z2 = z * z;
    double p0 = 0.1666666666666667 + r * 0.04166666666666667;
    double p1 = 0.008333333333326136 + r * 0.0013888888888883748;
    double p2 = 0.00019841269874820627 + r * 2.4801587325547743e-05;
    double p3 = 2.7557255400206422e-06 + r * 2.75572736431103e-07;
    double p4 = 2.5105217004720745e-08 + r * 2.0914686968086876e-09;
    double p = (p0 + z * p1) + z2 * ((p2 + z * p3) + z2 * p4);
    return own_sum(r, 0.5 * z + ((z * r) * p + (c + c * r)));
}

/* The smaller and the larger; NaN if one is, as in NumPy. */
static inline double own_fmin(double a, double b) {
    return a < b || a != a ? a : b;
}

static inline double own_fmax(double a, double b) {
    return a > b || a != a ? a : b;
}

static inline double own_exp(double x) {
    x = own_clamp(x, -746.0, 710.0);
    double n = own_exponent(x);
    OwnSum e = own_exp_parts(x, 0.0, n), s = own_fast_add(1.0, e.hi);
    return own_scaled(s.hi + (s.lo + e.lo), n);
}

/* (exp(x) - 1) / 2^n for x in -45..710; n below 65 loses nothing. */
static inline OwnSum own_expm1_parts(double x, double n) {
    OwnSum e = own_exp_parts(x, 0.0, n);
    OwnSum one = own_add(1.0, -own_power(-(n > 64.0 ? 64.0 : n)));
    OwnSum s = own_fast_add(one.hi, e.hi);
    return own_fast_add(s.hi, s.lo + (one.lo + e.lo));
}

static inline double own_expm1(double x) {
    double clamped = own_clamp(x, -45.0, 710.0), n = own_exponent(clamped);
    double y = own_scaled(own_expm1_parts(clamped, n).hi, n);
    return fabs(x) < 1e-17 ? x : y;
}

/* |x| for x below 22, where exp(2 x) and exp(x) are far from overflow. */
static inline OwnSum own_expm1_sum(double x) {
    double n = own_exponent(x), scale = own_power(n);
    OwnSum e = own_expm1_parts(x, n);
    return own_sum(e.hi * scale, e.lo * scale);
}

static inline double own_tanh(double x) {
    double a = fabs(x), large = a > 22.0 ? 22.0 : a;
    OwnSum e = own_expm1_sum(2.0 * large), d = own_add(2.0, e.hi);
    OwnSum q = own_divide(e, own_sum(d.hi, d.lo + e.lo));
    return own_with_sign(a < 1e-8 ? a : q.hi, x);
}

/* atan of the nearest of 0, 1/2, 1, 3/2 and infinity, and fdlibm's polynomial of
   what is between. */
static inline double own_atan(double x) {
    double a = fabs(x), t, hi, lo, z, w, even, odd;
    int least = a < 0.4375, half = a < 0.6875, one = a < 1.1875, more = a < 2.4375;
    double top = least ? a : half ? 2.0 * a - 1.0 : one ? a - 1.0 : more ? a - 1.5 : -1.0;
    double down = least ? 1.0 : half ? 2.0 + a : one ? a + 1.0 : more ? 1.0 + 1.5 * a : a;
    t = top / down;
    hi = least ? 0.0 : half ? 0.4636476090008061 : one ? 0.7853981633974483
                     : more ? 0.982793723247329 : 1.5707963267948966;
    lo = least ? 0.0 : half ? 2.2698777452961687e-17 : one ? 3.061616997868383e-17
                     : more ? 1.3903311031230998e-17 : 6.123233995736766e-17;
    z = t * t;
    w = z * z;
    even = z * (0.3333333333333293 +
                w * (0.14285714272503466 +
                     w * (0.09090887133436507 +
                          w * (0.06661073137387531 +
                               w * (0.049768779946159324 + w * 0.016285820115365782)))));
    odd = w * (-0.19999999999876483 +
               w * (-0.11111110405462356 +
                    w * (-0.0769187620504483 +
                         w * (-0.058335701337905735 + w * -0.036531572744216916))));
    return own_with_sign(hi - ((t * (even + odd) - lo) - t), x);
}

static inline double own_sinh(double x) {
    double a = fabs(x), small = a > 22.0 ? 22.0 : a;
    OwnSum e = own_expm1_sum(small), d = own_add(1.0, e.hi);
    OwnSum q = own_divide(e, own_sum(d.hi, d.lo + e.lo));
    double near = 0.5 * own_total(e, q).hi;
    double clamped = own_clamp(a, 0.0, 711.0), n = own_exponent(clamped);
    OwnSum f = own_exp_parts(clamped, 0.0, n), s = own_fast_add(1.0, f.hi);
    double far = own_scaled(s.hi + (s.lo + f.lo), n - 1.0);
    return own_with_sign(a < 1e-8 ? a : a > 22.0 ? far : near, x);
}

static inline double own_cosh(double x) {
    double a = own_clamp(fabs(x), 0.0, 711.0), n = own_exponent(a);
    OwnSum e = own_exp_parts(a, 0.0, n), s = own_fast_add(1.0, e.hi);
    OwnSum m = own_fast_add(s.hi, s.lo + e.lo);
    double w = own_power(-2.0 * (n > 50.0 ? 50.0 : n));
    OwnSum total = own_add(m.hi, w / m.hi);
    double lo = total.lo + (m.lo - w * m.lo);
    return own_scaled(total.hi + lo, n - 1.0);
}

/* x = 2^n (1 + f) of a positive x, 1 + f between sqrt(1/2) and sqrt(2). */
static inline double own_mantissa(double x, double *n) {
    double tiny = x < 2.2250738585072014e-308 ? 54.0 : 0.0;
    uint64_t bits = own_bits(x * (tiny > 0.0 ? 18014398509481984.0 : 1.0));
    uint64_t shifted = bits - ((uint64_t)0x3fe6a09e << 32) + ((uint64_t)1023 << 52);
    uint64_t exponent = shifted >> 52;
    /* 2^52 + exponent, written by its bits: every vector unit can do that */
    *n = own_double(exponent | (uint64_t)0x433 << 52) - 4503599627371519.0 - tiny;
    return own_double(bits - ((exponent - 1023) << 52));
}

static inline double own_log(double x) {
    double n, m = own_mantissa(x, &n), f = m - 1.0, s = f / (2.0 + f), z = s * s;
    double w = z * z, half = 0.5 * f * f;
    double odd = w * (0.3999999999940941908 +
                      w * (0.2222219843214978396 + w * 0.1531383769920937332));
    double even = z * (0.6666666666666735130 +
                       w * (0.2857142874366239149 +
                            w * (0.1818357216161805012 + w * 0.1479819860511658591)));
    /* log(1 + f) = f - half + s (half + odd + even); f - half exactly */
    OwnSum lead = own_add(n * OWN_LN2_HI, f), more = own_fast_add(lead.hi, -half);
    double rest = s * (half + (odd + even)) + n * OWN_LN2_LO;
    double y = more.hi + ((lead.lo + more.lo) + rest);
    y = x > 0.0 ? y : x < 0.0 ? NAN : -INFINITY;
    return x != x || x > 1.7976931348623157e308 ? x : y;
}

/* log(x) of a positive finite x, good to 2^-68 of itself. */
static inline OwnSum own_log_sum(double x) {
    double n, m = own_mantissa(x, &n);
    OwnSum f = own_sum(m - 1.0, 0.0), d = own_add(1.0, m), s = own_divide(f, d);
    OwnSum z = own_product(s, s), third = {0.6666666666666666, 3.700743415417188e-17};
    OwnSum fifth = {0.4, -2.2204460492503132e-17}, sum;
    double g = 0.285714285714286 +
               z.hi * (0.22222222222140214 +
                       z.hi * (0.18181818226283877 +
                               z.hi * (0.15384606355892447 +
                                       z.hi * (0.13334204464506105 +
                                               z.hi * (0.11721731747176209 +
                                                       z.hi * 0.11567351729591345)))));
    sum = own_total(fifth, own_sum(z.hi * g, 0.0));
    sum = own_product(own_total(third, own_product(z, sum)), own_product(z, s));
    sum = own_total(own_sum(2.0 * s.hi, 2.0 * s.lo), sum);
    sum = own_total(own_sum(n * -1.7239444525610826e-13, n * -4.00865610552017e-26), sum);
    return own_total(own_sum(n * 0.6931471805601177, 0.0), sum);
}

static inline double own_pow(double x, double y) {
    double a = fabs(x), sign = 1.0, n;
    int whole = floor(y) == y, odd = whole && 2.0 * floor(0.5 * y) != y;
    OwnSum l, p, e, s;
    if (y == 0.0 || x == 1.0)
        return 1.0;
    if (x != x || y != y)
        return x + y;
    if (x < 0.0 && !whole && a < INFINITY)
        return NAN;
    if (odd)
        sign = own_with_sign(1.0, x);
    if (fabs(y) > 1.7976931348623157e308)
        return a == 1.0 ? 1.0 : (a > 1.0) == (y > 0.0) ? INFINITY : 0.0;
    if (a == 0.0 || a > 1.7976931348623157e308)
        return sign * ((a > 0.0) == (y > 0.0) ? INFINITY : 0.0);
    l = own_log_sum(a);
    if (!(fabs(y * l.hi) < 800.0)) /* far out of range; no splitting of y then */
        return sign * ((y > 0.0) == (l.hi > 0.0) ? INFINITY : 0.0);
    if (fabs(y) > 1e290) /* of an x so near to 1 that only the scale counts */
        p = own_sum(y * l.hi, y * l.lo);
    else
        p = own_product(l, own_sum(y, 0.0));
    p.hi = own_clamp(p.hi, -746.0, 711.0);
    n = own_exponent(p.hi);
    e = own_exp_parts(p.hi, p.lo, n);
    s = own_fast_add(1.0, e.hi);
    return sign * own_scaled(s.hi + (s.lo + e.lo), n);
}

#endif
