#include "component.h"

#include <math.h>
#include <string.h>

#define M feeddrive_model

const Variable *component_find(Component *c, const char *function,
                               unsigned reference, int boolean) {
    if (reference >= M.size) {
        component_refuse(c, "%s: there is no variable with value reference %u; the "
                            "largest is %u", function, reference, M.size - 1);
        return NULL;
    }
    const Variable *v = M.variables + M.variable_of[reference];
    if (v->boolean == boolean)
        return v;
    component_refuse(c, "%s: %s is a %s variable", function, v->name,
                     v->boolean ? "Boolean" : "floating-point");
    return NULL;
}

/* Phases in which a variable can be set, and why not in others. */
static int settable(const Component *c, const Variable *v, const char **why) {
    const int before = INSTANTIATED | INITIALIZING;
    const int exchange = c->model_exchange ? EXCHANGING : 0;
    if (v->constant || v->block == PERIOD) {
        *why = "it is a constant";
        return 0;
    }
    switch (v->block) {
    case INPUT:
        return before | RUNNING;
    case PARAMETER:
        *why = v->fixed ? "it is a fixed parameter, to be set before or during "
                          "initialization"
                        : "tunable parameters are set before initialization ends, "
                          "between steps or in event mode";
        return v->fixed ? before : before | STEPPING | EVENT | exchange;
    case STATE:
        *why = "states are set before or during initialization, in model exchange "
               "at any time";
        return before | exchange;
    case TIME:
        *why = "it is the time";
        return 0;
    default:
        *why = "it is computed by the model";
        return 0;
    }
}

/* Make room for a dead time that is raised while the simulation runs. */
static int fits_lines(Component *c, const char *function, const Variable *v,
                      const double *values) {
    unsigned i;
    if (!(c->simulation.state.phase & RUNNING))
        return 1;
    for (i = 0; i < M.n_delays; i++)
        if (M.delays[i].dead_time == v->reference &&
            !component_reserve(c, function, i, values[0]))
            return 0;
    return 1;
}

int component_may_set(Component *c, const char *function,
                      const Variable *variable, const double *values, size_t n) {
    const char *why = "the simulation is over";
    if (!(settable(c, variable, &why) & c->simulation.state.phase)) {
        component_refuse(c, "%s: %s cannot be set now: %s", function, variable->name,
                         why);
        return 0;
    }
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(values[i])) {
            component_refuse(c, "%s: %s cannot be %g; a finite value was expected",
                             function, variable->name, values[i]);
            return 0;
        }
    }
    return fits_lines(c, function, variable, values);
}

void component_set(Component *c, unsigned reference, const double *values,
                   size_t n) {
    State *state = &c->simulation.state;
    memcpy(c->simulation.values + reference, values, n * sizeof(double));
    if (reference < M.u)
        state->derived_stale = 1;
    if (state->phase != STEPPING)
        state->outputs_stale = 1;
}

const double *component_values(Component *c) {
    const State *state = &c->simulation.state;
    int holds = state->phase == EVENT && c->simulation.clocked && !state->ticking;
    if (state->phase & (INSTANTIATED | INITIALIZING | EXCHANGING) && !holds)
        simulation_refresh(&c->simulation);
    return c->simulation.values;
}

int component_no_type(Component *c, const char *function, size_t n,
                      unsigned reference) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (n == 0)
        return STATUS_OK;
    if (reference >= M.size)
        return component_refuse(c, "%s: there is no variable with value reference %u",
                                function, reference);
    const Variable *v = M.variables + M.variable_of[reference];
    return component_refuse(c, "%s: %s is a %s variable", function, v->name,
                            v->boolean ? "Boolean" : "64-bit floating-point");
}

int component_set_time(Component *c, const char *function, double time) {
    if (!component_may(c, function, EXCHANGING))
        return STATUS_ERROR;
    if (!isfinite(time))
        return component_refuse(c, "%s: time cannot be %g", function, time);
    c->simulation.values[M.size - 1] = time;
    return STATUS_OK;
}

unsigned component_continuous_states(void) {
    return M.continuous ? M.n_x : 0;
}

/* Tell whether array has room for all continuous states, n of them. */
static int counts(Component *c, const char *function, const double *array, size_t n) {
    const unsigned there = component_continuous_states();
    if (n == there)
        return component_given(c, function, n, array);
    component_refuse(c, "%s: %s has %u continuous states, not %lu", function,
                     M.identifier, there, (unsigned long)n);
    return 0;
}

int component_set_states(Component *c, const char *function, const double *x,
                         size_t n) {
    if (!component_may(c, function, CONTINUOUS_TIME) ||
        !counts(c, function, x, n))
        return STATUS_ERROR;
    for (unsigned i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return component_refuse(
                c, "%s: %s cannot be %g; a finite value was expected", function,
                M.variables[M.variable_of[M.x + i]].name, x[i]);
    if (n)
        memcpy(c->simulation.values + M.x, x, n * sizeof(double));
    c->simulation.state.outputs_stale = 1;
    return STATUS_OK;
}

int component_get_block(Component *c, const char *function, unsigned first,
                        double *values, size_t n) {
    if (!component_may(c, function, INITIALIZING | EXCHANGING | TERMINATED) ||
        !counts(c, function, values, n))
        return STATUS_ERROR;
    if (!n)
        return STATUS_OK;
    memcpy(values, component_values(c) + first, n * sizeof(double));
    for (unsigned i = 0; i < n; i++)
        if (!isfinite(values[i]))
            return component_refuse(c, "%s: %s is %g; a finite value was expected",
                                    function,
                                    M.variables[M.variable_of[first + i]].name,
                                    values[i]);
    return STATUS_OK;
}

int component_get_nominals(Component *c, const char *function, double *nominal,
                           size_t n) {
    if (!component_may(c, function, SOUND) || !counts(c, function, nominal, n))
        return STATUS_ERROR;
    if (n)
        memcpy(nominal, M.nominal, n * sizeof(double));
    return STATUS_OK;
}
