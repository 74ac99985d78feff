/* The functions of FMI 3.0 for co-simulation; see instance.h.
 *
 * The declarations follow the standard (https://fmi-standard.org), rewritten for the part of it
 * that is used here. A program that has the standard's header fmi3Functions.h includes it first,
 * and it replaces them. If several FMUs are linked into one program, define FMI3_FUNCTION_PREFIX
 * as the standard says: a prefix for the names of all functions.
 */
#include "instance.h"

#ifndef fmi3Functions_h

#include <stdbool.h>
#include <stdint.h>

#ifdef FMI3_FUNCTION_PREFIX
#define JOINED(prefix, name) prefix##name
#define PREFIXED(prefix, name) JOINED(prefix, name)
#define FMI3(name) PREFIXED(FMI3_FUNCTION_PREFIX, name)
#else
#define FMI3(name) name
#endif

#if defined _WIN32 || defined __CYGWIN__
#define FMI3_Export __declspec(dllexport)
#elif defined __GNUC__
#define FMI3_Export __attribute__((visibility("default")))
#else
#define FMI3_Export
#endif

#define fmi3True true
#define fmi3False false

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef char fmi3Char;
typedef const fmi3Char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;
typedef enum {
    fmi3IntervalNotYetKnown,
    fmi3IntervalUnchanged,
    fmi3IntervalChanged
} fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

#else
#define FMI3(name) name
#endif

#define CO_SIMULATION_ONLY "this FMU is for co-simulation only"
#define NO_EVENTS "this FMU has no events: start it without event mode"
#define NO_CLOCKS "this FMU has no clocks"
#define NOTHING_STRUCTURAL "this FMU has no structural parameters"

/* The value reference of the time comes after those of all other variables. */
#define TIME MODEL_VALUES

typedef struct {
    instance it;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} component;

static void tell(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, const char *why)
{
    if (log) {
        log(environment, fmi3Error, "logStatusError", why);
    }
}

static fmi3Status refused(fmi3Instance instance, const char *why)
{
    component *c = instance;
    tell(c->environment, c->log, why);
    return fmi3Error;
}

/* Return the status for success or failure. */
static fmi3Status status_of(component *c, int went)
{
    return went ? fmi3OK : refused(c, c->it.problem);
}

static fmi3Status not_here(fmi3Instance instance, size_t count, const char *why)
{
    return count == 0 ? fmi3OK : refused(instance, why);
}

FMI3_Export const char *FMI3(fmi3GetVersion)(void)
{
    return "3.0";
}

FMI3_Export fmi3Status FMI3(fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean loggingOn,
                                                 size_t nCategories, const fmi3String categories[])
{
    /* Only errors are logged, and they always are. */
    (void)instance;
    (void)loggingOn;
    (void)nCategories;
    (void)categories;
    return fmi3OK;
}

FMI3_Export fmi3Instance FMI3(fmi3InstantiateModelExchange)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage)
{
    (void)instanceName;
    (void)instantiationToken;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    tell(instanceEnvironment, logMessage, CO_SIMULATION_ONLY);
    return NULL;
}

FMI3_Export fmi3Instance FMI3(fmi3InstantiateScheduledExecution)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
    fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName;
    (void)instantiationToken;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    tell(instanceEnvironment, logMessage, CO_SIMULATION_ONLY);
    return NULL;
}

FMI3_Export fmi3Instance FMI3(fmi3InstantiateCoSimulation)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    const char *why = NULL;
    component *c;
    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)intermediateUpdate;
    if (!instantiationToken || strcmp(instantiationToken, MODEL_GUID) != 0) {
        why = "modelDescription.xml belongs to another FMU: its instantiation token differs";
    } else if (eventModeUsed) {
        why = NO_EVENTS;
    } else if (nRequiredIntermediateVariables > 0) {
        why = "this FMU has no values between communication points";
    }
    if (why) {
        tell(instanceEnvironment, logMessage, why);
        return NULL;
    }
    c = malloc(sizeof *c);
    if (!c) {
        return NULL;
    }
    c->environment = instanceEnvironment;
    c->log = logMessage;
    reset_instance(&c->it);
    return c;
}

FMI3_Export void FMI3(fmi3FreeInstance)(fmi3Instance instance)
{
    free(instance);
}

FMI3_Export fmi3Status FMI3(fmi3EnterInitializationMode)(fmi3Instance instance,
                                                         fmi3Boolean toleranceDefined,
                                                         fmi3Float64 tolerance,
                                                         fmi3Float64 startTime,
                                                         fmi3Boolean stopTimeDefined,
                                                         fmi3Float64 stopTime)
{
    component *c = instance;
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    if (!enter_initialization(&c->it)) {
        return status_of(c, 0);
    }
    c->it.now.start_time = c->it.now.time = startTime;
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3ExitInitializationMode)(fmi3Instance instance)
{
    component *c = instance;
    return status_of(c, exit_initialization(&c->it));
}

