/* The control laws and references of a joint, for sampled and continuous control alike. */
#ifndef SB_CONTROL_H
#define SB_CONTROL_H

#include "solver.h"

/* What Python mirrors is written as a list, from which mirrored.h also tells a library's fields and names. */
#define SB_FIELD(declaration) declaration;
#define SB_CONSTANT(name) SB_##name,

/* As KINDS, AT_ZERO and COURSES in axis.py. */
#define SB_KINDS(X) X(NONE) X(FEEDFORWARD) X(FEEDBACK) X(ADAPTIVE) X(ROBUST) X(DITHER)
#define SB_AT_ZERO(X) X(ZERO) X(HOLD) X(ERROR_SIGN) X(SET_VALUED)
#define SB_COURSES(X) X(LINE) X(SINE) X(STEPS) X(CURVE)
enum { SB_KINDS(SB_CONSTANT) };
enum { SB_AT_ZERO(SB_CONSTANT) };
enum { SB_COURSES(SB_CONSTANT) };
#define SB_TURN 6.283185307179586 /* rad */

/* One joint's part of the loop; mirrored in axis.py. Angles in rad, torques in N m.
 * friction: C0, C1, C2, alpha for forward and backward motion; reference: start, then rate, or amplitude, angular
 * frequency, phase; table (knots, 3): time, position, velocity. */
#define SB_AXIS(X)                                                                                              \
    X(double kp) X(double kv) X(double ki) X(double inertia) X(double filter) X(double lag) X(double resolution) \
    X(double limit) X(double ratio) X(double dead_band) X(double slope) X(double leakage) X(double inner)        \
    X(double amplitude) X(double omega)                                                                         \
    X(double gain[3]) X(double friction[2][4]) X(double reference[4]) X(const double *table) X(long long knots) \
    X(int controlled) X(int true_velocity) X(int kind) X(int at_zero) X(int reference_kind) X(int delay)
typedef struct {
    SB_AXIS(SB_FIELD)
} sb_axis;

/* What the controller of a joint sees and remembers. */
typedef struct {
    double error, rate_error, velocity, reference_rate, reference_acceleration, integral;
    double direction; /* -1, 0, 1: sign of the velocity as the law takes it */
    double held;      /* the last one that was not 0 */
    double least; /* an error within which the robust law is off in any case, rad */
    const double *theta;
} sb_seen;

/* The last knot at or before time t; -1 before the first. */
static long sb_knot(const sb_axis *a, double t) {
    long low = -1, high = (long)a->knots;
    while (high - low > 1) {
        const long middle = (low + high) / 2;
        if (a->table[3 * middle] <= t) low = middle;
        else high = middle;
    }
    return low;
}

/* Reference position, velocity and acceleration at time t. */
static void sb_reference(const sb_axis *a, double t, double *r, double *dr, double *ddr) {
    const double *c = a->reference;
    *dr = *ddr = 0.0;
    if (a->reference_kind == SB_LINE) {
        *r = c[0] + c[1] * t, *dr = c[1];
    } else if (a->reference_kind == SB_SINE) {
        *r = c[0] + c[1] * sin(c[2] * t + c[3]), *dr = c[1] * c[2] * cos(c[2] * t + c[3]);
        *ddr = -c[2] * c[2] * (*r - c[0]);
    } else {
        const long at = sb_knot(a, t);
        *r = c[0];
        if (at < 0) return;
        const double *k = a->table + 3 * at;
        *r = k[1];
        if (a->reference_kind == SB_STEPS) return;
        if (at + 1 == a->knots) { /* the last knot is the curve's end, where it still moves */
            if (t == k[0]) *dr = k[2];
            return;
        }
        const double h = k[3] - k[0], x = (t - k[0]) / h, d = k[4] - k[1]; /* cubic Hermite */
        const double b = 3 * d - h * (2 * k[2] + k[5]), e = h * (k[2] + k[5]) - 2 * d;
        *r = k[1] + x * (h * k[2] + x * (b + x * e));
        *dr = k[2] + x * (2 * b + 3 * x * e) / h;
        *ddr = (2 * b + 6 * x * e) / (h * h);
    }
}

/* Whether the law moves the joint in time. */
static int sb_dithered(const sb_axis *a) { return a->kind == SB_DITHER && a->omega != 0.0 && a->amplitude != 0.0; }

static double sb_sign(double x) { return (x > 0.0) - (x < 0.0); }

/* Tustin's level for motion in one direction at a speed. */
static double sb_tustin(const sb_axis *a, double direction, double speed) {
    const double *c = a->friction[direction < 0.0];
    return c[0] + c[1] * exp(-speed / c[3]) + c[2] * speed;
}

/* Torque of the PID alone, with the feedforward of inertia. */
static double sb_pid(const sb_axis *a, const sb_seen *s) {
    return a->kp * s->error + a->kv * s->rate_error + a->ki * s->integral + a->inertia * s->reference_acceleration;
}

/* The sign that a compensation takes the friction to have; at rest, as the loop says. */
static double sb_friction_sign(const sb_axis *a, const sb_seen *s) {
    if (s->direction != 0.0) return s->direction;
    switch (a->at_zero) {
    case SB_HOLD: return s->held;
    case SB_ERROR_SIGN: return sb_sign(s->error);
    case SB_SET_VALUED: return sb_sign(sb_pid(a, s));
    default: return 0.0;
    }
}

