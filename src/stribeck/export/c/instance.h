/* One instance of the FMU: the engine's simulation, the values that the importer sets, and where it stands.
 *
 * Included after the generated model (model.h). Nothing is global, and after instantiation memory is asked for only
 * where the standard wants an object to be made (a copy of the FMU state).
 */
#ifndef FM_INSTANCE_H
#define FM_INSTANCE_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "bare.h"

#include "advance.h"
#include "report.h"

#define FM_BOUND 1e5 /* rad and rad/s; beyond it a motion is unbounded */
#define FM_TOLERANCE 1e-8
#ifndef FM_RING
#define FM_RING 1 /* commands that are kept for a delay */
#endif

/* Where an instance stands in the standard's state machine. */
enum { FM_START = 1, FM_INIT = 2, FM_EVENT = 4, FM_CONTINUOUS = 8, FM_STEP = 16, FM_DONE = 32, FM_CONFIGURE = 64 };
enum { FM_RUNNING = FM_INIT | FM_EVENT | FM_CONTINUOUS | FM_STEP, FM_ANY = 127 };

enum { FM_EXCHANGE, FM_COSIMULATION };

/* As in both versions of the standard. */
enum { FM_OK, FM_WARNING, FM_DISCARD, FM_ERROR };

enum { FM_LOG_EVENTS = 1, FM_LOG_WARNING = 2, FM_LOG_DISCARD = 4, FM_LOG_ERROR = 8, FM_LOG_ALL = 15 };
static const char *const fm_categories[] = {"logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError"};

/* A command from one instant on: value + slope (t - start). */
typedef struct {
    double start, value, slope;
} fm_command;

/* All that changes while it runs; a copy of it is an FMU state. */
typedef struct {
    sb_sim sim;
    double p[SB_NP + 1], q_start[SB_N], dq_start[SB_N], tau[SB_N], slope[SB_N];
    fm_command ring[SB_N][FM_RING];
    double seen[4 * SB_N]; /* recorded position and velocity, friction and actuator torque, where known */
    double tolerance, start;
    int count[SB_N], newest[SB_N], at[SB_N]; /* of the rings: how many, where the last, and which is in force */
    int stands, touched, known; /* touched: an input or a parameter was set since the last step or event */
} fm_core;

typedef struct fm_instance fm_instance;
struct fm_instance {
    fm_core core;
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

/* Put everything back to how it was after instantiation. */
static void fm_restart(fm_instance *f) {
    fm_core *c = &f->core;
    memset(c, 0, sizeof *c);
    for (int i = 0; i < SB_NP; i++) c->p[i] = fm_defaults[i];
    sb_init(&c->sim, c->p, FM_TOLERANCE);
    c->sim.bound = FM_BOUND;
    c->tolerance = FM_TOLERANCE;
    c->stands = FM_START, c->touched = 1;
}

static void fm_name(fm_instance *f, const char *name) {
    size_t length = name ? strlen(name) : 0;
    if (length >= sizeof f->name) length = sizeof f->name - 1;
    if (length) memcpy(f->name, name, length);
    f->name[length] = 0;
}

/* What forbids an instance of this kind, or NULL. */
static const char *fm_refuses(int kind) {
    if (kind == FM_EXCHANGE && sizeof(FM_ONLY_STEPS) > 1) return FM_ONLY_STEPS;
    return NULL;
}

static int fm_set_tolerance(fm_instance *f, double tolerance) {
    if (!(tolerance > 0.0 && tolerance < 1.0)) return fm_fail(f, "the tolerance must lie between 0 and 1");
    f->core.tolerance = tolerance > 1e-13 ? tolerance : 1e-13;
    f->core.sim.rtol = 0.1 * f->core.tolerance, f->core.sim.atol = 0.01 * f->core.tolerance;
    return FM_OK;
}

static int fm_set_start(fm_instance *f, double time) {
    if (time - time != 0.0) return fm_fail(f, "the start time is not finite");
    f->core.start = f->core.sim.t = time, f->core.touched = 1;
    return FM_OK;
}

#endif
