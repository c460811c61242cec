/* One step of the arm. Moreau's midpoint scheme at a fixed step: positions move half a step with the old velocity,
 * all smooth forces act there, friction is solved implicitly at the new velocity for all joints together
 * (Gauss-Seidel on the exact one-joint solution), positions move the other half. A stuck joint has velocity zero. */
#ifndef STEPPER_H
#define STEPPER_H
#include <string.h>
#include "fields.h"
#include "tree.h"
#include "friction.h"
#include "drive.h"

#define SWEEPS 400
enum { OK = 0, DIVERGED = 1, SINGULAR = 2, NO_MEMORY = 3 };

typedef struct {
    const World *world;
    const Joint *joint;
    int n, base, free, slosh[MAX_JOINTS], flexible[MAX_JOINTS]; /* free: bodies, and the way of a base that slides */
    Tree tree;
    double x[MAX_BODIES], v[MAX_BODIES], v_old[MAX_BODIES];             /* bodies, relative to the parent */
    double theta[MAX_JOINTS], omega[MAX_JOINTS], omega_old[MAX_JOINTS]; /* rotors behind a transmission */
    double amplifier[MAX_JOINTS], second[MAX_JOINTS], rotor_torque[MAX_JOINTS], speed_log[MAX_JOINTS];
    Friction friction[MAX_JOINTS];
} Plant;

static double motor_angle(const Plant *p, int k) { return p->flexible[k] ? p->theta[k] : p->x[p->base + k]; }
static double motor_rate(const Plant *p, int k) { return p->flexible[k] ? p->omega[k] : p->v[p->base + k]; }

static void add_body(Tree *tree, int parent, Vec mount, double mass, Vec com, double inertia, double rotor) {
    int i = tree->count++;
    tree->parent[i] = parent;
    tree->mount[i] = mount;
    tree->mass[i] = mass;
    tree->com[i] = com;
    tree->inertia[i] = inertia;
    tree->rotor[i] = rotor;
}

static void build(Plant *p, const World *world, const Joint *joint, int n) {
    memset(p, 0, sizeof *p);
    p->world = world;
    p->joint = joint;
    p->n = n;
    p->base = world->base_stiffness > 0.0;
    Vec foot = {world->foot_x, world->foot_y}; /* about which a base turns, seen from the first axis */
    if (p->base) add_body(&p->tree, -1, foot, 0.0, (Vec){0, 0}, world->base_inertia, 0.0);
    for (int k = 0; k < n; k++) {
        const Joint *j = &joint[k];
        p->flexible[k] = j->stiffness > 0.0;
        Vec mount = {k > 0 ? joint[k - 1].length : 0.0, 0.0};
        if (k == 0 && p->base) mount = (Vec){-foot.x, -foot.y};
        add_body(&p->tree, p->tree.count - 1, mount, j->mass, (Vec){j->com_x, j->com_y}, j->inertia,
                 p->flexible[k] ? 0.0 : j->rotor);
    }
    for (int k = 0; k < n; k++) {
        const Joint *j = &joint[k];
        if (j->slosh_mass <= 0.0) continue;
        p->slosh[k] = p->tree.count;
        add_body(&p->tree, p->base + k, (Vec){j->slosh_arm, 0.0}, j->slosh_mass, (Vec){j->slosh_length, 0.0}, 0.0, 0.0);
    }
    p->free = p->tree.count + (world->slide_stiffness > 0.0);
}

/* A straight wall in the arm's plane pushes the end of the last link back; its force works along each body's turning. */
static void lean(const Plant *p, const double *x, const double *v, double *force) {
    const World *w = p->world;
    Vec axis[MAX_BODIES], end = {p->base * w->foot_x, p->base * w->foot_y}, speed = {0.0, 0.0}, normal = {cos(w->plane_direction), sin(w->plane_direction)};
    double phi = 0.0, omega = 0.0;
    for (int i = 0; i < p->base + p->n; i++) {
        Vec reach = i < p->base ? (Vec){-w->foot_x, -w->foot_y} : (Vec){p->joint[i - p->base].length, 0.0};
        axis[i] = end;
        phi += x[i];
        omega += v[i];
        Vec link = turn((Vec){cos(phi), sin(phi)}, reach);
        end = (Vec){end.x + link.x, end.y + link.y};
        speed = (Vec){speed.x - omega * link.y, speed.y + omega * link.x};
    }
    double depth = dot(normal, end) - w->plane_distance;
    if (depth <= 0.0) return;
    double push = w->plane_stiffness * pow(depth, w->plane_exponent) * fmax(0.0, 1.0 + w->plane_damping * dot(normal, speed));
    for (int i = 0; i < p->base + p->n; i++) force[i] -= push * cross(minus(end, axis[i]), normal);
}

