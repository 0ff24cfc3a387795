/* FMI 3.0: getting and setting.  A value reference names a whole variable and
   takes as many values as that has elements, rows first. */
#include "component.h" /* first: it may set the prefix */

#include "fmi3Functions.h"

/* The variable of a reference if it has room in the values that are left. */
static const Variable *whole(Component *c, const char *function,
                             fmi3ValueReference reference, int boolean,
                             size_t left) {
    const Variable *v = component_find(c, function, reference, boolean);
    if (!v)
        return NULL;
    if (v->reference != reference) {
        component_refuse(c, "%s: value reference %u lies inside %s, which has %u",
                         function, (unsigned)reference, v->name, v->reference);
        return NULL;
    }
    if (v->size > left) {
        component_refuse(c, "%s: %s has %u values, but only %lu were given", function,
                         v->name, v->size, (unsigned long)left);
        return NULL;
    }
    return v;
}

static unsigned size_of(fmi3ValueReference reference) {
    return feeddrive_model.variables[feeddrive_model.variable_of[reference]].size;
}

static fmi3Status all_used(Component *c, const char *function, size_t left) {
    if (!left)
        return fmi3OK;
    return (fmi3Status)component_refuse(c, "%s: %lu values more than the variables have",
                            function, (unsigned long)left);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance,
                          const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Float64 values[],
                          size_t nValues) {
    const char *function = "fmi3GetFloat64";
    if (!component_may(OF(instance), function, ANY) ||
        !component_given(OF(instance), function, nValueReferences, valueReferences) ||
        !component_given(OF(instance), function, nValues, values))
        return fmi3Error;
    const double *from = component_values(OF(instance));
    for (size_t i = 0; i < nValueReferences; i++) {
        const Variable *v = whole(OF(instance), function, valueReferences[i], 0, nValues);
        if (!v)
            return fmi3Error;
        for (unsigned k = 0; k < v->size; k++)
            *values++ = from[v->reference + k];
        nValues -= v->size;
    }
    return all_used(OF(instance), function, nValues);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance,
                          const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Float64 values[],
                          size_t nValues) {
    const char *function = "fmi3SetFloat64";
    const fmi3Float64 *next = values;
    if (!component_may(OF(instance), function, SOUND) ||
        !component_given(OF(instance), function, nValueReferences, valueReferences) ||
        !component_given(OF(instance), function, nValues, values))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        const Variable *v = whole(OF(instance), function, valueReferences[i], 0, nValues);
        if (!v || !component_may_set(OF(instance), function, v, next, v->size))
            return fmi3Error;
        next += v->size;
        nValues -= v->size;
    }
    if (all_used(OF(instance), function, nValues) != fmi3OK)
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        unsigned size = size_of(valueReferences[i]);
        component_set(OF(instance), valueReferences[i], values, size);
        values += size;
    }
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance,
                          const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Boolean values[],
                          size_t nValues) {
    const char *function = "fmi3GetBoolean";
    if (!component_may(OF(instance), function, ANY) ||
        !component_given(OF(instance), function, nValueReferences, valueReferences) ||
        !component_given(OF(instance), function, nValues, values))
        return fmi3Error;
    const double *from = component_values(OF(instance));
    for (size_t i = 0; i < nValueReferences; i++) {
        const Variable *v = whole(OF(instance), function, valueReferences[i], 1, nValues);
        if (!v)
            return fmi3Error;
        for (unsigned k = 0; k < v->size; k++)
            *values++ = from[v->reference + k] != 0;
        nValues -= v->size;
    }
    return all_used(OF(instance), function, nValues);
}

fmi3Status fmi3SetBoolean(fmi3Instance instance,
                          const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Boolean values[],
                          size_t nValues) {
    const char *function = "fmi3SetBoolean";
    if (!component_may(OF(instance), function, SOUND) ||
        !component_given(OF(instance), function, nValueReferences, valueReferences) ||
        !component_given(OF(instance), function, nValues, values))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        const Variable *v = whole(OF(instance), function, valueReferences[i], 1, nValues);
        if (!v || !component_may_set(OF(instance), function, v, NULL, 0))
            return fmi3Error;
        nValues -= v->size;
    }
    if (all_used(OF(instance), function, nValues) != fmi3OK)
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        unsigned size = size_of(valueReferences[i]);
        for (unsigned k = 0; k < size; k++) {
            double number = *values++ ? 1.0 : 0.0;
            component_set(OF(instance), valueReferences[i] + k, &number, 1);
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance,
                                        const fmi3ValueReference unknowns[],
                                        size_t nUnknowns,
                                        const fmi3ValueReference knowns[],
                                        size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[],
                                        size_t nSensitivity) {
    const char *function = "fmi3GetDirectionalDerivative";
    Component *c = OF(instance);
    const Variable *v;
    size_t i;
    unsigned k;
    if (!component_direction_begin(c, function) ||
        !component_given(c, function, nUnknowns, unknowns) ||
        !component_given(c, function, nKnowns, knowns) ||
        !component_given(c, function, nSeed, seed) ||
        !component_given(c, function, nSensitivity, sensitivity))
        return fmi3Error;
    for (i = 0; i < nKnowns; i++) {
        if (!(v = whole(c, function, knowns[i], 0, nSeed)))
            return fmi3Error;
        for (k = 0; k < v->size; k++)
            if (!component_direction_seed(c, function, knowns[i] + k, *seed++))
                return fmi3Error;
        nSeed -= v->size;
    }
    component_direction(c);
    for (i = 0; i < nUnknowns; i++) {
        if (!(v = whole(c, function, unknowns[i], 0, nSensitivity)))
            return fmi3Error;
        for (k = 0; k < v->size; k++)
            if (!component_direction_of(c, function, unknowns[i] + k, sensitivity++))
                return fmi3Error;
        nSensitivity -= v->size;
    }
    return all_used(c, function, nSeed + nSensitivity);
}