FMI3_Export fmi3Status FMI3(fmi3EnterEventMode)(fmi3Instance instance)
{
    return refused(instance, NO_EVENTS);
}

FMI3_Export fmi3Status FMI3(fmi3EnterStepMode)(fmi3Instance instance)
{
    return refused(instance, NO_EVENTS);
}

FMI3_Export fmi3Status FMI3(fmi3Terminate)(fmi3Instance instance)
{
    component *c = instance;
    c->it.now.phase = TERMINATED;
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3Reset)(fmi3Instance instance)
{
    component *c = instance;
    reset_instance(&c->it);
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3GetFloat64)(fmi3Instance instance,
                                            const fmi3ValueReference valueReferences[],
                                            size_t nValueReferences, fmi3Float64 values[],
                                            size_t nValues)
{
    component *c = instance;
    size_t i;
    if (nValues != nValueReferences) {
        return refused(c, "each variable of this FMU has one value");
    }
    for (i = 0; i < nValues; i++) {
        if (valueReferences[i] == TIME) {
            values[i] = c->it.now.time;
        } else if (!get_values(&c->it, valueReferences + i, 1, values + i)) {
            return status_of(c, 0);
        }
    }
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3SetFloat64)(fmi3Instance instance,
                                            const fmi3ValueReference valueReferences[],
                                            size_t nValueReferences, const fmi3Float64 values[],
                                            size_t nValues)
{
    component *c = instance;
    if (nValues != nValueReferences) {
        return refused(c, "each variable of this FMU has one value");
    }
    return status_of(c, set_values(&c->it, valueReferences, nValues, values));
}

/* Values of the other types. No variable has these types. */
#define NONE_OF(type)                                                                             \
    FMI3_Export fmi3Status FMI3(fmi3Get##type)(fmi3Instance instance,                              \
                                               const fmi3ValueReference valueReferences[],         \
                                               size_t nValueReferences, fmi3##type values[],       \
                                               size_t nValues)                                     \
    {                                                                                              \
        (void)valueReferences;                                                                     \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        return not_here(instance, nValueReferences, REAL_ONLY);                                    \
    }                                                                                              \
    FMI3_Export fmi3Status FMI3(fmi3Set##type)(fmi3Instance instance,                              \
                                               const fmi3ValueReference valueReferences[],         \
                                               size_t nValueReferences, const fmi3##type values[], \
                                               size_t nValues)                                     \
    {                                                                                              \
        (void)valueReferences;                                                                     \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        return not_here(instance, nValueReferences, REAL_ONLY);                                    \
    }

NONE_OF(Float32)
NONE_OF(Int8)
NONE_OF(UInt8)
NONE_OF(Int16)
NONE_OF(UInt16)
NONE_OF(Int32)
NONE_OF(UInt32)
NONE_OF(Int64)
NONE_OF(UInt64)
NONE_OF(Boolean)
NONE_OF(String)

