/* The part that this FMU is: an arm, with true stiction. What the standard's functions (both.h) ask of a part. */
#ifndef FM_PART_H
#define FM_PART_H

#include "core.h"
#include "instance.h"

#include "slopes.h"
#include "step.h"

/* Put everything back to how it was after instantiation. */
static void fm_restart(fm_core *c) {
    memset(c, 0, sizeof *c);
    for (int i = 0; i < SB_NP; i++) c->p[i] = fm_defaults[i];
    sb_init(&c->sim, c->p, FM_TOLERANCE);
    c->sim.bound = FM_BOUND;
    c->tolerance = FM_TOLERANCE;
    c->stands = FM_START, c->touched = 1;
}

/* Take a core that lay elsewhere. */
static void fm_adopt(fm_instance *f, const fm_core *c) {
    if (&f->core != c) f->core = *c;
    f->core.sim.p = f->core.p;
    f->core.sim.control = NULL;
    for (int j = 0; j < SB_N; j++)
        if (f->core.ring[j][f->core.at[j]].slope != 0.0) f->core.sim.control = fm_ramp;
}

/* Whether values that came as bytes can be gone on from: what they index lies inside, what they say can be. */
static int fm_sound(const fm_core *c) {
    int sound = c->sim.status >= SB_OK && c->sim.status <= SB_NOT_FINITE;
    sound &= c->sim.rtol > 0.0 && c->sim.atol > 0.0 && c->sim.h > 0.0 && c->sim.longest > 0.0 && sb_finite(&c->sim.t, 1);
    sound &= sb_finite(c->p, SB_NP) && sb_finite(c->tau, SB_N) && sb_finite(c->slope, SB_N);
    for (int j = 0; j < SB_N; j++) {
        const double m = c->sim.mode[j];
        sound &= m == 0.0 || m == 1.0 || m == -1.0;
        sound &= c->count[j] >= 0 && c->count[j] <= FM_RING;
        sound &= c->newest[j] >= 0 && c->newest[j] < FM_RING && c->at[j] >= 0 && c->at[j] < FM_RING;
        sound &= c->count[j] == 0 || (c->newest[j] < c->count[j] && c->at[j] < c->count[j]);
    }
    return sound;
}

static int fm_set_tolerance(fm_instance *f, double tolerance) {
    if (!(tolerance > 0.0 && tolerance < 1.0)) return fm_fail(f, "the tolerance must lie between 0 and 1");
    f->core.tolerance = tolerance > 1e-13 ? tolerance : 1e-13;
    f->core.sim.rtol = 0.1 * f->core.tolerance, f->core.sim.atol = 0.01 * f->core.tolerance;
    return FM_OK;
}

static void fm_set_start(fm_instance *f, double time) { f->core.start = f->core.sim.t = time, f->core.touched = 1; }

/* The derivative of an input over the next communication step. */
static int fm_set_slope(fm_instance *f, unsigned vr, int order, double value) {
    if (vr < FM_TAU || vr >= (unsigned)FM_Q || order != 1)
        return fm_fail(f, "only inputs have a derivative, of order 1");
    if (value - value != 0.0) return fm_fail(f, "an input's derivative is not finite");
    f->core.slope[vr - FM_TAU] = value;
    return FM_OK;
}

static double fm_now(const fm_core *c) { return c->sim.t; }
static int fm_stopped(const fm_core *c) { return c->sim.status != SB_OK; }
static int fm_waits(const fm_core *c) { return c->sim.waiting != 0; }

static void fm_enter_events(fm_instance *f) {
    if (f->core.stands == FM_STEP) f->core.known = 0;
}

/* The event iteration, to its end. */
static int fm_iterate(fm_instance *f, int *jumped) {
    double unused;
    *jumped = fm_update(f);
    if (f->kind == FM_COSIMULATION && !fm_take_inputs(f, &unused))
        return fm_fail(f, "too many changes of the command are on their way");
    return FM_OK;
}

/* --- Model Exchange ------------------------------------------------------------------------------------------- */

static void fm_set_time(fm_instance *f, double time) {
    if (f->core.sim.t != time) f->core.sim.t = time, fm_stale(f);
}

static void fm_get_states(fm_instance *f, double *y) {
    if (f->core.stands == FM_INIT) fm_begin(f);
    memcpy(y, f->core.sim.y, sizeof(double) * SB_NS);
}

static void fm_get_rates(fm_instance *f, double *rates) {
    fm_stand_still(f);
    memcpy(rates, f->core.sim.f, sizeof(double) * SB_NS);
}

static void fm_get_indicators(fm_instance *f, double *indicators) {
    fm_stand_still(f);
    for (int j = 0, i = 0; j < SB_N; j++)
        if (!sb_bristle[j]) indicators[i++] = fm_indicator(&f->core.sim, j);
}

#endif
