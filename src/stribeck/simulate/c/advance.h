/* From one instant to the next: error-controlled steps that end at events. */
#ifndef SB_ADVANCE_H
#define SB_ADVANCE_H

#include "contact.h"

/* The longest step: what time itself does to a joint that sticks shows in no error. */
static double sb_longest(const sb_sim *s) {
    double most = s->longest;
    for (int i = 0; sb_waves[i][0] >= 0; i++) {
        const double frequency = fabs(s->p[sb_waves[i][0]]) * sb_waves[i][1];
        if (frequency > 0.0) most = fmin(most, SB_PART / frequency);
    }
    return most;
}

/* Look inside a step whose end is fine for an excursion: gives a shorter step that ends in one, or 0. */
static double sb_inside(sb_sim *s, double h, const double *after, const double *fafter, const char *begun,
                        double *y, double *f, double *margin, double *g) {
    double at = 0.0;
    int stuck = 0;
    for (int j = 0; j < SB_N; j++) {
        const double m = s->mode[j];
        if (s->clamped[j]) continue;
        if (sb_bristle[j]) continue;
        if (m == 0.0) { stuck = 1; continue; }
        const double v0 = m * s->y[SB_N + j], v1 = m * after[SB_N + j];
        const double d0 = h * m * s->f[SB_N + j], d1 = h * m * fafter[SB_N + j];
        if (begun[j] || d0 >= 0.0 || d1 <= 0.0) continue;
        /* the velocity's cubic through both ends: v0 + d0 x + b x^2 + a x^3 */
        const double a = 2 * (v0 - v1) + d0 + d1, b = 3 * (v1 - v0) - 2 * d0 - d1;
        const double root = sqrt(fmax(b * b - 3 * a * d0, 0.0)), x = d0 / -(b + root);
        if (x > 0.0 && x < 1.0 && v0 + x * (d0 + x * (b + x * a)) < 0.0) at = at > 0.0 ? fmin(at, x) : x;
    }
    if (at == 0.0 && stuck) {
        for (int i = 0; i < s->ny; i++) y[i] = 0.5 * (s->y[i] + after[i]) + h / 8 * (s->f[i] - fafter[i]);
        sb_rhs(s, s->t + 0.5 * h, y, f, margin);
        sb_watch(s, y, margin, g);
        for (int j = 0; j < SB_N; j++)
            if (s->mode[j] == 0.0 && g[j] < 0.0) at = 0.5;
    }
    if (at == 0.0) return 0.0;
    sb_try(s, at * h, y, f, margin);
    sb_watch(s, y, margin, g);
    return sb_lowest(g, begun) < 0.0 ? at * h : 0.0;
}

/* Take the state at the end of a step. */
static void sb_accept(sb_sim *s, double t, const double *y, const double *f, const double *margin) {
    for (int j = 0; j < SB_N; j++) {
        if (s->mode[j] == 0.0) s->stuck_time[j] += t - s->t;
        s->top_speed[j] = fmax(s->top_speed[j], fabs(y[SB_N + j]));
    }
    s->t = t;
    memcpy(s->y, y, sizeof(double) * s->ny);
    memcpy(s->f, f, sizeof(double) * s->ny);
    memcpy(s->margin, margin, sizeof s->margin);
    s->steps++;
    if (s->remember) s->remember(s);
    for (int j = 0; j < SB_N; j++) {
        const double far = fmin(fabs(y[j]), fabs(y[j] - s->ramp[j] * t)); /* what is led, or left behind, does not grow */
        if (!(far < s->bound && fabs(y[SB_N + j]) < s->bound)) s->status = SB_UNBOUNDED;
    }
}

/* Pass an event at the present state, found by the watch values g. */
static void sb_pass(sb_sim *s, const double *g) {
    for (int j = 0; j < SB_N; j++)
        if (!sb_bristle[j] && s->mode[j] != 0.0 && g[j] < 0.0) s->y[SB_N + j] = 0.0;
    s->stalled = s->t - s->last_event < 1e-12 * (1.0 + fabs(s->t)) ? s->stalled + 1 : 0;
    s->last_event = s->t;
    if (s->stalled > 20) s->status = SB_TOO_MANY_EVENTS;
    s->fresh = 0;
    sb_settle(s);
}

