/* Event-accurate integration of an arm with true stiction.
 *
 * Included after the generated model, which defines SB_N (joints), SB_NS (states), SB_NP (parameters) and the functions
 * sb_flow and sb_jacobian. No memory is allocated and nothing is global: any number of simulations run side by side.
 *
 * The mode of a joint is -1 or +1 while it slides and 0 while it sticks. Steps end exactly at the instants at which a
 * sliding joint's velocity passes zero or a stuck joint's holding torque passes the break-away level.
 *
 * Dormand & Prince (1980), 5(4); where it turns stiff, RODAS 4(3) of Hairer & Wanner (1996), section IV.7.
 */
#ifndef SB_SOLVER_H
#define SB_SOLVER_H

#include <math.h>
#include <string.h>

#ifndef SB_NZ
#define SB_NZ 0 /* most states that a controller adds */
#endif
#define SB_NY (SB_NS + SB_NZ)
#define SB_WHILE 0.1 /* s, for which steps and events are counted together */

enum { SB_OK, SB_UNBOUNDED, SB_TOO_MANY_EVENTS, SB_STEP_TOO_SMALL, SB_TOO_MANY_STEPS, SB_NOT_FINITE };

static const int sb_waves[][2] = SB_WAVES; /* (place in p of a frequency in Hz, its highest multiple), closed by -1 */
#define SB_PART 0.05                       /* of the shortest period with which time moves the arm: the longest step */

typedef struct {
    double t, mode_before, mode_after;
    int joint;
} sb_event;

typedef struct sb_sim sb_sim;

/* A command that follows the state between samples: torques u (SB_N), derivatives dz of the controller's own states,
 * which follow the arm's in y. */
typedef void (*sb_control)(sb_sim *s, double t, const double *y, double *u, double *dz);

/* What such a command remembers of each state that is reached. */
typedef void (*sb_remember)(sb_sim *s);

struct sb_sim {
    const double *p;
    double t, h, rtol, atol, bound;
    double longest; /* step */
    double ramp[SB_N]; /* rad/s that a position is led at */
    double y[SB_NY], mode[SB_N], u[SB_N];
    double f[SB_NY], margin[2 * SB_N]; /* at the present state, where fresh */
    int ny, fresh, stiff, near_edge, suspicion, calm, status;
    long steps, rejected, evaluations, events, step_limit, event_limit;
    double last_event;
    int stalled;
    sb_control control;
    sb_remember remember;
    const void *loop; /* what the control needs to know */
    char clamped[SB_N]; /* held still from outside */
    char defer, waiting; /* whether to stop before an event is passed; whether one waits, found by the values passing */
    double passing[SB_N];
    double held[SB_N];  /* the last sign other than 0 of the velocity as the control takes it */
    double stuck_time[SB_N], top_speed[SB_N]; /* s since the start; rad/s since it was last reset */
    sb_event *log;
    long log_size, log_count;
    double k[7][SB_NY]; /* stages of the step at hand */
    double matrix[SB_NY * SB_NY], dfdt[SB_NY];
    int pivot[SB_NY];
};

static void sb_init(sb_sim *s, const double *p, double tolerance) {
    memset(s, 0, sizeof *s);
    s->p = p;
    s->rtol = 0.1 * tolerance, s->atol = 0.01 * tolerance;
    s->h = 1e-3;
    s->bound = 1e6;
    s->longest = HUGE_VAL;
    s->ny = SB_NS;
    s->step_limit = 50000; /* of one stretch between two commands, and of each SB_WHILE of a longer one */
    s->event_limit = 5000;
    s->last_event = -HUGE_VAL;
}

static void sb_model(sb_sim *s, double t, const double *y, const double *mode, const double *u, double *dy,
                     double *margin) {
    const double *arg[SB_FLOW_ARG];
    double *res[SB_FLOW_RES];
    long long int iw[SB_FLOW_IW + 1];
    double w[SB_FLOW_W + 1];
    arg[0] = &t, arg[1] = y, arg[2] = mode, arg[3] = u, arg[4] = s->p;
    res[0] = dy, res[1] = margin;
    sb_flow(arg, res, iw, w, 0);
    s->evaluations++;
}

