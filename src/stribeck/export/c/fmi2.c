/* FMI 2.0 for Model Exchange and Co-Simulation over the runtime. */
#include "model.h"

#include "fmi2Functions.h"

#include "blob.h"
#include "slopes.h"
#include "step.h"

#define FM_OPEN(where)                                                                                                \
    fm_instance *f = c;                                                                                               \
    if (!fm_may(f, (where), __func__)) return fmi2Error
#define FM_ARRAY(array, count)                                                                                        \
    if (!fm_given(f, (array), (count), __func__)) return fmi2Error

static void fm_say(const fm_instance *f, int status, const char *category, const char *text) {
    ((fmi2CallbackLogger)f->logger)(f->environment, f->name, (fmi2Status)status, category, "%s", text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String names[]) {
    FM_OPEN(FM_ANY);
    return (fmi2Status)fm_set_log(f, on, count, names);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean log_on) {
    const int kind = type == fmi2ModelExchange ? FM_EXCHANGE : FM_COSIMULATION;
    const char *wrong = fm_refuses(kind);
    fm_instance *f;
    (void)resources, (void)visible;
    if (!functions) return NULL;
    if (!guid || strcmp(guid, FM_TOKEN)) wrong = "the GUID is not that of this FMU's modelDescription.xml";
    if (wrong) {
        if (functions->logger)
            functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError", "%s", wrong);
        return NULL;
    }
    f = functions->allocateMemory ? functions->allocateMemory(1, sizeof *f) : calloc(1, sizeof *f);
    if (!f) return NULL;
    memset(f, 0, sizeof *f);
    fm_restart(f);
    fm_name(f, name);
    f->kind = kind, f->log_on = log_on, f->log_mask = FM_LOG_ALL;
    f->environment = functions->componentEnvironment;
    f->logger = (void (*)(void))functions->logger;
    f->say = functions->logger ? fm_say : NULL;
    f->allocate = functions->allocateMemory ? functions->allocateMemory : calloc;
    f->release = functions->allocateMemory && functions->freeMemory ? functions->freeMemory : free;
    return f;
}

void fmi2FreeInstance(fmi2Component c) {
    fm_instance *f = c;
    if (f) f->release(f);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop) {
    FM_OPEN(FM_START);
    (void)stop_defined, (void)stop;
    if (tolerance_defined && fm_set_tolerance(f, tolerance) != FM_OK) return fmi2Error;
    return (fmi2Status)fm_set_start(f, start);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    FM_OPEN(FM_START);
    f->core.stands = FM_INIT;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    FM_OPEN(FM_INIT);
    fm_begin(f);
    f->core.stands = f->kind == FM_EXCHANGE ? FM_EVENT : FM_STEP;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    FM_OPEN(FM_EVENT | FM_CONTINUOUS | FM_STEP);
    f->core.stands = FM_DONE;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    FM_OPEN(FM_ANY);
    fm_restart(f);
    return fmi2OK;
}

/* --- values --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real value[]) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(vr, count);
    FM_ARRAY(value, count);
    for (size_t i = 0; i < count; i++)
        if (fm_get_real(f, vr[i], value + i) != FM_OK) return fmi2Error;
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Integer value[]) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(vr, count);
    FM_ARRAY(value, count);
    for (size_t i = 0; i < count; i++) {
        int32_t number;
        if (fm_get_integer(f, vr[i], &number) != FM_OK) return fmi2Error;
        value[i] = number;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Real value[]) {
    FM_OPEN(FM_START | FM_RUNNING);
    FM_ARRAY(vr, count);
    FM_ARRAY(value, count);
    for (size_t i = 0; i < count; i++)
        if (fm_set_real(f, vr[i], value[i]) != FM_OK) return fmi2Error;
    return fmi2OK;
}

/* The FMU has no variables of the other kinds, and no integers to set. */
static fmi2Status fm_none(fmi2Component c, size_t count, const char *function) {
    if (!c) return fmi2Error;
    if (count == 0) return fmi2OK;
    fm_log(c, FM_ERROR, FM_LOG_ERROR, "%s: no such variable", function);
    return fmi2Error;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Integer value[]) {
    (void)vr, (void)value;
    return fm_none(c, count, __func__);
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Boolean value[]) {
    (void)vr, (void)value;
    return fm_none(c, count, __func__);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Boolean value[]) {
    (void)vr, (void)value;
    return fm_none(c, count, __func__);
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2String value[]) {
    (void)vr, (void)value;
    return fm_none(c, count, __func__);
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2String value[]) {
    (void)vr, (void)value;
    return fm_none(c, count, __func__);
}

/* --- the FMU's state ------------------------------------------------------------------------------------------ */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    if (!*state) *state = f->allocate(1, sizeof(fm_core));
    if (!*state) return (fmi2Status)fm_fail(f, "no memory for a copy of the state");
    *(fm_core *)*state = f->core;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    fm_adopt(f, state);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    FM_OPEN(FM_ANY);
    if (state && *state) f->release(*state), *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    FM_ARRAY(size, 1);
    *size = fm_blob_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    FM_ARRAY(bytes, size);
    if (size < fm_blob_size()) return (fmi2Status)fm_fail(f, "the state does not fit the bytes");
    fm_write(state, (unsigned char *)bytes);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(bytes, size);
    FM_ARRAY(state, 1);
    fm_core *core = f->allocate(1, sizeof *core);
    if (!core) return (fmi2Status)fm_fail(f, "no memory for a copy of the state");
    const char *wrong = fm_read(core, (const unsigned char *)bytes, size);
    if (wrong) {
        f->release(core);
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "the serialised state is refused: %s", wrong);
        return fmi2Error;
    }
    if (*state) f->release(*state);
    *state = core;
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_ARRAY(unknown, unknowns);
    FM_ARRAY(known, knowns);
    FM_ARRAY(seed, knowns);
    FM_ARRAY(sensitivity, unknowns);
    return (fmi2Status)fm_directional(f, unknown, unknowns, known, knowns, seed, sensitivity);
}

