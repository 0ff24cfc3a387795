#include "component.h"

#include "memory.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define M feeddrive_model
#define LONGEST 1e9 /* substeps or ticks in one step; more is a mistake */
#define MESSAGE 1024

static void tell(const Component *c, const char *message) {
    if (c->log && c->callback)
        c->log(c->environment, c->callback, c->name, STATUS_ERROR,
               "logStatusError", message);
}

int component_refuse(Component *c, const char *format, ...) {
    char room[MESSAGE], *longer = NULL, *message = room;
    size_t name, size;
    va_list arguments;
    if (!c || !c->logging)
        return STATUS_ERROR;
    va_start(arguments, format);
    name = strlen(c->name) + 2;
    size = name + (size_t)vsnprintf(NULL, 0, format, arguments) + 1;
    va_end(arguments);
    if (size > MESSAGE)
        longer = (char *)memory_more(size);
    if (longer)
        message = longer;
    else if (size > MESSAGE)
        size = MESSAGE; /* without a heap the end is cut */
    if (name < size) {
        snprintf(message, size, "%s: ", c->name);
        va_start(arguments, format);
        vsnprintf(message + name, size - name, format, arguments);
        va_end(arguments);
        tell(c, message);
    }
    memory_release(longer);
    return STATUS_ERROR;
}

/* Why there can be no such instance, or NULL. */
static const char *objection(const char *name, const char *token,
                             int model_exchange) {
    if (!name || !*name)
        return "an instance needs a name; none was given";
    if (!token || strcmp(token, M.token) != 0)
        return "the token (guid) is not that of this binary; take it from the "
               "modelDescription.xml of the same FMU";
    if (model_exchange && !M.continuous)
        return "a sampled model has no model exchange; use co-simulation";
    if (model_exchange && (M.advance || M.n_delays))
        return "a model with its own integration or dead time has no model "
               "exchange; use co-simulation";
    return NULL;
}

Component *component_new(const char *name, const char *token, int model_exchange,
                         int logging, Log *log, void (*callback)(void),
                         void *environment) {
    Component trial, *c;
    const char *why = objection(name, token, model_exchange);
    size_t head = (sizeof *c + sizeof(double) - 1) / sizeof(double);
    memset(&trial, 0, sizeof trial);
    trial.name = name ? name : "";
    trial.logging = 1;
    trial.log = log;
    trial.callback = callback;
    trial.environment = environment;
    trial.model_exchange = model_exchange;
    if (why) {
        component_refuse(&trial, "%s is not instantiated: %s", M.identifier, why);
        return NULL;
    }
    head *= sizeof(double);
    c = (Component *)memory_take(head + simulation_size() + strlen(name) + 1);
    if (!c) {
        component_refuse(&trial, "there is no memory for another instance");
        return NULL;
    }
    *c = trial;
    c->logging = logging;
    c->name = strcpy((char *)c + head + simulation_size(), name);
    simulation_place(&c->simulation, (char *)c + head);
    simulation_reset(&c->simulation);
    c->simulation.state.phase = INSTANTIATED;
    return c;
}

Component *component_opened(Component *c, const char *resources) {
    const char *why = c && M.open ? M.open(resources) : NULL;
    if (!why)
        return c;
    c->logging = 1;
    component_refuse(c, "%s is not instantiated: %s", M.identifier, why);
    component_free(c);
    return NULL;
}

void component_free(Component *c) {
    if (!c)
        return;
    simulation_free(&c->simulation);
    memory_give(c);
}

static const char *phase_name(int phase) {
    switch (phase) {
    case INSTANTIATED: return "before initialization mode";
    case INITIALIZING: return "in initialization mode";
    case STEPPING: return "between steps";
    case EVENT: return "in event mode";
    case CONTINUOUS_TIME: return "in continuous-time mode";
    case TERMINATED: return "after terminate";
    default: return "after a failed step (reset it, or set an earlier state)";
    }
}

int component_may(Component *c, const char *function, int phases) {
    if (!c)
        return 0;
    if (c->simulation.state.phase & phases)
        return 1;
    component_refuse(c, "%s is not allowed %s", function,
                     phase_name(c->simulation.state.phase));
    return 0;
}

int component_given(Component *c, const char *function, size_t n,
                    const void *array) {
    if (array || !n)
        return 1;
    component_refuse(c, "%s: an array of %lu elements was expected, NULL was given",
                     function, (unsigned long)n);
    return 0;
}

int component_set_logging(Component *c, const char *function, int on,
                          size_t n, const char *const categories[]) {
    static const char *const known[] = {"logAll", "logStatusError",
                                        "logStatusWarning", "logStatusDiscard",
                                        "logStatusFatal"};
    int errors = n == 0;
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    for (size_t i = 0; i < n; i++) {
        const char *name = categories && categories[i] ? categories[i] : "";
        size_t k = 0;
        while (k < sizeof known / sizeof *known && strcmp(name, known[k]) != 0)
            k++;
        if (k == sizeof known / sizeof *known)
            return component_refuse(c, "%s: there is no log category %.60s; see "
                                       "LogCategories in modelDescription.xml",
                                    function, name);
        errors = errors || k < 2; /* the only messages there are */
    }
    c->logging = on && errors;
    return STATUS_OK;
}

