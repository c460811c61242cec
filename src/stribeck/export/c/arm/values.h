/* Variables by value reference; the ranges mirror variables.py. */
#ifndef FM_VALUES_H
#define FM_VALUES_H

#include "modes.h"

enum {
    FM_TIME,
    FM_TAU,
    FM_Q = FM_TAU + SB_N,
    FM_DQ = FM_Q + SB_N,
    FM_FRICTION = FM_DQ + SB_N,
    FM_SLIDING = FM_FRICTION + SB_N,
    FM_STATE = FM_SLIDING + SB_N,
    FM_RATE = FM_STATE + SB_NS,
    FM_INDICATOR = FM_RATE + SB_NS,
    FM_P = FM_INDICATOR + SB_N,
    FM_Q_START = FM_P + SB_NP,
    FM_DQ_START = FM_Q_START + SB_N,
    FM_CONSTANT = FM_DQ_START + SB_N,
    FM_MODE = FM_CONSTANT + FM_CONSTANTS,
    FM_EVENTS = FM_MODE + SB_N,
    FM_END
};

static double fm_sliding(const sb_sim *s, int j) {
    const double v = s->y[SB_N + j];
    return sb_bristle[j] ? (v > 0.0) - (v < 0.0) : s->mode[j];
}

static int fm_get_real(fm_instance *f, unsigned vr, double *value) {
    fm_core *c = &f->core;
    const sb_sim *s = &c->sim;
    const int i = (int)vr;
    if (vr >= FM_MODE) return fm_unknown_real(f, vr);
    if (i >= FM_CONSTANT) return *value = fm_constants[i - FM_CONSTANT], FM_OK;
    if (i >= FM_DQ_START) return *value = c->dq_start[i - FM_DQ_START], FM_OK;
    if (i >= FM_Q_START) return *value = c->q_start[i - FM_Q_START], FM_OK;
    if (i >= FM_P) return *value = c->p[i - FM_P], FM_OK;
    if (i == FM_TIME) return *value = s->t, FM_OK;
    if (i < FM_Q) return *value = c->tau[i - FM_TAU], FM_OK;
    if (c->stands & (FM_START | FM_INIT | FM_CONFIGURE)) fm_begin(f);
    if (i >= FM_INDICATOR) return fm_evaluate(f), *value = fm_indicator(s, i - FM_INDICATOR), FM_OK;
    if (i >= FM_RATE) return fm_evaluate(f), *value = s->f[i - FM_RATE], FM_OK;
    if (i >= FM_STATE) return *value = s->y[i - FM_STATE], FM_OK;
    if (i >= FM_SLIDING) return *value = fm_sliding(s, i - FM_SLIDING), FM_OK;
    fm_look(f);
    *value = c->seen[i - FM_Q];
    return FM_OK;
}

static int fm_get_integer(fm_instance *f, unsigned vr, int32_t *value) {
    if (vr < FM_MODE || vr >= FM_END) {
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "no integer variable has value reference %u", vr);
        return FM_ERROR;
    }
    if (f->core.stands & (FM_START | FM_INIT | FM_CONFIGURE)) fm_begin(f);
    *value = vr == FM_EVENTS ? (int32_t)f->core.sim.events : (int32_t)f->core.sim.mode[vr - FM_MODE];
    return FM_OK;
}

static int fm_set_parameter(fm_instance *f, unsigned vr, double value) {
    const int i = (int)vr - FM_P;
    if (f->core.p[i] == value) return FM_OK;
    if (fm_fixed[i] && !(f->core.stands & (FM_START | FM_INIT)))
        return fm_refuse(f, vr, value, "it says how a simulation starts");
    if (f->core.stands == FM_CONTINUOUS) return fm_refuse(f, vr, value, "a parameter is tuned in event mode");
    if (!(value >= fm_lower[i] && value <= fm_upper[i])) {
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "the parameter with value reference %u must lie between %g and %g, not %g",
               vr, fm_lower[i], fm_upper[i], value);
        return FM_ERROR;
    }
    f->core.p[i] = value, fm_stale(f), f->core.touched = 1;
    return FM_OK;
}

static int fm_set_real(fm_instance *f, unsigned vr, double value) {
    fm_core *c = &f->core;
    const int i = (int)vr;
    if (value - value != 0.0) return fm_refuse(f, vr, value, "it must be finite");
    if (vr >= FM_TAU && vr < FM_Q) {
        if (c->tau[i - FM_TAU] == value) return FM_OK;
        c->tau[i - FM_TAU] = value, c->touched = 1;
        /* in step mode it is of the next step; a late one comes through by the ring */
        if (f->kind == FM_EXCHANGE || (c->stands == FM_EVENT && fm_delay(c, i - FM_TAU) == 0.0))
            c->sim.u[i - FM_TAU] = value, fm_stale(f);
        return FM_OK;
    }
    if (vr >= FM_P && vr < FM_Q_START) return fm_set_parameter(f, vr, value);
    if (vr >= FM_Q_START && vr < FM_CONSTANT) {
        double *start = vr < FM_DQ_START ? &c->q_start[i - FM_Q_START] : &c->dq_start[i - FM_DQ_START];
        if (*start == value) return FM_OK; /* gemseo-fmu, older OpenModelicas: all anew, late */
        if (!(c->stands & (FM_START | FM_INIT))) return fm_refuse(f, vr, value, "it says how a simulation starts");
        *start = value;
        c->touched = 1;
        return FM_OK;
    }
    return fm_refuse(f, vr, value, "it is neither an input nor a parameter");
}

#endif