FMI3_Export fmi3Status FMI3(fmi3GetBinary)(fmi3Instance instance,
                                           const fmi3ValueReference valueReferences[],
                                           size_t nValueReferences, size_t valueSizes[],
                                           fmi3Binary values[], size_t nValues)
{
    (void)valueReferences;
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return not_here(instance, nValueReferences, REAL_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3SetBinary)(fmi3Instance instance,
                                           const fmi3ValueReference valueReferences[],
                                           size_t nValueReferences, const size_t valueSizes[],
                                           const fmi3Binary values[], size_t nValues)
{
    (void)valueReferences;
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return not_here(instance, nValueReferences, REAL_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3GetClock)(fmi3Instance instance,
                                          const fmi3ValueReference valueReferences[],
                                          size_t nValueReferences, fmi3Clock values[])
{
    (void)valueReferences;
    (void)values;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3SetClock)(fmi3Instance instance,
                                          const fmi3ValueReference valueReferences[],
                                          size_t nValueReferences, const fmi3Clock values[])
{
    (void)valueReferences;
    (void)values;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3GetNumberOfVariableDependencies)(fmi3Instance instance,
                                                                 fmi3ValueReference valueReference,
                                                                 size_t *nDependencies)
{
    (void)valueReference;
    (void)nDependencies;
    return refused(instance, "modelDescription.xml says what depends on what");
}

FMI3_Export fmi3Status FMI3(fmi3GetVariableDependencies)(
    fmi3Instance instance, fmi3ValueReference dependent, size_t elementIndicesOfDependent[],
    fmi3ValueReference independents[], size_t elementIndicesOfIndependents[],
    fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    (void)dependent;
    (void)elementIndicesOfDependent;
    (void)independents;
    (void)elementIndicesOfIndependents;
    (void)dependencyKinds;
    (void)nDependencies;
    return refused(instance, "modelDescription.xml says what depends on what");
}

FMI3_Export fmi3Status FMI3(fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *FMUState)
{
    component *c = instance;
    if (!*FMUState) {
        *FMUState = malloc(sizeof(snapshot));
    }
    if (!*FMUState) {
        return refused(c, "there is no memory for a state");
    }
    memcpy(*FMUState, &c->it.now, sizeof(snapshot));
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState FMUState)
{
    component *c = instance;
    memcpy(&c->it.now, FMUState, sizeof(snapshot));
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    if (FMUState) {
        free(*FMUState);
        *FMUState = NULL;
    }
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3SerializedFMUStateSize)(fmi3Instance instance,
                                                        fmi3FMUState FMUState, size_t *size)
{
    (void)instance;
    (void)FMUState;
    *size = sizeof(snapshot);
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState FMUState,
                                                   fmi3Byte serializedState[], size_t size)
{
    if (size < sizeof(snapshot)) {
        return refused(instance, "there is too little room for a state");
    }
    memcpy(serializedState, FMUState, sizeof(snapshot));
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3DeserializeFMUState)(fmi3Instance instance,
                                                     const fmi3Byte serializedState[], size_t size,
                                                     fmi3FMUState *FMUState)
{
    if (size != sizeof(snapshot)) {
        return refused(instance, "the bytes are no state of this FMU");
    }
    if (!*FMUState) {
        *FMUState = malloc(sizeof(snapshot));
    }
    if (!*FMUState) {
        return refused(instance, "there is no memory for a state");
    }
    memcpy(*FMUState, serializedState, sizeof(snapshot));
    return fmi3OK;
}

FMI3_Export fmi3Status FMI3(fmi3GetDirectionalDerivative)(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)unknowns;
    (void)knowns;
    (void)nKnowns;
    (void)seed;
    (void)nSeed;
    (void)sensitivity;
    (void)nSensitivity;
    return not_here(instance, nUnknowns, NO_DERIVATIVES);
}

FMI3_Export fmi3Status FMI3(fmi3GetAdjointDerivative)(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)unknowns;
    (void)knowns;
    (void)nKnowns;
    (void)seed;
    (void)nSeed;
    (void)sensitivity;
    (void)nSensitivity;
    return not_here(instance, nUnknowns, NO_DERIVATIVES);
}

FMI3_Export fmi3Status FMI3(fmi3GetOutputDerivatives)(fmi3Instance instance,
                                                      const fmi3ValueReference valueReferences[],
                                                      size_t nValueReferences,
                                                      const fmi3Int32 orders[],
                                                      fmi3Float64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)orders;
    (void)values;
    (void)nValues;
    return not_here(instance, nValueReferences, NO_DERIVATIVES);
}

FMI3_Export fmi3Status FMI3(fmi3EnterConfigurationMode)(fmi3Instance instance)
{
    return refused(instance, NOTHING_STRUCTURAL);
}

FMI3_Export fmi3Status FMI3(fmi3ExitConfigurationMode)(fmi3Instance instance)
{
    return refused(instance, NOTHING_STRUCTURAL);
}

FMI3_Export fmi3Status FMI3(fmi3GetIntervalDecimal)(fmi3Instance instance,
                                                    const fmi3ValueReference valueReferences[],
                                                    size_t nValueReferences,
                                                    fmi3Float64 intervals[],
                                                    fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences;
    (void)intervals;
    (void)qualifiers;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3GetIntervalFraction)(fmi3Instance instance,
                                                     const fmi3ValueReference valueReferences[],
                                                     size_t nValueReferences, fmi3UInt64 counters[],
                                                     fmi3UInt64 resolutions[],
                                                     fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3GetShiftDecimal)(fmi3Instance instance,
                                                 const fmi3ValueReference valueReferences[],
                                                 size_t nValueReferences, fmi3Float64 shifts[])
{
    (void)valueReferences;
    (void)shifts;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3GetShiftFraction)(fmi3Instance instance,
                                                  const fmi3ValueReference valueReferences[],
                                                  size_t nValueReferences, fmi3UInt64 counters[],
                                                  fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3SetIntervalDecimal)(fmi3Instance instance,
                                                    const fmi3ValueReference valueReferences[],
                                                    size_t nValueReferences,
                                                    const fmi3Float64 intervals[])
{
    (void)valueReferences;
    (void)intervals;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3SetIntervalFraction)(fmi3Instance instance,
                                                     const fmi3ValueReference valueReferences[],
                                                     size_t nValueReferences,
                                                     const fmi3UInt64 counters[],
                                                     const fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3SetShiftDecimal)(fmi3Instance instance,
                                                 const fmi3ValueReference valueReferences[],
                                                 size_t nValueReferences,
                                                 const fmi3Float64 shifts[])
{
    (void)valueReferences;
    (void)shifts;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3SetShiftFraction)(fmi3Instance instance,
                                                  const fmi3ValueReference valueReferences[],
                                                  size_t nValueReferences,
                                                  const fmi3UInt64 counters[],
                                                  const fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    return not_here(instance, nValueReferences, NO_CLOCKS);
}

