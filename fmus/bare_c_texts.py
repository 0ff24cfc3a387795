"""The C that a plain C model is filled into (``bare_c``)."""

HEADER = """\
/* {summary}.

       {name} m;
       {name}_init(&m);
       every {num}/{den} s:  set m.u;  {name}_step(&m);  read m.y

   Arrays are stored rows first.  Nothing is allocated; instances are independent.
{single}   Made by feeddrive. */
#ifndef {guard}
#define {guard}

typedef {real} {name}_real;

typedef struct {{
{members}}} {name};

/* Start values everywhere, and what follows from the parameters. */
void {name}_init({name} *m);

/* What follows from the parameters; needed after a change of m->p. */
void {name}_prepare({name} *m);

/* One sample: outputs from inputs and states, then the states move on. */
void {name}_step({name} *m);

#endif
"""
SINGLE = """\
   In float, what counts ticks stays at 16777216, after {:.4g} s.
"""
SOURCE = """\
#include "{name}.h"

#include <string.h>

#define casadi_real {real}
{quiet}
{code}

static const {name}_real sample_time[1] = {{{T_s}}};

void {name}_init({name} *m) {{
    static const {name} start = {{
        {start}}};
    *m = start;
    {name}_prepare(m);
}}

void {name}_prepare({name} *m) {{
    const {name}_real *arg[{sz_arg}] = {{{p}, sample_time}};
    {name}_real *res[{sz_res}] = {{{d}}};
    long long iw[{sz_iw}];
    {name}_real w[{sz_w}];
    (void)m;
    prepare(arg, res, iw, w, 0);
}}

void {name}_step({name} *m) {{
    {name}_real next[{n_x}], w[{sz_w}];
    const {name}_real *arg[{sz_arg}] = {{{x}, {u}, {p}, {d}, sample_time}};
    {name}_real *res[{sz_res}] = {{next, {result}}};
    long long iw[{sz_iw}];
    step(arg, res, iw, w, 0);
    {keep}
}}
"""
STEPS_OF = """\
#include "{name}.h"
#include <string.h>
__attribute__((visibility("default")))
void run_test_vector(int n, const double *u, double *y) {{
    {name} m;
    {name}_init(&m);
    for (int k = 0; k < n; k++, u += {n_u}, y += {n_y}) {{
        {set_u}
        {name}_step(&m);
        memcpy(y, &m.y, {n_y} * sizeof(double));
    }}
}}
"""
TEST = """\
/* Steps {name} through a test vector; outputs are those of the FMU.  Prints how
   many differ in any bit, and the largest error relative to the largest output. */
#include "{name}.h"

#include <math.h>
#include <stdio.h>

static const double inputs[{steps}][{w_u}] = {{
{inputs}}};
static const double outputs[{steps}][{n_y}] = {{
{outputs}}};

int main(void) {{
    static {name} m;
    int k, i, differing = 0;
    double largest = 0, error = 0;
    {name}_init(&m);
    for (k = 0; k < {steps}; k++) {{
        for (i = 0; i < {n_u}; i++)
            {assign}
        {name}_step(&m);
        for (i = 0; i < {n_y}; i++) {{
            double y = (double)((const {name}_real *)&m.y)[i];
            differing += y != outputs[k][i];
            error = fmax(error, fabs(y - outputs[k][i]));
            largest = fmax(largest, fabs(outputs[k][i]));
        }}
    }}
    printf("%d differ, largest error %.2g\\n", differing,
           largest > 0 ? error / largest : error);
    return differing != 0 && sizeof({name}_real) == sizeof(double);
}}
"""
