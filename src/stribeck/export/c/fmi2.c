/* FMI 2.0 over a part: what only this version has; the rest stands in both.h. */
#include "model.h"

#include "fmi2Functions.h"

#include "part.h"

#define FMI(name) fmi2##name
#define FMI_STATE(before, after) fmi2##before##FMUstate##after
#define FMI_READ_STATE fmi2DeSerializeFMUstate
#define FMI_GET_RATES fmi2GetDerivatives
typedef fmi2Status fmi_status;
typedef fmi2Component fmi_handle;
typedef fmi2Boolean fmi_boolean;
typedef fmi2String fmi_string;
typedef fmi2Byte fmi_byte;
typedef fmi2ValueReference fmi_reference;

#include "both.h"

static void fm_say(const fm_instance *f, int status, const char *category, const char *text) {
    ((fmi2CallbackLogger)f->logger)(f->environment, f->name, (fmi2Status)status, category, "%s", text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean log_on) {
    const int kind = type == fmi2ModelExchange ? FM_EXCHANGE : FM_COSIMULATION;
    const char *wrong = fm_refuses(kind, guid);
    (void)resources, (void)visible;
    if (!functions) return NULL;
    if (wrong) {
        if (functions->logger)
            functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError", "%s", wrong);
        return NULL;
    }
    return fm_make(kind, name, log_on, functions->componentEnvironment, (void (*)(void))functions->logger, fm_say,
                   functions->allocateMemory ? functions->allocateMemory : calloc,
                   functions->allocateMemory && functions->freeMemory ? functions->freeMemory : free);
}

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    FM_OPEN(FM_START);
    (void)stop_defined, (void)stop;
    return (fmi2Status)fm_set_up(f, tolerance_defined, tolerance, start);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component instance) {
    FM_OPEN(FM_START);
    f->core.stands = FM_INIT;
    return fmi2OK;
}

/* --- values --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component instance, const fmi2ValueReference vr[], size_t count, fmi2Real values[]) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(vr, count);
    FM_ARRAY(values, count);
    return (fmi2Status)fm_get_reals(f, vr, count, values);
}

fmi2Status fmi2SetReal(fmi2Component instance, const fmi2ValueReference vr[], size_t count, const fmi2Real values[]) {
    FM_OPEN(FM_START | FM_RUNNING);
    FM_ARRAY(vr, count);
    FM_ARRAY(values, count);
    return (fmi2Status)fm_set_reals(f, vr, count, values);
}

fmi2Status fmi2GetInteger(fmi2Component instance, const fmi2ValueReference vr[], size_t count, fmi2Integer values[]) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(vr, count);
    FM_ARRAY(values, count);
    return (fmi2Status)fm_get_integers(f, vr, count, values);
}

/* The FMU has no variables of the other kinds, and no integers to set. */
#define FM_NONE(name, type)                                                                                           \
    fmi2Status name(fmi2Component instance, const fmi2ValueReference vr[], size_t count, type values[]) {             \
        (void)vr, (void)values;                                                                                       \
        return (fmi2Status)fm_none(instance, count, __func__);                                                        \
    }
FM_NONE(fmi2SetInteger, const fmi2Integer)
FM_NONE(fmi2GetBoolean, fmi2Boolean)
FM_NONE(fmi2SetBoolean, const fmi2Boolean)
FM_NONE(fmi2GetString, fmi2String)
FM_NONE(fmi2SetString, const fmi2String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    FM_OPEN(FM_RUNNING | FM_DONE);
    FM_ARRAY(unknown, unknowns);
    FM_ARRAY(known, knowns);
    FM_ARRAY(seed, knowns);
    FM_ARRAY(sensitivity, unknowns);
    return (fmi2Status)fm_directional(f, unknown, unknowns, known, knowns, seed, sensitivity);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component instance, fmi2EventInfo *info) {
    int jumped;
    FM_OPEN(FM_EVENT);
    FM_ARRAY(info, 1);
    memset(info, 0, sizeof *info);
    const int status = fm_iterate(f, &jumped);
    info->valuesOfContinuousStatesChanged = jumped;
    return (fmi2Status)status;
}

/* --- Co-Simulation -------------------------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real values[]) {
    FM_OPEN(FM_IF(FM_COSIMULATION, FM_START | FM_INIT | FM_STEP));
    FM_ARRAY(vr, count);
    FM_ARRAY(order, count);
    FM_ARRAY(values, count);
    for (size_t i = 0; i < count; i++)
        if (fm_set_slope(f, vr[i], order[i], values[i]) != FM_OK) return fmi2Error;
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real values[]) {
    FM_OPEN(FM_IF(FM_COSIMULATION, FM_STEP | FM_DONE));
    FM_ARRAY(vr, count);
    FM_ARRAY(order, count);
    FM_ARRAY(values, count);
    return (fmi2Status)fm_output_slopes(f, vr, count, order, values);
}

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
    FM_OPEN(FM_STEP);
    (void)no_return;
    return (fmi2Status)fm_step(f, t, h, 0);
}

fmi2Status fmi2CancelStep(fmi2Component instance) {
    FM_OPEN(FM_ANY);
    FM_FAIL("steps end before they return: there is none to cancel");
}

/* What an importer may ask about the last step: one answer of each type at most. */
#define FM_STATUS(name, type, about, answer)                                                                          \
    fmi2Status name(fmi2Component instance, const fmi2StatusKind kind, type *value) {                                 \
        FM_OPEN(FM_ANY);                                                                                              \
        FM_ARRAY(value, 1);                                                                                           \
        if (kind != (about)) return fmi2Discard;                                                                      \
        *value = (answer);                                                                                            \
        return fmi2OK;                                                                                                \
    }
FM_STATUS(fmi2GetStatus, fmi2Status, fmi2DoStepStatus, fm_stopped(&f->core) ? fmi2Discard : fmi2OK)
FM_STATUS(fmi2GetRealStatus, fmi2Real, fmi2LastSuccessfulTime, fm_now(&f->core))
FM_STATUS(fmi2GetBooleanStatus, fmi2Boolean, fmi2Terminated, fm_stopped(&f->core))

fmi2Status fmi2GetIntegerStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Integer *value) {
    FM_OPEN(FM_ANY);
    (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2String *value) {
    FM_OPEN(FM_ANY);
    (void)kind;
    FM_ARRAY(value, 1);
    *value = "";
    return fmi2Discard;
}
