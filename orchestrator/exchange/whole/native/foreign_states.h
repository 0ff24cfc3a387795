/* States of FMUs of others inside a composition; included behind foreign.h. */

/* The state as bytes, to be freed; none where it is not instantiated.  0 if it is
   refused. */
static int foreign_save(const Foreign *f, const Loaded *l, unsigned char **bytes,
                        size_t *size) {
    void *state = NULL;
    int two = f->major == 2, status;
    *bytes = NULL;
    *size = 0;
    if (!l->instance)
        return 1;
    status = two ? (int)CALL(l, fmi2GetFMUstate, fmi2GetFMUstateTYPE, &state)
                 : (int)CALL(l, fmi3GetFMUState, fmi3GetFMUStateTYPE, &state);
    if (fine(status))
        status = two ? (int)CALL(l, fmi2SerializedFMUstateSize,
                                 fmi2SerializedFMUstateSizeTYPE, state, size)
                     : (int)CALL(l, fmi3SerializedFMUStateSize,
                                 fmi3SerializedFMUStateSizeTYPE, state, size);
    if (fine(status) && (*bytes = (unsigned char *)malloc(*size + 1)) == NULL)
        status = 3;
    if (fine(status))
        status = two ? (int)CALL(l, fmi2SerializeFMUstate, fmi2SerializeFMUstateTYPE, state,
                                 (fmi2Byte *)*bytes, *size)
                     : (int)CALL(l, fmi3SerializeFMUState, fmi3SerializeFMUStateTYPE, state,
                                 *bytes, *size);
    if (state && two)
        CALL(l, fmi2FreeFMUstate, fmi2FreeFMUstateTYPE, &state);
    else if (state)
        CALL(l, fmi3FreeFMUState, fmi3FreeFMUStateTYPE, &state);
    return fine(status);
}

static int foreign_load(const Foreign *f, Loaded *l, const unsigned char *bytes,
                        size_t size) {
    void *state = NULL;
    int two = f->major == 2, status;
    if (!size) {
        foreign_free(l, f->major);
        return 1;
    }
    if (!l->instance && !instantiated(f, l))
        return 0;
    status = two ? (int)CALL(l, fmi2DeSerializeFMUstate, fmi2DeSerializeFMUstateTYPE,
                             (const fmi2Byte *)bytes, size, &state)
                 : (int)CALL(l, fmi3DeserializeFMUState, fmi3DeserializeFMUStateTYPE, bytes,
                             size, &state);
    if (fine(status))
        status = two ? (int)CALL(l, fmi2SetFMUstate, fmi2SetFMUstateTYPE, state)
                     : (int)CALL(l, fmi3SetFMUState, fmi3SetFMUStateTYPE, state);
    if (state && two)
        CALL(l, fmi2FreeFMUstate, fmi2FreeFMUstateTYPE, &state);
    else if (state)
        CALL(l, fmi3FreeFMUState, fmi3FreeFMUStateTYPE, &state);
    return fine(status);
}
