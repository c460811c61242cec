/* FMI 3.0 for Model Exchange and Co-Simulation over the runtime. */
#include "model.h"

#include "fmi3Functions.h"

#include "blob.h"
#include "slopes.h"
#include "step.h"

#define FM_OPEN(where)                                                                                                \
    fm_instance *f = instance;                                                                                        \
    if (!fm_may(f, (where), __func__)) return fmi3Error
#define FM_ARRAY(array, count)                                                                                        \
    if (!fm_given(f, (array), (count), __func__)) return fmi3Error
#define FM_COUNTS(a, b)                                                                                               \
    if ((a) != (b)) return (fmi3Status)fm_fail(f, "the numbers of values and of value references differ")

static void fm_say(const fm_instance *f, int status, const char *category, const char *text) {
    ((fmi3LogMessageCallback)f->logger)(f->environment, (fmi3Status)status, category, text);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String names[]) {
    FM_OPEN(FM_ANY);
    return (fmi3Status)fm_set_log(f, on, count, names);
}

static fm_instance *fm_make(int kind, fmi3String name, fmi3String token, int log_on, void *environment,
                            fmi3LogMessageCallback log) {
    const char *wrong = fm_refuses(kind);
    if (!token || strcmp(token, FM_TOKEN)) wrong = "the token is not that of this FMU's modelDescription.xml";
    if (wrong) {
        if (log) log(environment, fmi3Error, "logStatusError", wrong);
        return NULL;
    }
    fm_instance *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    fm_restart(f);
    fm_name(f, name);
    f->kind = kind, f->log_on = log_on, f->log_mask = FM_LOG_ALL;
    f->environment = environment;
    f->logger = (void (*)(void))log;
    f->say = log ? fm_say : NULL;
    f->allocate = calloc, f->release = free;
    return f;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean log_on, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)resources, (void)visible;
    return fm_make(FM_EXCHANGE, name, token, log_on, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean log_on, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t required_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)resources, (void)visible, (void)required, (void)required_count, (void)update;
    fm_instance *f = fm_make(FM_COSIMULATION, name, token, log_on, environment, log);
    if (f) f->event_mode = event_mode, f->early_return = early_return;
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

void fmi3FreeInstance(fmi3Instance instance) { free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
    FM_OPEN(FM_START);
    (void)stop_defined, (void)stop;
    if (tolerance_defined && fm_set_tolerance(f, tolerance) != FM_OK) return fmi3Error;
    if (fm_set_start(f, start) != FM_OK) return fmi3Error;
    f->core.stands = FM_INIT;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    FM_OPEN(FM_INIT);
    fm_begin(f);
    f->core.stands = f->kind == FM_EXCHANGE || f->event_mode ? FM_EVENT : FM_STEP;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    FM_OPEN(f && (f->kind == FM_EXCHANGE || f->event_mode) ? FM_CONTINUOUS | FM_STEP | FM_EVENT : 0);
    if (f->core.stands == FM_STEP) f->core.known = 0;
    f->core.stands = FM_EVENT;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    FM_OPEN(FM_EVENT | FM_CONTINUOUS | FM_STEP);
    f->core.stands = FM_DONE;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    FM_OPEN(FM_ANY);
    fm_restart(f);
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

/* --- values --------------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Float64 values[],
                          size_t value_count) {
    FM_OPEN(FM_ANY);
    FM_COUNTS(count, value_count);
    FM_ARRAY(vr, count);
    FM_ARRAY(values, count);
    for (size_t i = 0; i < count; i++)
        if (fm_get_real(f, vr[i], values + i) != FM_OK) return fmi3Error;
    return fmi3OK;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Int32 values[],
                        size_t value_count) {
    FM_OPEN(FM_ANY);
    FM_COUNTS(count, value_count);
    FM_ARRAY(vr, count);
    FM_ARRAY(values, count);
    for (size_t i = 0; i < count; i++)
        if (fm_get_integer(f, vr[i], values + i) != FM_OK) return fmi3Error;
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                          const fmi3Float64 values[], size_t value_count) {
    FM_OPEN(FM_START | FM_RUNNING);
    FM_COUNTS(count, value_count);
    FM_ARRAY(vr, count);
    FM_ARRAY(values, count);
    for (size_t i = 0; i < count; i++)
        if (fm_set_real(f, vr[i], values[i]) != FM_OK) return fmi3Error;
    return fmi3OK;
}

/* The FMU has no variables of the other kinds, and no integers to set. */
static fmi3Status fm_none(fmi3Instance instance, size_t count, const char *function) {
    if (!instance) return fmi3Error;
    if (count == 0) return fmi3OK;
    fm_log(instance, FM_ERROR, FM_LOG_ERROR, "%s: no such variable", function);
    return fmi3Error;
}

#define FM_NO_GET(name, type)                                                                                         \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, type values[],                \
                    size_t value_count) {                                                                             \
        (void)vr, (void)values, (void)value_count;                                                                    \
        return fm_none(instance, count, __func__);                                                                    \
    }