/* Generalised forces on the bodies that do not come from the rotors. */
static void passive(const Plant *p, const double *x, const double *v, double *force) {
    int last = p->free - 1;
    for (int i = 0; i < p->free; i++) force[i] = 0.0;
    if (p->free > p->tree.count) force[last] = -p->world->slide_stiffness * x[last] - p->world->slide_damping * v[last];
    if (p->base) force[0] = -p->world->base_stiffness * x[0] - p->world->base_damping * v[0];
    if (p->world->plane_stiffness > 0.0) lean(p, x, v, force);
    for (int k = 0; k < p->n; k++) {
        const Joint *j = &p->joint[k];
        int i = p->base + k;
        force[i] += outside(j, x[i], v[i]);
        if (p->slosh[k]) force[p->slosh[k]] -= j->slosh_stiffness * x[p->slosh[k]] + j->slosh_damping * v[p->slosh[k]];
        if (j->tendon_stiffness > 0.0 && p->n > 1) { /* a cable from joint to joint, which only pulls */
            int other = p->base + (k + 1 < p->n ? k + 1 : k - 1);
            double pull = j->tendon_stiffness * (x[i] - j->tendon_ratio * x[other] - j->tendon_slack);
            if (pull > 0.0) {
                force[i] -= pull;
                force[other] += j->tendon_ratio * pull;
            }
        }
    }
}

/* Row and column of a base that slides: the whole momentum along its way, and the force that it takes to turn the links. */
static void slide_along(const Plant *p, const double *x, const double *v, double *needed, double matrix[MAX_BODIES][MAX_BODIES]) {
    const World *w = p->world;
    Vec way = {cos(w->slide_direction), sin(w->slide_direction)};
    double spin[MAX_BODIES], rest[MAX_BODIES] = {0.0};
    int last = p->tree.count;
    Pose pose;
    outwards(&p->tree, (Vec){0.0, 0.0}, x, v, NULL, &pose, spin);
    needed[last] = 0.0;
    matrix[last][last] = w->slide_mass;
    for (int i = 0; i < last; i++) {
        needed[last] += dot(way, pose.com_pull[i]);
        matrix[last][last] += p->tree.mass[i];
    }
    for (int i = 0; i < last; i++) {
        double acc[MAX_BODIES] = {0.0};
        acc[i] = 1.0;
        outwards(&p->tree, (Vec){0.0, 0.0}, x, rest, acc, &pose, spin);
        matrix[last][i] = 0.0;
        for (int m = 0; m < last; m++) matrix[last][i] += dot(way, pose.com_pull[m]);
        matrix[i][last] = matrix[last][i];
    }
}

/* Mobility (inverse mass) and torque of motion at the position x; the single sliding axis is a case of its own. */
static int rigid(const Plant *p, const double *x, const double *v, double *needed, double inverse[MAX_BODIES][MAX_BODIES]) {
    const Tree *tree = &p->tree;
    if (p->world->prismatic > 0.0) {
        if (p->free != 1) return 0; /* nothing can hang on it, nor it on anything */
        needed[0] = -tree->mass[0] * p->world->gravity_x;
        inverse[0][0] = 1.0 / (tree->mass[0] + tree->rotor[0]);
        return 1;
    }
    Pose pose;
    double spin[MAX_BODIES], matrix[MAX_BODIES][MAX_BODIES];
    outwards(tree, (Vec){p->world->gravity_x, p->world->gravity_y}, x, v, NULL, &pose, spin);
    inwards(tree, &pose, spin, NULL, needed);
    mass_matrix(tree, &pose, matrix);
    if (p->free > tree->count) slide_along(p, x, v, needed, matrix);
    return invert(p->free, matrix, inverse);
}

