/* Dry friction as a set-valued law, or as a parallel row of elasto-slide elements, both solved implicitly.
 *
 * Each step asks for the velocity v with  v + a * lambda(v) = b,  where b is the velocity that the joint would have
 * without friction and a = step * mobility. The level of friction is frozen in everything but v. */
#ifndef FRICTION_H
#define FRICTION_H
#include <math.h>
#include "fields.h"

#define ELEMENTS 5
typedef struct { double constant, drop, scale, viscous, extra, extra_scale, squared, quadratic; } Level;
typedef struct {
    Level forward, backward;
    double slip[ELEMENTS]; /* deflection of the elements, rad */
    double dwell, rest, warmth, load;
    double weight;         /* torque that holds the link against gravity */
    double drive;          /* torque of the rotor in the last step */
    double net;            /* what dry friction left of it */
    double torque;         /* friction torque of the last step, opposing the motion */
} Friction;

/* Friction without the viscous part, and with it, at speed u >= 0; the slope too. */
static double dry(const Level *l, double u, double *slope) {
    double e1 = l->drop != 0.0 ? l->drop * exp(-u / l->scale) : 0.0;
    double way = u / l->extra_scale; /* the extra fall is exponential, or a bell (squared 1) */
    double e2 = l->extra != 0.0 ? l->extra * exp(l->squared != 0.0 ? -way * way : -way) : 0.0;
    double value = l->constant + e1 + e2;
    *slope = (e1 != 0.0 ? -e1 / l->scale : 0.0) + (e2 != 0.0 ? -e2 / l->extra_scale * (l->squared != 0.0 ? 2.0 * way : 1.0) : 0.0);
    if (value > 0.0) return value;
    *slope = 0.0;
    return 0.0;
}
static double wet(const Level *l, double u, double *slope) {
    *slope = l->viscous + 2.0 * l->quadratic * u;
    return l->viscous * u + l->quadratic * u * u;
}

/* Level of one direction in this step: Tustin's constants with every addition that depends on state. */
static Level level_now(const Joint *j, const Friction *f, int forward, double angle, double factor, double old_speed) {
    double C0 = forward ? j->f_C0 : j->b_C0, C1 = forward ? j->f_C1 : j->b_C1;
    double C2 = forward ? j->f_C2 : j->b_C2, alpha = forward ? j->f_alpha : j->b_alpha;
    double memory = j->wear_work > 0.0 ? exp(-f->warmth) : f->warmth; /* what is left of newness, or warmth */
    double warm = factor * fmax(0.05, 1.0 + j->warm_change * memory);
    Level l = {warm * C0, warm * C1 + j->dwell_rise * f->dwell, alpha, warm * C2,
               j->stribeck_torque, j->stribeck_velocity, j->stribeck_squared, j->quadratic};
    if (j->wave_amplitude != 0.0) l.constant += j->wave_amplitude * sin(j->wave_harmonic * angle + j->wave_phase);
    if (j->wave_overtone != 0.0)
        l.constant += j->wave_overtone * sin(2.0 * j->wave_harmonic * angle + j->wave_overtone_phase);
    if (j->load_ratio != 0.0) { /* of what leaves the gear, what enters it (1), the motor's (2), the weight (3), the net (4) */
        double passed = j->load_input > 3.5 ? f->net : j->load_input > 2.5 ? f->weight : j->load_input > 1.5 ? f->drive
                                                                           : f->load + j->load_input * f->torque;
        l.constant += j->load_ratio * fabs(passed);
    }
    if (j->sticky_torque != 0.0 && fabs(angle - j->sticky_centre) < j->sticky_width && fabs(f->load) > j->sticky_load)
        l.constant += j->sticky_torque;
    if (j->friction_lag > 0.0) { /* Hess & Soom: the level follows the speed of a moment ago */
        l.constant += l.drop * exp(-old_speed / l.scale);
        l.drop = 0.0;
        if (j->friction_lag_drop == 0.0) { /* else the viscous part keeps to the speed of now */
            l.constant += l.viscous * old_speed;
            l.viscous = 0.0;
        }
    }
    return l;
}

/* Set-valued law: sticks exactly (v = 0) while |b| / a stays below break-away, else Newton on the sliding branch. */
static double slide(const Friction *f, double guess, double a, double b, double *torque) {
    const Level *l = b >= 0.0 ? &f->forward : &f->backward;
    double slope, slope2, size = fabs(b);
    if (size <= a * dry(l, 0.0, &slope)) {
        *torque = b / a;
        return 0.0;
    }
    double low = 0.0, high = size, u = guess * b > 0.0 ? fmin(fabs(guess), size) : fmax(0.0, size - a * l->constant), value = 0.0;
    for (int k = 0; k < 60; k++) {
        value = dry(l, u, &slope) + wet(l, u, &slope2);
        double miss = u + a * value - size;
        if (fabs(miss) <= 1e-15 * size) break;
        if (miss > 0.0) high = u; else low = u;
        double next = u - miss / (1.0 + a * (slope + slope2));
        u = next > low && next < high ? next : 0.5 * (low + high);
    }
    *torque = copysign((size - u) / a, b);
    return copysign(u, b);
}

/* Break points of the elements: means of five equal parts of an exponential law, so that the virgin curve bends like
 * F (1 - exp(-k x / F)), with closed inner loops (Iwan 1966), which a single bristle state cannot have. */
static const double share[ELEMENTS] = {0.021485158948632233, 0.0720194667917734, 0.13997908150993232,
                                       0.24462871026284194, 0.5218875824868201};

static double elements(const Joint *j, const Friction *f, double v, double step, double *slope, double *next) {
    double cut, cut_back, viscous_slope, u = fabs(v), each = j->bristle_stiffness / ELEMENTS;
    const Level *l = v >= 0.0 ? &f->forward : &f->backward;
    double top = dry(&f->forward, u, &cut), bottom = dry(&f->backward, u, &cut_back);
    double torque = copysign(wet(l, u, &viscous_slope), v), side = v >= 0.0 ? 1.0 : -1.0;
    *slope = viscous_slope;
    for (int i = 0; i < ELEMENTS; i++) {
        double z = f->slip[i] + step * v, gain = each + j->bristle_damping / (ELEMENTS * step);
        double most = share[i] * top / each, least = -share[i] * bottom / each;
        if (z > most) { z = most; *slope += gain * side * share[i] * cut / each; }
        else if (z < least) { z = least; *slope -= gain * side * share[i] * cut_back / each; }
        else *slope += gain * step;
        torque += each * z + j->bristle_damping / (ELEMENTS * step) * (z - f->slip[i]);
        if (next) next[i] = z;
    }
    return torque;
}

static double stretch(const Joint *j, const Friction *f, double guess, double a, double b, double step, double *torque) {
    double slope, v = guess, low = -INFINITY, high = INFINITY;
    for (int k = 0; k < 100; k++) {
        *torque = elements(j, f, v, step, &slope, 0);
        double miss = v + a * *torque - b;
        if (fabs(miss) <= 1e-13 * (fabs(b) + a * fabs(*torque) + 1e-9)) break;
        if (miss > 0.0) high = fmin(high, v); else low = fmax(low, v);
        double next = v - miss / (1.0 + a * fmax(slope, 0.0));
        int inside = next > low && next < high;
        v = inside || isinf(low) || isinf(high) ? next : 0.5 * (low + high);
    }
    return v;
}
#endif
