/* A robot arm that records itself: the sampled controller, the encoder and the log around the stepper. */
#include <stdlib.h>
#include "stepper.h"

#define TRUTH 7        /* motor angle and rate, link angle and rate, friction, rotor torque, transmitted torque */
#define HISTORY 16384  /* steps of past speed kept for the friction lag */

typedef struct { double seen, rate, sum; } Control;

/* Command of the laboratory's controller for sample i. */
static double control(const Joint *j, Control *c, double period, double q, const double *want, double forward, int first) {
    double keep = j->control_filter > 0.0 ? exp(-period / j->control_filter) : 0.0;
    double raw = first ? 0.0 : (q - c->seen) / period, error = want[0] - q;
    c->rate = keep * c->rate + (1.0 - keep) * raw;
    c->seen = q;
    double u = j->kp * error + j->kd * (want[1] - c->rate) + j->ki * (c->sum + period * error) + forward;
    if (!(j->torque_limit > 0.0) || fabs(u) <= j->torque_limit) {
        c->sum += period * error; /* no wind-up while the drive is at its limit */
        return u;
    }
    return copysign(j->torque_limit, u);
}

/* What a recording reads and writes; arrays are row-major, of width n unless said. */
typedef struct {
    int n, samples, substeps, fine;
    double period, h;
    const double *reference; /* (samples, n, 2): position and velocity that the controller wants */
    const double *forward;   /* (samples, n): torque that it adds */
    const double *noise;     /* (samples, n): of the encoder */
    const double *push;      /* (samples * fine + 1, n): torque from outside, linear between points */
    const double *factor;    /* the same: factor on friction */
    double *q, *tau, *dq;    /* (samples, n) */
    double *truth;           /* (samples, n, TRUTH) */
    double *past;            /* (HISTORY, MAX_JOINTS): speeds of the last steps */
    long steps;
    int logged[MAX_JOINTS];
    Control loop[MAX_JOINTS];
} Record;

/* The controller sees the encoder of joint k at sample i, and answers. */
static void sample(Plant *p, Record *r, int i, int k) {
    const Joint *j = &p->joint[k];
    int at = i * r->n + k;
    double angle = motor_angle(p, k), seen = counts(j->resolution, encoder(j, angle) + r->noise[at]);
    if (j->time_shift == 0.0) r->q[at] = seen;
    r->dq[at] = p->speed_log[k] * encoder_slope(j, angle);
    r->tau[at] = control(j, &r->loop[k], r->period, seen, r->reference + 2 * at, r->forward[at], i == 0);
    if (i == 0) {
        p->amplifier[k] = drive(j, r->tau[at], motor_rate(p, k));
        p->second[k] = j->lag_damping > 0.0 ? 0.0 : p->amplifier[k];
    }
    double values[TRUTH] = {angle, motor_rate(p, k), p->x[p->base + k], p->v[p->base + k],
                            p->friction[k].torque, p->rotor_torque[k], p->friction[k].load};
    memcpy(r->truth + (size_t)TRUTH * at, values, sizeof values);
}

/* Speed of joint k a friction lag ago; zero before the start. */
static double speed_before(Record *r, const Joint *j, int k, double speed) {
    double back = j->friction_lag / r->h;
    long b = (long)back;
    r->past[(r->steps % HISTORY) * MAX_JOINTS + k] = fabs(speed);
    if (b + 1 > r->steps) return 0.0;
    return (1.0 - (back - b)) * r->past[((r->steps - b) % HISTORY) * MAX_JOINTS + k] +
           (back - b) * r->past[((r->steps - b - 1) % HISTORY) * MAX_JOINTS + k];
}

/* A position channel whose clock is off: it notes the angle between `was` and now, at times of its own. */
static void note(const Plant *p, Record *r, int k, double t, double was) {
    const Joint *j = &p->joint[k];
    for (; j->time_shift != 0.0 && r->logged[k] < r->samples; r->logged[k]++) {
        double late = r->logged[k] * r->period - j->time_shift - t;
        if (late > r->h) return;
        double here = was + fmax(0.0, late / r->h) * (motor_angle(p, k) - was);
        int at = r->logged[k] * r->n + k;
        r->q[at] = counts(j->resolution, encoder(j, here) + r->noise[at]);
    }
}

