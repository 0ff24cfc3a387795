/* The functions of correct.c that only FMI 2 has. */
typedef struct {
    Logger *logger;
    void *allocate, *free, *finished, *environment;
} Callbacks;

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *resources, const Callbacks *callbacks,
                             int visible, int logging) {
    return create(name, guid, logging ? callbacks->logger : NULL,
                  callbacks->environment);
}

EXPORT int fmi2SetupExperiment(Instance *s, int tolerant, double tolerance,
                               double from, int stops, double stop) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "an experiment now");
    if (KIND == 4 && !stops)
        return refuse(s, "a stop time is needed");
    s->t = from;
    return OK;
}

EXPORT int ENTER(Instance *s) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "initialisation now");
    s->phase = INITIALISING;
    return OK;
}

EXPORT int fmi2Reset(Instance *s) {
    start(s);
    return OK;
}

static double *place(Instance *s, unsigned vr) {
    if (vr >= 100 && vr < 100 + MORE)
        return s->more + vr - 100;
    return vr == 0 ? &s->u : vr == 1 ? &s->y : vr == 2 ? s->a : NULL;
}

EXPORT int fmi2GetReal(Instance *s, const unsigned *vr, size_t n, double *v) {
    may(s, ~FAILED);
    for (size_t i = 0; i < n; i++)
        if (!place(s, vr[i]))
            return refuse(s, "no such variable");
        else
            v[i] = *place(s, vr[i]);
    return OK;
}

EXPORT int fmi2SetReal(Instance *s, const unsigned *vr, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        if (!may(s, INSTANTIATED | INITIALISING | (vr[i] == 0 ? STEPPING : 0)) ||
            vr[i] == 1 || !place(s, vr[i]) || !isfinite(v[i]))
            return refuse(s, "it cannot be set, or not to that");
        *place(s, vr[i]) = v[i];
    }
    return OK;
}

EXPORT int fmi2DoStep(Instance *s, double t, double h, int no_set) {
    return advance(s, t, h);
}

EXPORT int fmi2GetBooleanStatus(Instance *s, int kind, int *value) {
    *value = s->phase == ENDED;
    return kind == 3 ? OK : ERROR;
}

EXPORT int fmi2GetRealStatus(Instance *s, int kind, double *value) {
    *value = s->t;
    return kind == 2 ? OK : ERROR;
}

#define REFUSED(name)                                                              \
    EXPORT int name(Instance *s) {                                                 \
        may(s, ~FAILED);                                                           \
        return refuse(s, #name " is not supported");                               \
    }
REFUSED(fmi2SetRealInputDerivatives)
REFUSED(fmi2GetRealOutputDerivatives)
REFUSED(fmi2GetDirectionalDerivative)
REFUSED(fmi2GetFMUstate)
