/* The functions of correct.c that only FMI 3 has. */
EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *resources, _Bool visible,
                                         _Bool logging, _Bool events, _Bool early,
                                         const unsigned *vr, size_t n,
                                         void *environment, Logger *logger,
                                         void *update) {
    return create(name, token, logging ? logger : NULL, environment);
}

EXPORT int ENTER(Instance *s, _Bool tolerant, double tolerance, double from,
                 _Bool stops, double stop) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "initialisation now");
    if (KIND == 4 && !stops)
        return refuse(s, "a stop time is needed");
    s->t = from;
    s->phase = INITIALISING;
    return OK;
}

EXPORT int fmi3EnterConfigurationMode(Instance *s) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "configuration now");
    s->phase = CONFIGURING;
    return OK;
}

EXPORT int fmi3ExitConfigurationMode(Instance *s) {
    if (!may(s, CONFIGURING))
        return refuse(s, "no configuration to leave");
    s->phase = INSTANTIATED;
    return OK;
}

EXPORT int fmi3Reset(Instance *s) {
    start(s);
    return OK;
}

EXPORT int fmi3GetFloat64(Instance *s, const unsigned *vr, size_t n, double *v,
                          size_t left) {
    may(s, ~FAILED);
    for (size_t i = 0; i < n; i++) {
        const size_t size = vr[i] < 2 ? 1 : s->n;
        if (vr[i] > 3 || size > left)
            return refuse(s, "no such variable, or another size");
        for (size_t k = 0; k < size; k++)
            *v++ = vr[i] == 0   ? s->u
                   : vr[i] == 1 ? s->y
                   : vr[i] == 2 ? s->a[k]
                                : s->a[k] * s->u;
        left -= size;
    }
    return left ? refuse(s, "more values than that") : OK;
}

EXPORT int fmi3SetFloat64(Instance *s, const unsigned *vr, size_t n, const double *v,
                          size_t left) {
    for (size_t i = 0; i < n; i++) {
        const size_t size = vr[i] < 2 ? 1 : s->n;
        if (!may(s, INSTANTIATED | INITIALISING | (vr[i] == 0 ? STEPPING : 0)) ||
            (vr[i] != 0 && vr[i] != 2) || size > left)
            return refuse(s, "it cannot be set now, or not so many values");
        for (size_t k = 0; k < size; k++, v++)
            if (!isfinite(*v))
                return refuse(s, "it cannot be set to that");
            else
                *(vr[i] == 0 ? &s->u : s->a + k) = *v;
        left -= size;
    }
    return left ? refuse(s, "more values than that") : OK;
}

EXPORT int fmi3GetUInt64(Instance *s, const unsigned *vr, size_t n, uint64_t *v,
                         size_t left) {
    may(s, ~FAILED);
    if (n != 1 || left != 1 || *vr != 4)
        return refuse(s, "no such variable");
    *v = s->n;
    return OK;
}

EXPORT int fmi3SetUInt64(Instance *s, const unsigned *vr, size_t n, const uint64_t *v,
                         size_t left) {
    if (!may(s, CONFIGURING) || n != 1 || left != 1 || *vr != 4 || !*v || *v > LONGEST)
        return refuse(s, "structural parameters are set in configuration mode");
    s->n = *v;
    return OK;
}

EXPORT int fmi3DoStep(Instance *s, double t, double h, _Bool no_set, _Bool *event,
                      _Bool *ends, _Bool *early, double *reached) {
    int status = advance(s, t, h);
    *event = *early = 0;
    *ends = status == DISCARD;
    *reached = s->t;
    return status == DISCARD ? OK : status;
}

#define REFUSED(name)                                                              \
    EXPORT int name(Instance *s) {                                                 \
        may(s, ~FAILED);                                                           \
        return refuse(s, #name " is not supported");                               \
    }
REFUSED(fmi3GetDirectionalDerivative)
REFUSED(fmi3GetAdjointDerivative)
REFUSED(fmi3GetOutputDerivatives)
REFUSED(fmi3GetFMUState)