static double one_joint(const Joint *j, const Friction *f, double guess, double a, double b, double h, double *torque) {
    return j->bristle_stiffness > 0.0 ? stretch(j, f, guess, a, b, h, torque) : slide(f, guess, a, b, torque);
}

/* New velocities from the friction-free ones. */
static void rub(Plant *p, double h, double inverse[MAX_BODIES][MAX_BODIES], double *v) {
    double lambda[MAX_JOINTS], rate[MAX_JOINTS], free_rate[MAX_JOINTS];
    int base = p->base;
    for (int k = 0; k < p->n; k++) {
        lambda[k] = p->flexible[k] ? 0.0 : p->friction[k].torque;
        rate[k] = motor_rate(p, k);
        free_rate[k] = v[base + k];
        if (!p->flexible[k]) continue;
        double a = h / p->joint[k].rotor;
        p->omega[k] = one_joint(&p->joint[k], &p->friction[k], p->omega[k], a, p->omega[k], h, &p->friction[k].torque);
    }
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double change = 0.0, size = 0.0;
        for (int k = 0; k < p->n; k++) {
            if (p->flexible[k]) continue;
            double b = free_rate[k], a = h * inverse[base + k][base + k], old = lambda[k];
            for (int m = 0; m < p->n; m++)
                if (m != k) b -= h * inverse[base + k][base + m] * lambda[m];
            rate[k] = one_joint(&p->joint[k], &p->friction[k], rate[k], a, b, h, &lambda[k]);
            change = fmax(change, fabs(lambda[k] - old));
            size = fmax(size, fabs(lambda[k]));
        }
        if (change <= 1e-11 * size) break;
    }
    for (int i = 0; i < p->free; i++)
        for (int k = 0; k < p->n; k++) v[i] -= h * inverse[i][base + k] * lambda[k];
    for (int k = 0; k < p->n; k++) {
        if (p->flexible[k]) continue;
        v[base + k] = rate[k]; /* exactly zero where it sticks */
        p->friction[k].torque = lambda[k];
    }
}

/* Memory of the friction contact after a step with the motor rate w. */
static void remember(const Joint *j, Friction *f, double h, double w) {
    double slope, next[ELEMENTS];
    if (j->bristle_stiffness > 0.0) {
        elements(j, f, w, h, &slope, next);
        memcpy(f->slip, next, sizeof next);
    }
    if (j->dwell_rise != 0.0 && j->dwell_distance <= 0.0) { /* kept until the next rest, which starts anew */
        f->rest = w == 0.0 ? f->rest + h : 0.0;
        if (f->rest > 0.0) f->dwell = f->rest / (f->rest + j->dwell_time);
    } else if (j->dwell_rise != 0.0) {
        double grow = h / j->dwell_time;
        f->dwell = (f->dwell + grow) / (1.0 + grow + h * fabs(w) / j->dwell_distance);
    }
    if (j->wear_work > 0.0) f->warmth += h * f->torque * w / j->wear_work;
    else if (j->warm_change != 0.0) { /* by friction's power, or, without one, by time alone */
        double heat = j->warm_power > 0.0 ? f->torque * w / j->warm_power : 1.0;
        f->warmth += h / j->warm_time * (heat - f->warmth);
    }
}

/* Torques on joint k in the middle of the step: on its link (added to `force`), or on its rotor. */
static void push_joint(Plant *p, int k, double t, double h, double command, double push, double mid, double glide,
                       double *force) {
    const Joint *j = &p->joint[k];
    double angle = p->flexible[k] ? p->theta[k] + 0.5 * h * p->omega[k] : mid;
    double rate = p->flexible[k] ? 1.5 * p->omega[k] - 0.5 * p->omega_old[k] : glide;
    double u = drive(j, command, rate);
    if (j->lag > 0.0 && j->lag_damping > 0.0)
        u = swung_mean(j->lag, j->lag_damping, u, h, &p->amplifier[k], &p->second[k]);
    else
        u = lagged_mean(j->lag_again, lagged_mean(j->lag, u, h, &p->amplifier[k]), h, &p->second[k]);
    double torque = at_rotor(j, u, angle, rate, t + 0.5 * h) + push;
    p->rotor_torque[k] = torque;
    if (!p->flexible[k]) {
        *force += torque;
        return;
    }
    double twist = shaft(j, angle - mid, rate - glide);
    *force += twist;
    p->friction[k].load = twist;
    p->omega_old[k] = p->omega[k];
    p->theta[k] = angle;
    p->omega[k] += h / j->rotor * (torque - twist);
}

