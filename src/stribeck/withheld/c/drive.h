/* What acts between the command and the joint, and on the joint from outside. */
#ifndef DRIVE_H
#define DRIVE_H
#include <math.h>
#include "fields.h"

#define TURN 6.283185307179586

/* Mean over [t, t + step] of the held command delayed by `delay`; the held value before the start is the first one. */
static double held_mean(const double *command, int stride, double period, double delay, double t, double step) {
    double from = (t - delay) / period, to = (t + step - delay) / period;
    long a = (long)floor(from + 1e-9), b = (long)floor(to - 1e-9);
    double first = command[(a < 0 ? 0 : a) * stride], second = command[(b < 0 ? 0 : b) * stride];
    if (a == b) return first;
    double weight = ((double)b - from) / (to - from);
    return weight * first + (1.0 - weight) * second;
}

/* Drive without memory: uneven gain, gain, dead zone, limit. What speed takes of the voltage, driving has no more. */
static double drive(const Joint *j, double u, double speed) {
    if (j->hardening != 0.0) {
        double x = u / j->hardening_torque;
        u *= 1.0 + j->hardening * x * x;
    }
    u *= j->gain;
    if (j->dead_zone > 0.0) u = fabs(u) <= j->dead_zone ? 0.0 : u - copysign(j->dead_zone * (1.0 - j->dead_zone_jump), u);
    double limit = j->saturation;
    if (u * speed > 0.0 && j->saturation_fade > 0.0) limit *= fmax(0.0, 1.0 - j->saturation_fade * fabs(speed));
    double bend = j->saturation_bend;
    if (bend > 0.0 && isfinite(limit)) return u * pow(1.0 + pow(fabs(u) / limit, bend), -1.0 / bend);
    return copysign(fmin(fabs(u), limit), u);
}

/* First-order lag over one step, exact for a constant input: returns the mean and moves the state to the end. */
static double lagged_mean(double lag, double u, double step, double *state) {
    if (lag <= 0.0) return *state = u;
    double fade = -expm1(-step / lag), mean = u + (*state - u) * fade * lag / step;
    *state += (u - *state) * fade;
    return mean;
}

/* Second-order lag over one step of the implicit midpoint rule: returns the mean and moves the state to the end. */
static double swung_mean(double lag, double damping, double u, double step, double *state, double *rate) {
    double turn = step * 2.0 * damping / lag, before = *state, even = 0.25 * turn * turn, drag = damping * turn;
    double moved = (*rate * step * (1.0 - drag - even) + turn * turn * (u - before)) / (1.0 + drag + even);
    *state += 0.5 * (*rate * step + moved);
    *rate = moved / step;
    return 0.5 * (before + *state);
}

/* Torque at the rotor beyond the amplifier: pulsation, cogging, offset, supply bang. */
static double at_rotor(const Joint *j, double torque, double angle, double speed, double t) {
    if (j->ripple_ratio != 0.0 || j->ripple_overtone != 0.0)
        torque *= 1.0 + j->ripple_ratio * sin(j->ripple_harmonic * angle + j->ripple_phase) +
                  j->ripple_overtone * sin(2.0 * j->ripple_harmonic * angle + j->ripple_overtone_phase);
    if (j->cogging_amplitude != 0.0 || j->cogging_overtone != 0.0)
        torque += j->cogging_amplitude * sin(j->cogging_harmonic * angle + j->cogging_phase) +
                  j->cogging_overtone * sin(2.0 * j->cogging_harmonic * angle + j->cogging_overtone_phase);
    if (j->supply_torque != 0.0 && fabs(speed) > j->supply_speed)
        torque += copysign(j->supply_torque, sin(TURN * j->supply_frequency * t));
    return torque + j->offset;
}

/* Torque that the transmission passes to the link: spring with play; the flanks push, they never pull. */
static double shaft(const Joint *j, double twist, double twist_rate) {
    double play = 0.5 * j->gap;
    if (fabs(twist) <= play && play > 0.0) return 0.0;
    double torque = j->stiffness * (twist - copysign(play, twist)) + j->damping * twist_rate;
    if (play > 0.0 && torque * twist < 0.0) return 0.0;
    return torque;
}

/* Cable and wall, on the link's angle. Wall: Hunt & Crossley (1975), force k d^e (1 + c d'), and a damper D d' beside. */
static double outside(const Joint *j, double angle, double rate) {
    double taut = angle - j->cable_rest;
    double torque = -taut * (j->cable_stiffness + j->cable_cubic * taut * taut);
    if (j->wall_stiffness > 0.0) {
        double depth = (angle - j->wall_position) * j->wall_side;
        if (depth > 0.0) {
            double sinks = rate * j->wall_side;
            double force = j->wall_stiffness * pow(depth, j->wall_exponent) * (1.0 + j->wall_damping * sinks);
            force += j->wall_damper * sinks;
            torque -= j->wall_side * fmax(0.0, force);
        }
    }
    return torque;
}

static double encoder(const Joint *j, double angle) {
    double turns = j->eccentricity_harmonic * angle;
    return angle + j->encoder_offset + j->eccentricity * sin(turns + j->eccentricity_phase) +
           j->eccentricity_overtone * sin(2.0 * turns + j->eccentricity_overtone_phase);
}
static double encoder_slope(const Joint *j, double angle) {
    double turns = j->eccentricity_harmonic * angle;
    return 1.0 + j->eccentricity_harmonic * (j->eccentricity * cos(turns + j->eccentricity_phase) +
                                             2.0 * j->eccentricity_overtone * cos(2.0 * turns + j->eccentricity_overtone_phase));
}
static double counts(double resolution, double reading) {
    return resolution > 0.0 ? resolution * floor(reading / resolution + 0.5) : reading;
}
#endif
