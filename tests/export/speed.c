/* CPU time of steps of 1 ms, of any FMI 2 binary; and an FMU whose step does nothing but add up time. */
#include <time.h>

typedef int (*do_step)(void *c, double t, double h, int);

typedef struct {
    double time;
} idle;

__attribute__((visibility("default"))) int idle_step(void *c, double t, double h, int no) {
    (void)no;
    ((idle *)c)->time = t + h;
    return 0;
}

/* Nanoseconds a step, over `count` steps of h from the time `start`; less than 0 where one fails. */
double timed(do_step step, void *c, double start, double h, long count) {
    struct timespec a, b;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
    for (long k = 0; k < count; k++)
        if (step(c, start + (double)k * h, h, 1) != 0) return -1.0;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
    return (1e9 * (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec)) / (double)count;
}
