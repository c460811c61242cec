/* A sampled controller as an FMU: the laws of control.h, an input for each measured signal, a torque for each joint.
 *
 * Included after the generated model.h, which defines CT_N (joints), CT_RING (commands kept for a delay), CT_SAMPLE
 * (sample time, s), CT_TOKEN, ct_axes and ct_tables. Nothing is global; memory is asked for at instantiation and for
 * copies of the state only.
 */
#ifndef CT_CORE_H
#define CT_CORE_H

#include <stdlib.h>

#define CT_NUMBERS 30 /* doubles at the head of sb_axis, each a parameter */

/* Value references; mirrored in variables.py. */
enum {
    CT_TIME, CT_SAMPLE_TIME, CT_Q, CT_DQ = CT_Q + CT_N, CT_TAU = CT_DQ + CT_N, CT_REF = CT_TAU + CT_N,
    CT_RATE = CT_REF + CT_N, CT_PARAMETER = CT_RATE + CT_N, CT_END = CT_PARAMETER + CT_NUMBERS * CT_N
};
enum { CT_OK = 0, CT_ERROR = 3 };
enum { CT_START = 1, CT_INIT = 2, CT_STEP = 4, CT_DONE = 8, CT_ANY = 15 };

typedef struct {
    sb_axis axis[CT_N];
    sb_memory memory[CT_N];
    double ring[CT_N][CT_RING], q[CT_N], dq[CT_N], tau[CT_N], sample, start, time;
    long long next; /* the sample that comes next */
    int stands;
} ct_core;

typedef struct {
    ct_core core;
    void *environment;
    void (*logger)(void);
    void (*say)(const void *c, const char *text);
} ct_instance;

static int ct_fail(const ct_instance *c, const char *text) {
    if (c->say) c->say(c, text);
    return CT_ERROR;
}

static int ct_may(const ct_instance *c, int where, const char *function) {
    if (!c) return 0;
    if (c->core.stands & where) return 1;
    ct_fail(c, function);
    return 0;
}

static void ct_attach(ct_core *c) {
    for (int j = 0; j < CT_N; j++) c->axis[j].table = ct_tables[j];
}

static void ct_restart(ct_core *c) {
    memset(c, 0, sizeof *c);
    memcpy(c->axis, ct_axes, sizeof c->axis);
    ct_attach(c);
    c->sample = CT_SAMPLE;
    c->stands = CT_START;
}

static void ct_begin(ct_core *c) {
    for (int j = 0; j < CT_N; j++) sb_sampled_start(c->axis + j, c->memory + j);
    c->next = 0, c->time = c->start, c->stands = CT_STEP;
}

/* The samples that fall into [time, time + h): each takes the present inputs. */
static int ct_do_step(ct_instance *f, double time, double h) {
    ct_core *c = &f->core;
    const double near = 1e-6 * c->sample, since = time - c->start;
    if (!(h > 0.0) || h - h != 0.0) return ct_fail(f, "a communication step must be positive and finite");
    if (!(fabs(time - c->time) <= near)) return ct_fail(f, "a step must begin where the last one ended");
    for (int j = 0; j < CT_N; j++)
        if (!(c->q[j] - c->q[j] == 0.0) || !(c->dq[j] - c->dq[j] == 0.0)) return ct_fail(f, "an input is not finite");
    for (; c->next * c->sample < since + h - near; c->next++) {
        const double t = c->next * c->sample;
        for (int j = 0; j < CT_N; j++) {
            const sb_axis *a = c->axis + j;
            const double q = sb_encoded(a, c->q[j]);
            c->ring[j][c->next % CT_RING] = sb_sampled(a, c->memory + j, t, c->sample, c->next == 0, q, c->dq[j]);
            c->tau[j] = c->next >= a->delay ? c->ring[j][(c->next - a->delay) % CT_RING] : 0.0;
        }
    }
    c->time = time + h;
    return CT_OK;
}

static int ct_get(const ct_core *c, unsigned vr, double *value) {
    double r, dr, ddr;
    if (vr == CT_TIME) *value = c->time;
    else if (vr == CT_SAMPLE_TIME) *value = c->sample;
    else if (vr < CT_DQ) *value = c->q[vr - CT_Q];
    else if (vr < CT_TAU) *value = c->dq[vr - CT_DQ];
    else if (vr < CT_REF) *value = c->tau[vr - CT_TAU];
    else if (vr < CT_PARAMETER) {
        sb_reference(c->axis + (vr - CT_REF) % CT_N, c->time - c->start, &r, &dr, &ddr);
        *value = vr < CT_RATE ? r : dr;
    } else if (vr < CT_END) *value = ((const double *)&c->axis[(vr - CT_PARAMETER) / CT_NUMBERS])[(vr - CT_PARAMETER) % CT_NUMBERS];
    else return 0;
    return 1;
}

static int ct_set(ct_core *c, unsigned vr, double value) {
    if (value - value != 0.0) return 0;
    if (vr == CT_SAMPLE_TIME && value > 0.0 && c->stands & (CT_START | CT_INIT)) c->sample = value;
    else if (vr >= CT_Q && vr < CT_DQ) c->q[vr - CT_Q] = value;
    else if (vr >= CT_DQ && vr < CT_TAU) c->dq[vr - CT_DQ] = value;
    else if (vr >= CT_PARAMETER && vr < CT_END) ((double *)&c->axis[(vr - CT_PARAMETER) / CT_NUMBERS])[(vr - CT_PARAMETER) % CT_NUMBERS] = value;
    else return 0;
    return 1;
}

/* A state as bytes: the token, then the core without its pointers. */
#define CT_BYTES (sizeof CT_TOKEN + sizeof(ct_core))

static void ct_write(const ct_core *c, void *bytes) {
    ct_core bare = *c;
    for (int j = 0; j < CT_N; j++) bare.axis[j].table = NULL;
    memcpy(bytes, CT_TOKEN, sizeof CT_TOKEN);
    memcpy((char *)bytes + sizeof CT_TOKEN, &bare, sizeof bare);
}

static int ct_read(ct_core *c, const void *bytes, size_t size) {
    if (size != CT_BYTES || memcmp(bytes, CT_TOKEN, sizeof CT_TOKEN)) return 0;
    memcpy(c, (const char *)bytes + sizeof CT_TOKEN, sizeof *c);
    for (int j = 0; j < CT_N; j++) { /* what indexes memory is not taken from outside */
        c->axis[j].knots = ct_axes[j].knots, c->axis[j].delay = ct_axes[j].delay;
        c->axis[j].reference_kind = ct_axes[j].reference_kind;
    }
    if (c->next < 0 || !(c->sample > 0.0)) return 0;
    ct_attach(c);
    return 1;
}

#endif