#define FM_NO_SET(name, type) FM_NO_GET(name, const type)

FM_NO_GET(fmi3GetFloat32, fmi3Float32)
FM_NO_SET(fmi3SetFloat32, fmi3Float32)
FM_NO_GET(fmi3GetInt8, fmi3Int8)
FM_NO_SET(fmi3SetInt8, fmi3Int8)
FM_NO_GET(fmi3GetUInt8, fmi3UInt8)
FM_NO_SET(fmi3SetUInt8, fmi3UInt8)
FM_NO_GET(fmi3GetInt16, fmi3Int16)
FM_NO_SET(fmi3SetInt16, fmi3Int16)
FM_NO_GET(fmi3GetUInt16, fmi3UInt16)
FM_NO_SET(fmi3SetUInt16, fmi3UInt16)
FM_NO_SET(fmi3SetInt32, fmi3Int32)
FM_NO_GET(fmi3GetUInt32, fmi3UInt32)
FM_NO_SET(fmi3SetUInt32, fmi3UInt32)
FM_NO_GET(fmi3GetInt64, fmi3Int64)
FM_NO_SET(fmi3SetInt64, fmi3Int64)
FM_NO_GET(fmi3GetUInt64, fmi3UInt64)
FM_NO_SET(fmi3SetUInt64, fmi3UInt64)
FM_NO_GET(fmi3GetBoolean, fmi3Boolean)
FM_NO_SET(fmi3SetBoolean, fmi3Boolean)
FM_NO_GET(fmi3GetString, fmi3String)
FM_NO_SET(fmi3SetString, fmi3String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, size_t sizes[],
                         fmi3Binary values[], size_t value_count) {
    (void)vr, (void)sizes, (void)values, (void)value_count;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const size_t sizes[],
                         const fmi3Binary values[], size_t value_count) {
    (void)vr, (void)sizes, (void)values, (void)value_count;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Clock values[]) {
    (void)vr, (void)values;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Clock values[]) {
    (void)vr, (void)values;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t *count) {
    (void)vr, (void)count;
    return fm_none(instance, 1, __func__);
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t elements[],
                                       fmi3ValueReference independents[], size_t others[], fmi3DependencyKind kinds[],
                                       size_t count) {
    (void)vr, (void)elements, (void)independents, (void)others, (void)kinds, (void)count;
    return fm_none(instance, 1, __func__);
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                  fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)intervals, (void)qualifiers;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)counters, (void)resolutions, (void)qualifiers;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                               fmi3Float64 shifts[]) {
    (void)vr, (void)shifts;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                fmi3UInt64 counters[], fmi3UInt64 resolutions[]) {
    (void)vr, (void)counters, (void)resolutions;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                  const fmi3Float64 intervals[]) {
    (void)vr, (void)intervals;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)counters, (void)resolutions;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                               const fmi3Float64 shifts[]) {
    (void)vr, (void)shifts;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)counters, (void)resolutions;
    return fm_none(instance, count, __func__);
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    return fm_none(instance, 1, __func__);
}

/* --- the FMU's state ------------------------------------------------------------------------------------------ */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    if (!*state) *state = f->allocate(1, sizeof(fm_core));
    if (!*state) return (fmi3Status)fm_fail(f, "no memory for a copy of the state");
    *(fm_core *)*state = f->core;
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    fm_adopt(f, state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    FM_OPEN(FM_ANY);
    if (state && *state) f->release(*state), *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    FM_ARRAY(size, 1);
    *size = fm_blob_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    FM_ARRAY(bytes, size);
    if (size < fm_blob_size()) return (fmi3Status)fm_fail(f, "the state does not fit the bytes");
    fm_write(state, bytes);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(bytes, size);
    FM_ARRAY(state, 1);
    fm_core *core = f->allocate(1, sizeof *core);
    if (!core) return (fmi3Status)fm_fail(f, "no memory for a copy of the state");
    const char *wrong = fm_read(core, bytes, size);
    if (wrong) {
        f->release(core);
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "the serialised state is refused: %s", wrong);
        return fmi3Error;
    }
    if (*state) f->release(*state);
    *state = core;
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t unknowns,
                                        const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
                                        size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_COUNTS(knowns, seeds);
    FM_COUNTS(unknowns, sensitivities);
    FM_ARRAY(unknown, unknowns);
    FM_ARRAY(known, knowns);
    FM_ARRAY(seed, knowns);
    FM_ARRAY(sensitivity, unknowns);
    return (fmi3Status)fm_directional(f, unknown, unknowns, known, knowns, seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t unknowns,
                                    const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
                                    size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_COUNTS(unknowns, seeds);
    FM_COUNTS(knowns, sensitivities);
    FM_ARRAY(unknown, unknowns);
    FM_ARRAY(known, knowns);
    FM_ARRAY(seed, unknowns);
    FM_ARRAY(sensitivity, knowns);
    return (fmi3Status)fm_adjoint_derivative(f, unknown, unknowns, known, knowns, seed, sensitivity);
}

