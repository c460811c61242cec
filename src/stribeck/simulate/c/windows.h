/* Open loop under recorded commands, whole or in windows that each start at a given state. */
#ifndef SB_WINDOWS_H
#define SB_WINDOWS_H

#include "advance.h"
#include "report.h"

static const int sb_delays[][2] = SB_DELAYS; /* (joint, place in p), closed by -1 */

/* A sampled command, held from each instant to the next and delayed for each joint. */
typedef struct {
    const double *times, *command; /* (count), (count, SB_N) */
    long count, at[SB_N];
    double delay[SB_N];
    int quiet; /* no torque before the first command has come through, rather than the first one */
} sb_hold;

static void sb_hold_start(sb_hold *c, const double *times, const double *command, long count, const double *p,
                          double t) {
    memset(c, 0, sizeof *c);
    c->times = times, c->command = command, c->count = count;
    for (int k = 0; sb_delays[k][0] >= 0; k++) c->delay[sb_delays[k][0]] += p[sb_delays[k][1]];
    for (int j = 0; j < SB_N; j++) {
        long low = 0, high = count; /* the last instant that has come through, 0 before the first */
        while (high - low > 1) {
            const long middle = (low + high) / 2;
            if (times[middle] + c->delay[j] <= t) low = middle;
            else high = middle;
        }
        c->at[j] = low;
    }
}

/* Give the command at time t and the next instant at which it changes. Tells whether it changed. */
static int sb_hold_at(sb_hold *c, double t, double *u, double *next) {
    int changed = 0;
    *next = HUGE_VAL;
    for (int j = 0; j < SB_N; j++) {
        while (c->at[j] + 1 < c->count && c->times[c->at[j] + 1] + c->delay[j] <= t) c->at[j]++;
        const int early = c->quiet && c->at[j] == 0 && c->times[0] + c->delay[j] > t;
        const double value = early ? 0.0 : c->command[c->at[j] * SB_N + j];
        if (early) *next = fmin(*next, c->times[0] + c->delay[j]);
        changed |= value != u[j];
        u[j] = value;
        if (c->at[j] + 1 < c->count) *next = fmin(*next, c->times[c->at[j] + 1] + c->delay[j]);
    }
    return changed;
}

/* Where results go: (., 6, SB_N) recorded position and velocity, friction and actuator torque, time stuck so far, top
 * speed since the row before; the rest may be NULL. */
typedef struct {
    double *signals, *modes, *states;
} sb_record;

static void sb_store(sb_sim *s, const sb_record *r, long row) {
    double *out = r->signals + row * 6 * SB_N;
    sb_report(s, out, out + SB_N, out + 2 * SB_N, out + 3 * SB_N);
    memcpy(out + 4 * SB_N, s->stuck_time, sizeof s->stuck_time);
    memcpy(out + 5 * SB_N, s->top_speed, sizeof s->top_speed);
    memset(s->top_speed, 0, sizeof s->top_speed);
    for (int j = 0; r->modes && j < SB_N; j++) {
        const double v = s->y[SB_N + j];
        r->modes[row * SB_N + j] = !sb_bristle[j] ? s->mode[j] : v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0;
    }
    if (r->states) memcpy(r->states + row * SB_NS, s->y, sizeof(double) * SB_NS);
}

/* Simulate samples first .. first + samples - 1 from the state y; gives the number of rows that were filled. */
static long sb_window(sb_sim *s, const double *times, const double *command, long count, long first, long samples,
                      const double *y, const double *mode, const sb_record *r, long row) {
    sb_hold hold;
    double next;
    s->t = times[first];
    memcpy(s->y, y, sizeof(double) * SB_NS);
    for (int j = 0; j < SB_N; j++) s->mode[j] = mode ? mode[j] : 0.0;
    if (!sb_finite(s->y, SB_NS)) return s->status = SB_NOT_FINITE, 0;
    sb_hold_start(&hold, times, command, count, s->p, s->t);
    sb_hold_at(&hold, s->t, s->u, &next);
    sb_settle(s);
    s->events = 0, s->log_count = 0;
    sb_store(s, r, row);
    for (long i = 1; i < samples; i++) {
        const double end = times[first + i];
        while (s->t < end) {
            if (sb_advance(s, fmin(end, next)) != SB_OK) return i;
            if (s->t < end || next <= end) {
                if (sb_hold_at(&hold, s->t, s->u, &next)) s->fresh = 0, sb_settle(s);
            }
        }
        sb_store(s, r, row + i);
    }
    return samples;
}

/* Exported. Windows w of samples[w] rows from first[w], one after the other; info (windows, 4): status, rows filled,
 * events, steps. */
SB_EXPORT void sb_windows(const double *p, double tolerance, double bound, const double *times, const double *command,
                          long long count, long long windows, const long long *first, const long long *samples,
                          const double *y, const double *mode, double *signals, double *modes, double *states,
                          long long *info, sb_event *log, long long log_size) {
    sb_record record = {signals, modes, states};
    long row = 0;
    for (long w = 0; w < windows; w++) {
        sb_sim s;
        sb_init(&s, p, tolerance);
        s.bound = bound, s.log = log, s.log_size = log_size;
        const long filled = sb_window(&s, times, command, count, first[w], samples[w], y + w * SB_NS,
                                      mode ? mode + w * SB_N : NULL, &record, row);
        info[4 * w] = s.status, info[4 * w + 1] = filled, info[4 * w + 2] = s.events, info[4 * w + 3] = s.steps;
        row += samples[w];
    }
}

/* Exported. Steps of one size by one method in the present modes, events ignored: for convergence studies. */
SB_EXPORT int sb_fixed(const double *p, int implicit, double h, long long steps, double *y, const double *mode,
                       const double *u) {
    sb_sim s;
    double after[SB_NY], f[SB_NY], margin[2 * SB_N];
    sb_init(&s, p, 1.0);
    memcpy(s.y, y, sizeof(double) * SB_NS);
    memcpy(s.mode, mode, sizeof s.mode);
    memcpy(s.u, u, sizeof s.u);
    s.stiff = implicit;
    for (long long i = 0; i < steps; i++) {
        sb_rhs(&s, s.t, s.y, s.f, s.margin);
        if (implicit) sb_slopes(&s, s.matrix, s.dfdt);
        if (!(sb_try(&s, h, after, f, margin) >= 0.0)) return SB_NOT_FINITE;
        memcpy(s.y, after, sizeof after);
        s.t += h;
    }
    memcpy(y, s.y, sizeof(double) * SB_NS);
    return SB_OK;
}

#endif