static void sb_choose_method(sb_sim *s) {
    if (!s->stiff && s->suspicion > 15) {
        s->stiff = 1;
    } else if (s->stiff && s->steps % 50 == 49) {
        /* would the explicit method do at this step? */
        double y[SB_NY], f[SB_NY], margin[2 * SB_N];
        if (sb_explicit(s, s->h, y, f, margin) < 1.0 && !s->near_edge) s->stiff = s->suspicion = 0;
    }
    if (s->stiff) sb_slopes(s, s->matrix, s->dfdt);
}

/* One accepted step, at most h; an event ends it early. Gives 0 where the step cannot be made. */
static int sb_step(sb_sim *s, double limit) {
    double y[SB_NY], f[SB_NY], margin[2 * SB_N], g0[SB_N], g[SB_N];
    char begun[SB_N] = {0};
    if (!s->fresh) sb_rhs(s, s->t, s->y, s->f, s->margin), s->fresh = 1;
    if (!sb_finite(s->f, s->ny)) return s->status = SB_NOT_FINITE, 0;
    sb_choose_method(s);
    sb_watch(s, s->y, s->margin, g0);
    for (int j = 0; j < SB_N; j++) begun[j] = g0[j] <= 0.0 && s->mode[j] != 0.0;
    for (double h = fmin(fmin(s->h, sb_longest(s)), limit);;) {
        const double error = sb_try(s, h, y, f, margin);
        if (!(error <= 1.0)) {
            s->rejected++;
            h *= error > 0.0 && error < HUGE_VAL ? fmax(0.2, 0.9 * pow(error, s->stiff ? -0.25 : -0.2)) : 0.1;
            s->h = h;
            if (h < 1e-14 * (1.0 + fabs(s->t))) return s->status = SB_STEP_TOO_SMALL, 0;
            continue;
        }
        if (!s->stiff) { /* stiff is who keeps coming near the edge of the stability region */
            s->calm = s->near_edge ? 0 : s->calm + 1;
            s->suspicion = s->calm > 5 ? 0 : s->suspicion + s->near_edge;
        }
        const double grow = fmin(5.0, 0.9 * pow(fmax(error, 1e-10), s->stiff ? -0.25 : -0.2));
        s->h = h < limit ? h * grow : fmax(s->h, h * grow);
        sb_watch(s, y, margin, g);
        if (sb_lowest(g, begun) >= 0.0) {
            double yi[SB_NY], fi[SB_NY], mi[2 * SB_N], gi[SB_N];
            const double inside = sb_inside(s, h, y, f, begun, yi, fi, mi, gi);
            if (inside == 0.0) {
                sb_accept(s, h < limit ? s->t + h : s->t + limit, y, f, margin);
                return 1;
            }
            h = inside;
            memcpy(y, yi, sizeof y), memcpy(f, fi, sizeof f), memcpy(margin, mi, sizeof margin);
            memcpy(g, gi, sizeof g);
        }
        h = sb_locate(s, h, begun, sb_lowest(g0, begun), sb_lowest(g, begun), y, f, margin, g);
        sb_accept(s, s->t + h, y, f, margin);
        if (s->status != SB_OK) return 1;
        if (s->defer) memcpy(s->passing, g, sizeof g), s->waiting = 1;
        else sb_pass(s, g);
        return 1;
    }
}

/* Integrate to the instant end under the present command, or to the first event where events are to wait. */
static int sb_advance(sb_sim *s, double end) {
    double since = s->t;
    long steps = s->steps, events = s->events;
    while (s->status == SB_OK && s->t < end && !s->waiting) {
        const double left = end - s->t;
        if (s->t - since >= SB_WHILE) since = s->t, steps = s->steps, events = s->events;
        if (!sb_step(s, left)) break;
        if (end - s->t < 1e-14 * (1.0 + fabs(end))) s->t = end;
        if (s->steps - steps > s->step_limit) s->status = SB_TOO_MANY_STEPS;
        if (s->events - events > s->event_limit) s->status = SB_TOO_MANY_EVENTS;
    }
    return s->status;
}

#endif
