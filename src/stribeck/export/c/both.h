/* The functions that both versions of the standard have, each once.
 *
 * Included by fmi2.c and fmi3.c, which say how their version names things: FMI(name), FMI_STATE(before, after) and
 * FMI_READ_STATE for functions, fmi_status, fmi_handle, fmi_boolean, fmi_string, fmi_byte and fmi_reference for types.
 * What an arm or a controller does at these calls stands in its part.h.
 */
#ifndef FM_BOTH_H
#define FM_BOTH_H

#include "blob.h"

#define FM_OPEN(where)                                                                                                \
    fm_instance *f = instance;                                                                                        \
    if (!fm_may(f, (where), __func__)) return (fmi_status)FM_ERROR
#define FM_ARRAY(array, count)                                                                                        \
    if (!fm_given(f, (array), (count), __func__)) return (fmi_status)FM_ERROR
#define FM_FAIL(what) return (fmi_status)fm_fail(f, what)
#define FM_ONE_EACH(count, wanted, what)                                                                              \
    if ((count) != (wanted)) FM_FAIL("the number of " what " is another")
#define FM_IF(kind_of, where) (f && f->kind == (kind_of) ? (where) : 0) /* modes, for one kind of instance alone */
#define FM_READABLE (FM_INIT | FM_EVENT | FM_CONTINUOUS | FM_DONE)

/* What an importer leaves out of the call is NULL; gives NULL where it asks for what there is not. */
static fm_instance *fm_make(int kind, const char *name, int log_on, void *environment, void (*logger)(void),
                            void (*say)(const fm_instance *, int, const char *, const char *),
                            void *(*allocate)(size_t, size_t), void (*release)(void *)) {
    fm_instance *f = allocate(1, sizeof *f);
    if (!f) return NULL;
    memset(f, 0, sizeof *f);
    fm_restart(&f->core);
    fm_name(f, name);
    f->kind = kind, f->log_on = log_on, f->log_mask = FM_LOG_ALL;
    f->environment = environment, f->logger = logger, f->say = logger ? say : NULL;
    f->allocate = allocate, f->release = release;
    return f;
}

void FMI(FreeInstance)(fmi_handle instance) {
    fm_instance *f = instance;
    if (f) f->release(f);
}

fmi_status FMI(SetDebugLogging)(fmi_handle instance, fmi_boolean on, size_t count, const fmi_string names[]) {
    FM_OPEN(FM_ANY);
    return (fmi_status)fm_set_log(f, on, count, names);
}

/* --- from mode to mode ---------------------------------------------------------------------------------------- */

/* What a simulation begins with: the tolerance, where the importer gives one, and the time. */
static int fm_set_up(fm_instance *f, int tolerance_defined, double tolerance, double start) {
    if (tolerance_defined && fm_set_tolerance(f, tolerance) != FM_OK) return FM_ERROR;
    if (start - start != 0.0) return fm_fail(f, "the start time is not finite");
    fm_set_start(f, start);
    return FM_OK;
}

fmi_status FMI(ExitInitializationMode)(fmi_handle instance) {
    FM_OPEN(FM_INIT);
    fm_begin(f);
    f->core.stands = f->kind == FM_EXCHANGE || f->event_mode ? FM_EVENT : FM_STEP;
    return (fmi_status)FM_OK;
}

fmi_status FMI(EnterEventMode)(fmi_handle instance) {
    FM_OPEN(f && (f->kind == FM_EXCHANGE || f->event_mode) ? FM_CONTINUOUS | FM_STEP | FM_EVENT : 0);
    fm_enter_events(f);
    f->core.stands = FM_EVENT;
    return (fmi_status)FM_OK;
}

fmi_status FMI(EnterContinuousTimeMode)(fmi_handle instance) {
    FM_OPEN(FM_IF(FM_EXCHANGE, FM_EVENT));
    f->core.stands = FM_CONTINUOUS;
    return (fmi_status)FM_OK;
}

fmi_status FMI(Terminate)(fmi_handle instance) {
    FM_OPEN(FM_EVENT | FM_CONTINUOUS | FM_STEP);
    f->core.stands = FM_DONE;
    return (fmi_status)FM_OK;
}

fmi_status FMI(Reset)(fmi_handle instance) {
    FM_OPEN(FM_ANY);
    fm_restart(&f->core);
    return (fmi_status)FM_OK;
}

/* --- values --------------------------------------------------------------------------------------------------- */

static int fm_get_reals(fm_instance *f, const fmi_reference vr[], size_t count, double values[]) {
    for (size_t i = 0; i < count; i++)
        if (fm_get_real(f, vr[i], values + i) != FM_OK) return FM_ERROR;
    return FM_OK;
}

static int fm_set_reals(fm_instance *f, const fmi_reference vr[], size_t count, const double values[]) {
    for (size_t i = 0; i < count; i++)
        if (fm_set_real(f, vr[i], values[i]) != FM_OK) return FM_ERROR;
    return FM_OK;
}

static int fm_get_integers(fm_instance *f, const fmi_reference vr[], size_t count, int32_t values[]) {
    for (size_t i = 0; i < count; i++)
        if (fm_get_integer(f, vr[i], values + i) != FM_OK) return FM_ERROR;
    return FM_OK;
}

