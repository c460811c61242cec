/* The FMU state as bytes: a header that says what it belongs to, then values only, no pointers.
 *
 * The part gives FM_EACH(X), which names every value of its core that a simulation goes on from, FM_SIZES, three
 * numbers that two models of the same layout share, and fm_sound, which tells whether values can be gone on from.
 */
#ifndef FM_BLOB_H
#define FM_BLOB_H

#define FM_BLOB_VERSION 2u

typedef struct {
    char magic[8];
    uint32_t version, order, bytes, sizes[3]; /* order: of the bytes in a word */
    uint64_t model, sum;
} fm_header;

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
    static const uint32_t sizes[] = FM_SIZES;
    fm_header header;
    memset(&header, 0, sizeof header);
    memcpy(header.magic, "stribeck", 8);
    memcpy(header.sizes, sizes, sizeof header.sizes);
    header.version = FM_BLOB_VERSION, header.order = 0x01020304u, header.bytes = (uint32_t)fm_blob_size();
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
    fm_restart(c);
#define FM_GET(field) memcpy(&c->field, at, sizeof c->field), at += sizeof c->field;
    FM_EACH(FM_GET)
#undef FM_GET
    if (c->stands <= 0 || c->stands >= 2 * FM_CONFIGURE || (c->stands & (c->stands - 1))) return "it stands nowhere";
    return fm_sound(c) ? NULL : "its values cannot be";
}

#endif
