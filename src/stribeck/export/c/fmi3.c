/* FMI 3.0 over a part: what only this version has; the rest stands in both.h. */
#include "model.h"

#include "fmi3Functions.h"

#include "part.h"

#define FMI(name) fmi3##name
#define FMI_STATE(before, after) fmi3##before##FMUState##after
#define FMI_READ_STATE fmi3DeserializeFMUState
#define FMI_GET_RATES fmi3GetContinuousStateDerivatives
typedef fmi3Status fmi_status;
typedef fmi3Instance fmi_handle;
typedef fmi3Boolean fmi_boolean;
typedef fmi3String fmi_string;
typedef fmi3Byte fmi_byte;
typedef fmi3ValueReference fmi_reference;

#include "both.h"

#define FM_COUNTS(a, b)                                                                                               \
    if ((a) != (b)) FM_FAIL("the numbers of values and of value references differ")

static void fm_say(const fm_instance *f, int status, const char *category, const char *text) {
    ((fmi3LogMessageCallback)f->logger)(f->environment, (fmi3Status)status, category, text);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

static fm_instance *fm_instantiate(int kind, fmi3String name, fmi3String token, int log_on, void *environment,
                                   fmi3LogMessageCallback log) {
    const char *wrong = fm_refuses(kind, token);
    if (!wrong) return fm_make(kind, name, log_on, environment, (void (*)(void))log, fm_say, calloc, free);
    if (log) log(environment, fmi3Error, "logStatusError", wrong);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean log_on, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)resources, (void)visible;
    return fm_instantiate(FM_EXCHANGE, name, token, log_on, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean log_on, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t required_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)resources, (void)visible, (void)required, (void)required_count, (void)update;
    fm_instance *f = fm_instantiate(FM_COSIMULATION, name, token, log_on, environment, log);
    if (f) f->event_mode = event_mode && FM_HAS_EVENT_MODE, f->early_return = early_return;
    return f;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean log_on,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)log_on, (void)clock, (void)lock, (void)unlock;
    if (log) log(environment, fmi3Error, "logStatusError", "this FMU has no Scheduled Execution");
    return NULL;
}

/* --- from mode to mode ---------------------------------------------------------------------------------------- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
    FM_OPEN(FM_START);
    (void)stop_defined, (void)stop;
    if (fm_set_up(f, tolerance_defined, tolerance, start) != FM_OK) return fmi3Error;
    f->core.stands = FM_INIT;
    return fmi3OK;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    FM_OPEN(FM_START);
    f->core.stands = FM_CONFIGURE;
    return fmi3OK;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    FM_OPEN(FM_CONFIGURE);
    f->core.stands = FM_START;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    FM_OPEN(FM_IF(FM_COSIMULATION, FM_EVENT));
    f->core.stands = FM_STEP;
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    FM_OPEN(FM_INIT | FM_EVENT);
    return fmi3OK; /* discrete states change in fmi3UpdateDiscreteStates alone */
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *needs_update, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next) {
    int jumped;
    FM_OPEN(FM_EVENT);
    if (!needs_update || !terminate || !nominals_changed || !values_changed || !next_defined || !next)
        FM_FAIL("fmi3UpdateDiscreteStates was given no place for a result");
    *needs_update = *terminate = *nominals_changed = *next_defined = fmi3False;
    *next = 0.0;
    const int status = fm_iterate(f, &jumped);
    *values_changed = jumped != 0;
    return (fmi3Status)status;
}

/* --- values --------------------------------------------------------------------------------------------------- */

#define FM_REFERENCES const fmi3ValueReference vr[], size_t count
#define FM_VALUES(name, type, where, all)                                                                             \
    fmi3Status name(fmi3Instance instance, FM_REFERENCES, type values[], size_t value_count) {                        \
        FM_OPEN(where);                                                                                               \
        FM_COUNTS(count, value_count);                                                                                \
        FM_ARRAY(vr, count);                                                                                          \
        FM_ARRAY(values, count);                                                                                      \
        return (fmi3Status)all(f, vr, count, values);                                                                 \
    }
FM_VALUES(fmi3GetFloat64, fmi3Float64, FM_ANY, fm_get_reals)
FM_VALUES(fmi3SetFloat64, const fmi3Float64, FM_START | FM_RUNNING, fm_set_reals)
FM_VALUES(fmi3GetInt32, fmi3Int32, FM_ANY, fm_get_integers)

