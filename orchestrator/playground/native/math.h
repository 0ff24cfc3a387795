/* What the loops use of the C library, where there is none: instructions of
   WebAssembly, and fmax of the compiler's own library. */
#ifndef PLAYED_MATH_H
#define PLAYED_MATH_H

#define INFINITY __builtin_inf()
#define NAN __builtin_nan("")
#define fabs __builtin_fabs
#define floor __builtin_floor
#define ceil __builtin_ceil
#define sqrt __builtin_sqrt
#define fmax __builtin_fmax

#endif