/* --- events --------------------------------------------------------------------------------------------------- */

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    FM_OPEN(FM_INIT | FM_EVENT);
    return fmi3OK; /* discrete states change in fmi3UpdateDiscreteStates alone */
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *needs_update, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next) {
    double unused;
    FM_OPEN(FM_EVENT);
    if (!needs_update || !terminate || !nominals_changed || !values_changed || !next_defined || !next)
        return (fmi3Status)fm_fail(f, "fmi3UpdateDiscreteStates was given no place for a result");
    *needs_update = *terminate = *nominals_changed = *next_defined = fmi3False;
    *next = 0.0;
    *values_changed = fm_update(f) != 0;
    if (f->kind == FM_COSIMULATION && !fm_take_inputs(f, &unused))
        return (fmi3Status)fm_fail(f, "too many changes of the command are on their way");
    return fmi3OK;
}

/* --- Model Exchange ------------------------------------------------------------------------------------------- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    FM_OPEN(f && f->kind == FM_EXCHANGE ? FM_EVENT : 0);
    f->core.stands = FM_CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_return, fmi3Boolean *event,
                                       fmi3Boolean *terminate) {
    FM_OPEN(FM_CONTINUOUS);
    FM_ARRAY(event, 1);
    FM_ARRAY(terminate, 1);
    (void)no_return;
    *event = *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    FM_OPEN(f && f->kind == FM_EXCHANGE ? FM_EVENT | FM_CONTINUOUS : 0);
    if (time - time != 0.0) return (fmi3Status)fm_fail(f, "the time is not finite");
    if (f->core.sim.t != time) f->core.sim.t = time, fm_stale(f);
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t count) {
    FM_OPEN(FM_CONTINUOUS);
    FM_ARRAY(x, count);
    if (count != SB_NS) return (fmi3Status)fm_fail(f, "the number of states is another");
    if (!sb_finite(x, SB_NS)) return (fmi3Status)fm_fail(f, "a state is not finite");
    fm_set_states(f, x);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t count) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_ARRAY(derivatives, count);
    if (count != SB_NS) return (fmi3Status)fm_fail(f, "the number of states is another");
    if (f->core.stands == FM_INIT) fm_begin(f);
    fm_evaluate(f);
    memcpy(derivatives, f->core.sim.f, sizeof(double) * SB_NS);
    if (sb_finite(derivatives, SB_NS)) return fmi3OK;
    fm_log(f, FM_DISCARD, FM_LOG_DISCARD, "the derivatives are not finite at t = %.15g s", f->core.sim.t);
    return fmi3Discard;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t count) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_ARRAY(indicators, count);
    if (count != FM_INDICATORS) return (fmi3Status)fm_fail(f, "the number of event indicators is another");
    if (f->core.stands == FM_INIT) fm_begin(f);
    fm_evaluate(f);
    for (int j = 0, i = 0; j < SB_N; j++)
        if (!sb_bristle[j]) indicators[i++] = fm_indicator(&f->core.sim, j);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t count) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_ARRAY(x, count);
    if (count != SB_NS) return (fmi3Status)fm_fail(f, "the number of states is another");
    if (f->core.stands == FM_INIT) fm_begin(f);
    memcpy(x, f->core.sim.y, sizeof(double) * SB_NS);
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(nominals, count);
    if (count != SB_NS) return (fmi3Status)fm_fail(f, "the number of states is another");
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(count, 1);
    *count = FM_INDICATORS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(count, 1);
    *count = SB_NS;
    return fmi3OK;
}

/* --- Co-Simulation -------------------------------------------------------------------------------------------- */

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    FM_OPEN(f && f->kind == FM_COSIMULATION ? FM_EVENT : 0);
    f->core.stands = FM_STEP;
    return fmi3OK;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count) {
    FM_OPEN(f && f->kind == FM_COSIMULATION ? FM_STEP | FM_DONE : 0);
    FM_COUNTS(count, value_count);
    FM_ARRAY(vr, count);
    FM_ARRAY(orders, count);
    FM_ARRAY(values, count);
    for (size_t i = 0; i < count; i++)
        if (fm_output_slope(f, vr[i], orders[i], values + i) != FM_OK) return fmi3Error;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_return,
                      fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    FM_OPEN(FM_STEP);
    (void)no_return;
    if (!event_needed || !terminate || !early || !last)
        return (fmi3Status)fm_fail(f, "fmi3DoStep was given no place for a result");
    const int status = fm_step(f, t, h, f->event_mode && f->early_return);
    *event_needed = f->core.sim.waiting != 0;
    *terminate = status == FM_DISCARD;
    *early = status == FM_OK && f->core.sim.t < t + h;
    *last = f->core.sim.t;
    return (fmi3Status)status;
}
