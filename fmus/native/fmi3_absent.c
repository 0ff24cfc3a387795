/* FMI 3.0: functions of which the description says that they are not supported,
   and types of which there are no variables. */
#include "component.h" /* first: it may set the prefix */

#include "fmi3Functions.h"

static fmi3Status fmi3_absent(fmi3Instance instance, const char *function) {
    if (!component_may(OF(instance), function, ANY))
        return fmi3Error;
    return (fmi3Status)component_refuse(OF(instance), "%s is not supported", function);
}

static fmi3Status fmi3_no_type(fmi3Instance instance, const char *function,
                          const fmi3ValueReference valueReferences[], size_t n) {
    if (!component_may(OF(instance), function, ANY) ||
        !component_given(OF(instance), function, n, valueReferences))
        return fmi3Error;
    return (fmi3Status)component_no_type(OF(instance), function, n, n ? valueReferences[0] : 0);
}

#define NO_TYPE(Type)                                                            \
    fmi3Status fmi3Get##Type(fmi3Instance instance,                              \
                             const fmi3ValueReference valueReferences[],         \
                             size_t nValueReferences, fmi3##Type values[],       \
                             size_t nValues) {                                   \
        return fmi3_no_type(instance, "fmi3Get" #Type, valueReferences,               \
                       nValueReferences);                                        \
    }                                                                            \
    fmi3Status fmi3Set##Type(fmi3Instance instance,                              \
                             const fmi3ValueReference valueReferences[],         \
                             size_t nValueReferences, const fmi3##Type values[], \
                             size_t nValues) {                                   \
        return fmi3_no_type(instance, "fmi3Set" #Type, valueReferences,               \
                       nValueReferences);                                        \
    }

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(Int32)
NO_TYPE(UInt32)
NO_TYPE(Int64)
NO_TYPE(UInt64)
NO_TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance instance,
                         const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, size_t valueSizes[],
                         fmi3Binary values[], size_t nValues) {
    return fmi3_no_type(instance, "fmi3GetBinary", valueReferences, nValueReferences);
}

fmi3Status fmi3SetBinary(fmi3Instance instance,
                         const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, const size_t valueSizes[],
                         const fmi3Binary values[], size_t nValues) {
    return fmi3_no_type(instance, "fmi3SetBinary", valueReferences, nValueReferences);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance,
                                               fmi3ValueReference valueReference,
                                               size_t* nDependencies) {
    return fmi3_absent(instance, "fmi3GetNumberOfVariableDependencies");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance,
                                       fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[],
                                       fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[],
                                       size_t nDependencies) {
    return fmi3_absent(instance, "fmi3GetVariableDependencies");
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance,
                                    const fmi3ValueReference unknowns[],
                                    size_t nUnknowns,
                                    const fmi3ValueReference knowns[],
                                    size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[],
                                    size_t nSensitivity) {
    return fmi3_absent(instance, "fmi3GetAdjointDerivative");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    return fmi3_absent(instance, "fmi3EnterConfigurationMode");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    return fmi3_absent(instance, "fmi3ExitConfigurationMode");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance,
                                  const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences,
                                  const fmi3Float64 intervals[]) {
    return fmi3_absent(instance, "fmi3SetIntervalDecimal");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance,
                                   const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences,
                                   const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
    return fmi3_absent(instance, "fmi3SetIntervalFraction");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance,
                               const fmi3ValueReference valueReferences[],
                               size_t nValueReferences,
                               const fmi3Float64 shifts[]) {
    return fmi3_absent(instance, "fmi3SetShiftDecimal");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance,
                                const fmi3ValueReference valueReferences[],
                                size_t nValueReferences,
                                const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
    return fmi3_absent(instance, "fmi3SetShiftFraction");
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    return fmi3_absent(instance, "fmi3EvaluateDiscreteStates");
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance,
                                    const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences,
                                    const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
    return fmi3_absent(instance, "fmi3GetOutputDerivatives");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance,
                                      fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
    return fmi3_absent(instance, "fmi3ActivateModelPartition");
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance,
                                  fmi3Float64 eventIndicators[],
                                  size_t nEventIndicators) {
    return nEventIndicators ? fmi3_absent(instance, "fmi3GetEventIndicators") : fmi3OK;
}