static int substep(Plant *p, Record *r, int i, int s) {
    double command[MAX_JOINTS], torque[MAX_JOINTS], scale[MAX_JOINTS], old[MAX_JOINTS], was[MAX_JOINTS];
    double t = i * r->period + s * r->h, fine = ((double)s + 0.5) / r->substeps * r->fine, w = fine - floor(fine);
    int a = (i * r->fine + (int)fine) * r->n, b = a + r->n;
    for (int k = 0; k < r->n; k++) {
        command[k] = held_mean(r->tau + k, r->n, r->period, p->joint[k].delay, t, r->h);
        torque[k] = (1.0 - w) * r->push[a + k] + w * r->push[b + k];
        scale[k] = (1.0 - w) * r->factor[a + k] + w * r->factor[b + k];
        old[k] = speed_before(r, &p->joint[k], k, motor_rate(p, k));
        was[k] = motor_angle(p, k);
    }
    int status = step(p, t, r->h, command, torque, scale, old);
    for (int k = 0; k < r->n; k++) {
        lagged_mean(p->joint[k].velocity_lag, motor_rate(p, k), r->h, &p->speed_log[k]);
        note(p, r, k, t, was[k]);
    }
    r->steps++;
    return status;
}

/* Record an arm; `start` (n, 2) holds angle and rate, `carried` (n) the warmth or the wear, read and written. */
int plant_record(const World *world, const Joint *joint, int n, int samples, int substeps, int fine, double period,
                 const double *reference, const double *forward, const double *noise, const double *push,
                 const double *factor, const double *start, double *carried, double *q, double *tau, double *dq,
                 double *truth) {
    Plant *p = malloc(sizeof *p);
    double *past = calloc((size_t)HISTORY * MAX_JOINTS, sizeof *past);
    if (!p || !past) {
        free(past);
        free(p);
        return NO_MEMORY;
    }
    Record r = {n, samples, substeps, fine, period, period / substeps, reference, forward, noise, push, factor,
                q, tau, dq, truth, past, 0, {0}, {{0.0, 0.0, 0.0}}};
    int status = OK;
    build(p, world, joint, n);
    place(p, start);
    for (int k = 0; k < n; k++) p->friction[k].warmth = carried[k];
    for (int i = 0; i < samples && status == OK; i++) {
        for (int k = 0; k < n; k++) sample(p, &r, i, k);
        for (int s = 0; s < substeps && status == OK; s++) status = substep(p, &r, i, s);
    }
    for (int k = 0; k < n; k++) {
        carried[k] = p->friction[k].warmth;
        for (; joint[k].time_shift != 0.0 && r.logged[k] < samples; r.logged[k]++) q[r.logged[k] * n + k] = motor_angle(p, k);
    }
    free(past);
    free(p);
    return status;
}

/* Torque of the bare rigid arm along a motion, friction apart: q, dq, ddq, out are (samples, n). */
void plant_inverse(const World *world, const Joint *joint, int n, int samples, const double *q, const double *dq,
                   const double *ddq, double *out) {
    Plant p;
    Pose pose;
    double spin[MAX_BODIES];
    build(&p, world, joint, n);
    for (int i = 0; i < samples * n; i += n) {
        if (world->prismatic > 0.0) {
            out[i] = (joint[0].mass + joint[0].rotor) * ddq[i] - joint[0].mass * world->gravity_x;
            continue;
        }
        outwards(&p.tree, (Vec){world->gravity_x, world->gravity_y}, q + i, dq + i, ddq + i, &pose, spin);
        inwards(&p.tree, &pose, spin, ddq + i, out + i);
    }
}

const char *plant_joint_fields(void) { return JOINT_FIELDS(QUOTE) ""; }
const char *plant_world_fields(void) { return WORLD_FIELDS(QUOTE) ""; }
int plant_truth_width(void) { return TRUTH; }
