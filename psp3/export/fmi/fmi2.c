/* The functions of FMI 2.0 for co-simulation; see instance.h.
 *
 * The declarations follow the standard (https://fmi-standard.org), rewritten for the part of it
 * that is used here. A program that has the standard's header fmi2Functions.h includes it first,
 * and it replaces them. If several FMUs are linked into one program, define FMI2_FUNCTION_PREFIX
 * as the standard says: a prefix for the names of all functions.
 */
#include "instance.h"

#ifndef fmi2Functions_h

#ifdef FMI2_FUNCTION_PREFIX
#define JOINED(prefix, name) prefix##name
#define PREFIXED(prefix, name) JOINED(prefix, name)
#define FMI2(name) PREFIXED(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI2(name) name
#endif

#if defined _WIN32 || defined __CYGWIN__
#define FMI2_Export __declspec(dllexport)
#elif defined __GNUC__
#define FMI2_Export __attribute__((visibility("default")))
#else
#define FMI2_Export
#endif

#define fmi2True 1
#define fmi2False 0

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
    fmi2DoStepStatus,
    fmi2PendingStatus,
    fmi2LastSuccessfulTime,
    fmi2Terminated
} fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String,
                                   fmi2String, ...);
typedef void *(*fmi2CallbackAllocateMemory)(size_t, size_t);
typedef void (*fmi2CallbackFreeMemory)(void *);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment, fmi2Status);

typedef struct {
    const fmi2CallbackLogger logger;
    const fmi2CallbackAllocateMemory allocateMemory;
    const fmi2CallbackFreeMemory freeMemory;
    const fmi2StepFinished stepFinished;
    const fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#else
#define FMI2(name) name
#endif

typedef struct {
    instance it;
    const fmi2CallbackFunctions *callbacks;
    char *name;
} component;

/* Log the reason of an error. The text is passed as the format itself, because some importing
 * programs do not fill in further arguments. */
static void tell(const fmi2CallbackFunctions *callbacks, fmi2String name, const char *why)
{
    char words[2 * sizeof ((instance *)0)->problem];
    size_t length = 0;
    if (!callbacks->logger) {
        return;
    }
    for (; *why && length + 2 < sizeof words; why++) {
        if (*why == '%') {
            words[length++] = '%';
        }
        words[length++] = *why;
    }
    words[length] = '\0';
    callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "logStatusError", words);
}

static fmi2Status refused(component *c, const char *why)
{
    tell(c->callbacks, c->name, why);
    return fmi2Error;
}

/* Return the status for success or failure. */
static fmi2Status status_of(component *c, int went)
{
    return went ? fmi2OK : refused(c, c->it.problem);
}

static fmi2Status not_here(fmi2Component c, size_t count, const char *why)
{
    return count == 0 ? fmi2OK : refused(c, why);
}

FMI2_Export const char *FMI2(fmi2GetTypesPlatform)(void)
{
    return "default";
}

FMI2_Export const char *FMI2(fmi2GetVersion)(void)
{
    return "2.0";
}

FMI2_Export fmi2Status FMI2(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean loggingOn,
                                                 size_t nCategories, const fmi2String categories[])
{
    /* Only errors are logged, and they always are. */
    (void)c;
    (void)loggingOn;
    (void)nCategories;
    (void)categories;
    return fmi2OK;
}

