/* Contact modes: which joints stick, which slide, and where a step meets a change of mode. */
#ifndef SB_CONTACT_H
#define SB_CONTACT_H

#include "solver.h"

static const char sb_bristle[SB_N] = SB_BRISTLES; /* friction carried by a state: no modes */

/* Values that are positive while the present modes hold. */
static void sb_watch(const sb_sim *s, const double *y, const double *margin, double *g) {
    for (int j = 0; j < SB_N; j++) {
        if (sb_bristle[j] || s->clamped[j]) g[j] = 1.0;
        else if (s->mode[j] != 0.0) g[j] = s->mode[j] * y[SB_N + j];
        else g[j] = fmin(margin[j], margin[SB_N + j]);
    }
}

/* How far modes are from holding at the present state, for joints at rest: 0 where they hold. */
static double sb_violation(const sb_sim *s, const double *mode, const double *dy, const double *margin) {
    double worst = 0.0;
    for (int j = 0; j < SB_N; j++) {
        if (sb_bristle[j] || s->clamped[j] || s->y[SB_N + j] != 0.0) continue;
        if (mode[j] == 0.0) worst = fmax(worst, -fmin(margin[j], margin[SB_N + j]));
        else if (!(mode[j] * dy[SB_N + j] > 0.0)) worst = fmax(worst, fmax(-mode[j] * dy[SB_N + j], 1e-300));
    }
    return worst;
}

static void sb_note(sb_sim *s, int joint, double before, double after) {
    s->events++;
    if (s->log && s->log_count < s->log_size) {
        sb_event *e = s->log + s->log_count++;
        e->t = s->t, e->joint = joint, e->mode_before = before, e->mode_after = after;
    }
}

/* Search the 3^k combinations of the k joints at rest, fewest sliding first, and take the one that holds. */
static void sb_search(sb_sim *s, const int *rest, int k, double *mode) {
    double best = HUGE_VAL, trial[SB_N], dy[SB_NY], margin[2 * SB_N], kept[SB_N];
    long total = 1;
    for (int i = 0; i < k; i++) total *= 3;
    memcpy(kept, s->mode, sizeof kept);
    memcpy(trial, s->mode, sizeof trial);
    for (int sliding = 0; sliding <= k && best > 0.0; sliding++)
        for (long code = 0; code < total && best > 0.0; code++) {
            int count = 0;
            long rest_of = code;
            for (int i = 0; i < k; i++, rest_of /= 3) {
                trial[rest[i]] = rest_of % 3 == 2 ? -1.0 : (double)(rest_of % 3);
                count += rest_of % 3 != 0;
            }
            if (count != sliding) continue;
            memcpy(s->mode, trial, sizeof trial);
            sb_rhs(s, s->t, s->y, dy, margin);
            const double violation = sb_violation(s, trial, dy, margin);
            if (violation < best) best = violation, memcpy(mode, trial, sizeof trial);
        }
    memcpy(s->mode, kept, sizeof kept);
}

/* Set the modes that hold at the present state and command. */
static void sb_settle(sb_sim *s) {
    int rest[SB_N], k = 0, moving = 0;
    double before[SB_N], mode[SB_N];
    memcpy(before, s->mode, sizeof before);
    for (int j = 0; j < SB_N; j++) {
        const double v = s->y[SB_N + j];
        if (s->clamped[j]) s->mode[j] = 0.0;
        else if (sb_bristle[j]) s->mode[j] = v < 0.0 ? -1.0 : 1.0; /* any but 0: the row is not masked */
        else if (v != 0.0) {
            s->mode[j] = v > 0.0 ? 1.0 : -1.0;
        } else rest[k++] = j, moving += s->mode[j] != 0.0;
    }
    if (k == 0) {
        if (s->remember) s->remember(s);
        return;
    }
    s->fresh = 0;
    if (!moving) { /* usual at a new command: all that rest go on resting */
        sb_rhs(s, s->t, s->y, s->f, s->margin);
        s->fresh = sb_violation(s, s->mode, s->f, s->margin) == 0.0;
    }
    if (!s->fresh) {
        memcpy(mode, s->mode, sizeof mode);
        sb_search(s, rest, k, mode);
        memcpy(s->mode, mode, sizeof mode);
    }
    for (int j = 0; j < SB_N; j++)
        if (!sb_bristle[j] && s->mode[j] != before[j]) sb_note(s, j, before[j], s->mode[j]);
    if (s->remember) s->remember(s);
}

/* Smallest watch value; a joint that has just begun to slide (fresh[j]) counts only once it is below zero. */
static double sb_lowest(const double *g, const char *begun) {
    double low = HUGE_VAL;
    for (int j = 0; j < SB_N; j++)
        if (!(begun[j] && g[j] >= 0.0)) low = fmin(low, g[j]);
    return low;
}

/* Shrink the step h, at whose end a watch value is below zero, to the first instant at which one is.
 * Every trial is a whole step of the method, so that the state there has its full order. */
static double sb_locate(sb_sim *s, double h, const char *begun, double start, double end, double *after,
                        double *fafter, double *margin, double *g) {
    double low = 0.0, high = h, at_low = start, at_high = end, width = h;
    double y[SB_NY], f[SB_NY], m[2 * SB_N], trial[SB_N];
    const double narrow = 1e-13 + 1e-15 * fabs(s->t);
    for (int i = 0; i < 200 && high - low > narrow; i++) {
        double at = 0.5 * (low + high);
        if (i % 3 != 2 && at_low < HUGE_VAL) at = low + (high - low) * at_low / (at_low - at_high);
        at = fmin(fmax(at, low + 0.4 * narrow), high - 0.4 * narrow);
        sb_try(s, at, y, f, m);
        sb_watch(s, y, m, trial);
        const double value = sb_lowest(trial, begun);
        if (value < 0.0) {
            high = at, at_high = value;
            memcpy(after, y, sizeof y), memcpy(fafter, f, sizeof f), memcpy(margin, m, sizeof m);
            memcpy(g, trial, sizeof trial);
            if (high - low > 0.5 * width) at_low *= 0.5;
        } else {
            low = at, at_low = value;
            if (high - low > 0.5 * width) at_high *= 0.5;
        }
        width = high - low;
    }
    return high;
}

#endif
