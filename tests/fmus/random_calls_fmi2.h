/* The calls of random_calls.c that only FMI 2 has, or names so. */
#define F(name) fmi2##name
static void log_message(fmi2ComponentEnvironment environment, fmi2String instance,
                        fmi2Status status, fmi2String category, fmi2String format, ...) {
    va_list arguments;
    va_start(arguments, format);
    heard(format, arguments);
    va_end(arguments);
}

static Handle create(int exchange) {
    static const fmi2CallbackFunctions callbacks = {log_message, NULL, NULL, NULL, NULL};
    static const fmi2CallbackFunctions silent = {NULL, NULL, NULL, NULL, NULL};
    return fmi2Instantiate(name_of_it(),
                           exchange ? fmi2ModelExchange : fmi2CoSimulation,
                           !rarely() ? M.token : below(2) ? "other" : NULL, NULL,
                           !rarely() ? &callbacks : below(2) ? &silent : NULL, 0,
                           below(2));
}

static int begin(Handle c, unsigned which) {
    switch (which) {
    case 0:
        return fmi2SetupExperiment(c, below(2), number(), rarely() ? number() : 0.0,
                                   rarely(), number());
    case 1:
        return fmi2EnterInitializationMode(c);
    case 2:
        return fmi2EnterEventMode(c);
    default: {
        fmi2EventInfo *info = array(1, sizeof *info);
        int status = fmi2NewDiscreteStates(c, info);
        free(info);
        return status;
    }
    }
}

static int transfer(Handle c, unsigned which) {
    Reference *vr = (Reference *)chosen();
    double *values = numbers(n_references);
    int *truths = array(n_references, sizeof *truths), status;
    for (size_t i = 0; truths && i < n_references; i++)
        truths[i] = (int)below(2);
    switch (which) {
    case 0: status = fmi2SetReal(c, vr, n_references, values); break;
    case 1: status = fmi2GetBoolean(c, vr, n_references, truths); break;
    case 2: status = fmi2SetBoolean(c, vr, n_references, truths); break;
    case 3: status = fmi2GetInteger(c, vr, n_references, truths); break;
    case 4: status = fmi2SetString(c, vr, n_references, NULL); break;
    default: status = fmi2GetReal(c, vr, n_references, values);
    }
    free(vr);
    free(values);
    free(truths);
    return status;
}

static int step(Handle c, double t, double h) {
    return fmi2DoStep(c, t, h, 1);
}

static int ask(Handle c, unsigned which) {
    double *time = array(1, sizeof *time);
    int *ended = array(1, sizeof *ended), status, other = rarely();
    if (rarely())
        status = fmi2GetEventIndicators(c, time, below(2));
    else
        status = which ? fmi2GetRealStatus(c, other ? fmi2Terminated
                                                    : fmi2LastSuccessfulTime, time)
                       : fmi2GetBooleanStatus(c, other ? fmi2PendingStatus
                                                       : fmi2Terminated, ended);
    free(time);
    free(ended);
    return status;
}

static int derive(Handle c) {
    size_t n = below(3), m = below(3);
    Reference *of = array(n, sizeof *of), *by = array(m, sizeof *by);
    double *found = numbers(n), *seed = numbers(m);
    for (size_t i = 0; of && i < n; i++)
        of[i] = unknown();
    for (size_t i = 0; by && i < m; i++)
        by[i] = known();
    int status = fmi2GetDirectionalDerivative(c, of, n, by, m, seed, found);
    free(of);
    free(by);
    free(found);
    free(seed);
    return status;
}
#define GET_STATE fmi2GetFMUstate
#define SET_STATE fmi2SetFMUstate
#define FREE_STATE fmi2FreeFMUstate
#define SIZE fmi2SerializedFMUstateSize
#define WRITE(c, s, b, n) fmi2SerializeFMUstate(c, s, (fmi2Byte *)(b), n)
#define READ(c, b, n, s) fmi2DeSerializeFMUstate(c, (const fmi2Byte *)(b), n, s)
#define DERIVATIVES fmi2GetDerivatives