FMI3_Export fmi3Status FMI3(fmi3EvaluateDiscreteStates)(fmi3Instance instance)
{
    return refused(instance, NO_EVENTS);
}

FMI3_Export fmi3Status FMI3(fmi3UpdateDiscreteStates)(fmi3Instance instance,
                                                      fmi3Boolean *discreteStatesNeedUpdate,
                                                      fmi3Boolean *terminateSimulation,
                                                      fmi3Boolean *nominalsOfContinuousStatesChanged,
                                                      fmi3Boolean *valuesOfContinuousStatesChanged,
                                                      fmi3Boolean *nextEventTimeDefined,
                                                      fmi3Float64 *nextEventTime)
{
    (void)discreteStatesNeedUpdate;
    (void)terminateSimulation;
    (void)nominalsOfContinuousStatesChanged;
    (void)valuesOfContinuousStatesChanged;
    (void)nextEventTimeDefined;
    (void)nextEventTime;
    return refused(instance, NO_EVENTS);
}

FMI3_Export fmi3Status FMI3(fmi3DoStep)(fmi3Instance instance,
                                        fmi3Float64 currentCommunicationPoint,
                                        fmi3Float64 communicationStepSize,
                                        fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                        fmi3Boolean *eventHandlingNeeded,
                                        fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn,
                                        fmi3Float64 *lastSuccessfulTime)
{
    component *c = instance;
    int went = move_on(&c->it, currentCommunicationPoint, communicationStepSize);
    (void)noSetFMUStatePriorToCurrentPoint;
    *eventHandlingNeeded = fmi3False;
    *terminateSimulation = fmi3False;
    *earlyReturn = fmi3False;
    *lastSuccessfulTime = c->it.now.time;
    return status_of(c, went);
}

/* Functions for other kinds of simulation exist as well, because importers load all functions. */

FMI3_Export fmi3Status FMI3(fmi3EnterContinuousTimeMode)(fmi3Instance instance)
{
    return refused(instance, CO_SIMULATION_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3CompletedIntegratorStep)(
    fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
    fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    (void)enterEventMode;
    (void)terminateSimulation;
    return refused(instance, CO_SIMULATION_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3SetTime)(fmi3Instance instance, fmi3Float64 time)
{
    (void)time;
    return refused(instance, CO_SIMULATION_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3SetContinuousStates)(fmi3Instance instance,
                                                     const fmi3Float64 continuousStates[],
                                                     size_t nContinuousStates)
{
    (void)continuousStates;
    (void)nContinuousStates;
    return refused(instance, CO_SIMULATION_ONLY);
}

/* Functions for external integrators, which have nothing to integrate here. */
#define NO_ARRAY(name)                                                                             \
    FMI3_Export fmi3Status FMI3(name)(fmi3Instance instance, fmi3Float64 values[], size_t count)    \
    {                                                                                              \
        (void)values;                                                                              \
        (void)count;                                                                               \
        return refused(instance, CO_SIMULATION_ONLY);                                              \
    }

NO_ARRAY(fmi3GetContinuousStateDerivatives)
NO_ARRAY(fmi3GetEventIndicators)
NO_ARRAY(fmi3GetContinuousStates)
NO_ARRAY(fmi3GetNominalsOfContinuousStates)

FMI3_Export fmi3Status FMI3(fmi3GetNumberOfEventIndicators)(fmi3Instance instance,
                                                            size_t *nEventIndicators)
{
    (void)nEventIndicators;
    return refused(instance, CO_SIMULATION_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3GetNumberOfContinuousStates)(fmi3Instance instance,
                                                             size_t *nContinuousStates)
{
    (void)nContinuousStates;
    return refused(instance, CO_SIMULATION_ONLY);
}

FMI3_Export fmi3Status FMI3(fmi3ActivateModelPartition)(fmi3Instance instance,
                                                        fmi3ValueReference clockReference,
                                                        fmi3Float64 activationTime)
{
    (void)clockReference;
    (void)activationTime;
    return refused(instance, CO_SIMULATION_ONLY);
}
