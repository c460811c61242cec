/* The FMU state as bytes: a header that says what it belongs to, then values only, no pointers. */
#ifndef FM_BLOB_H
#define FM_BLOB_H

#include "values.h"

#define FM_BLOB_VERSION 1u

typedef struct {
    char magic[8];
    uint32_t version, order, bytes, sizes[3]; /* order: of the bytes in a word */
    uint64_t model, sum;
} fm_header;

/* Every value that a simulation goes on from. What a step makes anew (stages, matrices) is left out. */
#define FM_EACH(X)                                                                                                    \
    X(sim.t) X(sim.h) X(sim.rtol) X(sim.atol) X(sim.y) X(sim.mode) X(sim.u) X(sim.f) X(sim.margin) X(sim.fresh)       \
    X(sim.stiff) X(sim.near_edge) X(sim.suspicion) X(sim.calm) X(sim.status) X(sim.steps) X(sim.rejected)             \
    X(sim.evaluations) X(sim.events) X(sim.last_event) X(sim.stalled) X(sim.held) X(sim.stuck_time) X(sim.top_speed)  \
    X(sim.waiting) X(sim.passing) X(p) X(q_start) X(dq_start) X(tau) X(slope) X(ring) X(seen) X(tolerance) X(start)   \
    X(count) X(newest) X(at) X(stands) X(touched) X(known)

static size_t fm_blob_size(void) {
    size_t size = sizeof(fm_header);
#define FM_ADD(field) size += sizeof ((fm_core *)0)->field;
    FM_EACH(FM_ADD)
#undef FM_ADD
    return size;
}

/* Fowler, Noll and Vo's hash, 64 bits. */
static uint64_t fm_hash(const unsigned char *bytes, size_t count, uint64_t hash) {
    for (size_t i = 0; i < count; i++) hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

static uint64_t fm_model(void) {
    return fm_hash((const unsigned char *)FM_TOKEN, sizeof FM_TOKEN - 1, 14695981039346656037u);
}

static fm_header fm_header_of(const unsigned char *values) {
    fm_header header;
    memset(&header, 0, sizeof header);
    memcpy(header.magic, "stribeck", 8);
    header.version = FM_BLOB_VERSION, header.order = 0x01020304u, header.bytes = (uint32_t)fm_blob_size();
    header.sizes[0] = SB_N, header.sizes[1] = SB_NS, header.sizes[2] = SB_NP;
    header.model = fm_model();
    header.sum = fm_hash(values, fm_blob_size() - sizeof header, header.model);
    return header;
}

static void fm_write(const fm_core *c, unsigned char *bytes) {
    unsigned char *at = bytes + sizeof(fm_header);
#define FM_PUT(field) memcpy(at, &c->field, sizeof c->field), at += sizeof c->field;
    FM_EACH(FM_PUT)
#undef FM_PUT
    const fm_header header = fm_header_of(bytes + sizeof header);
    memcpy(bytes, &header, sizeof header);
}

/* Whether values that came as bytes can be gone on from: what they index lies inside, what they say can be. */
static int fm_sound(const fm_core *c) {
    const int s = c->stands;
    int sound = s > 0 && s < 2 * FM_CONFIGURE && (s & (s - 1)) == 0;
    sound &= c->sim.status >= SB_OK && c->sim.status <= SB_NOT_FINITE;
    sound &= c->sim.rtol > 0.0 && c->sim.atol > 0.0 && c->sim.h > 0.0 && sb_finite(&c->sim.t, 1);
    sound &= sb_finite(c->p, SB_NP) && sb_finite(c->tau, SB_N) && sb_finite(c->slope, SB_N);
    for (int j = 0; j < SB_N; j++) {
        const double m = c->sim.mode[j];
        sound &= m == 0.0 || m == 1.0 || m == -1.0;
        sound &= c->count[j] >= 0 && c->count[j] <= FM_RING;
        sound &= c->newest[j] >= 0 && c->newest[j] < FM_RING && c->at[j] >= 0 && c->at[j] < FM_RING;
        sound &= c->count[j] == 0 || (c->newest[j] < c->count[j] && c->at[j] < c->count[j]);
    }
    return sound;
}

/* Read bytes into a core. Gives what is wrong with them, or NULL. */
static const char *fm_read(fm_core *c, const unsigned char *bytes, size_t size) {
    fm_header header, wanted;
    if (size < sizeof header) return "it is too short for a header";
    memcpy(&header, bytes, sizeof header);
    if (memcmp(header.magic, "stribeck", 8)) return "it is not a state of this kind of FMU";
    if (header.version != FM_BLOB_VERSION) return "it was written by another version";
    if (size != fm_blob_size() || header.bytes != size) return "it is truncated or of another machine";
    wanted = fm_header_of(bytes + sizeof header);
    if (header.model != wanted.model) return "it is a state of another model";
    if (memcmp(&header, &wanted, sizeof header)) return "it is damaged";
    const unsigned char *at = bytes + sizeof header;
    memset(c, 0, sizeof *c);
    sb_init(&c->sim, c->p, FM_TOLERANCE);
    c->sim.bound = FM_BOUND;
#define FM_GET(field) memcpy(&c->field, at, sizeof c->field), at += sizeof c->field;
    FM_EACH(FM_GET)
#undef FM_GET
    return fm_sound(c) ? NULL : "its values cannot be";
}

/* Take a core that lay elsewhere. */
static void fm_adopt(fm_instance *f, const fm_core *c) {
    if (&f->core != c) f->core = *c;
    f->core.sim.p = f->core.p;
    f->core.sim.control = NULL;
    for (int j = 0; j < SB_N; j++)
        if (f->core.ring[j][f->core.at[j]].slope != 0.0) f->core.sim.control = fm_ramp;
}

#endif