static int fm_output_slopes(fm_instance *f, const fmi_reference vr[], size_t count, const int32_t orders[],
                            double values[]) {
    for (size_t i = 0; i < count; i++)
        if (fm_output_slope(f, vr[i], orders[i], values + i) != FM_OK) return FM_ERROR;
    return FM_OK;
}

/* --- the FMU's state ------------------------------------------------------------------------------------------ */

fmi_status FMI_STATE(Get, )(fmi_handle instance, void **state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    if (!*state) *state = f->allocate(1, sizeof(fm_core));
    if (!*state) FM_FAIL("no memory for a copy of the state");
    *(fm_core *)*state = f->core;
    return (fmi_status)FM_OK;
}

fmi_status FMI_STATE(Set, )(fmi_handle instance, void *state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    fm_adopt(f, state);
    return (fmi_status)FM_OK;
}

fmi_status FMI_STATE(Free, )(fmi_handle instance, void **state) {
    FM_OPEN(FM_ANY);
    if (state && *state) f->release(*state), *state = NULL;
    return (fmi_status)FM_OK;
}

fmi_status FMI_STATE(Serialized, Size)(fmi_handle instance, void *state, size_t *size) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    FM_ARRAY(size, 1);
    *size = fm_blob_size();
    return (fmi_status)FM_OK;
}

fmi_status FMI_STATE(Serialize, )(fmi_handle instance, void *state, fmi_byte bytes[], size_t size) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(state, 1);
    FM_ARRAY(bytes, size);
    if (size < fm_blob_size()) FM_FAIL("the state does not fit the bytes");
    fm_write(state, (unsigned char *)bytes);
    return (fmi_status)FM_OK;
}

fmi_status FMI_READ_STATE(fmi_handle instance, const fmi_byte bytes[], size_t size, void **state) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(bytes, size);
    FM_ARRAY(state, 1);
    fm_core *core = f->allocate(1, sizeof *core);
    if (!core) FM_FAIL("no memory for a copy of the state");
    const char *wrong = fm_read(core, (const unsigned char *)bytes, size);
    if (wrong) {
        f->release(core);
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "the serialised state is refused: %s", wrong);
        return (fmi_status)FM_ERROR;
    }
    if (*state) f->release(*state);
    *state = core;
    return (fmi_status)FM_OK;
}

/* --- Model Exchange ------------------------------------------------------------------------------------------- */

fmi_status FMI(CompletedIntegratorStep)(fmi_handle instance, fmi_boolean no_return, fmi_boolean *event,
                                        fmi_boolean *terminate) {
    FM_OPEN(FM_CONTINUOUS);
    FM_ARRAY(event, 1);
    FM_ARRAY(terminate, 1);
    (void)no_return;
    *event = *terminate = 0;
    return (fmi_status)FM_OK;
}

fmi_status FMI(SetTime)(fmi_handle instance, double time) {
    FM_OPEN(FM_IF(FM_EXCHANGE, FM_EVENT | FM_CONTINUOUS));
    if (time - time != 0.0) FM_FAIL("the time is not finite");
    fm_set_time(f, time);
    return (fmi_status)FM_OK;
}

/* Whether every one of some numbers is finite. */
static int fm_finite(const double x[], size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += x[i] - x[i];
    return sum == 0.0;
}

fmi_status FMI(SetContinuousStates)(fmi_handle instance, const double x[], size_t count) {
    FM_OPEN(FM_CONTINUOUS);
    FM_ARRAY(x, count);
    FM_ONE_EACH(count, FM_STATES, "states");
    if (!fm_finite(x, count)) FM_FAIL("a state is not finite");
    fm_set_states(f, x);
    return (fmi_status)FM_OK;
}

fmi_status FMI_GET_RATES(fmi_handle instance, double derivatives[], size_t count) {
    FM_OPEN(FM_READABLE);
    FM_ARRAY(derivatives, count);
    FM_ONE_EACH(count, FM_STATES, "states");
    fm_get_rates(f, derivatives);
    if (fm_finite(derivatives, count)) return (fmi_status)FM_OK;
    fm_log(f, FM_DISCARD, FM_LOG_DISCARD, "the derivatives are not finite at t = %.15g s", fm_now(&f->core));
    return (fmi_status)FM_DISCARD;
}

fmi_status FMI(GetEventIndicators)(fmi_handle instance, double indicators[], size_t count) {
    FM_OPEN(FM_READABLE);
    FM_ARRAY(indicators, count);
    FM_ONE_EACH(count, FM_INDICATORS, "event indicators");
    fm_get_indicators(f, indicators);
    return (fmi_status)FM_OK;
}

fmi_status FMI(GetContinuousStates)(fmi_handle instance, double x[], size_t count) {
    FM_OPEN(FM_READABLE);
    FM_ARRAY(x, count);
    FM_ONE_EACH(count, FM_STATES, "states");
    fm_get_states(f, x);
    return (fmi_status)FM_OK;
}

fmi_status FMI(GetNominalsOfContinuousStates)(fmi_handle instance, double nominals[], size_t count) {
    FM_OPEN(FM_ANY);
    FM_ARRAY(nominals, count);
    FM_ONE_EACH(count, FM_STATES, "states");
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0;
    return (fmi_status)FM_OK;
}

#endif
