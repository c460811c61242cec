/* Parameters of the plant. Every field is a double; the Python side reads the names from the compiled library,
 * so the order here is the only place where the layout is written down. SI units throughout. */
#ifndef FIELDS_H
#define FIELDS_H

#define MAX_JOINTS 4

#define JOINT_FIELDS(X)                                                                                          \
    /* rigid link and rotor */                                                                                   \
    X(length) X(mass) X(com_x) X(com_y) X(inertia) X(rotor)                                                      \
    /* Tustin constants, forward and backward */                                                                 \
    X(f_C0) X(f_C1) X(f_C2) X(f_alpha) X(b_C0) X(b_C1) X(b_C2) X(b_alpha)                                        \
    /* additions to the friction level */                                                                        \
    X(stribeck_torque) X(stribeck_velocity) X(stribeck_squared)                                                  \
    X(bristle_stiffness) X(bristle_damping) X(friction_lag) X(friction_lag_drop)                                 \
    X(dwell_rise) X(dwell_time) X(dwell_distance) X(warm_change) X(warm_time) X(warm_power) X(wear_work) X(wear_lost) \
    X(wave_amplitude) X(wave_harmonic) X(wave_phase) X(wave_overtone) X(wave_overtone_phase)                     \
    X(load_ratio) X(load_input) X(quadratic)                                                                     \
    /* drive */                                                                                                  \
    X(lag) X(lag_again) X(lag_damping) X(delay) X(gain) X(offset)                                                \
    X(saturation) X(saturation_fade) X(saturation_bend) X(dead_zone) X(dead_zone_jump)                           \
    X(cogging_amplitude) X(cogging_harmonic) X(cogging_phase)                                                    \
    X(ripple_ratio) X(ripple_harmonic) X(ripple_phase)                                                           \
    X(cogging_overtone) X(cogging_overtone_phase) X(ripple_overtone) X(ripple_overtone_phase)                    \
    /* transmission: stiffness 0 means rigid */                                                                  \
    X(stiffness) X(damping) X(gap)                                                                               \
    /* encoder and recorder */                                                                                   \
    X(eccentricity) X(eccentricity_harmonic) X(eccentricity_phase) X(encoder_offset) X(resolution)               \
    X(eccentricity_overtone) X(eccentricity_overtone_phase) X(time_shift) X(velocity_lag)                        \
    /* outside forces */                                                                                         \
    X(cable_stiffness) X(cable_rest) X(cable_cubic) X(wall_position) X(wall_side) X(wall_stiffness) X(wall_damping) \
    X(wall_exponent) X(wall_damper)                                                                              \
    /* effects that no library knows */                                                                          \
    X(supply_torque) X(supply_frequency) X(supply_speed)                                                         \
    X(sticky_torque) X(sticky_centre) X(sticky_width) X(sticky_load)                                             \
    X(tendon_stiffness) X(tendon_ratio) X(tendon_slack) X(hardening) X(hardening_torque)                         \
    X(slosh_mass) X(slosh_arm) X(slosh_length) X(slosh_stiffness) X(slosh_damping)                               \
    /* controller of the laboratory */                                                                           \
    X(kp) X(kd) X(ki) X(control_filter) X(torque_limit)

#define WORLD_FIELDS(X)                                                                                          \
    X(prismatic) X(gravity_x) X(gravity_y) X(base_stiffness) X(base_damping) X(base_inertia) X(foot_x) X(foot_y) \
    X(slide_stiffness) X(slide_damping) X(slide_mass) X(slide_direction)                                         \
    X(plane_direction) X(plane_distance) X(plane_stiffness) X(plane_damping) X(plane_exponent)

#define DECLARE(name) double name;
#define QUOTE(name) #name " "
typedef struct { JOINT_FIELDS(DECLARE) } Joint;
typedef struct { WORLD_FIELDS(DECLARE) } World;
#endif