/* What holds the links against gravity at the position x, for joints whose friction goes with it. */
static void weigh(Plant *p, const double *x) {
    Pose pose;
    double rest[MAX_BODIES] = {0.0}, spin[MAX_BODIES], held[MAX_BODIES];
    int asked = 0;
    for (int k = 0; k < p->n; k++) asked += p->joint[k].load_ratio != 0.0 && p->joint[k].load_input == 3.0;
    if (!asked) return;
    outwards(&p->tree, (Vec){p->world->gravity_x, p->world->gravity_y}, x, rest, NULL, &pose, spin);
    inwards(&p->tree, &pose, spin, NULL, held);
    if (p->world->prismatic > 0.0) held[0] = -p->tree.mass[0] * p->world->gravity_x;
    for (int k = 0; k < p->n; k++) p->friction[k].weight = held[p->base + k];
}

/* One step. `command` is the mean amplifier input of the step, `push` a torque from outside, `factor` scales friction. */
static int step(Plant *p, double t, double h, const double *command, const double *push, const double *factor,
                const double *old_speed) {
    int count = p->free, base = p->base;
    double mid[MAX_BODIES], glide[MAX_BODIES], force[MAX_BODIES], needed[MAX_BODIES], v[MAX_BODIES];
    double inverse[MAX_BODIES][MAX_BODIES];
    for (int i = 0; i < count; i++) {
        mid[i] = p->x[i] + 0.5 * h * p->v[i];
        glide[i] = 1.5 * p->v[i] - 0.5 * p->v_old[i]; /* velocity of the middle of the step, extrapolated */
    }
    if (!rigid(p, mid, glide, needed, inverse)) return SINGULAR;
    passive(p, mid, glide, force);
    weigh(p, mid);
    for (int k = 0; k < p->n; k++) {
        Friction *f = &p->friction[k];
        double angle = p->flexible[k] ? p->theta[k] + 0.5 * h * p->omega[k] : mid[base + k];
        f->forward = level_now(&p->joint[k], f, 1, angle, factor[k], old_speed[k]);
        f->backward = level_now(&p->joint[k], f, 0, angle, factor[k], old_speed[k]);
        push_joint(p, k, t, h, command[k], push[k], mid[base + k], glide[base + k], &force[base + k]);
    }
    for (int i = 0; i < count; i++) {
        v[i] = p->v[i];
        for (int m = 0; m < count; m++) v[i] += h * inverse[i][m] * (force[m] - needed[m]);
    }
    rub(p, h, inverse, v);
    for (int k = 0; k < p->n; k++) {
        Friction *f = &p->friction[k];
        double w = p->flexible[k] ? p->omega[k] : v[base + k];
        if (p->flexible[k]) p->theta[k] += 0.5 * h * w;
        else f->load = p->rotor_torque[k] - f->torque - p->joint[k].rotor * (w - p->v[base + k]) / h;
        double slope, fluid = copysign(wet(w >= 0.0 ? &f->forward : &f->backward, fabs(w), &slope), w);
        f->drive = p->rotor_torque[k];
        f->net = f->drive - (f->torque - fluid);
        remember(&p->joint[k], f, h, w);
        if (!(fabs(w) < 1e4)) return DIVERGED;
    }
    for (int i = 0; i < count; i++) {
        p->v_old[i] = p->v[i];
        p->v[i] = v[i];
        p->x[i] = mid[i] + 0.5 * h * v[i];
        if (!(fabs(v[i]) < 1e4)) return DIVERGED;
    }
    return OK;
}

/* The shafts carry nothing at the start. */
static void place(Plant *p, const double *start) {
    for (int k = 0; k < p->n; k++) {
        double rate = start[2 * k + 1];
        p->theta[k] = p->x[p->base + k] = start[2 * k];
        p->omega[k] = p->omega_old[k] = p->v[p->base + k] = p->v_old[p->base + k] = p->speed_log[k] = rate;
    }
}
#endif
