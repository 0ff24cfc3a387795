/* The whole FMU as one translation unit, in C99 or C++. */
#include "component.h" /* first: it may set the prefix */

#include "component.c"
#include "delay.c"
#include "derivatives.c"
#include "fmi2.c"
#include "fmi2_interfaces.c"
#include "fmi3.c"
#include "fmi3_absent.c"
#include "fmi3_clocks.c"
#include "fmi3_values.c"
#include "memory.c"
#include "simulation.c"
#include "snapshot.c"
#include "values.c"
#include "model_data.c"
