/* FMI 3.0 for Co-Simulation over the controller. */
#include "control.h"
#include "model.h"

#include "core.h"

#include "fmi3Functions.h"

#define CT_OPEN(where)                                                                                                 \
    ct_instance *f = c;                                                                                                \
    if (!ct_may(f, where, __func__)) return fmi3Error

static void ct_say(const void *c, const char *text) {
    const ct_instance *f = c;
    ((fmi3LogMessageCallback)f->logger)(f->environment, fmi3Error, "logStatusError", text);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean log_on, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    if (!token || strcmp(token, CT_TOKEN) != 0) return NULL;
    ct_instance *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    f->logger = (void (*)(void))logger, f->environment = environment;
    if (log_on && logger) f->say = ct_say;
    ct_restart(&f->core);
    return f;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean log_on, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean log_on,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String names[]) {
    CT_OPEN(CT_ANY);
    f->say = on && f->logger ? ct_say : NULL;
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean known, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean ends, fmi3Float64 stop) {
    CT_OPEN(CT_START);
    if (start - start != 0.0) return fmi3Error;
    f->core.start = f->core.time = start;
    f->core.stands = CT_INIT;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    CT_OPEN(CT_INIT);
    ct_begin(&f->core);
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    CT_OPEN(CT_STEP);
    f->core.stands = CT_DONE;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c) {
    CT_OPEN(CT_ANY);
    ct_restart(&f->core);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count, fmi3Float64 value[], size_t n) {
    CT_OPEN(CT_ANY);
    if (n < count || (count && (!vr || !value))) return (fmi3Status)ct_fail(f, "too few values");
    for (size_t i = 0; i < count; i++)
        if (!ct_get(&f->core, vr[i], value + i)) return (fmi3Status)ct_fail(f, "no such variable");
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count, const fmi3Float64 value[],
                          size_t n) {
    CT_OPEN(CT_START | CT_INIT | CT_STEP);
    if (n < count || (count && (!vr || !value))) return (fmi3Status)ct_fail(f, "too few values");
    for (size_t i = 0; i < count; i++)
        if (!ct_set(&f->core, vr[i], value[i])) return (fmi3Status)ct_fail(f, "cannot be set to this");
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    CT_OPEN(CT_STEP);
    const int status = ct_do_step(f, t, h);
    if (event) *event = fmi3False;
    if (terminate) *terminate = fmi3False;
    if (early) *early = fmi3False;
    if (reached) *reached = f->core.time;
    return (fmi3Status)status;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    CT_OPEN(CT_ANY);
    if (!state || (!*state && !(*state = malloc(sizeof(ct_core))))) return fmi3Error;
    memcpy(*state, &f->core, sizeof f->core);
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    CT_OPEN(CT_ANY);
    if (!state) return fmi3Error;
    memcpy(&f->core, state, sizeof f->core);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    CT_OPEN(CT_ANY);
    if (state) free(*state), *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    CT_OPEN(CT_ANY);
    if (!state || !size) return fmi3Error;
    *size = CT_BYTES;
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    CT_OPEN(CT_ANY);
    if (!state || !bytes || size < CT_BYTES) return (fmi3Status)ct_fail(f, "the state does not fit the bytes");
    ct_write(state, bytes);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    CT_OPEN(CT_ANY);
    if (!bytes || !state || (!*state && !(*state = malloc(sizeof(ct_core))))) return fmi3Error;
    if (ct_read(*state, bytes, size)) return fmi3OK;
    free(*state), *state = NULL;
    return (fmi3Status)ct_fail(f, "the bytes are no state of this FMU");
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count) {
    CT_OPEN(CT_ANY);
    if (count) *count = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count) {
    CT_OPEN(CT_ANY);
    if (count) *count = 0;
    return fmi3OK;
}