static double sb_feedback(const sb_axis *a, const sb_seen *s) {
    const double sign = sb_friction_sign(a, s);
    return a->ratio * sign * sb_tustin(a, sign, s->direction * s->velocity);
}

/* The regressor of the adaptive law: torque = theta . Y. */
static void sb_regressor(const sb_axis *a, const sb_seen *s, double *y) {
    const double sign = sb_friction_sign(a, s);
    y[0] = sign;
    y[1] = sign * exp(-s->direction * s->velocity / a->friction[sign < 0.0][3]);
    y[2] = s->direction != 0.0 ? s->velocity : 0.0;
}

/* Torque of the law before the limit. */
static double sb_law(const sb_axis *a, double t, const sb_seen *s) {
    const double pd = sb_pid(a, s);
    double y[3], sign;
    switch (a->kind) {
    case SB_FEEDFORWARD:
        sign = sb_sign(s->reference_rate);
        return pd + (sign != 0.0 ? a->ratio * sign * sb_tustin(a, sign, sign * s->reference_rate) : 0.0);
    case SB_FEEDBACK: return pd + sb_feedback(a, s);
    case SB_ADAPTIVE:
        sb_regressor(a, s, y);
        return pd + s->theta[0] * y[0] + s->theta[1] * y[1] + s->theta[2] * y[2];
    case SB_ROBUST: { /* Southward, Radcliffe & MacCluer (1991) */
        const double *c = a->friction[s->error < 0.0];
        const double level = a->ratio * (c[0] + c[1]), size = fabs(s->error);
        return pd + (size > fmax(a->inner, s->least) && a->kp * size < level ? sb_sign(s->error) * (level - a->kp * size) : 0.0);
    }
    case SB_DITHER: return pd + a->amplitude * sin(a->omega * t);
    default: return pd;
    }
}

/* Rate of change of the adaptive law's constants (Canudas de Wit et al. 1991, with sigma-modification). */
static void sb_adapt(const sb_axis *a, const sb_seen *s, double *dtheta) {
    double y[3];
    sb_regressor(a, s, y);
    const double drive = fabs(s->error) > a->inner ? s->rate_error + a->slope * s->error : 0.0;
    for (int i = 0; i < 3; i++) dtheta[i] = a->gain[i] * (y[i] * drive - a->leakage * s->theta[i]);
}

/* What is no number stays none: fmin would make the limit of it. */
static double sb_limited(const sb_axis *a, double torque) {
    return torque > a->limit ? a->limit : torque < -a->limit ? -a->limit : torque;
}

/* The integral stands still where it would push a saturated command further. */
static int sb_winds_up(const sb_axis *a, double torque, double error) {
    return fabs(torque) > a->limit && torque * error > 0.0;
}

/* --- sampled -------------------------------------------------------------------------------------------------- */

/* A smaller difference of two positions, rad, is what rounding may leave of none. Without this floor a joint that creeps
 * on is at rest once its last digit stands still, which differs from one compiler, or step of the solver, to another. */
#define SB_LEAST_MOVE 1e-12

/* What a sampled controller remembers of a joint from one sample to the next. */
#define SB_MEMORY(X) X(double last) X(double filtered) X(double integral) X(double held) X(double theta[3])
typedef struct {
    SB_MEMORY(SB_FIELD)
} sb_memory;

/* The filtered velocity as a law takes it, rad/s: what it moves in a sample has the same floor, or it would keep the sign
 * of a joint that stands still until it is too small for a number, which is a time that no law knows of. */
static double sb_filtered(const sb_memory *m, double sample) {
    return fabs(m->filtered) * sample < SB_LEAST_MOVE ? 0.0 : m->filtered;
}

static void sb_sampled_start(const sb_axis *a, sb_memory *m) {
    memset(m, 0, sizeof *m);
    for (int i = 0; i < 3; i++) m->theta[i] = a->ratio * a->friction[0][i];
}

/* One joint's command at the sample at time t from the recorded position and velocity. */
static double sb_sampled(const sb_axis *a, sb_memory *m, double t, double sample, int first, double q, double dq) {
    double r, velocity = dq;
    sb_seen s;
    sb_reference(a, t, &r, &s.reference_rate, &s.reference_acceleration);
    if (!a->true_velocity) velocity = !first && fabs(q - m->last) >= SB_LEAST_MOVE ? (q - m->last) / sample : 0.0;
    m->last = q;
    if (a->filter > 0.0) {
        m->filtered += -expm1(-sample / a->filter) * (velocity - m->filtered);
        velocity = sb_filtered(m, sample);
    }
    s.error = r - q, s.velocity = velocity, s.rate_error = s.reference_rate - velocity;
    s.direction = fabs(velocity) > a->dead_band ? sb_sign(velocity) : 0.0;
    s.integral = m->integral, s.held = m->held, s.theta = m->theta, s.least = 0.0;
    const double torque = sb_law(a, t, &s);
    if (!sb_winds_up(a, torque, s.error)) m->integral += s.error * sample;
    if (s.direction != 0.0) m->held = s.direction;
    if (a->kind == SB_ADAPTIVE) {
        double dtheta[3];
        sb_adapt(a, &s, dtheta);
        for (int i = 0; i < 3; i++) m->theta[i] += sample * dtheta[i];
    }
    return sb_limited(a, torque);
}

/* What an encoder of that resolution gives. */
static double sb_encoded(const sb_axis *a, double q) {
    return a->resolution > 0.0 ? a->resolution * floor(q / a->resolution + 0.5) : q;
}

#endif
