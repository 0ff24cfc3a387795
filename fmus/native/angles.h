/* sin, cos and tan of elementary.h: at most 1 ulp for every finite argument. */
#ifndef ANGLES_H
#define ANGLES_H

#include "sums.h"

#define OWN_NEAR 1.6e6 /* the argument's number of quarter turns stays below 2^20 */

/* x - n pi/2 for |x| <= OWN_NEAR; returns n + OWN_MAGIC. */
static inline double own_reduce_near(double x, OwnSum *r) {
    double shifted = x * 0.6366197723675814 + OWN_MAGIC, n = shifted - OWN_MAGIC;
    OwnSum a = own_add(x - n * 1.5707963267341256, -(n * 6.077100506303966e-11));
    OwnSum b = own_add(a.hi, -(n * 2.0222662487111665e-21));
    *r = own_fast_add(b.hi, (a.lo + b.lo) - n * 8.4784276603689e-32);
    return shifted;
}

/* The same for any finite x, by integers (Payne and Hanek). */
static inline double own_reduce_far(double x, OwnSum *r) {
    static const uint32_t two_over_pi[] = { /* its bits after the point */
        0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041,
        0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c,
        0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41,
        0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f,
        0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
        0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08,
        0x56033046, 0xfc7b6bab, 0xf0cfbc20, 0x9af4361d};
    uint64_t bits = own_bits(x), mantissa;
    int exponent = (int)(bits >> 52 & 2047) - 1075, first, i;
    uint32_t factor[2], product[8] = {0};
    if (exponent > 971) { /* infinite or NaN */
        *r = own_sum(NAN, 0.0);
        return OWN_MAGIC;
    }
    mantissa = (bits & (((uint64_t)1 << 52) - 1)) | (uint64_t)1 << 52;
    factor[0] = (uint32_t)mantissa;
    factor[1] = (uint32_t)(mantissa >> 32);
    /* Bits of 2/pi before first give multiples of 4.  Six words follow. */
    first = exponent > 2 ? exponent - 2 : 0;
    for (i = 0; i < 6; i++) {
        int at = (first >> 5) + 5 - i, shift = first & 31, j;
        uint64_t pair = (uint64_t)two_over_pi[at] << 32 | two_over_pi[at + 1];
        uint64_t word = (pair << shift) >> 32, carry = 0;
        for (j = 0; j < 2; j++) {
            uint64_t t = word * factor[j] + product[i + j] + carry;
            product[i + j] = (uint32_t)t;
            carry = t >> 32;
        }
        product[i + 2] = (uint32_t)carry;
    }
    {
        /* product 2^(exponent - first - 192): the point is above bit place */
        int place = 192 + first - exponent, k;
        uint64_t part[3];
        double sign = x < 0.0 ? -1.0 : 1.0, quarter;
        for (k = 0; k < 3; k++) { /* 48 bits each, from two above the point on */
            int low = place + 2 - 48 * (k + 1);
            uint64_t lower = product[low >> 5], upper = 0;
            if ((low >> 5) + 1 < 8)
                upper = product[(low >> 5) + 1];
            part[k] = (lower | upper << 32) >> (low & 31);
            if ((low & 31) > 16 && (low >> 5) + 2 < 8)
                part[k] |= (uint64_t)product[(low >> 5) + 2] << (64 - (low & 31));
            part[k] &= ((uint64_t)1 << 48) - 1;
        }
        quarter = (double)(part[0] >> 46);
        part[0] &= ((uint64_t)1 << 46) - 1;
        {
            double a = (double)part[0] / 70368744177664.0; /* 2^46 */
            double b = (double)part[1] / 19807040628566084398385987584.0;
            double c = (double)part[2] / 5575186299632655785383929568162090376495104.0;
            OwnSum turn, half_pi = {1.5707963267948966, 6.123233995736766e-17};
            if (a >= 0.5) {
                a -= 1.0;
                quarter += 1.0;
            }
            turn = own_add(a, b);
            turn = own_product(own_fast_add(turn.hi, turn.lo + c), half_pi);
            *r = own_sum(sign * turn.hi, sign * turn.lo);
        }
        return sign * quarter + OWN_MAGIC;
    }
}

