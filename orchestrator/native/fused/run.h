/* The loop over instants; included behind the programs, which it dispatches. */

/* Instants from..from + count - 1 of a stretch, counted over all its repetitions;
   returns how many were finished, as kernel_run. */
EXPORTED int64_t engine_run(Engine *e, int64_t first, int64_t length,
                            const int64_t *offsets, const int32_t *programs, int64_t n,
                            int64_t from, int64_t count) {
    int64_t i = from % n, begin = first + from / n * length;
    e->failure = FINE;
#ifdef KERNEL
    if (e->kernel)
        K->full = K->failure = 0;
#endif
    for (int64_t done = 0; done < count; done++) {
        int64_t k = begin + offsets[i];
        if (!carry_out_program(e, programs[i], k, seconds_of(e, k)))
            return done;
#ifdef KERNEL
        if (e->kernel && K->ending) {
            K->failure = ENDED;
            K->part = K->ending - 1;
        }
        if (e->kernel && (K->full || K->ending))
            return done + 1;
#endif
        if (++i == n) {
            i = 0;
            begin += length;
        }
    }
    return count;
}

EXPORTED int engine_lanes(void) {
    return W;
}

EXPORTED size_t engine_size(void) {
    return sizeof(Engine);
}
