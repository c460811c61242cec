/* The command in force: held or ramped between communication points, and late where the arm delays it. */
#ifndef FM_COMMAND_H
#define FM_COMMAND_H

#include "core.h"
#include "instance.h"

static const int fm_delays[][2] = SB_DELAYS; /* (joint, place in p), closed by -1 */

static double fm_delay(const fm_core *c, int joint) {
    double delay = 0.0;
    for (int k = 0; fm_delays[k][0] >= 0; k++)
        if (fm_delays[k][0] == joint) delay += c->p[fm_delays[k][1]];
    return delay;
}

static fm_core *fm_core_of(sb_sim *s) { return (fm_core *)(void *)s; } /* the simulation is its first member */

/* The command at time t, in the pieces that are in force: an sb_control. */
static void fm_ramp(sb_sim *s, double t, const double *y, double *u, double *dz) {
    const fm_core *c = fm_core_of(s);
    (void)y, (void)dz;
    for (int j = 0; j < SB_N; j++) {
        const fm_command *piece = &c->ring[j][c->at[j]];
        u[j] = piece->value + piece->slope * (t - fm_delay(c, j) - piece->start);
    }
}

/* Fill the rings with the present command, as if it had always been there. */
static void fm_command_start(fm_core *c) {
    for (int j = 0; j < SB_N; j++) {
        const fm_command piece = {-1e300, c->tau[j], 0.0};
        c->ring[j][0] = piece;
        c->count[j] = 1, c->newest[j] = c->at[j] = 0;
        c->sim.u[j] = c->tau[j];
    }
    c->sim.control = NULL;
}

/* Note the command that holds from now on. Gives 0 where too many changes are still on their way. */
static int fm_command_note(fm_core *c) {
    for (int j = 0; j < SB_N; j++) {
        const fm_command *last = &c->ring[j][c->newest[j]], piece = {c->sim.t, c->tau[j], c->slope[j]};
        if (last->slope == 0.0 && piece.slope == 0.0 && last->value == piece.value) continue;
        const int replaces = FM_RING == 1 || last->start == piece.start;
        if (!replaces) {
            const int place = (c->newest[j] + 1) % FM_RING;
            if (c->count[j] == FM_RING && place == c->at[j]) return 0;
            c->newest[j] = place;
            if (c->count[j] < FM_RING) c->count[j]++;
        }
        c->ring[j][c->newest[j]] = piece;
    }
    return 1;
}

/* Put the command of the present instant in force; give the next instant at which one comes through. Tells whether
 * anything changed. */
static int fm_command_now(fm_core *c, double *next) {
    int changed = 0, ramps = 0;
    double u[SB_N];
    *next = HUGE_VAL;
    for (int j = 0; j < SB_N; j++) {
        const double delay = fm_delay(c, j);
        while (c->at[j] != c->newest[j]) {
            const int place = (c->at[j] + 1) % FM_RING;
            const double due = c->ring[j][place].start + delay;
            if (due > c->sim.t) {
                *next = fmin(*next, due);
                break;
            }
            c->at[j] = place, changed = 1;
        }
        ramps |= c->ring[j][c->at[j]].slope != 0.0;
    }
    fm_ramp(&c->sim, c->sim.t, NULL, u, NULL);
    for (int j = 0; j < SB_N; j++) changed |= u[j] != c->sim.u[j], c->sim.u[j] = u[j];
    c->sim.control = ramps ? fm_ramp : NULL;
    return changed || ramps;
}

#endif