/* --- Model Exchange ------------------------------------------------------------------------------------------- */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    FM_OPEN(f && f->kind == FM_EXCHANGE ? FM_CONTINUOUS | FM_EVENT : 0);
    f->core.stands = FM_EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    FM_OPEN(FM_EVENT);
    FM_ARRAY(info, 1);
    memset(info, 0, sizeof *info);
    info->valuesOfContinuousStatesChanged = fm_update(f);
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    FM_OPEN(FM_EVENT);
    f->core.stands = FM_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_return, fmi2Boolean *event,
                                       fmi2Boolean *terminate) {
    FM_OPEN(FM_CONTINUOUS);
    FM_ARRAY(event, 1);
    FM_ARRAY(terminate, 1);
    (void)no_return;
    *event = *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    FM_OPEN(f && f->kind == FM_EXCHANGE ? FM_EVENT | FM_CONTINUOUS : 0);
    if (time - time != 0.0) return (fmi2Status)fm_fail(f, "the time is not finite");
    if (f->core.sim.t != time) f->core.sim.t = time, fm_stale(f);
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t count) {
    FM_OPEN(FM_CONTINUOUS);
    FM_ARRAY(x, count);
    if (count != SB_NS) return (fmi2Status)fm_fail(f, "the number of states is another");
    if (!sb_finite(x, SB_NS)) return (fmi2Status)fm_fail(f, "a state is not finite");
    fm_set_states(f, x);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t count) {
    FM_OPEN(FM_INIT | FM_EVENT | FM_CONTINUOUS | FM_DONE);
    FM_ARRAY(derivatives, count);
    if (count != SB_NS) return (fmi2Status)fm_fail(f, "the number of states is another");
    if (f->core.stands == FM_INIT) fm_begin(f);
    fm_evaluate(f);
    memcpy(derivatives, f->core.sim.f, sizeof(double) * SB_NS);
    if (sb_finite(derivatives, SB_NS)) return fmi2OK;
    fm_log(f, FM_DISCARD, FM_LOG_DISCARD, "the derivatives are not finite at t = %.15g s", f->core.sim.t);
    return fmi2Discard;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t count) {
    FM_OPEN(FM_INIT | FM_EVENT | FM_CONTINUOUS | FM_DONE);
    FM_ARRAY(indicators, count);
    if (count != FM_INDICATORS) return (fmi2Status)fm_fail(f, "the number of event indicators is another");
    if (f->core.stands == FM_INIT) fm_begin(f);
    fm_evaluate(f);
    for (int j = 0, i = 0; j < SB_N; j++)
        if (!sb_bristle[j]) indicators[i++] = fm_indicator(&f->core.sim, j);
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t count) {
    FM_OPEN(FM_INIT | FM_EVENT | FM_CONTINUOUS | FM_DONE);
    FM_ARRAY(x, count);
    if (count != SB_NS) return (fmi2Status)fm_fail(f, "the number of states is another");
    if (f->core.stands == FM_INIT) fm_begin(f);
    memcpy(x, f->core.sim.y, sizeof(double) * SB_NS);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(nominals, count);
    if (count != SB_NS) return (fmi2Status)fm_fail(f, "the number of states is another");
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0;
    return fmi2OK;
}

/* --- Co-Simulation -------------------------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    FM_OPEN(f && f->kind == FM_COSIMULATION ? FM_START | FM_INIT | FM_STEP : 0);
    FM_ARRAY(vr, count);
    FM_ARRAY(order, count);
    FM_ARRAY(value, count);
    for (size_t i = 0; i < count; i++) {
        const int known = vr[i] >= FM_TAU && vr[i] < (unsigned)FM_Q && order[i] == 1;
        if (!known) return (fmi2Status)fm_fail(f, "only inputs have a derivative, of order 1");
        if (value[i] - value[i] != 0.0) return (fmi2Status)fm_fail(f, "an input's derivative is not finite");
        f->core.slope[vr[i] - FM_TAU] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[]) {
    FM_OPEN(f && f->kind == FM_COSIMULATION ? FM_STEP | FM_DONE : 0);
    FM_ARRAY(vr, count);
    FM_ARRAY(order, count);
    FM_ARRAY(value, count);
    for (size_t i = 0; i < count; i++)
        if (fm_output_slope(f, vr[i], order[i], value + i) != FM_OK) return fmi2Error;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
    FM_OPEN(FM_STEP);
    (void)no_return;
    return (fmi2Status)fm_step(f, t, h, 0);
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    FM_OPEN(FM_ANY);
    return (fmi2Status)fm_fail(f, "steps end before they return: there is none to cancel");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(value, 1);
    if (kind != fmi2DoStepStatus) return fmi2Discard;
    *value = f->core.sim.status == SB_OK ? fmi2OK : fmi2Discard;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(value, 1);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = f->core.sim.t;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(value, 1);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = f->core.sim.status != SB_OK;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    FM_OPEN(FM_ANY);
    (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    FM_OPEN(FM_ANY);
    (void)kind;
    FM_ARRAY(value, 1);
    *value = "";
    return fmi2Discard;
}
