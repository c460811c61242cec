/* A first-order lag as an FMI 2 slave, and ways in which a binary can misbehave. WAY says which. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct { double u, x, T; } lag;

static int calls; /* a global, so that a second instance in one process differs: not in two processes */

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return WAY == 7 ? "3.0" : "2.0"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place, const void *callbacks,
                      int visible, int logging) {
    (void)name, (void)type, (void)place, (void)callbacks, (void)visible, (void)logging;
    if (strcmp(guid, "{tiny}") != 0) return NULL;
    lag *m = calloc(1, sizeof *m);
    m->T = 0.5;
    return m;
}

void fmi2FreeInstance(void *m) { free(m); }

int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value) {
    lag *m = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == 0) m->u = value[i];
        else if (vr[i] == 2) m->T = value[i];
        else return 3;
    }
    return 0;
}

int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    lag *m = c;
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == 0 ? m->u : vr[i] == 1 ? m->x : m->T;
    return 0;
}

int fmi2DoStep(void *c, double t, double h, int keep) {
    lag *m = c;
    (void)t, (void)keep;
    if (WAY == 1 && ++calls == 3) *(volatile int *)16 = 1; /* crashes */
    if (WAY == 2) for (;;) { }                             /* hangs */
    if (WAY == 3) m->x = 0.0 / (m->x - m->x);              /* not a number */
    if (WAY == 4) { while (malloc(1 << 28)) { } return 3; } /* eats memory */
    if (WAY == 5) exit(0);                                 /* pretends to be done */
    if (WAY == 6) return 3;                                /* fails */
    if (WAY == 8) m->x = (double)getpid();                 /* another result each time */
    else m->x += (m->u + 1.0 - m->x) * h / m->T;
    return 0;
}