FMI2_Export fmi2Component FMI2(fmi2Instantiate)(fmi2String instanceName, fmi2Type fmuType,
                                                fmi2String fmuGUID, fmi2String fmuResourceLocation,
                                                const fmi2CallbackFunctions *functions,
                                                fmi2Boolean visible, fmi2Boolean loggingOn)
{
    const char *why = NULL;
    component *c;
    (void)fmuResourceLocation;
    (void)visible;
    (void)loggingOn;
    if (!functions || !functions->allocateMemory || !functions->freeMemory) {
        return NULL;
    }
    if (fmuType != fmi2CoSimulation) {
        why = "this FMU is for co-simulation only";
    } else if (!fmuGUID || strcmp(fmuGUID, MODEL_GUID) != 0) {
        why = "modelDescription.xml belongs to another FMU: its GUID differs";
    }
    if (why) {
        tell(functions, instanceName, why);
        return NULL;
    }
    c = functions->allocateMemory(1, sizeof(component));
    if (!c) {
        return NULL;
    }
    c->callbacks = functions;
    c->name = functions->allocateMemory(instanceName ? strlen(instanceName) + 1 : 1, 1);
    if (!c->name) {
        functions->freeMemory(c);
        return NULL;
    }
    strcpy(c->name, instanceName ? instanceName : "");
    reset_instance(&c->it);
    return c;
}

FMI2_Export void FMI2(fmi2FreeInstance)(fmi2Component c)
{
    component *it = c;
    if (it) {
        it->callbacks->freeMemory(it->name);
        it->callbacks->freeMemory(it);
    }
}

FMI2_Export fmi2Status FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean toleranceDefined,
                                                 fmi2Real tolerance, fmi2Real startTime,
                                                 fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    component *it = c;
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    if (it->it.now.phase != INSTANTIATED) {
        return refused(it, INITIALIZED);
    }
    it->it.now.start_time = it->it.now.time = startTime;
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2EnterInitializationMode)(fmi2Component c)
{
    component *it = c;
    return status_of(it, enter_initialization(&it->it));
}

FMI2_Export fmi2Status FMI2(fmi2ExitInitializationMode)(fmi2Component c)
{
    component *it = c;
    return status_of(it, exit_initialization(&it->it));
}

FMI2_Export fmi2Status FMI2(fmi2Terminate)(fmi2Component c)
{
    component *it = c;
    it->it.now.phase = TERMINATED;
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2Reset)(fmi2Component c)
{
    component *it = c;
    reset_instance(&it->it);
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                         fmi2Real value[])
{
    component *it = c;
    return status_of(it, get_values(&it->it, vr, nvr, value));
}

FMI2_Export fmi2Status FMI2(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                         const fmi2Real value[])
{
    component *it = c;
    return status_of(it, set_values(&it->it, vr, nvr, value));
}

FMI2_Export fmi2Status FMI2(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[],
                                            size_t nvr, fmi2Integer value[])
{
    (void)vr;
    (void)value;
    return not_here(c, nvr, REAL_ONLY);
}

FMI2_Export fmi2Status FMI2(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[],
                                            size_t nvr, fmi2Boolean value[])
{
    (void)vr;
    (void)value;
    return not_here(c, nvr, REAL_ONLY);
}

FMI2_Export fmi2Status FMI2(fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[],
                                           size_t nvr, fmi2String value[])
{
    (void)vr;
    (void)value;
    return not_here(c, nvr, REAL_ONLY);
}

FMI2_Export fmi2Status FMI2(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[],
                                            size_t nvr, const fmi2Integer value[])
{
    (void)vr;
    (void)value;
    return not_here(c, nvr, REAL_ONLY);
}

FMI2_Export fmi2Status FMI2(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[],
                                            size_t nvr, const fmi2Boolean value[])
{
    (void)vr;
    (void)value;
    return not_here(c, nvr, REAL_ONLY);
}

FMI2_Export fmi2Status FMI2(fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[],
                                           size_t nvr, const fmi2String value[])
{
    (void)vr;
    (void)value;
    return not_here(c, nvr, REAL_ONLY);
}

