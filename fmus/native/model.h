/* What the generated model_data.c tells the adapters about one model.

   All values of an instance lie in one vector; a value reference is an index:

       parameters | inputs | outputs | states | derivatives | T_s | time

   Equations are CasADi functions; an argument they do not need may be NULL, a
   result always has a place:

       prepare(p, T_s) -> d
       step(x, u, p, d, T_s) -> (x_next, y)      sampled
       derivative(x, u, p, d) -> der_x           continuous
       output(x, u, p, d) -> y                   continuous
       advance(x, u, p, d, h) -> x_next          continuous, or NULL
       tangent(x, u, p, d, T_s, dx, du) -> (d_der_x, d_y)     or NULL */
#ifndef MODEL_H
#define MODEL_H

#include "names.h"

typedef int Equation(const double **arg, double **res, long long *iw,
                     double *w, int mem);

/* Read what the model needs from its resources; return why not, or NULL. */
typedef const char *Open(const char *resources);

typedef enum { PARAMETER, INPUT, OUTPUT, STATE, DERIVATIVE, PERIOD, TIME } Block;

typedef struct {
    const char *name;
    unsigned reference; /* of the first element */
    unsigned size;      /* number of elements, rows first */
    Block block;
    int boolean, constant, fixed;
} Variable;

/* One delayed element of an input and the parameter with its dead time (s). */
typedef struct {
    unsigned input, dead_time;
    unsigned capacity; /* changes that fit into its line from the start */
} Delay;

typedef struct {
    const char *identifier, *token;
    const Variable *variables;
    const unsigned *variable_of; /* index into variables, per reference */
    const double *start;         /* per reference */
    const double *nominal;       /* per state */
    unsigned size;               /* of the vector, time included */
    unsigned u, y, x, der_x, T_s; /* first reference of each block */
    unsigned n_u, n_y, n_x, n_d;
    int continuous;
    int clock; /* the model has an input clock; sampled */
    double h_max;                     /* longest substep (s); continuous */
    long long period_num, period_den; /* T_s as a fraction (s); sampled */
    const Delay *delays;
    unsigned n_delays;
    Equation *prepare, *step, *derivative, *output, *advance, *tangent;
    Open *open; /* or NULL */
    unsigned sz_arg, sz_res, sz_iw, sz_w; /* work vectors of the equations */
} Model;

extern const Model feeddrive_model;

#ifdef FEEDDRIVE_INSTANCES /* no heap, but a pool of that many places */
#include <stddef.h>
extern double feeddrive_pool[];
extern const size_t feeddrive_place; /* doubles of one place */
#endif

#endif
