/* Operations on FMUs that are not inlined: the kernel's, one double at a time. */
#define K ((Kernel *)e->kernel)

static inline int called(Engine *e, const Op *op, int64_t k, double t) {
    const Now now = {k, -1, t, 0};
    return carry_out(K, op, &now);
}
