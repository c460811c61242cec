/* Co-Simulation: from one communication point to the next. */
#ifndef FM_STEP_H
#define FM_STEP_H

#include "modes.h"

static const char *fm_why(int status) {
    switch (status) {
    case SB_UNBOUNDED: return "the motion is unbounded";
    case SB_TOO_MANY_EVENTS: return "too many events in a short time";
    case SB_STEP_TOO_SMALL: return "the step size became too small";
    case SB_TOO_MANY_STEPS: return "too many steps in a short time";
    default: return "the motion is not finite";
    }
}

/* Settle under what was set since the last step. Gives 0 where too many commands are on their way. */
static int fm_take_inputs(fm_instance *f, double *next) {
    fm_core *c = &f->core;
    if (!fm_command_note(c)) return 0;
    const int changed = fm_command_now(c, next);
    if (changed || c->touched) c->sim.fresh = 0, sb_settle(&c->sim);
    c->touched = 0;
    return 1;
}

/* Advance from the time t by h; where `early`, only to the first event. Events that may not wait are passed inside. */
static int fm_step(fm_instance *f, double t, double h, int early) {
    fm_core *c = &f->core;
    sb_sim *s = &c->sim;
    const double end = t + h;
    const long before = s->events;
    double next;
    if (fm_follows(f, t, h, s->t) != FM_OK) return FM_ERROR;
    if (s->status != SB_OK) return fm_fail(f, "the step before has failed");
    c->known = 0;
    if (s->waiting) fm_update(f);
    if (!sb_finite(s->y, SB_NS)) s->status = SB_NOT_FINITE;
    else if (!fm_take_inputs(f, &next)) {
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "more than %d changes of the command are on their way: take longer steps",
               FM_RING);
        return FM_ERROR;
    }
    s->defer = (char)early;
    while (s->status == SB_OK && s->t < end && !s->waiting) {
        sb_advance(s, fmin(end, next));
        if (s->status == SB_OK && next <= s->t && fm_command_now(c, &next)) s->fresh = 0, sb_settle(s);
    }
    memset(c->slope, 0, sizeof c->slope); /* of this step alone: the next one holds what is set */
    if (s->events != before) fm_log(f, FM_OK, FM_LOG_EVENTS, "%ld events up to t = %.15g s", s->events - before, s->t);
    if (s->status == SB_OK) return FM_OK;
    fm_log(f, FM_DISCARD, FM_LOG_DISCARD, "stopped at t = %.15g s: %s", s->t, fm_why(s->status));
    return FM_DISCARD;
}

#endif
