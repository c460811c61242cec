/* The part that this FMU is: the sampled controllers of a loop, one a joint. What the standard's functions (both.h)
 * ask of a part: the laws of control.h, an input for each measured signal, a torque for each joint.
 *
 * Included after the generated model.h, which defines CT_N (joints), CT_RING (commands kept for a delay), CT_SAMPLE
 * (sample time, s), FM_TOKEN, ct_axes, ct_tables and ct_least (the least that each parameter of a joint may be).
 */
#ifndef FM_PART_H
#define FM_PART_H

#define CT_NUMBERS 30 /* doubles at the head of sb_axis, each a parameter */
#define CT_MOST 1e8   /* samples in one communication step */

/* Value references; the ranges mirror variables.py. */
enum {
    CT_TIME,
    CT_SAMPLE_TIME,
    CT_Q,
    CT_DQ = CT_Q + CT_N,
    CT_TAU = CT_DQ + CT_N,
    CT_REF = CT_TAU + CT_N,
    CT_RATE = CT_REF + CT_N,
    CT_P = CT_RATE + CT_N,
    CT_END = CT_P + CT_NUMBERS * CT_N
};

typedef struct {
    double p[CT_N][CT_NUMBERS], ring[CT_N][CT_RING], q[CT_N], dq[CT_N], tau[CT_N], sample, start, time;
    sb_memory memory[CT_N];
    long long next; /* the sample that comes next */
    int stands;
} fm_core;

#define FM_EACH(X) X(p) X(ring) X(q) X(dq) X(tau) X(sample) X(start) X(time) X(memory) X(next) X(stands)
#define FM_SIZES {CT_N, CT_RING, CT_NUMBERS}
#define FM_STATES 0
#define FM_INDICATORS 0
#define FM_HAS_EVENT_MODE 0
#define FM_ONLY_STEPS "a sampled controller has no continuous states to exchange: use Co-Simulation"

#include "instance.h"

/* One joint's part of the loop, with the parameters as they are now. */
static sb_axis fm_axis(const fm_core *c, int j) {
    sb_axis axis = ct_axes[j];
    memcpy(&axis, c->p[j], sizeof c->p[j]);
    axis.table = ct_tables[j];
    return axis;
}

static void fm_restart(fm_core *c) {
    memset(c, 0, sizeof *c);
    for (int j = 0; j < CT_N; j++) memcpy(c->p[j], ct_axes + j, sizeof c->p[j]);
    c->sample = CT_SAMPLE;
    c->stands = FM_START;
}

static void fm_adopt(fm_instance *f, const fm_core *c) {
    if (&f->core != c) f->core = *c;
}

static int fm_sound(const fm_core *c) {
    const double all = c->sample + c->start + c->time;
    return c->next >= 0 && c->next < 1LL << 53 && c->sample > 0.0 && all - all == 0.0;
}

static int fm_set_tolerance(fm_instance *f, double tolerance) {
    (void)f, (void)tolerance; /* nothing is integrated */
    return FM_OK;
}

static void fm_set_start(fm_instance *f, double time) { f->core.start = f->core.time = time; }

static void fm_begin(fm_instance *f) {
    fm_core *c = &f->core;
    for (int j = 0; j < CT_N; j++) {
        const sb_axis axis = fm_axis(c, j);
        sb_sampled_start(&axis, c->memory + j);
    }
    c->next = 0, c->time = c->start;
}

static double fm_now(const fm_core *c) { return c->time; }
static int fm_stopped(const fm_core *c) { return (void)c, 0; }
static int fm_waits(const fm_core *c) { return (void)c, 0; }

/* --- values --------------------------------------------------------------------------------------------------- */

static int fm_get_real(fm_instance *f, unsigned vr, double *value) {
    const fm_core *c = &f->core;
    const int i = (int)vr;
    double r, dr, ddr;
    if (vr >= CT_END) return fm_unknown_real(f, vr);
    if (i >= CT_P) return *value = c->p[(i - CT_P) / CT_NUMBERS][(i - CT_P) % CT_NUMBERS], FM_OK;
    if (i >= CT_REF) {
        const sb_axis axis = fm_axis(c, (i - CT_REF) % CT_N);
        sb_reference(&axis, c->time - c->start, &r, &dr, &ddr);
        return *value = i < CT_RATE ? r : dr, FM_OK;
    }
    if (i >= CT_TAU) return *value = c->tau[i - CT_TAU], FM_OK;
    if (i >= CT_DQ) return *value = c->dq[i - CT_DQ], FM_OK;
    if (i >= CT_Q) return *value = c->q[i - CT_Q], FM_OK;
    return *value = i == CT_TIME ? c->time : c->sample, FM_OK;
}

