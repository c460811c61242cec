/* Directional and adjoint derivatives in the present modes, by the forward and reverse mode of the generated code. */
#ifndef FM_SLOPES_H
#define FM_SLOPES_H

#include "values.h"

/* What the generated derivatives take: t, y, u, p in one column; and give: rates, recorded position and velocity,
 * friction torque, margins. */
enum { FM_X_T, FM_X_Y, FM_X_U = FM_X_Y + SB_NS, FM_X_P = FM_X_U + SB_N, FM_X = FM_X_P + SB_NP };
enum { FM_W_RATE, FM_W_SEEN = SB_NS, FM_W_MARGIN = FM_W_SEEN + 3 * SB_N, FM_W = FM_W_MARGIN + 2 * SB_N };
/* And those of the start: q_start, dq_start, u, p. */
enum { FM_S_DQ = SB_N, FM_S_U = 2 * SB_N, FM_S_P = 3 * SB_N, FM_S = FM_S_P + SB_NP };

typedef struct {
    double x[FM_X], start[FM_S], w[FM_W], late; /* late: of a delayed input */
} fm_seeds;

#define FM_LARGER(a, b) ((a) > (b) ? (a) : (b))

/* The equations' derivative along `in` (FM_X) into (FM_W), or its adjoint the other way. */
static void fm_call_along(fm_instance *f, int adjoint, const double *in, double *out) {
    fm_core *c = &f->core;
    const double *arg[FM_LARGER(FM_TANGENT_ARG, FM_ADJOINT_ARG)];
    double *res[FM_LARGER(FM_TANGENT_RES, FM_ADJOINT_RES)], work[FM_LARGER(FM_TANGENT_W, FM_ADJOINT_W) + 1];
    long long int iw[FM_LARGER(FM_TANGENT_IW, FM_ADJOINT_IW) + 1];
    arg[0] = &c->sim.t, arg[1] = c->sim.y, arg[2] = c->sim.mode, arg[3] = c->sim.u, arg[4] = c->p, arg[5] = in;
    res[0] = out;
    (adjoint ? fm_adjoint : fm_tangent)(arg, res, iw, work, 0);
}

/* The start's derivative along `in` (FM_S) into (SB_NS), or its adjoint the other way. */
static void fm_call_start(fm_instance *f, int adjoint, const double *in, double *out) {
    fm_core *c = &f->core;
    const double *arg[FM_LARGER(FM_BEGIN_TANGENT_ARG, FM_BEGIN_ADJOINT_ARG)];
    double *res[FM_LARGER(FM_BEGIN_TANGENT_RES, FM_BEGIN_ADJOINT_RES)];
    double work[FM_LARGER(FM_BEGIN_TANGENT_W, FM_BEGIN_ADJOINT_W) + 1];
    long long int iw[FM_LARGER(FM_BEGIN_TANGENT_IW, FM_BEGIN_ADJOINT_IW) + 1];
    arg[0] = c->q_start, arg[1] = c->dq_start, arg[2] = c->tau, arg[3] = c->p, arg[4] = in;
    res[0] = out;
    (adjoint ? fm_start_adjoint : fm_start_tangent)(arg, res, iw, work, 0);
}

/* The place of a known variable among the seeds, or NULL. */
static double *fm_known(fm_instance *f, fm_seeds *s, unsigned vr) {
    const int i = (int)vr, begins = f->core.stands == FM_INIT;
    if (vr == FM_TIME) return &s->x[FM_X_T];
    if (vr < FM_Q && begins) return &s->start[FM_S_U + i - FM_TAU];
    if (vr < FM_Q) return fm_delay(&f->core, i - FM_TAU) > 0.0 ? &s->late : &s->x[FM_X_U + i - FM_TAU];
    if (vr >= FM_STATE && vr < FM_RATE && !begins) return &s->x[FM_X_Y + i - FM_STATE];
    if (vr >= FM_P && vr < FM_Q_START) return begins ? &s->start[FM_S_P + i - FM_P] : &s->x[FM_X_P + i - FM_P];
    if (vr >= FM_Q_START && vr < FM_CONSTANT && begins) return &s->start[i - FM_Q_START];
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "no derivative with respect to value reference %u %s", vr,
           fm_name_of(f->core.stands));
    return NULL;
}

