/* Closed loops: the sampled and the continuous controller around the arm. */
#ifndef SB_LOOP_H
#define SB_LOOP_H

#include "control.h"
#include "windows.h"

enum { SB_INTEGRAL, SB_FILTER, SB_LAG, SB_THETA, SB_OWN = SB_THETA + 3 }; /* states of a continuous controller's joint */

/* The loop at hand. Arrays of `count` rows: q what the encoder gives, noise may be NULL. */
typedef struct {
    const sb_axis *axis; /* (SB_N) */
    double sample, start[SB_N];
    long long count;
    const double *times, *noise;
    double *command, *seen;
} sb_loop;

/* --- sampled -------------------------------------------------------------------------------------------------- */

/* Between samples only the drive's lag moves. */
static void sb_sampled_lag(sb_sim *s, double t, const double *y, double *u, double *dz) {
    const sb_loop *loop = s->loop;
    (void)t;
    for (int j = 0; j < SB_N; j++) {
        const double lag = loop->axis[j].controlled ? loop->axis[j].lag : 0.0;
        u[j] = lag > 0.0 ? y[SB_NS + j] : s->u[j];
        dz[j] = lag > 0.0 ? (s->u[j] - y[SB_NS + j]) / lag : 0.0;
    }
}

/* Commands of sample k, delayed by whole samples, into row k. */
static void sb_sample(sb_sim *s, const sb_loop *loop, sb_memory *memory, double *computed, long k) {
    double q[SB_N], dq[SB_N], unused[SB_N], friction[SB_N];
    sb_report(s, q, dq, friction, unused);
    for (int j = 0; j < SB_N; j++) {
        const sb_axis *a = loop->axis + j;
        if (a->controlled && loop->noise) q[j] += loop->noise[k * SB_N + j];
        if (a->controlled) q[j] = sb_encoded(a, q[j]);
        loop->seen[k * SB_N + j] = q[j];
        computed[k * SB_N + j] = 0.0;
        if (a->controlled)
            computed[k * SB_N + j] = sb_sampled(a, memory + j, loop->times[k], loop->sample, k == 0, q[j], dq[j]);
        loop->command[k * SB_N + j] = k >= a->delay ? computed[(k - a->delay) * SB_N + j] : 0.0;
    }
}

static long sb_run_sampled(sb_sim *s, const sb_loop *loop, double *computed, const sb_record *record) {
    sb_memory memory[SB_N];
    sb_hold hold;
    double next;
    int lagged = 0;
    for (int j = 0; j < SB_N; j++) {
        sb_sampled_start(loop->axis + j, memory + j);
        lagged |= loop->axis[j].controlled && loop->axis[j].lag > 0.0;
    }
    if (lagged) s->control = sb_sampled_lag, s->ny = SB_NS + SB_N;
    sb_hold_start(&hold, loop->times, loop->command, 1, s->p, 0.0);
    hold.quiet = 1;
    for (long k = 0; k < loop->count; k++) {
        sb_sample(s, loop, memory, computed, k);
        hold.count = k + 1;
        sb_hold_at(&hold, s->t, s->u, &next);
        s->fresh = 0;
        sb_settle(s);
        if (k == 0) s->events = s->log_count = 0; /* how it starts is no event */
        sb_store(s, record, k);
        while (k + 1 < loop->count && s->t < loop->times[k + 1]) {
            if (sb_advance(s, fmin(loop->times[k + 1], next)) != SB_OK) return k + 1;
            if (s->t < loop->times[k + 1] && sb_hold_at(&hold, s->t, s->u, &next)) s->fresh = 0, sb_settle(s);
        }
    }
    return loop->count;
}

/* --- continuous ----------------------------------------------------------------------------------------------- */

