/* Serialised states of an FMU's sources, changed at random and signed again, are refused
   or taken without a byte out of place.  states TRIES SEED; prints tries and taken.
   With LIBFUZZER, what is changed is what libFuzzer says. */
#include "fmi2Functions.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HEAD = 40, DIGEST = 32, SIZE = 24 }; /* bytes, as in snapshot.c */

#ifndef LIBFUZZER
static uint64_t seed;

static unsigned below(unsigned n) { /* splitmix64 */
    uint64_t z = (seed += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (unsigned)((z ^ (z >> 31)) % n);
}

#endif

static void sign(unsigned char *bytes, size_t size) {
    uint64_t digest = 14695981039346656037u, whole = size;
    for (size_t i = HEAD; i < size; i++)
        digest = (digest ^ bytes[i]) * 1099511628211u;
    memcpy(bytes + SIZE, &whole, sizeof whole);
    memcpy(bytes + DIGEST, &digest, sizeof digest);
}

static void quiet(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c,
                  fmi2String m, ...) {
    (void)e, (void)i, (void)s, (void)c, (void)m;
}

static fmi2Component begun(void) {
    static const fmi2CallbackFunctions callbacks = {quiet, NULL, NULL, NULL, NULL};
    fmi2Component it =
        fmi2Instantiate("it", fmi2CoSimulation, TOKEN, NULL, &callbacks, 0, 0);
    if (!it || fmi2SetupExperiment(it, 0, 0, 0, 0, 0) ||
        fmi2EnterInitializationMode(it) || fmi2ExitInitializationMode(it))
        exit(1);
    return it;
}

#ifdef LIBFUZZER
/* A sound state some steps on, of which the data changes bytes and appends some. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n) {
    static const fmi2ValueReference input = INPUT_REFERENCE;
    static fmi2Component it;
    static unsigned char *sound;
    static size_t size;
    static fmi2FMUstate state;
    fmi2FMUstate other = NULL;
    fmi2Real u = 1;
    if (!it) {
        it = begun();
        for (int k = 0; k < 4; k++, u++)
            if (fmi2SetReal(it, &input, 1, &u) || fmi2DoStep(it, k * 1e-4, 1e-4, 1))
                abort();
        if (fmi2GetFMUstate(it, &state) ||
            fmi2SerializedFMUstateSize(it, state, &size) || !(sound = malloc(size)) ||
            fmi2SerializeFMUstate(it, state, (fmi2Byte *)sound, size))
            abort();
    }
    size_t more = n ? data[0] % 64 : 0, length = size + more;
    unsigned char *bytes = calloc(length, 1);
    memcpy(bytes, sound, size);
    for (size_t i = 1; i + 2 < n; i += 3)
        bytes[HEAD + (data[i] << 8 | data[i + 1]) % (length - HEAD)] = data[i + 2];
    sign(bytes, length);
    if (!fmi2DeSerializeFMUstate(it, (const fmi2Byte *)bytes, length, &other)) {
        fmi2SetFMUstate(it, other);
        fmi2GetReal(it, &input, 1, &u);
        if (fmi2SetFMUstate(it, state)) { /* in a phase that there is not */
            fmi2FreeInstance(it);
            it = begun();
        }
        fmi2FreeFMUstate(it, &other);
    }
    free(bytes);
    return 0;
}
#else
int main(int count, char **words) {
    const fmi2ValueReference input = INPUT_REFERENCE;
    int tries = count > 2 ? atoi(words[1]) : 0, taken = 0;
    seed = count > 2 ? strtoull(words[2], NULL, 10) : 0;
    alarm(300); /* what would never end fails */
    fmi2Component it = begun();
    fmi2FMUstate state = NULL;
    size_t size = 0;
    for (int k = 0; k < 4; k++) {
        fmi2Real u = 1 + k;
        if (fmi2SetReal(it, &input, 1, &u) || fmi2DoStep(it, k * 1e-4, 1e-4, 1))
            return 2;
    }
    if (fmi2GetFMUstate(it, &state) || fmi2SerializedFMUstateSize(it, state, &size))
        return 3;
    unsigned char *sound = malloc(size);
    if (fmi2SerializeFMUstate(it, state, (fmi2Byte *)sound, size))
        return 4;
    for (int n = 0; n < tries; n++) {
        size_t length = below(4) ? size : size + below(64) - below(64);
        unsigned char *bytes = calloc(length ? length : 1, 1);
        memcpy(bytes, sound, length < size ? length : size);
        for (unsigned k = below(6); length > HEAD && k > 0; k--) {
            static const unsigned char wild[] = {0, 1, 0x7f, 0x80, 0xff};
            bytes[HEAD + below((unsigned)(length - HEAD))] =
                below(2) ? wild[below(5)] : (unsigned char)below(256);
        }
        if (length >= HEAD && below(10))
            sign(bytes, length);
        fmi2FMUstate other = NULL;
        if (!fmi2DeSerializeFMUstate(it, (const fmi2Byte *)bytes, length, &other)) {
            fmi2Real value;
            taken += !fmi2SetFMUstate(it, other);
            fmi2GetReal(it, &input, 1, &value);
            if (fmi2SetFMUstate(it, state)) { /* in a phase that there is not */
                fmi2FreeInstance(it);
                it = begun();
            }
            fmi2FreeFMUstate(it, &other);
        }
        free(bytes);
    }
    free(sound);
    fmi2FreeFMUstate(it, &state);
    fmi2FreeInstance(it);
    printf("%d tries, %d taken\n", tries, taken);
    return 0;
}
#endif