static void sb_rhs(sb_sim *s, double t, const double *y, double *dy, double *margin) {
    const double *u = s->u;
    double now[SB_N];
    if (s->control) {
        s->control(s, t, y, now, dy + SB_NS);
        u = now;
    }
    sb_model(s, t, y, s->mode, u, dy, margin);
}

static int sb_finite(const double *y, int n) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += y[i] - y[i];
    return sum == 0.0;
}

static double sb_error(const sb_sim *s, const double *y, const double *after, const double *error) {
    double worst = 0.0;
    for (int i = 0; i < s->ny; i++) {
        const double size = fmax(fabs(y[i]), fabs(after[i]));
        worst = fmax(worst, fabs(error[i]) / (s->atol + s->rtol * size));
    }
    return worst;
}

/* --- Dormand-Prince ------------------------------------------------------------------------------------------- */

/* One step of size h from the present state; s->f holds its derivative. Gives the scaled error, or NaN. */
static double sb_explicit(sb_sim *s, double h, double *after, double *fafter, double *margin) {
    static const double c[7] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
    static const double a[7][6] = {
        {0},
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
    };
    static const double e[7] = {71.0 / 57600,      0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200,
                                22.0 / 525, -1.0 / 40};
    double last[SB_NY], error[SB_NY], unused[2 * SB_N];
    const int n = s->ny;
    memcpy(s->k[0], s->f, sizeof(double) * n);
    for (int i = 1; i < 7; i++) {
        for (int r = 0; r < n; r++) {
            double sum = 0.0;
            for (int j = 0; j < i; j++) sum += a[i][j] * s->k[j][r];
            after[r] = s->y[r] + h * sum;
        }
        if (i == 5) memcpy(last, after, sizeof(double) * n);
        sb_rhs(s, s->t + c[i] * h, after, s->k[i], i == 6 ? margin : unused);
    }
    memcpy(fafter, s->k[6], sizeof(double) * n);
    for (int r = 0; r < n; r++) {
        double sum = 0.0;
        for (int j = 0; j < 7; j++) sum += e[j] * s->k[j][r];
        error[r] = h * sum;
    }
    if (!sb_finite(after, n) || !sb_finite(fafter, n)) return NAN;
    /* Hairer's test: the largest eigenvalue times h, against the edge of the stability region */
    double top = 0.0, bottom = 0.0;
    for (int r = 0; r < n; r++) {
        top += (s->k[6][r] - s->k[5][r]) * (s->k[6][r] - s->k[5][r]);
        bottom += (after[r] - last[r]) * (after[r] - last[r]);
    }
    s->near_edge = bottom > 0.0 && h * h * top > 2.8 * 2.8 * bottom;
    return sb_error(s, s->y, after, error);
}

/* --- RODAS ---------------------------------------------------------------------------------------------------- */

static int sb_factor(double *a, int *pivot, int n) {
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k])) best = i;
        pivot[k] = best;
        if (!(fabs(a[best * n + k]) > 0.0)) return 0;
        if (best != k)
            for (int j = 0; j < n; j++) {
                const double swap = a[k * n + j];
                a[k * n + j] = a[best * n + j], a[best * n + j] = swap;
            }
        for (int i = k + 1; i < n; i++) {
            const double m = a[i * n + k] /= a[k * n + k];
            if (m != 0.0)
                for (int j = k + 1; j < n; j++) a[i * n + j] -= m * a[k * n + j];
        }
    }
    return 1;
}