/* An unknown variable as factors times results: (place in w, factor) or, in initialization, a state's place. */
static int fm_unknown(fm_instance *f, unsigned vr, int *place, double *factor, int *state) {
    const sb_sim *s = &f->core.sim;
    const int i = (int)vr;
    *factor = 1.0, *state = -1, *place = -1;
    if (vr >= FM_Q && vr < FM_SLIDING) return *place = FM_W_SEEN + i - FM_Q, 1;
    if (vr >= FM_SLIDING && vr < FM_STATE) return *factor = 0.0, *place = 0, 1; /* constant between events */
    if (vr >= FM_STATE && vr < FM_RATE && f->core.stands == FM_INIT) return *state = i - FM_STATE, 1;
    if (vr >= FM_RATE && vr < FM_INDICATOR) return *place = i - FM_RATE, 1;
    if (vr >= FM_INDICATOR && vr < FM_P && !sb_bristle[i - FM_INDICATOR]) {
        const int j = i - FM_INDICATOR;
        if (s->mode[j] != 0.0) return *state = SB_N + j, *factor = s->mode[j], 1;
        return *place = FM_W_MARGIN + (s->margin[j] <= s->margin[SB_N + j] ? j : SB_N + j), 1;
    }
    fm_log(f, FM_ERROR, FM_LOG_ERROR, "no derivative of value reference %u %s", vr, fm_name_of(f->core.stands));
    return 0;
}

/* Make sure that the derivatives are taken where the values are. */
static void fm_stand_still(fm_instance *f) {
    if (f->core.stands == FM_INIT) fm_begin(f);
    fm_evaluate(f);
}

static int fm_directional(fm_instance *f, const unsigned *unknown, size_t unknowns, const unsigned *known,
                          size_t knowns, const double *seed, double *sensitivity) {
    fm_seeds s;
    memset(&s, 0, sizeof s);
    fm_stand_still(f);
    for (size_t k = 0; k < knowns; k++) {
        double *at = fm_known(f, &s, known[k]);
        if (!at) return FM_ERROR;
        *at += seed[k];
    }
    if (f->core.stands == FM_INIT) {
        fm_call_start(f, 0, s.start, s.x + FM_X_Y);
        memcpy(s.x + FM_X_U, s.start + FM_S_U, sizeof(double) * (SB_N + SB_NP)); /* u and p follow each other in both */
    }
    fm_call_along(f, 0, s.x, s.w);
    for (size_t i = 0; i < unknowns; i++) {
        int place, state;
        double factor;
        if (!fm_unknown(f, unknown[i], &place, &factor, &state)) return FM_ERROR;
        sensitivity[i] = factor * (state >= 0 ? s.x[FM_X_Y + state] : s.w[place]);
    }
    return FM_OK;
}

static int fm_adjoint_derivative(fm_instance *f, const unsigned *unknown, size_t unknowns, const unsigned *known,
                                 size_t knowns, const double *seed, double *sensitivity) {
    fm_seeds s;
    double direct[SB_NS] = {0};
    memset(&s, 0, sizeof s);
    fm_stand_still(f);
    for (size_t i = 0; i < unknowns; i++) {
        int place, state;
        double factor;
        if (!fm_unknown(f, unknown[i], &place, &factor, &state)) return FM_ERROR;
        if (state >= 0) direct[state] += factor * seed[i];
        else s.w[place] += factor * seed[i];
    }
    fm_call_along(f, 1, s.w, s.x);
    for (int i = 0; i < SB_NS; i++) s.x[FM_X_Y + i] += direct[i];
    if (f->core.stands == FM_INIT) {
        fm_call_start(f, 1, s.x + FM_X_Y, s.start);
        for (int i = 0; i < SB_N + SB_NP; i++) s.start[FM_S_U + i] += s.x[FM_X_U + i];
    }
    for (size_t k = 0; k < knowns; k++) {
        const double *at = fm_known(f, &s, known[k]);
        if (!at) return FM_ERROR;
        sensitivity[k] = *at;
    }
    return FM_OK;
}

/* Time derivative of an output along the present motion. */
static int fm_output_slope(fm_instance *f, unsigned vr, int order, double *value) {
    fm_seeds s;
    if (order != 1 || vr < FM_Q || vr >= FM_STATE) return fm_fail(f, "only outputs have a derivative, of order 1");
    memset(&s, 0, sizeof s);
    fm_evaluate(f);
    s.x[FM_X_T] = 1.0;
    memcpy(s.x + FM_X_Y, f->core.sim.f, sizeof(double) * SB_NS);
    if (f->core.sim.control)
        for (int j = 0; j < SB_N; j++) s.x[FM_X_U + j] = f->core.ring[j][f->core.at[j]].slope;
    fm_call_along(f, 0, s.x, s.w);
    *value = vr < FM_SLIDING ? s.w[FM_W_SEEN + (int)vr - FM_Q] : 0.0;
    return FM_OK;
}

#endif