FMI2_Export fmi2Status FMI2(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *FMUstate)
{
    component *it = c;
    if (!*FMUstate) {
        *FMUstate = it->callbacks->allocateMemory(1, sizeof(snapshot));
    }
    if (!*FMUstate) {
        return refused(it, "there is no memory for a state");
    }
    memcpy(*FMUstate, &it->it.now, sizeof(snapshot));
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate FMUstate)
{
    component *it = c;
    memcpy(&it->it.now, FMUstate, sizeof(snapshot));
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *FMUstate)
{
    component *it = c;
    if (FMUstate && *FMUstate) {
        it->callbacks->freeMemory(*FMUstate);
        *FMUstate = NULL;
    }
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate FMUstate,
                                                        size_t *size)
{
    (void)c;
    (void)FMUstate;
    *size = sizeof(snapshot);
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate FMUstate,
                                                   fmi2Byte serializedState[], size_t size)
{
    if (size < sizeof(snapshot)) {
        return refused(c, "there is too little room for a state");
    }
    memcpy(serializedState, FMUstate, sizeof(snapshot));
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2DeSerializeFMUstate)(fmi2Component c,
                                                     const fmi2Byte serializedState[], size_t size,
                                                     fmi2FMUstate *FMUstate)
{
    component *it = c;
    if (size != sizeof(snapshot)) {
        return refused(it, "the bytes are no state of this FMU");
    }
    if (!*FMUstate) {
        *FMUstate = it->callbacks->allocateMemory(1, sizeof(snapshot));
    }
    if (!*FMUstate) {
        return refused(it, "there is no memory for a state");
    }
    memcpy(*FMUstate, serializedState, sizeof(snapshot));
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2GetDirectionalDerivative)(
    fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
    const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
    fmi2Real dvUnknown[])
{
    (void)vUnknown_ref;
    (void)vKnown_ref;
    (void)nKnown;
    (void)dvKnown;
    (void)dvUnknown;
    return not_here(c, nUnknown, NO_DERIVATIVES);
}

FMI2_Export fmi2Status FMI2(fmi2SetRealInputDerivatives)(fmi2Component c,
                                                         const fmi2ValueReference vr[], size_t nvr,
                                                         const fmi2Integer order[],
                                                         const fmi2Real value[])
{
    (void)vr;
    (void)order;
    (void)value;
    return not_here(c, nvr, "inputs of this FMU are constant during a step");
}

FMI2_Export fmi2Status FMI2(fmi2GetRealOutputDerivatives)(fmi2Component c,
                                                          const fmi2ValueReference vr[], size_t nvr,
                                                          const fmi2Integer order[],
                                                          fmi2Real value[])
{
    (void)vr;
    (void)order;
    (void)value;
    return not_here(c, nvr, NO_DERIVATIVES);
}

FMI2_Export fmi2Status FMI2(fmi2DoStep)(fmi2Component c, fmi2Real currentCommunicationPoint,
                                        fmi2Real communicationStepSize,
                                        fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    component *it = c;
    (void)noSetFMUStatePriorToCurrentPoint;
    return status_of(it, move_on(&it->it, currentCommunicationPoint, communicationStepSize));
}

FMI2_Export fmi2Status FMI2(fmi2CancelStep)(fmi2Component c)
{
    return refused(c, "a step cannot be canceled: none runs in the background");
}

FMI2_Export fmi2Status FMI2(fmi2GetStatus)(fmi2Component c, const fmi2StatusKind s,
                                           fmi2Status *value)
{
    (void)c;
    (void)s;
    (void)value;
    return fmi2Discard;
}

FMI2_Export fmi2Status FMI2(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind s,
                                               fmi2Real *value)
{
    component *it = c;
    if (s != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = it->it.now.time;
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind s,
                                                  fmi2Integer *value)
{
    (void)c;
    (void)s;
    (void)value;
    return fmi2Discard;
}

FMI2_Export fmi2Status FMI2(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind s,
                                                  fmi2Boolean *value)
{
    component *it = c;
    if (s != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = it->it.now.phase == FAILED ? fmi2True : fmi2False;
    return fmi2OK;
}

FMI2_Export fmi2Status FMI2(fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind s,
                                                 fmi2String *value)
{
    (void)c;
    (void)s;
    (void)value;
    return fmi2Discard;
}
