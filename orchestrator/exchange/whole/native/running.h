/* The loop of a composition without Python; included behind its tables. */

size_t whole_size(void) {
    return (sizeof(Memory) + sizeof(double) - 1) / sizeof(double);
}

#if N_FOREIGN
size_t whole_loaded(void) {
    return N_FOREIGN * sizeof(Loaded);
}

void whole_free(void *loaded) {
    for (int i = 0; i < N_FOREIGN; i++)
        foreign_free((Loaded *)loaded + i, foreign[i].major);
}

unsigned whole_foreign(void) {
    return N_FOREIGN;
}

int whole_save(const void *loaded, unsigned i, unsigned char **bytes, size_t *size) {
    return foreign_save(foreign + i, (const Loaded *)loaded + i, bytes, size);
}

int whole_load(void *loaded, unsigned i, const unsigned char *bytes, size_t size) {
    return foreign_load(foreign + i, (Loaded *)loaded + i, bytes, size);
}
#else
size_t whole_loaded(void) {
    return 0;
}

void whole_free(void *loaded) {
    (void)loaded;
}
#endif

static double *place_of(Memory *m, const Outer *v) {
    return (double *)((char *)m + v->place);
}

static void take(Memory *m, const double *values, unsigned from, unsigned to) {
    for (unsigned i = from; i < to; i++) {
        const Outer *v = outside + i;
        *place_of(m, v) = v->converts ? v->gain * values[i] + v->offset : values[i];
    }
}

/* Carries out a half of an instant. */
static int half(Memory *m, const double *values, int64_t k, int32_t program) {
    take(m, values, FIRST_INPUT, FIRST_OUTPUT);
    return carry_out_program(&m->e, program, k, seconds_of(&m->e, k));
}

static int go_to(Memory *m, const double *values, int64_t tick, int last) {
    while (1) {
        const Stretch *here = stretches + m->stretch;
        int64_t k = here->first + m->repeat * here->length + here->offsets[m->entry];
        if (k > tick)
            return 1;
        if (!m->open && !half(m, values, k, here->first_halves[m->entry]))
            return 0;
        m->open = last == HALF && k == tick;
        if (m->open)
            return 1;
        if (!half(m, values, k, here->second_halves[m->entry]))
            return 0;
        if (++m->entry < here->n)
            continue;
        m->entry = 0;
        if (m->stretch + 1 == N_STRETCHES) /* for ever */
            m->repeat++;
        else if (++m->repeat == here->repeats) {
            m->repeat = 0;
            m->stretch++;
        }
    }
}

int whole_start(double *memory, const double *values, void *loaded) {
    Memory *m = (Memory *)(void *)memory;
    int done;
    memset(m, 0, sizeof *m);
    bind_memory(m, loaded);
    start_values(m);
    take(m, values, 0, FIRST_OUTPUT);
    take(m, values, FIRST_STATE, FIRST_STATE + N_STATES);
    done = engine_start(&m->e);
    unbind_memory(m);
    return done;
}

int whole_run(double *memory, const double *values, void *loaded, int64_t tick, int last) {
    Memory *m = (Memory *)(void *)memory;
    int done;
    bind_memory(m, loaded);
    done = !m->e.failure && go_to(m, values, tick, last);
    unbind_memory(m);
    return done;
}

int whole_finish(double *memory, const double *values, void *loaded) {
    Memory *m = (Memory *)(void *)memory;
    const Stretch *here = stretches + m->stretch;
    int64_t k = here->first + m->repeat * here->length + here->offsets[m->entry];
    return !m->open || whole_run(memory, values, loaded, k, WHOLE);
}

void whole_read(const double *memory, double *values, int states) {
    Memory *m = (Memory *)(void *)memory;
    unsigned end = states ? FIRST_STATE + N_STATES : FIRST_STATE;
    for (unsigned i = FIRST_OUTPUT; i < end; i++) {
        const Outer *v = outside + i;
        double held = *place_of(m, v);
        values[i] = v->converts ? v->gain * held + v->offset : held;
    }
}

int whole_failure(const double *memory, unsigned *place, double *t) {
    const Engine *e = &((const Memory *)(const void *)memory)->e;
    *t = seconds_of(e, e->instant);
    *place = FIRST_STATE + N_STATES +
             (e->failure == UNSETTLED ? N_PARTS : (unsigned)e->part);
    return e->failure == FINE        ? WHOLE_FINE
           : e->failure == LINE_FULL ? WHOLE_LINE_FULL
                                     : WHOLE_NOT_FINITE;
}

int whole_fits(unsigned i, double tau) {
    double wanted = fmin(ceil(tau / delayed[i].h_max * SHORTEST) + 2, LONGEST_LINE);
    return wanted <= delayed[i].room;
}