static void sb_measure(sb_sim *s, double t, const double *y, double *q, double *dq) {
#if SB_SENSING
    const double *arg[SB_OUTPUTS_ARG];
    double *res[SB_OUTPUTS_RES], friction[SB_N], actuator[SB_N];
    long long int iw[SB_OUTPUTS_IW + 1];
    double w[SB_OUTPUTS_W + 1];
    arg[0] = &t, arg[1] = y, arg[2] = s->mode, arg[3] = s->u, arg[4] = s->p;
    res[0] = q, res[1] = dq, res[2] = friction, res[3] = actuator;
    sb_outputs(arg, res, iw, w, 0);
#else
    (void)s, (void)t;
    memcpy(q, y, sizeof(double) * SB_N);
    memcpy(dq, y + SB_N, sizeof(double) * SB_N);
#endif
}

/* The sign of joint j's velocity as its law takes it; 0 where it counts as none. */
static double sb_direction(const sb_sim *s, const sb_axis *a, int j, double velocity) {
    /* the mode is the sign of the velocity, and on either side of zero it stays so within a step */
    if (a->filter == 0.0 && a->dead_band == 0.0 && !sb_bristle[j]) return s->mode[j];
    return fabs(velocity) > a->dead_band ? sb_sign(velocity) : 0.0;
}

/* Within a dead-band a law may hold the sign from before: it is known at the end of a step that has left the band. */
static void sb_hold_signs(sb_sim *s) {
    const sb_loop *loop = s->loop;
    double q[SB_N], dq[SB_N];
    sb_measure(s, s->t, s->y, q, dq);
    for (int j = 0; j < SB_N; j++) {
        const sb_axis *a = loop->axis + j;
        if (!a->controlled) continue;
        const double sign = sb_direction(s, a, j, a->filter > 0.0 ? s->y[SB_NS + SB_OWN * j + SB_FILTER] : dq[j]);
        if (sign != 0.0) s->held[j] = sign;
    }
}

/* rad. The robust law turns over at zero error, where it would bring a joint to rest by ever more reversals in ever less
 * time: within this error the joint stands, as the law's set of torques there would hold it. */
#define SB_LEAST_ERROR 1e-9

static void sb_continuous(sb_sim *s, double t, const double *y, double *u, double *dz) {
    const sb_loop *loop = s->loop;
    double q[SB_N], dq[SB_N], r;
    sb_measure(s, t, y, q, dq);
    for (int j = 0; j < SB_N; j++) {
        const sb_axis *a = loop->axis + j;
        const double *z = y + SB_NS + SB_OWN * j;
        double *out = dz + SB_OWN * j;
        sb_seen seen;
        memset(out, 0, sizeof(double) * SB_OWN);
        u[j] = 0.0;
        if (!a->controlled) continue;
        sb_reference(a, t, &r, &seen.reference_rate, &seen.reference_acceleration);
        seen.velocity = a->filter > 0.0 ? z[SB_FILTER] : dq[j];
        seen.error = r - q[j], seen.rate_error = seen.reference_rate - seen.velocity;
        seen.direction = sb_direction(s, a, j, seen.velocity);
        seen.least = SB_LEAST_ERROR, seen.held = s->held[j], seen.integral = z[SB_INTEGRAL], seen.theta = z + SB_THETA;
        const double torque = sb_law(a, t, &seen), limited = sb_limited(a, torque);
        u[j] = a->lag > 0.0 ? z[SB_LAG] : limited;
        if (!sb_winds_up(a, torque, seen.error)) out[SB_INTEGRAL] = seen.error;
        if (a->filter > 0.0) out[SB_FILTER] = (dq[j] - z[SB_FILTER]) / a->filter;
        if (a->lag > 0.0) out[SB_LAG] = (limited - z[SB_LAG]) / a->lag;
        if (a->kind == SB_ADAPTIVE) sb_adapt(a, &seen, out + SB_THETA);
    }
}

/* A dither and a sine to follow move the arm in time as well. */
static void sb_bound_steps(sb_sim *s, const sb_axis *axis) {
    for (int j = 0; j < SB_N; j++) {
        const sb_axis *a = axis + j;
        const double dither = sb_dithered(a) ? fabs(a->omega) : 0.0;
        const double rate = fmax(dither, a->reference_kind == SB_SINE ? fabs(a->reference[2]) : 0.0);
        if (a->controlled && rate > 0.0) s->longest = fmin(s->longest, SB_PART * SB_TURN / rate);
    }
}

