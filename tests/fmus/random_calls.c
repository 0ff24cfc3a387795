/* Calls the functions of an FMU's sources in random order with random arguments,
   of which many are wrong: other lengths, NULL, unknown references, NaN.

   random_calls CALLS SEED; linked with the sources, FMI defined as 2 or 3.
   Prints how many calls were made and how many returned OK.  Every array has
   exactly the size it is said to have, so that a sanitizer sees a byte beyond.  Linked
   with --wrap=malloc,--wrap=calloc and NO_MEMORY defined the FMU is denied memory now
   and then. */
#include "model.h"

#if FMI == 2
#include "fmi2Functions.h"
typedef fmi2ValueReference Reference;
typedef fmi2Component Handle;
typedef int Truth;
#else
#include "fmi3Functions.h"
typedef fmi3ValueReference Reference;
typedef fmi3Instance Handle;
typedef _Bool Truth;
#endif

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define M feeddrive_model
#define MANY 3   /* instances and states at a time */
#define LONG 6   /* references in one call, at most */

static unsigned long long seed;
static long fine, messages;

static unsigned below(unsigned n) { /* splitmix64 */
    unsigned long long z = (seed += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (unsigned)((z ^ (z >> 31)) % n);
}

static int rarely(void) {
    return below(20) == 0;
}

static double number(void) {
    static const double wild[] = {NAN, INFINITY, -INFINITY, 1e300, -1e-300, -0.0};
    return rarely() ? wild[below(6)] : ((double)below(2001) - 1000.0) / 500.0;
}

#ifdef NO_MEMORY
static int denies;
void *__real_malloc(size_t), *__real_calloc(size_t, size_t);
void *__wrap_malloc(size_t size) {
    return denies && rarely() ? NULL : __real_malloc(size);
}
void *__wrap_calloc(size_t n, size_t size) {
    return denies && rarely() ? NULL : __real_calloc(n, size);
}
#define malloc __real_malloc
#else
static int denies;
#endif

static void *array(size_t n, size_t size) {
    return rarely() ? NULL : malloc(n * size ? n * size : 1);
}

static const char *name_of_it(void) {
    static char longest[2000];
    memset(longest, 'n', sizeof longest - 1);
    return !rarely() ? "it" : below(3) ? longest : below(2) ? "" : NULL;
}

static double *numbers(size_t n) {
    double *values = array(n, sizeof *values);
    for (size_t i = 0; values && i < n; i++)
        values[i] = number();
    return values;
}

/* The length of a step: mostly a few periods, never one that takes minutes. */
static double length(void) {
    static const double odd[] = {0.0, -1e-3, NAN, 1e-12, 1e15, INFINITY};
    double period = M.continuous ? 1e-4 : (double)M.period_num / (double)M.period_den;
    return rarely() ? odd[below(6)] : period * (1 + below(20)) / 4;
}

static struct {
    Handle it;
    double t;
} pool[MANY];
static void *states[MANY];
static unsigned char *bytes;
static size_t n_bytes;

static void heard(const char *format, va_list arguments) {
    char text[4096];
    vsnprintf(text, sizeof text, format, arguments);
    messages += strlen(text) > 0;
}

static Reference references[LONG];
static size_t n_references, n_values;

/* Choose references, existing and not, and how many values they take. */
static const Reference *chosen(void) {
    n_references = below(LONG + 1);
    n_values = 0;
    Reference *copy = array(n_references, sizeof *copy);
    for (size_t i = 0; i < n_references; i++) {
        unsigned reference = below(M.size + 1 + (unsigned)rarely() * 100000);
        n_values += reference < M.size
                        ? M.variables[M.variable_of[reference]].size
                        : 1;
        references[i] = reference;
    }
    if (copy)
        memcpy(copy, references, n_references * sizeof *copy);
    if (rarely())
        n_values = below(9);
    return copy;
}

/* Something to derive by, or of what there is a derivative; or another thing. */
static Reference known(void) {
    return rarely() ? below(M.size + 1)
                    : below(2) ? M.u + below(M.n_u + 1) : M.x + below(M.n_x + 1);
}
static Reference unknown(void) {
    return rarely() ? below(M.size + 1)
                    : M.continuous && below(2) ? M.der_x + below(M.n_x + 1)
                                               : M.y + below(M.n_y + 1);
}

static size_t some_states(void) {
    return rarely() ? below(9) : M.continuous ? M.n_x : (rarely() ? M.n_x : 0);
}

static void damage(void) {
    if (bytes && n_bytes && below(4) == 0)
        bytes[below((unsigned)n_bytes)] ^= (unsigned char)(1 + below(255));
}

#if FMI == 2
#include "random_calls_fmi2.h"
#else
#include "random_calls_fmi3.h"
#endif

static int exchange(Handle c, unsigned which) {
    const size_t n = some_states();
    double *x = numbers(n);
    Truth *told = array(2, sizeof *told);
    int status;
    switch (which) {
    case 0: status = F(EnterContinuousTimeMode)(c); break;
    case 1: status = F(SetTime)(c, number()); break;
    case 2: status = F(SetContinuousStates)(c, x, n); break;
    case 3: status = F(GetContinuousStates)(c, x, n); break;
    case 4: status = F(GetNominalsOfContinuousStates)(c, x, n); break;
    case 5:
        status = F(CompletedIntegratorStep)(c, 1, below(4) ? told : NULL,
                                            told && below(4) ? told + 1 : NULL);
        break;
    default: status = DERIVATIVES(c, x, n);
    }
    free(x);
    free(told);
    return status;
}

static int save(Handle c, unsigned which) {
    void **state = states + below(MANY);
    switch (which) {
    case 0: return GET_STATE(c, rarely() ? NULL : state);
    case 1: return SET_STATE(c, *state);
    case 2: return FREE_STATE(c, rarely() ? NULL : state);
    case 3: {
        size_t size = 0;
        int status = SIZE(c, *state, rarely() ? NULL : &size);
        if (status || !size)
            return status;
        free(bytes);
        n_bytes = rarely() ? size - 1 : size;
        bytes = malloc(n_bytes);
        status = WRITE(rarely() ? NULL : c, rarely() ? NULL : *state,
                       rarely() ? NULL : bytes, n_bytes);
        if (status)
            memset(bytes, 1, n_bytes);
        damage();
        return status;
    }
    default: return READ(c, rarely() ? NULL : bytes, n_bytes, rarely() ? NULL : state);
    }
}

static int call(unsigned i) {
    Handle c = pool[i].it;
    if (!c) {
        int exchange = M.continuous && !M.advance && !M.n_delays;
        pool[i].it = create(rarely() ? !exchange : exchange && below(2));
        pool[i].t = 0;
        return !pool[i].it;
    }
    if (below(100) == 0)
        c = NULL;
    switch (below(17)) {
    case 16: return derive(c);
    case 0:
    case 1: return begin(c, below(4));
    case 2: return F(ExitInitializationMode)(c);
    case 3:
    case 4:
    case 5: return transfer(c, below(14));
    case 6:
    case 7: return exchange(c, below(8));
    case 8:
    case 9: return save(c, below(5));
    case 10: return ask(c, below(2));
    case 11:
        if (rarely()) {
            static const char *const names[][3] = {
                {"logAll", "nothing", NULL}, {"logStatusError", "logAll", NULL},
                {"logStatusWarning", "logStatusWarning", "logAll"}};
            return F(SetDebugLogging)(c, below(2), below(4),
                                      rarely() ? NULL : names[below(3)]);
        }
        if (below(4))
            return begin(c, 1);
        return below(4) ? F(Reset)(c) : F(Terminate)(c);
    case 12:
        if (below(8))
            return transfer(c, 13);
        F(FreeInstance)(c);
        pool[i].it = c ? NULL : pool[i].it;
        return 0;
    default: {
        const double h = length(), t = rarely() ? number() : pool[i].t;
        int status = step(c, t, h);
        if (!status)
            pool[i].t = t + h;
        else if (rarely())
            pool[i].t = 0; /* after a reset it begins there */
        return status;
    }
    }
}

#if FMI == 2
/* Fill a delay line beyond its end, and lengthen one that holds something. */
static void fill_lines(Handle c) {
    Reference dead_time = M.delays[0].dead_time, input = M.delays[0].input;
    int full = 0, lengthened = 0;
    for (int longer = 0; longer < 2; longer++) {
        double t = 0, tau = 1e-3;
        fine += F(Reset)(c) + fmi2SetupExperiment(c, 0, 0, 0, 0, 0);
        fmi2SetReal(c, &dead_time, 1, &tau);
        F(EnterInitializationMode)(c);
        F(ExitInitializationMode)(c);
        for (int k = 0; k < 100000 && !full; k++, t += 1e-9) {
            double u = k % 2;
            fmi2SetReal(c, &input, 1, &u);
            full = longer ? k == 5 : fmi2DoStep(c, t, 1e-9, 1) != 0;
            fine += longer && !fmi2DoStep(c, t, 1e-9, 1);
        }
        tau = 1;
        lengthened = !fmi2SetReal(c, &dead_time, 1, &tau);
        full = !longer && !full ? 2 : 0;
    }
    if (full || !lengthened) {
        fprintf(stderr, "a delay line that is filled: %d %d\n", full, lengthened);
        exit(1);
    }
}
#else
static void fill_lines(Handle c) {
    (void)c;
}
#endif

int main(int argc, char **argv) {
    const long calls = argc > 1 ? atol(argv[1]) : 1000;
    seed = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    denies = 1;
    for (long k = 0; k < calls; k++)
        fine += call(below(MANY)) == 0;
    denies = 0;
    Handle last = create(0);
    while (!last)
        last = create(0);
    if (M.n_delays)
        fill_lines(last);
    for (unsigned i = 0; i < MANY; i++) {
        FREE_STATE(last, states + i);
        F(FreeInstance)(pool[i].it);
    }
    F(FreeInstance)(last);
    free(bytes);
    printf("%ld calls, %ld OK, %ld messages\n", calls, fine, messages);
    return 0;
}