static int fm_set_real(fm_instance *f, unsigned vr, double value) {
    fm_core *c = &f->core;
    const int i = (int)vr;
    if (value - value != 0.0) return fm_refuse(f, vr, value, "it must be finite");
    if (vr >= CT_P && vr < CT_END) {
        const int k = (i - CT_P) % CT_NUMBERS;
        if (value >= ct_least[k]) return c->p[(i - CT_P) / CT_NUMBERS][k] = value, FM_OK;
        fm_log(f, FM_ERROR, FM_LOG_ERROR, "the parameter with value reference %u must be %g or more, not %g", vr,
               ct_least[k], value);
        return FM_ERROR;
    }
    if (vr >= CT_Q && vr < CT_DQ) return c->q[i - CT_Q] = value, FM_OK;
    if (vr >= CT_DQ && vr < CT_TAU) return c->dq[i - CT_DQ] = value, FM_OK;
    if (vr != CT_SAMPLE_TIME) return fm_refuse(f, vr, value, "it is neither an input nor a parameter");
    if (c->sample == value) return FM_OK; /* as arm/values.h: some importers set all anew, late */
    if (!(c->stands & (FM_START | FM_INIT))) return fm_refuse(f, vr, value, "it says how a simulation starts");
    if (!(value > 0.0)) return fm_refuse(f, vr, value, "it must be positive");
    return c->sample = value, FM_OK;
}

static int fm_get_integer(fm_instance *f, unsigned vr, int32_t *value) {
    (void)vr, (void)value;
    return fm_fail(f, "a controller has no integer variables");
}

/* --- steps ---------------------------------------------------------------------------------------------------- */

/* The samples that fall into [t, t + h): each takes the present inputs. */
static int fm_step(fm_instance *f, double t, double h, int early) {
    fm_core *c = &f->core;
    const double near = 1e-6 * c->sample, end = t - c->start + h - near;
    (void)early;
    if (fm_follows(f, t, h, c->time) != FM_OK) return FM_ERROR;
    if (!(end / c->sample - (double)c->next < CT_MOST)) return fm_fail(f, "too many samples in one step");
    for (; c->next * c->sample < end; c->next++) {
        const double now = c->next * c->sample;
        for (int j = 0; j < CT_N; j++) {
            const sb_axis axis = fm_axis(c, j);
            const double q = sb_encoded(&axis, c->q[j]);
            c->ring[j][c->next % CT_RING] =
                sb_sampled(&axis, c->memory + j, now, c->sample, c->next == 0, q, c->dq[j]);
            c->tau[j] = c->next >= axis.delay ? c->ring[j][(c->next - axis.delay) % CT_RING] : 0.0;
        }
    }
    c->time = t + h;
    return FM_OK;
}

/* --- what a sampled controller has not ------------------------------------------------------------------------ */

static int fm_set_slope(fm_instance *f, unsigned vr, int order, double value) {
    (void)vr, (void)order, (void)value;
    return fm_fail(f, "inputs are not interpolated");
}

static int fm_output_slope(fm_instance *f, unsigned vr, int order, double *value) {
    (void)vr, (void)order, (void)value;
    return fm_fail(f, "outputs are held between samples: no derivatives");
}

static int fm_directional(fm_instance *f, const unsigned *unknown, size_t unknowns, const unsigned *known,
                          size_t knowns, const double *seed, double *sensitivity) {
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)seed, (void)sensitivity;
    return fm_fail(f, "a sampled controller gives no derivatives");
}
#define fm_adjoint_derivative fm_directional

static void fm_enter_events(fm_instance *f) { (void)f; }
static int fm_iterate(fm_instance *f, int *jumped) { return *jumped = 0, fm_fail(f, "there are no events"); }
static void fm_set_time(fm_instance *f, double time) { (void)f, (void)time; }
static void fm_set_states(fm_instance *f, const double *x) { (void)f, (void)x; }
static void fm_get_states(fm_instance *f, double *x) { (void)f, (void)x; }
static void fm_get_rates(fm_instance *f, double *x) { (void)f, (void)x; }
static void fm_get_indicators(fm_instance *f, double *x) { (void)f, (void)x; }

#endif
