/* The calls of random_calls.c that only FMI 3 has, or names so. */
#define F(name) fmi3##name
static void log_message(fmi3InstanceEnvironment environment, fmi3Status status,
                        fmi3String category, fmi3String message) {
    messages += strlen(message) > 0;
}

static Handle create(int exchange) {
    const char *name = name_of_it();
    const char *token = !rarely() ? M.token : below(2) ? "other" : NULL;
    fmi3LogMessageCallback log = rarely() ? NULL : log_message;
    if (below(200) == 0)
        return fmi3InstantiateScheduledExecution(name, token, NULL, 0, 0, NULL, log,
                                                 NULL, NULL, NULL);
    if (exchange)
        return fmi3InstantiateModelExchange(name, token, NULL, 0, below(2), NULL, log);
    return fmi3InstantiateCoSimulation(name, token, NULL, 0, below(2), below(2), 0, NULL,
                                       rarely(), NULL, log, NULL);
}

static int begin(Handle c, unsigned which) {
    switch (which) {
    case 0: {
        double *x = numbers(1);
        size_t *count = array(1, sizeof *count);
        int status = rarely() ? fmi3GetNumberOfEventIndicators(c, count)
                              : fmi3GetNumberOfContinuousStates(c, count);
        free(x);
        free(count);
        return status;
    }
    case 1:
        return fmi3EnterInitializationMode(c, below(2), number(),
                                           rarely() ? number() : 0.0, rarely(),
                                           number());
    case 2:
        return fmi3EnterEventMode(c);
    default: {
        Truth *told = array(5, sizeof *told);
        int status = rarely()
                         ? fmi3UpdateDiscreteStates(c, NULL, NULL, NULL, NULL, NULL, NULL)
                     : told ? fmi3UpdateDiscreteStates(
                                  c, told, rarely() ? NULL : told + 1,
                                  rarely() ? NULL : told + 2,
                                  rarely() ? NULL : told + 3,
                                  rarely() ? NULL : told + 4, NULL)
                            : fmi3EnterStepMode(c);
        free(told);
        return status;
    }
    }
}

static int transfer(Handle c, unsigned which) {
    Reference *vr = (Reference *)chosen();
    double *values = numbers(n_values), *intervals = numbers(n_references);
    Truth *truths = array(n_values, sizeof *truths);
    Truth *clocks = array(n_references, sizeof *clocks);
    fmi3IntervalQualifier *qualifiers = array(n_references, sizeof *qualifiers);
    fmi3UInt64 *counters = array(n_references, sizeof *counters);
    int status;
    for (size_t i = 0; truths && i < n_values; i++)
        truths[i] = below(2) != 0;
    for (size_t i = 0; clocks && i < n_references; i++)
        clocks[i] = below(2) != 0;
    if (((which > 2 && which < 7) || which == 9 || which == 10) && vr && n_references && below(2))
        vr[0] = M.size; /* the clock, where there is one */
    switch (which) {
    case 0: status = fmi3SetFloat64(c, vr, n_references, values, n_values); break;
    case 1: status = fmi3GetBoolean(c, vr, n_references, truths, n_values); break;
    case 2: status = fmi3SetBoolean(c, vr, n_references, truths, n_values); break;
    case 3: status = fmi3SetClock(c, vr, n_references, clocks); break;
    case 4: status = fmi3GetClock(c, vr, n_references, clocks); break;
    case 5:
        status = fmi3GetIntervalDecimal(c, vr, n_references, intervals, qualifiers);
        break;
    case 6:
        status = fmi3GetIntervalFraction(c, vr, n_references, counters, counters,
                                         qualifiers);
        break;
    case 9: status = fmi3GetShiftDecimal(c, vr, n_references, intervals); break;
    case 10: status = fmi3GetShiftFraction(c, vr, n_references, counters, counters); break;
    case 7: status = fmi3GetInt32(c, vr, n_references, NULL, n_values); break;
    case 8: status = fmi3SetBinary(c, vr, n_references, NULL, NULL, n_values); break;
    default: status = fmi3GetFloat64(c, vr, n_references, values, n_values);
    }
    free(vr);
    free(values);
    free(intervals);
    free(truths);
    free(clocks);
    free(qualifiers);
    free(counters);
    return status;
}

static int step(Handle c, double t, double h) {
    Truth event, ends, early;
    double last;
    return rarely() ? fmi3DoStep(c, t, h, 1, NULL, NULL, NULL, NULL)
                    : fmi3DoStep(c, t, h, 1, &event, &ends, &early, &last);
}

static int ask(Handle c, unsigned which) {
    double *values = numbers(n_values);
    int status = which ? fmi3GetEventIndicators(c, values, below(2))
                       : fmi3EnterConfigurationMode(c);
    free(values);
    return status;
}

static int derive(Handle c) {
    size_t n = below(3), m = below(3), spare = rarely() ? below(3) : 0;
    Reference *of = array(n, sizeof *of), *by = array(m, sizeof *by);
    double *found = numbers(n + spare), *seed = numbers(m + spare);
    for (size_t i = 0; of && i < n; i++)
        of[i] = unknown();
    for (size_t i = 0; by && i < m; i++)
        by[i] = known();
    int status = below(2) ? fmi3GetDirectionalDerivative(c, of, n, by, m, seed,
                                                         m + spare, found, n + spare)
                          : fmi3GetAdjointDerivative(c, of, n, by, m, found, n, seed, m);
    free(of);
    free(by);
    free(found);
    free(seed);
    return status;
}
#define GET_STATE fmi3GetFMUState
#define SET_STATE fmi3SetFMUState
#define FREE_STATE fmi3FreeFMUState
#define SIZE fmi3SerializedFMUStateSize
#define WRITE(c, s, b, n) fmi3SerializeFMUState(c, s, (fmi3Byte *)(b), n)
#define READ(c, b, n, s) fmi3DeserializeFMUState(c, (const fmi3Byte *)(b), n, s)
#define DERIVATIVES fmi3GetContinuousStateDerivatives