static inline double own_sin_of(OwnSum r) {
    double x = r.hi, z = x * x, w = z * z;
    double p = (8.33333333332248946124e-03 - z * 1.98412698298579493134e-04) +
               w * ((2.75573137070700676789e-06 - z * 2.50507602534068634195e-08) +
                    w * 1.58969099521155010221e-10);
    double cubic = x * z * (z * p - 1.66666666666666324348e-01);
    return x + (cubic + r.lo * (1.0 - 0.5 * z));
}

static inline double own_cos_of(OwnSum r) {
    double x = r.hi, z = x * x, w = z * z, half = 0.5 * z, one = 1.0 - half;
    double p = (4.16666666666666019037e-02 - z * 1.38888888888741095749e-03) +
               w * ((2.48015872894767294178e-05 - z * 2.75573143513906633035e-07) +
                    w * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11));
    return one + (((1.0 - one) - half) + (w * p - x * r.lo));
}

/* sin(r + n pi/2), n in the lowest bits of shifted. */
static inline double own_wave(double shifted, OwnSum r) {
    uint64_t n = own_bits(shifted);
    double s = own_sin_of(r), c = own_cos_of(r), y = n & 1 ? c : s;
    return own_double(own_bits(y) ^ (n & 2) << 62);
}

static inline double own_ratio(double shifted, OwnSum r) {
    uint64_t n = own_bits(shifted);
    OwnSum z = own_multiply(r.hi, r.hi);
    double w = z.hi * z.hi, s = own_sin_of(r), c = own_cos_of(r), half = 0.5 * z.hi;
    /* the same sums with what their last addition rounds away */
    double one = 1.0 - half;
    double p = (4.16666666666666019037e-02 - z.hi * 1.38888888888741095749e-03) +
               w * ((2.48015872894767294178e-05 - z.hi * 2.75573143513906633035e-07) +
                    w * (2.08757232129817482790e-09 -
                         z.hi * 1.13596475577881948265e-11));
    double c_lo = (one - c) + (((1.0 - one) - half) +
                               (w * p - (r.hi * r.lo + 0.5 * z.lo)));
    double q = (8.33333333332248946124e-03 - z.hi * 1.98412698298579493134e-04) +
               w * ((2.75573137070700676789e-06 - z.hi * 2.50507602534068634195e-08) +
                    w * 1.58969099521155010221e-10);
    double cubic = r.hi * z.hi * (z.hi * q - 1.66666666666666324348e-01);
    double s_lo = (r.hi - s) + (cubic + r.lo * (1.0 - half));
    OwnSum sine = own_sum(s, s_lo), cosine = own_sum(c, c_lo);
    OwnSum top = n & 1 ? own_sum(-c, -c_lo) : sine, under = n & 1 ? sine : cosine;
    double y = own_divide(top, under).hi;
    return n & 1 || fabs(r.hi) > 1e-9 ? y : r.hi;
}

static inline double own_sin_near(double x) {
    OwnSum r;
    double n = own_reduce_near(x, &r), y = own_wave(n, r);
    return x == 0.0 ? x : y;
}

static inline double own_cos_near(double x) {
    OwnSum r;
    double n = own_reduce_near(x, &r);
    return own_wave(n + 1.0, r);
}

static inline double own_tan_near(double x) {
    OwnSum r;
    double n = own_reduce_near(x, &r), y = own_ratio(n, r);
    return x == 0.0 ? x : y;
}

static inline double own_sin(double x) {
    OwnSum r;
    if (fabs(x) <= OWN_NEAR)
        return own_sin_near(x);
    return own_wave(own_reduce_far(x, &r), r);
}

static inline double own_cos(double x) {
    OwnSum r;
    if (fabs(x) <= OWN_NEAR)
        return own_cos_near(x);
    return own_wave(own_reduce_far(x, &r) + 1.0, r);
}

static inline double own_tan(double x) {
    OwnSum r;
    if (fabs(x) <= OWN_NEAR)
        return own_tan_near(x);
    return own_ratio(own_reduce_far(x, &r), r);
}

#endif
