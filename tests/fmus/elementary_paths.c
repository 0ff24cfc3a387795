/* Every way through the elementary functions: on bits drawn at random, numbers of every
   size and the special ones.  What they give is tested elsewhere (test_elementary.py);
   here nothing may be undefined, and no branch unused. */
#include "elementary.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static uint64_t seed = 1;
static volatile double sink;

static uint64_t drawn(void) { /* splitmix64 */
    uint64_t z = (seed += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double number(void) {
    static const double special[] = {0.0, -0.0, 1.0, -1.0, INFINITY, -INFINITY, NAN, 2.0,
                                     0.5, 1e-18, 1e-9, 1e-310, 800.0, 3.0, -3.0, 1e300,
                                     1.0 + 0x1p-52, 1.0 - 0x1p-53, -1e300, 1.7e308};
    uint64_t bits = drawn();
    double x;
    switch (drawn() % 4) {
    case 0: return special[bits % (sizeof special / sizeof *special)];
    case 1: return (double)(int64_t)(bits % 2001) / 16.0 - 62.0;
    case 2: return ldexp((double)(bits >> 11), (int)(bits % 200) - 150);
    default: memcpy(&x, &bits, sizeof x); return x;
    }
}

int main(void) {
    for (int i = 0; i < 200000; i++) {
        double x = number(), y = number();
        sink = own_exp(x), sink = own_expm1(x), sink = own_log(x), sink = own_tanh(x);
        sink = own_sinh(x), sink = own_cosh(x), sink = own_tan(x), sink = own_atan(x);
        sink = own_sin(x), sink = own_cos(x), sink = own_pow(x, y);
        sink = own_fmin(x, y), sink = own_fmax(x, y);
    }
    printf("every way\n");
    return 0;
}
