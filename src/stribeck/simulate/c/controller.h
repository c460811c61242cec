/* The sampled controllers of all joints on their own, around whatever gives positions and takes torques. */
#ifndef SB_CONTROLLER_H
#define SB_CONTROLLER_H

#include "control.h"

SB_EXPORT void sb_controller_start(const sb_axis *axis, int n, sb_memory *memory) {
    for (int j = 0; j < n; j++) sb_sampled_start(axis + j, memory + j);
}

/* Exported. Torques at the sample at time t from positions q (n), noise included, and velocities dq (n); q becomes what
 * the encoders give. */
SB_EXPORT void sb_controller_sample(const sb_axis *axis, int n, sb_memory *memory, double t, double sample, int first,
                                    double *q, const double *dq, double *torque) {
    for (int j = 0; j < n; j++) {
        q[j] = sb_encoded(axis + j, q[j]);
        torque[j] = sb_sampled(axis + j, memory + j, t, sample, first, q[j], dq[j]);
    }
}

/* Exported. The references at the instants times (count), into (count, n) arrays. */
SB_EXPORT void sb_controller_references(const sb_axis *axis, int n, const double *times, long long count,
                                        double *position, double *rate) {
    double unused;
    for (long long k = 0; k < count; k++)
        for (int j = 0; j < n; j++)
            sb_reference(axis + j, times[k], position + k * n + j, rate + k * n + j, &unused);
}

#endif