/* What a controller has no use for. */
#define CT_NOT(name, ...)                                                                                              \
    fmi3Status name(fmi3Instance c, __VA_ARGS__) {                                                                     \
        CT_OPEN(CT_ANY);                                                                                               \
        return (fmi3Status)ct_fail(f, #name " does not apply to a sampled controller");                                \
    }
#define CT_NEVER(name)                                                                                                 \
    fmi3Status name(fmi3Instance c) {                                                                                  \
        CT_OPEN(CT_ANY);                                                                                               \
        return (fmi3Status)ct_fail(f, #name " does not apply to a sampled controller");                                \
    }
#define CT_REFS const fmi3ValueReference vr[], size_t count
#define CT_TYPE(type)                                                                                                  \
    CT_NOT(fmi3Get##type, CT_REFS, fmi3##type value[], size_t n)                                                       \
    CT_NOT(fmi3Set##type, CT_REFS, const fmi3##type value[], size_t n)
CT_TYPE(Float32)
CT_TYPE(Int8)
CT_TYPE(UInt8)
CT_TYPE(Int16)
CT_TYPE(UInt16)
CT_TYPE(Int32)
CT_TYPE(UInt32)
CT_TYPE(Int64)
CT_TYPE(UInt64)
CT_TYPE(Boolean)
CT_TYPE(String)
CT_NOT(fmi3GetBinary, CT_REFS, size_t sizes[], fmi3Binary value[], size_t n)
CT_NOT(fmi3SetBinary, CT_REFS, const size_t sizes[], const fmi3Binary value[], size_t n)
CT_NOT(fmi3GetClock, CT_REFS, fmi3Clock value[])
CT_NOT(fmi3SetClock, CT_REFS, const fmi3Clock value[])
CT_NOT(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *count)
CT_NOT(fmi3GetVariableDependencies, fmi3ValueReference vr, size_t elements[], fmi3ValueReference of[], size_t at[],
       fmi3DependencyKind kinds[], size_t n)
CT_NOT(fmi3GetDirectionalDerivative, const fmi3ValueReference unknown[], size_t unknowns,
       const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[], size_t seeds, fmi3Float64 result[],
       size_t results)
CT_NOT(fmi3GetAdjointDerivative, const fmi3ValueReference unknown[], size_t unknowns, const fmi3ValueReference known[],
       size_t knowns, const fmi3Float64 seed[], size_t seeds, fmi3Float64 result[], size_t results)
CT_NOT(fmi3GetOutputDerivatives, CT_REFS, const fmi3Int32 orders[], fmi3Float64 value[], size_t n)
CT_NOT(fmi3GetIntervalDecimal, CT_REFS, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
CT_NOT(fmi3GetIntervalFraction, CT_REFS, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
       fmi3IntervalQualifier qualifiers[])
CT_NOT(fmi3GetShiftDecimal, CT_REFS, fmi3Float64 shifts[])
CT_NOT(fmi3GetShiftFraction, CT_REFS, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
CT_NOT(fmi3SetIntervalDecimal, CT_REFS, const fmi3Float64 intervals[])
CT_NOT(fmi3SetIntervalFraction, CT_REFS, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
CT_NOT(fmi3SetShiftDecimal, CT_REFS, const fmi3Float64 shifts[])
CT_NOT(fmi3SetShiftFraction, CT_REFS, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
CT_NOT(fmi3UpdateDiscreteStates, fmi3Boolean *update, fmi3Boolean *terminate, fmi3Boolean *nominals,
       fmi3Boolean *states, fmi3Boolean *defined, fmi3Float64 *next)
CT_NOT(fmi3CompletedIntegratorStep, fmi3Boolean keep, fmi3Boolean *event, fmi3Boolean *terminate)
CT_NOT(fmi3SetTime, fmi3Float64 time)
CT_NOT(fmi3SetContinuousStates, const fmi3Float64 x[], size_t n)
CT_NOT(fmi3GetContinuousStateDerivatives, fmi3Float64 x[], size_t n)
CT_NOT(fmi3GetEventIndicators, fmi3Float64 x[], size_t n)
CT_NOT(fmi3GetContinuousStates, fmi3Float64 x[], size_t n)
CT_NOT(fmi3GetNominalsOfContinuousStates, fmi3Float64 x[], size_t n)
CT_NOT(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
CT_NEVER(fmi3EnterEventMode)
CT_NEVER(fmi3EnterConfigurationMode)
CT_NEVER(fmi3ExitConfigurationMode)
CT_NEVER(fmi3EvaluateDiscreteStates)
CT_NEVER(fmi3EnterContinuousTimeMode)
CT_NEVER(fmi3EnterStepMode)