static void sb_solve(const double *a, const int *pivot, double *b, int n) {
    for (int k = 0; k < n; k++) {
        const double swap = b[k];
        b[k] = b[pivot[k]], b[pivot[k]] = swap;
    }
    for (int k = 0; k < n; k++)
        for (int i = k + 1; i < n; i++) b[i] -= a[i * n + k] * b[k];
    for (int k = n; k-- > 0;) {
        for (int j = k + 1; j < n; j++) b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
}

/* d(rhs)/dy (rows of ny) and d(rhs)/dt: exact for the arm, by differences for the controller. */
static void sb_slopes(sb_sim *s, double *matrix, double *dfdt) {
    const int n = s->ny;
    const double *arg[SB_JACOBIAN_ARG];
    double *res[SB_JACOBIAN_RES], u[SB_N], dz[SB_NZ + 1], full[SB_NS * (SB_NS + SB_N + 1)];
    long long int iw[SB_JACOBIAN_IW + 1];
    double w[SB_JACOBIAN_W + 1];
    memcpy(u, s->u, sizeof u);
    if (s->control) s->control(s, s->t, s->y, u, dz);
    arg[0] = &s->t, arg[1] = s->y, arg[2] = s->mode, arg[3] = u, arg[4] = s->p;
    res[0] = full;
    sb_jacobian(arg, res, iw, w, 0);
    for (int r = 0; r < SB_NS; r++) {
        for (int c = 0; c < SB_NS; c++) matrix[r * n + c] = full[c * SB_NS + r];
        dfdt[r] = full[(SB_NS + SB_N) * SB_NS + r];
    }
    if (!s->control) return;
    double moved[SB_NY], umoved[SB_N], dzmoved[SB_NZ + 1];
    memcpy(moved, s->y, sizeof(double) * n);
    for (int c = 0; c <= n; c++) {
        double t = s->t, delta = 1e-7 * fmax(1e-3, c < n ? fabs(s->y[c]) : fabs(t));
        if (c < n) moved[c] += delta;
        else t += delta;
        s->control(s, t, moved, umoved, dzmoved);
        if (c < n) moved[c] = s->y[c];
        for (int r = 0; r < n; r++) {
            double slope = 0.0;
            if (r < SB_NS)
                for (int j = 0; j < SB_N; j++) slope += full[(SB_NS + j) * SB_NS + r] * (umoved[j] - u[j]) / delta;
            else slope = (dzmoved[r - SB_NS] - dz[r - SB_NS]) / delta;
            if (c == n) dfdt[r] = (r < SB_NS ? dfdt[r] : 0.0) + slope;
            else matrix[r * n + c] = (r < SB_NS && c < SB_NS ? matrix[r * n + c] : 0.0) + slope;
        }
    }
}

/* One RODAS step of size h from the present state. Gives the scaled error, or NaN. */
static double sb_implicit(sb_sim *s, double h, double *after, double *fafter, double *margin) {
    static const double gamma = 0.25, alpha[6] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
    static const double shift[6] = {0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0};
    static const double a[6][5] = {
        {0},
        {1.544},
        {0.9466785280815826, 0.2557011698983284},
        {3.314825187068521, 2.896124015972201, 0.9986419139977817},
        {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
        {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0},
    };
    static const double c[6][5] = {
        {0},
        {-5.6688},
        {-2.430093356833875, -0.2063599157091915},
        {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
        {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
        {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054},
    };
    const int n = s->ny;
    double lu[SB_NY * SB_NY], unused[2 * SB_N];
    for (int i = 0; i < n * n; i++) lu[i] = -s->matrix[i];
    for (int i = 0; i < n; i++) lu[i * n + i] += 1.0 / (h * gamma);
    if (!sb_finite(lu, n * n) || !sb_factor(lu, s->pivot, n)) return NAN;
    for (int i = 0; i < 6; i++) {
        double *k = s->k[i];
        for (int r = 0; r < n; r++) {
            double sum = s->y[r];
            for (int j = 0; j < i; j++) sum += a[i][j] * s->k[j][r];
            after[r] = sum;
        }
        if (i == 0) memcpy(k, s->f, sizeof(double) * n);
        else sb_rhs(s, s->t + alpha[i] * h, after, k, unused);
        for (int r = 0; r < n; r++) {
            double sum = 0.0;
            for (int j = 0; j < i; j++) sum += c[i][j] * s->k[j][r];
            k[r] += sum / h + h * shift[i] * s->dfdt[r];
        }
        sb_solve(lu, s->pivot, k, n);
    }
    for (int r = 0; r < n; r++) after[r] += s->k[5][r];
    if (!sb_finite(after, n)) return NAN;
    sb_rhs(s, s->t + h, after, fafter, margin);
    return sb_finite(fafter, n) ? sb_error(s, s->y, after, s->k[5]) : NAN;
}

static double sb_try(sb_sim *s, double h, double *after, double *fafter, double *margin) {
    return s->stiff ? sb_implicit(s, h, after, fafter, margin) : sb_explicit(s, h, after, fafter, margin);
}

#endif