/* The next instant after t at which a reference has a corner. */
static double sb_next_knot(const sb_loop *loop, double t) {
    double next = HUGE_VAL;
    for (int j = 0; j < SB_N; j++) {
        const sb_axis *a = loop->axis + j;
        if (!a->controlled || a->reference_kind < SB_STEPS) continue;
        const long after = sb_knot(a, t) + 1;
        if (after < a->knots) next = fmin(next, a->table[3 * after]);
    }
    return next;
}

static long sb_run_continuous(sb_sim *s, const sb_loop *loop, const sb_record *record) {
    double dz[SB_NZ];
    s->control = sb_continuous, s->remember = sb_hold_signs, s->ny = SB_NS + SB_NZ;
    sb_bound_steps(s, loop->axis);
    for (int j = 0; j < SB_N; j++)
        for (int i = 0; i < 3; i++)
            s->y[SB_NS + SB_OWN * j + SB_THETA + i] = loop->axis[j].ratio * loop->axis[j].friction[0][i];
    s->fresh = 0;
    sb_settle(s);
    s->events = s->log_count = 0; /* how it starts is no event */
    for (long k = 0; k < loop->count; k++) {
        while (s->t < loop->times[k]) {
            const double knot = sb_next_knot(loop, s->t);
            if (sb_advance(s, fmin(loop->times[k], knot)) != SB_OK) return k;
            if (s->t >= knot) s->fresh = 0, sb_settle(s);
        }
        double *command = loop->command + k * SB_N; /* as computed, not what a lag has let through of it */
        sb_continuous(s, s->t, s->y, command, dz);
        for (int j = 0; j < SB_N; j++) command[j] += loop->axis[j].lag * dz[SB_OWN * j + SB_LAG];
        sb_store(s, record, k);
        memcpy(loop->seen + k * SB_N, record->signals + k * 6 * SB_N, sizeof(double) * SB_N);
    }
    return loop->count;
}

/* Exported. One closed loop over the instants times (count,). sample 0 is a continuous controller. info as in
 * sb_windows; ended (1): the time reached. computed is scratch (count, SB_N). */
SB_EXPORT void sb_closed_loop(const double *p, double tolerance, double bound, const sb_axis *axis, double sample,
                              const double *times, long long count, const double *y, const double *noise,
                              double *command, double *computed, double *seen, double *signals, double *modes,
                              double *states, long long *info, double *ended, sb_event *log, long long log_size) {
    sb_sim s;
    sb_loop loop;
    sb_record record = {signals, modes, states};
    sb_init(&s, p, tolerance);
    memset(&loop, 0, sizeof loop);
    loop.axis = axis, loop.sample = sample, loop.count = count, loop.times = times;
    loop.noise = noise, loop.command = command, loop.seen = seen;
    s.bound = bound, s.log = log, s.log_size = log_size, s.loop = &loop;
    memcpy(s.y, y, sizeof(double) * SB_NS);
    for (int j = 0; j < SB_N; j++) s.clamped[j] = !axis[j].controlled;
    info[1] = 0;
    if (!sb_finite(s.y, SB_NS)) s.status = SB_NOT_FINITE;
    else if (sample > 0.0) info[1] = sb_run_sampled(&s, &loop, computed, &record);
    else info[1] = sb_run_continuous(&s, &loop, &record);
    info[0] = s.status, info[2] = s.events, info[3] = s.steps, *ended = s.t;
}

/* Exported. The references of the controlled joints at the instants times (count,), into (count, SB_N) arrays. */
SB_EXPORT void sb_references(const sb_axis *axis, const double *times, long long count, double *position,
                             double *rate) {
    double unused;
    for (long long k = 0; k < count; k++)
        for (int j = 0; j < SB_N; j++)
            if (axis[j].controlled)
                sb_reference(axis + j, times[k], position + k * SB_N + j, rate + k * SB_N + j, &unused);
}

#endif