int component_set_times(Component *c, const char *function, double start,
                        double stop) {
    State *state = &c->simulation.state;
    if (!isfinite(start) || !(stop >= start))
        return component_refuse(c, "%s: start time %.17g s must be finite and not "
                                   "after the stop time %.17g s",
                                function, start, stop);
    c->simulation.values[M.size - 1] = state->start_time = start;
    state->stop_time = stop;
    return STATUS_OK;
}

int component_move(Component *c, const char *function, int from, int to) {
    if (!component_may(c, function, from))
        return STATUS_ERROR;
    c->simulation.state.phase = to;
    return STATUS_OK;
}

/* The variable of a reference; part is "" or "element 3 of ", rows first. */
static const char *name_of(unsigned reference, char part[32]) {
    const Variable *v = M.variables + M.variable_of[reference];
    part[0] = '\0';
    if (v->size > 1)
        snprintf(part, 32, "element %u of ", reference - v->reference + 1);
    return v->name;
}

static int fit_to_go_on(Component *c, const char *function) {
    char part[32];
    unsigned wrong = simulation_not_finite(&c->simulation);
    if (wrong == M.size)
        return 1;
    const double *values = c->simulation.values;
    const char *name = name_of(wrong, part);
    component_refuse(c, "%s: %s%s is %g at t = %.9g s; finite values were expected",
                     function, part, name, values[wrong], values[M.size - 1]);
    return 0;
}

static int dead_times_fit(Component *c, const char *function) {
    char part[32];
    unsigned i = simulation_bad_delay(&c->simulation);
    if (i == M.n_delays)
        return 1;
    const char *name = name_of(M.delays[i].dead_time, part);
    component_refuse(c, "%s: dead time %s%s is %g s; it cannot be negative", function,
                     part, name, c->simulation.values[M.delays[i].dead_time]);
    return 0;
}

int component_reserve(Component *c, const char *function, unsigned i, double tau) {
    if (simulation_reserve(&c->simulation, i, tau))
        return 1;
    component_refuse(c, "%s: there is no memory for a dead time of %g s", function, tau);
    return 0;
}

int component_exit_initialization(Component *c, const char *function) {
    unsigned i;
    if (!component_may(c, function, INITIALIZING) || !dead_times_fit(c, function))
        return STATUS_ERROR;
    for (i = 0; i < M.n_delays; i++)
        if (!component_reserve(c, function, i,
                               c->simulation.values[M.delays[i].dead_time]))
            return STATUS_ERROR;
    simulation_refresh(&c->simulation);
    if (!fit_to_go_on(c, function))
        return STATUS_ERROR;
    simulation_begin(&c->simulation);
    c->simulation.state.phase =
        c->model_exchange || c->simulation.clocked ? EVENT : STEPPING;
    return STATUS_OK;
}

int component_enter_events(Component *c, const char *function) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    return component_move(c, function,
                          c->simulation.clocked ? STEPPING | EVENT : EXCHANGING, EVENT);
}

int component_leave_events(Component *c, const char *function) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!c->simulation.clocked)
        return component_refuse(c, "%s is not supported without event mode", function);
    simulation_activate(&c->simulation, 0);
    return component_move(c, function, EVENT, STEPPING);
}

int component_update(Component *c, const char *function) {
    if (!component_may(c, function, EVENT))
        return STATUS_ERROR;
    if (!c->simulation.state.ticking)
        return STATUS_OK;
    simulation_tick(&c->simulation);
    if (fit_to_go_on(c, function))
        return STATUS_OK;
    c->simulation.state.phase = FAILED;
    return STATUS_ERROR;
}

int component_reset(Component *c, const char *function) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    simulation_reset(&c->simulation);
    c->simulation.state.phase = INSTANTIATED;
    return STATUS_OK;
}

static int step_fits(Component *c, const char *function, double t, double h) {
    const State *state = &c->simulation.state;
    double now = c->simulation.values[M.size - 1];
    double rounding = 1e-9 * h + 8 * DBL_EPSILON * fabs(now);
    if (!(h > 0) || !isfinite(h)) {
        component_refuse(c, "%s: the step is %g s; it must be positive", function, h);
    } else if (!(fabs(t - now) <= rounding)) {
        component_refuse(c, "%s: the step begins at %.17g s, but the instance stands "
                            "at %.17g s", function, t, now);
    } else if (t + h > state->stop_time + rounding) {
        component_refuse(c, "%s: the step ends at %.17g s, after the stop time "
                            "%.17g s", function, t + h, state->stop_time);
    } else if (simulation_effort(h) > LONGEST) {
        component_refuse(c, "%s: a step of %g s would take %g inner steps; at most "
                            "%g are done", function, h, simulation_effort(h), LONGEST);
    } else {
        return 1;
    }
    return 0;
}

int component_step(Component *c, const char *function, double t, double h) {
    if (!component_may(c, function, STEPPING) || !step_fits(c, function, t, h) ||
        !dead_times_fit(c, function))
        return STATUS_ERROR;
    if (!simulation_step(&c->simulation, t, h))
        component_refuse(c, "%s: a delayed input changed too often within its dead time; "
                            "steps of %g s and more always fit",
                         function, M.h_max);
    else if (fit_to_go_on(c, function))
        return STATUS_OK;
    c->simulation.state.phase = FAILED;
    c->simulation.values[M.size - 1] = t; /* the last successful time */
    return STATUS_ERROR;
}
