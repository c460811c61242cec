/* Initial state, evaluation, event indicators and the event iteration. */
#ifndef FM_MODES_H
#define FM_MODES_H

#include "command.h"

#define FM_EDGE 1e-10 /* rad/s past zero at which a sliding joint's indicator changes sign: never zero at its start */
#define FM_PAST 1e-9  /* N m past break-away at which a stuck joint's does: found from either side, it lies past it */
#define FM_BEYOND 1e-3 /* rad/s past zero beyond which the equations see standstill no farther behind */
#define FM_SLOW 1e-9  /* rad/s: a joint that brakes and is slower at an event has come to rest */

static void fm_stale(fm_instance *f) { f->core.sim.fresh = f->core.known = 0; }

/* Derivatives and margins at the present instant. An importer's trial step may lie far past standstill, where the
 * sliding law must not run away; near it the law goes on smoothly, so that steps keep their order. */
static void fm_evaluate(fm_instance *f) {
    sb_sim *s = &f->core.sim;
    double y[SB_NS];
    if (s->fresh) return;
    memcpy(y, s->y, sizeof y);
    for (int j = 0; j < SB_N && f->kind == FM_EXCHANGE; j++)
        if (!sb_bristle[j] && s->mode[j] * y[SB_N + j] < -FM_BEYOND) y[SB_N + j] = -FM_BEYOND * s->mode[j];
    sb_rhs(s, s->t, y, s->f, s->margin);
    s->fresh = 1;
}

/* What the sensors give at the present instant. */
static void fm_look(fm_instance *f) {
    fm_core *c = &f->core;
    if (c->known) return;
    sb_report(&c->sim, c->seen, c->seen + SB_N, c->seen + 2 * SB_N, c->seen + 3 * SB_N);
    c->known = 1;
}

/* The state with which the simulation starts, from the values set so far. */
static void fm_begin(fm_instance *f) {
    fm_core *c = &f->core;
    sb_sim *s = &c->sim;
    const double *arg[FM_BEGIN_ARG];
    double *res[FM_BEGIN_RES], w[FM_BEGIN_W + 1];
    long long int iw[FM_BEGIN_IW + 1];
    if (!c->touched) return;
    arg[0] = c->q_start, arg[1] = c->dq_start, arg[2] = c->tau, arg[3] = c->p;
    res[0] = s->y;
    fm_start(arg, res, iw, w, 0);
    memset(s->mode, 0, sizeof s->mode);
    memset(s->held, 0, sizeof s->held);
    fm_command_start(c);
    fm_stale(f);
    sb_settle(s);
    s->events = 0; /* how it starts is no event */
    c->known = c->touched = 0;
}

/* Changes sign where the mode of a joint ends. */
static double fm_indicator(const sb_sim *s, int j) {
    if (sb_bristle[j]) return 1.0;
    if (s->mode[j] != 0.0) return s->mode[j] * s->y[SB_N + j] + FM_EDGE;
    return fmin(s->margin[j], s->margin[SB_N + j]) + FM_PAST;
}

/* Bring the modes up to date at the present instant, to the end in this one call. Tells whether a state jumped. */
static int fm_update(fm_instance *f) {
    sb_sim *s = &f->core.sim;
    const long before = s->events;
    int jumped = 0;
    if (f->kind == FM_COSIMULATION && f->core.touched) { /* what has led here comes first, then what was set here */
        fm_ramp(s, s->t, NULL, s->u, NULL);
        s->fresh = 0;
    }
    if (s->waiting) { /* the engine stands at an event */
        s->waiting = 0;
        sb_pass(s, s->passing);
        jumped = 1;
    } else {
        fm_evaluate(f);
        for (int j = 0; j < SB_N; j++) {
            double *v = &s->y[SB_N + j];
            const double ahead = s->mode[j] * *v;
            if (f->kind != FM_EXCHANGE || sb_bristle[j] || s->mode[j] == 0.0 || *v == 0.0) continue;
            if (ahead < 0.0 || (ahead <= FM_SLOW && s->mode[j] * s->f[SB_N + j] < 0.0)) *v = 0.0, jumped = 1;
        }
        s->fresh = 0;
        sb_settle(s);
    }
    f->core.known = f->core.touched = 0;
    if (s->events != before)
        for (int j = 0; j < SB_N; j++)
            fm_log(f, FM_OK, FM_LOG_EVENTS, "t = %.15g s: joint %d %s", s->t, j + 1,
                   s->mode[j] == 0.0 ? "sticks" : s->mode[j] > 0.0 ? "slides forward" : "slides backward");
    return jumped;
}

/* The integrator's state. A joint that sticks stays at rest, whatever an importer that lost a jump may say. */
static void fm_set_states(fm_instance *f, const double *y) {
    sb_sim *s = &f->core.sim;
    memcpy(s->y, y, sizeof(double) * SB_NS);
    for (int j = 0; j < SB_N; j++)
        if (!sb_bristle[j] && s->mode[j] == 0.0) s->y[SB_N + j] = 0.0;
    fm_stale(f);
}

#endif
