/* FMI 2.0 for Co-Simulation over the controller. */
#include "control.h"
#include "model.h"

#include "core.h"

#include "fmi2Functions.h"

#define CT_OPEN(where)                                                                                                 \
    ct_instance *f = c;                                                                                                \
    if (!ct_may(f, where, __func__)) return fmi2Error

static void ct_say(const void *c, const char *text) {
    const ct_instance *f = c;
    ((fmi2CallbackLogger)f->logger)(f->environment, "controller", fmi2Error, "logStatusError", "%s", text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean log_on) {
    (void)name, (void)resources, (void)visible;
    if (type != fmi2CoSimulation || !guid || strcmp(guid, CT_TOKEN) != 0) return NULL;
    ct_instance *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    if (log_on && functions && functions->logger) {
        f->logger = (void (*)(void))functions->logger, f->environment = functions->componentEnvironment;
        f->say = ct_say;
    }
    ct_restart(&f->core);
    return f;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String names[]) {
    CT_OPEN(CT_ANY);
    (void)count, (void)names;
    if (!on) f->say = NULL;
    else if (f->logger) f->say = ct_say;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean known, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean ends, fmi2Real stop) {
    CT_OPEN(CT_START);
    (void)known, (void)tolerance, (void)ends, (void)stop;
    if (start - start != 0.0) return fmi2Error;
    f->core.start = f->core.time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    CT_OPEN(CT_START);
    f->core.stands = CT_INIT;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    CT_OPEN(CT_INIT);
    ct_begin(&f->core);
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    CT_OPEN(CT_STEP);
    f->core.stands = CT_DONE;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    CT_OPEN(CT_ANY);
    ct_restart(&f->core);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real value[]) {
    CT_OPEN(CT_ANY);
    for (size_t i = 0; i < count; i++)
        if (!vr || !value || !ct_get(&f->core, vr[i], value + i)) return (fmi2Status)ct_fail(f, "no such variable");
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Real value[]) {
    CT_OPEN(CT_START | CT_INIT | CT_STEP);
    for (size_t i = 0; i < count; i++)
        if (!vr || !value || !ct_set(&f->core, vr[i], value[i])) return (fmi2Status)ct_fail(f, "cannot be set to this");
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean keep) {
    CT_OPEN(CT_STEP);
    (void)keep;
    return (fmi2Status)ct_do_step(f, t, h);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    CT_OPEN(CT_ANY);
    if (!state || (!*state && !(*state = malloc(sizeof(ct_core))))) return fmi2Error;
    memcpy(*state, &f->core, sizeof f->core);
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    CT_OPEN(CT_ANY);
    if (!state) return fmi2Error;
    memcpy(&f->core, state, sizeof f->core);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    CT_OPEN(CT_ANY);
    if (state) free(*state), *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    CT_OPEN(CT_ANY);
    if (!state || !size) return fmi2Error;
    *size = CT_BYTES;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    CT_OPEN(CT_ANY);
    if (!state || !bytes || size < CT_BYTES) return (fmi2Status)ct_fail(f, "the state does not fit the bytes");
    ct_write(state, bytes);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    CT_OPEN(CT_ANY);
    if (!bytes || !state || (!*state && !(*state = malloc(sizeof(ct_core))))) return fmi2Error;
    if (ct_read(*state, bytes, size)) return fmi2OK;
    free(*state), *state = NULL;
    return (fmi2Status)ct_fail(f, "the bytes are no state of this FMU");
}

/* What a controller without such variables has to say. */
#define CT_NO_VALUES(name, type)                                                                                       \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t count, type value[]) {                      \
        CT_OPEN(CT_ANY);                                                                                               \
        (void)vr, (void)value;                                                                                         \
        return count ? (fmi2Status)ct_fail(f, #name ": no such variable") : fmi2OK;                                    \
    }
CT_NO_VALUES(fmi2GetInteger, fmi2Integer)
CT_NO_VALUES(fmi2GetBoolean, fmi2Boolean)
CT_NO_VALUES(fmi2GetString, fmi2String)
CT_NO_VALUES(fmi2SetInteger, const fmi2Integer)
CT_NO_VALUES(fmi2SetBoolean, const fmi2Boolean)
CT_NO_VALUES(fmi2SetString, const fmi2String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    CT_OPEN(CT_ANY);
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)seed, (void)sensitivity;
    return (fmi2Status)ct_fail(f, "a sampled controller gives no derivatives");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    CT_OPEN(CT_ANY);
    (void)vr, (void)order, (void)value;
    return count ? (fmi2Status)ct_fail(f, "inputs are not interpolated") : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[]) {
    CT_OPEN(CT_ANY);
    (void)vr, (void)order, (void)value;
    return count ? (fmi2Status)ct_fail(f, "outputs are held between samples: no derivatives") : fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    CT_OPEN(CT_ANY);
    return (fmi2Status)ct_fail(f, "steps end before they return: there is none to cancel");
}

#define CT_NO_STATUS(name, type)                                                                                       \
    fmi2Status name(fmi2Component c, const fmi2StatusKind kind, type *value) {                                         \
        CT_OPEN(CT_ANY);                                                                                               \
        (void)kind, (void)value;                                                                                       \
        return fmi2Discard;                                                                                            \
    }
CT_NO_STATUS(fmi2GetStatus, fmi2Status)
CT_NO_STATUS(fmi2GetRealStatus, fmi2Real)
CT_NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
CT_NO_STATUS(fmi2GetBooleanStatus, fmi2Boolean)
CT_NO_STATUS(fmi2GetStringStatus, fmi2String)
