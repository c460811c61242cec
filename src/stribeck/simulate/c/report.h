/* What the sensors give, and the torques, at the present state. */
#ifndef SB_REPORT_H
#define SB_REPORT_H

#include "solver.h"

static void sb_report(sb_sim *s, double *measured, double *rate, double *friction, double *actuator) {
    const double *arg[SB_OUTPUTS_ARG], *u = s->u;
    double *res[SB_OUTPUTS_RES], now[SB_N], dz[SB_NZ + 1];
    long long int iw[SB_OUTPUTS_IW + 1];
    double w[SB_OUTPUTS_W + 1];
    if (s->control) s->control(s, s->t, s->y, now, dz), u = now;
    arg[0] = &s->t, arg[1] = s->y, arg[2] = s->mode, arg[3] = u, arg[4] = s->p;
    res[0] = measured, res[1] = rate, res[2] = friction, res[3] = actuator;
    sb_outputs(arg, res, iw, w, 0);
}

#endif
