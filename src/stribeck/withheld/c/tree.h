/* Planar rigid bodies in a tree. Newton-Euler outwards and inwards gives the torque without acceleration,
 * composite bodies (Walker & Orin 1982) give the mass matrix. Body order: parents before children. */
#ifndef TREE_H
#define TREE_H
#include <math.h>
#include "fields.h"

#define MAX_BODIES (2 + 2 * MAX_JOINTS) /* one row is left for a base that slides */
typedef struct { double x, y; } Vec;
typedef struct {
    int count, parent[MAX_BODIES];
    Vec mount[MAX_BODIES]; /* joint axis in the parent's frame */
    Vec com[MAX_BODIES];   /* centre of mass in the body's frame */
    double mass[MAX_BODIES], inertia[MAX_BODIES], rotor[MAX_BODIES];
} Tree;
typedef struct { Vec axis[MAX_BODIES], centre[MAX_BODIES], com_pull[MAX_BODIES]; } Pose;

static Vec turn(Vec e, Vec a) { return (Vec){e.x * a.x - e.y * a.y, e.y * a.x + e.x * a.y}; }
static double cross(Vec a, Vec b) { return a.x * b.y - a.y * b.x; }
static double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }
static Vec minus(Vec a, Vec b) { return (Vec){a.x - b.x, a.y - b.y}; }

/* Positions, and the force that each body needs for the velocities `rate` and accelerations `acc` (may be NULL). */
static void outwards(const Tree *tree, Vec gravity, const double *angle, const double *rate, const double *acc,
                     Pose *pose, double *spin_torque) {
    double phi[MAX_BODIES], omega[MAX_BODIES], beta[MAX_BODIES];
    Vec unit[MAX_BODIES], pull[MAX_BODIES];
    for (int i = 0; i < tree->count; i++) {
        int p = tree->parent[i];
        double alpha = acc ? acc[i] : 0.0;
        phi[i] = angle[i] + (p < 0 ? 0.0 : phi[p]);
        omega[i] = rate[i] + (p < 0 ? 0.0 : omega[p]);
        beta[i] = alpha + (p < 0 ? 0.0 : beta[p]);
        unit[i] = (Vec){cos(phi[i]), sin(phi[i])};
        if (p < 0) {
            pose->axis[i] = tree->mount[i];
            pull[i] = (Vec){-gravity.x, -gravity.y}; /* gravity as an acceleration of the base */
        } else {
            Vec r = turn(unit[p], tree->mount[i]);
            double w = omega[p] * omega[p];
            pose->axis[i] = (Vec){pose->axis[p].x + r.x, pose->axis[p].y + r.y};
            pull[i] = (Vec){pull[p].x - w * r.x - beta[p] * r.y, pull[p].y - w * r.y + beta[p] * r.x};
        }
        Vec c = turn(unit[i], tree->com[i]);
        double w = omega[i] * omega[i], m = tree->mass[i];
        pose->centre[i] = (Vec){pose->axis[i].x + c.x, pose->axis[i].y + c.y};
        pose->com_pull[i] = (Vec){m * (pull[i].x - w * c.x - beta[i] * c.y), m * (pull[i].y - w * c.y + beta[i] * c.x)};
        spin_torque[i] = tree->inertia[i] * beta[i];
    }
}

/* Joint torques that balance the forces of `outwards`; rotors turn with the relative acceleration. */
static void inwards(const Tree *tree, const Pose *pose, const double *spin_torque, const double *acc, double *torque) {
    Vec force[MAX_BODIES];
    double moment[MAX_BODIES]; /* about the body's own axis */
    for (int i = 0; i < tree->count; i++) {
        force[i] = pose->com_pull[i];
        moment[i] = spin_torque[i] + cross(minus(pose->centre[i], pose->axis[i]), force[i]);
    }
    for (int i = tree->count - 1; i >= 0; i--) {
        int p = tree->parent[i];
        torque[i] = moment[i] + (acc ? tree->rotor[i] * acc[i] : 0.0);
        if (p < 0) continue;
        moment[p] += moment[i] + cross(minus(pose->axis[i], pose->axis[p]), force[i]);
        force[p].x += force[i].x;
        force[p].y += force[i].y;
    }
}

/* Mass matrix from composite bodies: everything that hangs on axis i, as mass, first moment and inertia about it. */
static void mass_matrix(const Tree *tree, const Pose *pose, double matrix[MAX_BODIES][MAX_BODIES]) {
    double mass[MAX_BODIES], about[MAX_BODIES];
    Vec first[MAX_BODIES];
    for (int i = 0; i < tree->count; i++) {
        Vec c = minus(pose->centre[i], pose->axis[i]);
        mass[i] = tree->mass[i];
        first[i] = (Vec){mass[i] * c.x, mass[i] * c.y};
        about[i] = tree->inertia[i] + mass[i] * dot(c, c);
        for (int j = 0; j < tree->count; j++) matrix[i][j] = 0.0;
    }
    for (int i = tree->count - 1; i >= 0; i--) {
        int p = tree->parent[i];
        matrix[i][i] = about[i] + tree->rotor[i];
        for (int a = p; a >= 0; a = tree->parent[a])
            matrix[i][a] = matrix[a][i] = about[i] + dot(minus(pose->axis[i], pose->axis[a]), first[i]);
        if (p < 0) continue;
        Vec d = minus(pose->axis[i], pose->axis[p]);
        about[p] += about[i] + 2.0 * dot(d, first[i]) + mass[i] * dot(d, d);
        first[p].x += first[i].x + mass[i] * d.x;
        first[p].y += first[i].y + mass[i] * d.y;
        mass[p] += mass[i];
    }
}

/* Inverse of a symmetric positive definite matrix by Cholesky factors; returns 0 when it is not positive. */
static int invert(int n, double a[MAX_BODIES][MAX_BODIES], double inverse[MAX_BODIES][MAX_BODIES]) {
    double low[MAX_BODIES][MAX_BODIES], li[MAX_BODIES][MAX_BODIES];
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double s = a[i][j];
            for (int k = 0; k < j; k++) s -= low[i][k] * low[j][k];
            if (i == j && !(s > 0.0)) return 0;
            low[i][j] = i == j ? sqrt(s) : s / low[j][j];
        }
    for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++) {
            double s = i == j ? 1.0 : 0.0;
            for (int k = j; k < i; k++) s -= low[i][k] * li[k][j];
            li[i][j] = s / low[i][i];
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double s = 0.0;
            for (int k = i; k < n; k++) s += li[k][i] * li[k][j];
            inverse[i][j] = inverse[j][i] = s;
        }
    return 1;
}
#endif