/* The FMU has no variables of the other kinds, no clocks and no integers to set. */
#define FM_NONE(name, ...)                                                                                            \
    fmi3Status name(fmi3Instance instance, FM_REFERENCES, __VA_ARGS__) {                                              \
        return (fmi3Status)fm_none(instance, count, __func__);                                                        \
    }
#define FM_NO_GET(type) FM_NONE(fmi3Get##type, fmi3##type values[], size_t value_count)
#define FM_NO_SET(type) FM_NONE(fmi3Set##type, const fmi3##type values[], size_t value_count)
#define FM_NO_TYPE(type) FM_NO_GET(type) FM_NO_SET(type)

FM_NO_TYPE(Float32)
FM_NO_TYPE(Int8)
FM_NO_TYPE(UInt8)
FM_NO_TYPE(Int16)
FM_NO_TYPE(UInt16)
FM_NO_SET(Int32)
FM_NO_TYPE(UInt32)
FM_NO_TYPE(Int64)
FM_NO_TYPE(UInt64)
FM_NO_TYPE(Boolean)
FM_NO_TYPE(String)
FM_NONE(fmi3GetBinary, size_t sizes[], fmi3Binary values[], size_t value_count)
FM_NONE(fmi3SetBinary, const size_t sizes[], const fmi3Binary values[], size_t value_count)
FM_NONE(fmi3GetClock, fmi3Clock values[])
FM_NONE(fmi3SetClock, const fmi3Clock values[])
FM_NONE(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
FM_NONE(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
FM_NONE(fmi3GetShiftDecimal, fmi3Float64 shifts[])
FM_NONE(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
FM_NONE(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
FM_NONE(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
FM_NONE(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
FM_NONE(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t *count) {
    (void)vr, (void)count;
    return (fmi3Status)fm_none(instance, 1, __func__);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t elements[],
                                       fmi3ValueReference independents[], size_t others[], fmi3DependencyKind kinds[],
                                       size_t count) {
    (void)vr, (void)elements, (void)independents, (void)others, (void)kinds, (void)count;
    return (fmi3Status)fm_none(instance, 1, __func__);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    return (fmi3Status)fm_none(instance, 1, __func__);
}

/* --- derivatives ---------------------------------------------------------------------------------------------- */

#define FM_DERIVATIVE(name, along, from, to)                                                                          \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference unknown[], size_t unknowns,                       \
                    const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[], size_t seeds,          \
                    fmi3Float64 sensitivity[], size_t sensitivities) {                                                \
        FM_OPEN(FM_RUNNING | FM_DONE);                                                                                \
        FM_COUNTS(from, seeds);                                                                                       \
        FM_COUNTS(to, sensitivities);                                                                                 \
        FM_ARRAY(unknown, unknowns);                                                                                  \
        FM_ARRAY(known, knowns);                                                                                      \
        FM_ARRAY(seed, seeds);                                                                                        \
        FM_ARRAY(sensitivity, sensitivities);                                                                         \
        return (fmi3Status)along(f, unknown, unknowns, known, knowns, seed, sensitivity);                             \
    }
FM_DERIVATIVE(fmi3GetDirectionalDerivative, fm_directional, knowns, unknowns)
FM_DERIVATIVE(fmi3GetAdjointDerivative, fm_adjoint_derivative, unknowns, knowns)

/* --- Model Exchange ------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(count, 1);
    *count = FM_INDICATORS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(count, 1);
    *count = FM_STATES;
    return fmi3OK;
}

/* --- Co-Simulation -------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, FM_REFERENCES, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t value_count) {
    FM_OPEN(FM_IF(FM_COSIMULATION, FM_STEP | FM_DONE));
    FM_COUNTS(count, value_count);
    FM_ARRAY(vr, count);
    FM_ARRAY(orders, count);
    FM_ARRAY(values, count);
    return (fmi3Status)fm_output_slopes(f, vr, count, orders, values);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_return,
                      fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    FM_OPEN(FM_STEP);
    (void)no_return;
    if (!event_needed || !terminate || !early || !last) FM_FAIL("fmi3DoStep was given no place for a result");
    const int status = fm_step(f, t, h, f->event_mode && f->early_return);
    *last = fm_now(&f->core);
    *event_needed = fm_waits(&f->core);
    *terminate = status == FM_DISCARD;
    *early = status == FM_OK && *last < t + h;
    return (fmi3Status)status;
}
