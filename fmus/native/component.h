/* What FMI 2.0 and 3.0 have in common: phases, permissions, messages, states.

   Every refusal leaves the component as it was, returns STATUS_ERROR and logs
   one sentence that names the instance, the variable and what was expected.
   Only a step that fails spoils the component: then it can be reset, freed or
   given an earlier state.  Statuses are numbered as in both standards. */
#ifndef COMPONENT_H
#define COMPONENT_H

#include "simulation.h"

enum { STATUS_OK = 0, STATUS_ERROR = 3 };

/* Phases are bits, so that a function can name all in which it is allowed. */
enum {
    INSTANTIATED = 1,
    INITIALIZING = 2,
    STEPPING = 4,
    EVENT = 8,
    CONTINUOUS_TIME = 16,
    TERMINATED = 32,
    FAILED = 64,
    EXCHANGING = EVENT | CONTINUOUS_TIME,
    RUNNING = STEPPING | EXCHANGING,
    SOUND = INSTANTIATED | INITIALIZING | RUNNING | TERMINATED,
    ANY = SOUND | FAILED
};

typedef struct Component Component;
typedef void Log(void *environment, void (*callback)(void), const char *instance,
                 int status, const char *category, const char *message);

struct Component {
    Simulation simulation;
    const char *name;
    int model_exchange, logging;
    Log *log; /* hands a message to the importer's callback */
    void (*callback)(void);
    void *environment;
};

/* What FMI calls an instance. */
#define OF(instance) ((Component *)(instance))

/* Create an instance, or log why not and return NULL. */
Component *component_new(const char *name, const char *token, int model_exchange,
                         int logging, Log *log, void (*callback)(void),
                         void *environment);
/* Let the model read what it needs from the folder of resources (URI or path);
   free the component and return NULL with a message if it cannot. */
Component *component_opened(Component *c, const char *resources);
void component_free(Component *c);

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int component_refuse(Component *c, const char *format, ...);

/* Tell whether function may be called now; log why not. */
int component_may(Component *c, const char *function, int phases);

/* Tell whether there is an array if it is to have elements; log that it is NULL. */
int component_given(Component *c, const char *function, size_t n, const void *array);

int component_set_logging(Component *c, const char *function, int on,
                          size_t n, const char *const categories[]);

/* Phase changes; start and stop in s, stop infinite if not defined. */
int component_set_times(Component *c, const char *function, double start,
                        double stop);
int component_exit_initialization(Component *c, const char *function);

/* Make room for a dead time of tau (s) of delay i; returns 0 if there is none. */
int component_reserve(Component *c, const char *function, unsigned i, double tau);

int component_move(Component *c, const char *function, int from, int to);
int component_reset(Component *c, const char *function);

/* Event mode: clocked instances enter it from stepping, others from exchanging;
   an update runs the tick of an active clock. */
int component_enter_events(Component *c, const char *function);
int component_leave_events(Component *c, const char *function);
int component_update(Component *c, const char *function);

int component_step(Component *c, const char *function, double t, double h);

/* The variable a reference belongs to, or NULL with a message that it does not
   exist or is of the other type. */
const Variable *component_find(Component *c, const char *function,
                               unsigned reference, int boolean);

/* Tell whether variable may be set now to the n values; log why not. */
int component_may_set(Component *c, const char *function,
                      const Variable *variable, const double *values, size_t n);

/* Set n values from reference on; the caller has asked component_may_set. */
void component_set(Component *c, unsigned reference, const double *values,
                   size_t n);

/* All values, outputs up to date as far as the phase wants them. */
const double *component_values(Component *c);

/* Refuse a get or set of a type of which the model has no variables. */
int component_no_type(Component *c, const char *function, size_t n,
                      unsigned reference);

/* Model exchange; the states of a sampled model are none of its. */
unsigned component_continuous_states(void);
int component_set_states(Component *c, const char *function, const double *x,
                         size_t n);
int component_get_block(Component *c, const char *function, unsigned first,
                        double *values, size_t n);
int component_get_nominals(Component *c, const char *function, double *nominal,
                           size_t n);
int component_set_time(Component *c, const char *function, double time);

/* Directional derivatives: begin, seed the knowns (inputs and states), evaluate,
   ask for unknowns (outputs and derivatives).  They return 0 with a message. */
int component_direction_begin(Component *c, const char *function);
int component_direction_seed(Component *c, const char *function, unsigned reference,
                             double seed);
void component_direction(Component *c);
int component_direction_of(Component *c, const char *function, unsigned reference,
                           double *sensitivity);

/* FMU states: one block of memory, the same in memory and on disk. */
int snapshot_take(Component *c, const char *function, void **snapshot);
int snapshot_restore(Component *c, const char *function, const void *snapshot);
int snapshot_release(Component *c, const char *function, void **snapshot);
int snapshot_size(Component *c, const char *function, const void *snapshot,
                  size_t *size);
int snapshot_write(Component *c, const char *function, const void *snapshot,
                   unsigned char *bytes, size_t size);
int snapshot_read(Component *c, const char *function, const unsigned char *bytes,
                  size_t size, void **snapshot);

#endif
