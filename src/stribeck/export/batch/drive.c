/* Many simulations of one Co-Simulation FMU, of either version, without a word of Python in between.
 *
 * The FMU's functions come as addresses in the order of `functions` below. Declared here as the standard does, so that
 * no header is needed.
 */
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

typedef struct {
    void *instantiate, *set_real, *get_real, *setup, *enter, *leave, *step, *reset, *release;
} functions;

typedef void *(*instantiate2)(const char *, int, const char *, const char *, const callbacks *, int, int);
typedef void *(*instantiate3)(const char *, const char *, const char *, _Bool, _Bool, _Bool, _Bool, const uint32_t *,
                              size_t, void *, void *, void *);
typedef int (*set2)(void *, const uint32_t *, size_t, const double *);
typedef int (*set3)(void *, const uint32_t *, size_t, const double *, size_t);
typedef int (*get2)(void *, const uint32_t *, size_t, double *);
typedef int (*get3)(void *, const uint32_t *, size_t, double *, size_t);
typedef int (*setup2)(void *, int, double, double, int, double);
typedef int (*enter3)(void *, _Bool, double, double, _Bool, double);
typedef int (*plain)(void *);
typedef int (*step2)(void *, double, double, int);
typedef int (*step3)(void *, double, double, _Bool, _Bool *, _Bool *, _Bool *, double *);
typedef void (*release)(void *);

static void quiet(void *e, const char *n, int s, const char *c, const char *m, ...) { (void)e, (void)n, (void)s, (void)c, (void)m; }

typedef struct {
    int version;
    const functions *f;
    void *instance;
} target;

static int put(const target *t, const uint32_t *vr, size_t count, const double *values) {
    if (count == 0) return 0;
    return t->version == 2 ? ((set2)t->f->set_real)(t->instance, vr, count, values)
                           : ((set3)t->f->set_real)(t->instance, vr, count, values, count);
}

static int look(const target *t, const uint32_t *vr, size_t count, double *values) {
    if (count == 0) return 0;
    return t->version == 2 ? ((get2)t->f->get_real)(t->instance, vr, count, values)
                           : ((get3)t->f->get_real)(t->instance, vr, count, values, count);
}

static int begin(const target *t, double start, double tolerance) {
    int status;
    if (t->version == 2) {
        status = ((setup2)t->f->setup)(t->instance, 1, tolerance, start, 0, 0.0);
        if (status <= 1) status = ((plain)t->f->enter)(t->instance);
    } else status = ((enter3)t->f->enter)(t->instance, 1, tolerance, start, 0, 0.0);
    return status <= 1 ? ((plain)t->f->leave)(t->instance) : status;
}

static int step(const target *t, double time, double h) {
    _Bool event, terminate, early;
    double last;
    if (t->version == 2) return ((step2)t->f->step)(t->instance, time, h, 1);
    return ((step3)t->f->step)(t->instance, time, h, 1, &event, &terminate, &early, &last);
}

/* One simulation: values set, then rows of outputs at the instants. Gives the number of rows that were reached. */
static long long run(const target *t, const uint32_t *set_vr, size_t sets, const double *values, const uint32_t *in_vr,
                     size_t ins, const double *command, const uint32_t *out_vr, size_t outs, const double *times,
                     long long count, double tolerance, double *out) {
    if (put(t, set_vr, sets, values) > 1 || put(t, in_vr, ins, command) > 1) return 0;
    if (begin(t, times[0], tolerance) > 1) return 0;
    for (long long k = 0; k < count; k++) {
        if (look(t, out_vr, outs, out + k * (long long)outs) > 1) return k;
        if (k + 1 == count) break;
        if (put(t, in_vr, ins, command + k * (long long)ins) > 1) return k + 1;
        if (step(t, times[k], times[k + 1] - times[k]) > 1) return k + 1;
    }
    return count;
}

/* Exported. Simulations first .. last - 1; values (runs, sets), command (runs or 1, count, ins), out (runs, count,
 * outs), reached (runs). Gives 0 where the FMU cannot be instantiated. */
EXPORT int drive(int version, const functions *f, const char *token, long long first, long long last,
                 const uint32_t *set_vr, long long sets, const double *values, const uint32_t *in_vr, long long ins,
                 const double *command, int shared, const uint32_t *out_vr, long long outs, const double *times,
                 long long count, double tolerance, double *out, long long *reached) {
    const callbacks own = {quiet, calloc, free, NULL, NULL};
    target t = {version, f, NULL};
    t.instance = version == 2 ? ((instantiate2)f->instantiate)("batch", 1, token, "", &own, 0, 0)
                              : ((instantiate3)f->instantiate)("batch", token, "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    if (!t.instance) return 0;
    for (long long r = first; r < last; r++) {
        if (r > first) ((plain)f->reset)(t.instance);
        const double *u = command + (shared ? 0 : r * count * ins);
        reached[r] = run(&t, set_vr, (size_t)sets, values + r * sets, in_vr, (size_t)ins, u, out_vr, (size_t)outs, times,
                         count, tolerance, out + r * count * outs);
    }
    ((release)f->release)(t.instance);
    return 1;
}
