/* What an arm's FMU runs: the engine's simulation and the values that the importer sets. */
#ifndef FM_CORE_H
#define FM_CORE_H

#include "advance.h"
#include "report.h"

#define FM_BOUND 1e5 /* rad and rad/s; beyond it a motion is unbounded */
#define FM_TOLERANCE 1e-8
#ifndef FM_RING
#define FM_RING 1 /* commands that are kept for a delay */
#endif

/* A command from one instant on: value + slope (t - start). */
typedef struct {
    double start, value, slope;
} fm_command;

typedef struct {
    sb_sim sim;
    double p[SB_NP + 1], q_start[SB_N], dq_start[SB_N], tau[SB_N], slope[SB_N];
    fm_command ring[SB_N][FM_RING];
    double seen[4 * SB_N]; /* recorded position and velocity, friction and actuator torque, where known */
    double tolerance, start;
    int count[SB_N], newest[SB_N], at[SB_N]; /* of the rings: how many, where the last, and which is in force */
    int stands, touched, known; /* touched: an input or a parameter was set since the last step or event */
} fm_core;

/* Every value that a simulation goes on from. What a step makes anew (stages, matrices) is left out. */
#define FM_EACH(X)                                                                                                    \
    X(sim.t) X(sim.h) X(sim.rtol) X(sim.atol) X(sim.y) X(sim.mode) X(sim.u) X(sim.f) X(sim.margin) X(sim.fresh)       \
    X(sim.stiff) X(sim.near_edge) X(sim.suspicion) X(sim.calm) X(sim.status) X(sim.steps) X(sim.rejected)             \
    X(sim.evaluations) X(sim.events) X(sim.last_event) X(sim.stalled) X(sim.held) X(sim.stuck_time) X(sim.top_speed)  \
    X(sim.waiting) X(sim.passing) X(p) X(q_start) X(dq_start) X(tau) X(slope) X(ring) X(seen) X(tolerance) X(start)   \
    X(count) X(newest) X(at) X(stands) X(touched) X(known)
#define FM_SIZES {SB_N, SB_NS, SB_NP}
#define FM_STATES SB_NS
#define FM_HAS_EVENT_MODE 1

#endif
