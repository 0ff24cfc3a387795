#include "component.h"

#include <math.h>
#include <string.h>

#define M feeddrive_model

int component_direction_begin(Component *c, const char *function) {
    if (!component_may(c, function, INITIALIZING | RUNNING))
        return 0;
    if (!M.tangent) {
        component_refuse(c, "%s is not supported: %s rounds, or starts on a kink", function, M.identifier);
        return 0;
    }
    memset(c->simulation.tangent, 0, M.n_x * sizeof(double) + M.n_u * sizeof(double));
    return 1;
}

int component_direction_seed(Component *c, const char *function, unsigned reference,
                             double seed) {
    double *change = c->simulation.tangent;
    if (reference >= M.x && reference < M.x + M.n_x) {
        change[reference - M.x] = seed;
    } else if (reference >= M.u && reference < M.u + M.n_u) {
        change[M.n_x + reference - M.u] = seed;
    } else {
        component_refuse(c, "%s: value reference %u is no known: derivatives are by "
                            "inputs and states", function, reference);
        return 0;
    }
    return 1;
}

void component_direction(Component *c) {
    unsigned i;
    /* What is delayed does not act at once. */
    if (c->simulation.state.phase & RUNNING)
        for (i = 0; i < M.n_delays; i++)
            c->simulation.tangent[M.n_x + M.delays[i].input - M.u] = 0;
    simulation_tangent(&c->simulation);
}

int component_direction_of(Component *c, const char *function, unsigned reference,
                           double *sensitivity) {
    const double *result = c->simulation.tangent + M.n_x + M.n_u;
    if (M.continuous && reference >= M.der_x && reference < M.der_x + M.n_x) {
        *sensitivity = result[reference - M.der_x];
    } else if (reference >= M.y && reference < M.y + M.n_y) {
        *sensitivity = result[M.n_x + reference - M.y];
    } else {
        component_refuse(c, "%s: value reference %u is no unknown: derivatives are of "
                            "outputs and of derivatives of states",
                         function, reference);
        return 0;
    }
    if (isfinite(*sensitivity))
        return 1;
    component_refuse(c, "%s: there is no derivative at this point (value reference %u)",
                     function, reference);
    return 0;
}
