/* One instance of an FMU: what it runs (its core), how the importer wants it, and where it stands.
 *
 * Included by part.h once that has said what an fm_core is. Nothing is global, and after instantiation memory is
 * asked for only where the standard wants an object to be made (a copy of the FMU state).
 */
#ifndef FM_INSTANCE_H
#define FM_INSTANCE_H

#include <float.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "bare.h"

/* Where an instance stands in the standard's state machine; kept in its core's `stands`. */
enum { FM_START = 1, FM_INIT = 2, FM_EVENT = 4, FM_CONTINUOUS = 8, FM_STEP = 16, FM_DONE = 32, FM_CONFIGURE = 64 };
enum { FM_RUNNING = FM_INIT | FM_EVENT | FM_CONTINUOUS | FM_STEP, FM_ANY = 127 };

enum { FM_EXCHANGE, FM_COSIMULATION };

/* As in both versions of the standard. */
enum { FM_OK, FM_WARNING, FM_DISCARD, FM_ERROR };

enum { FM_LOG_EVENTS = 1, FM_LOG_WARNING = 2, FM_LOG_DISCARD = 4, FM_LOG_ERROR = 8, FM_LOG_ALL = 15 };
static const char *const fm_categories[] = {"logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError"};

typedef struct fm_instance fm_instance;
struct fm_instance {
    fm_core core; /* all that changes while it runs; a copy of it is an FMU state */
    int kind, event_mode, early_return, log_on, log_mask;
    void (*say)(const fm_instance *f, int status, const char *category, const char *text);
    void *environment;
    void (*logger)(void); /* the importer's, of its version's type */
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
    char name[128];
};

static void fm_log(const fm_instance *f, int status, int category, const char *format, ...) {
    char text[512];
    int number = 0;
    va_list arguments;
    if (!f->say || !f->log_on || !(f->log_mask & category)) return;
    while (!(category >> number & 1)) number++;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    f->say(f, status, fm_categories[number], text);
}

static int fm_fail(const fm_instance *f, const char *what) {
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "%s", what);
    return FM_ERROR;
}

static const char *fm_name_of(int stands) {
    switch (stands) {
    case FM_START: return "before initialization";
    case FM_INIT: return "in initialization mode";
    case FM_EVENT: return "in event mode";
    case FM_CONTINUOUS: return "in continuous-time mode";
    case FM_STEP: return "in step mode";
    case FM_CONFIGURE: return "in configuration mode";
    default: return "after termination";
    }
}

/* Whether a function may be called now; says so in the log where not. */
static int fm_may(const fm_instance *f, int where, const char *function) {
    if (!f) return 0;
    if (f->core.stands & where) return 1;
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "%s must not be called %s", function, fm_name_of(f->core.stands));
    return 0;
}

/* Whether an array that the importer hands over is there. */
static int fm_given(const fm_instance *f, const void *array, size_t count, const char *function) {
    if (array || count == 0) return 1;
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "%s was given no array for %lu values", function, (unsigned long)count);
    return 0;
}

/* Whether a function for variables that the FMU does not have was called for none. */
static int fm_none(const fm_instance *f, size_t count, const char *function) {
    if (!f) return FM_ERROR;
    if (count == 0) return FM_OK;
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "%s: no such variable", function);
    return FM_ERROR;
}

static int fm_set_log(fm_instance *f, int on, size_t count, const char *const *names) {
    int mask = 0;
    for (size_t i = 0; i < count; i++) {
        int bit = 0;
        if (!names || !names[i]) return fm_fail(f, "a log category has no name");
        if (!strcmp(names[i], "logAll")) bit = FM_LOG_ALL;
        for (int k = 0; k < 4; k++)
            if (!strcmp(names[i], fm_categories[k])) bit = 1 << k;
        if (!bit) {
            fm_log(f, FM_ERROR, FM_LOG_ERROR, "unknown log category \"%s\"", names[i]);
            return FM_ERROR;
        }
        mask |= bit;
    }
    f->log_on = on, f->log_mask = count ? mask : FM_LOG_ALL;
    return FM_OK;
}

static void fm_name(fm_instance *f, const char *name) {
    size_t length = name ? strlen(name) : 0;
    if (length >= sizeof f->name) length = sizeof f->name - 1;
    if (length) memcpy(f->name, name, length);
    f->name[length] = 0;
}

/* What forbids an instance of this kind with this token, or NULL. */
static const char *fm_refuses(int kind, const char *token) {
    if (!token || strcmp(token, FM_TOKEN)) return "the token (GUID) is not that of this FMU's modelDescription.xml";
    if (kind == FM_EXCHANGE && sizeof(FM_ONLY_STEPS) > 1) return FM_ONLY_STEPS;
    return NULL;
}

static int fm_refuse(const fm_instance *f, unsigned vr, double value, const char *why) {
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "the variable with value reference %u cannot be set to %g %s: %s", vr, value,
           fm_name_of(f->core.stands), why);
    return FM_ERROR;
}

static int fm_unknown_real(const fm_instance *f, unsigned vr) {
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "no real variable has value reference %u", vr);
    return FM_ERROR;
}

/* Whether a step may begin at t and last h: it does where the last one ended, but for what importers lose in adding
 * up. A thousandth of a step tells one that is repeated or left out, late in a simulation too. */
static int fm_follows(const fm_instance *f, double t, double h, double stands_at) {
    if (!(h > 0.0) || t + h - (t + h) != 0.0) return fm_fail(f, "the communication step must be positive and finite");
    const double lost = fmin(1e-9 * (1.0 + fabs(t)), 1e-3 * h), rounding = 8.0 * DBL_EPSILON * fabs(t);
    if (fabs(t - stands_at) <= fmax(lost, rounding)) return FM_OK;
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "a step from t = %.15g s was asked for, but time stands at %.15g s", t, stands_at);
    return FM_ERROR;
}

#endif
