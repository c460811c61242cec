/* One joint, one loop, one cell of a map: what it settles on. Event by event, in closed form where the joint sticks.
 *
 * Of its own, beside the engine: a cell has five states, its law is one expression, and thousands of cells are wanted.
 * State: deviation x = q - r, velocity v, integral z, filtered velocity w, drive torque l.
 */
#include <math.h>
#include <string.h>

#ifdef _WIN32
#define SB_EXPORT __declspec(dllexport)
#else
#define SB_EXPORT
#endif

/* What Python mirrors is written as a list, which a function at the end tells. */
#define FIELD(declaration) declaration;
#define CONSTANT(name) name,
#define QUOTE(text) #text ";"

/* As VERDICTS in cycle.py, KINDS in cells.py and AT_ZERO in axis.py. */
#define VERDICTS(X) X(REST) X(STICK_SLIP) X(HUNTING) X(SLIDING_CYCLE) X(CHATTER) X(UNBOUNDED) X(UNDETERMINED)
#define KINDS(X) X(NONE) X(FEEDFORWARD) X(FEEDBACK)
#define AT_ZERO(X) X(ZERO) X(HOLD) X(ERROR_SIGN) X(SET_VALUED)
enum { VERDICTS(CONSTANT) };
enum { KINDS(CONSTANT) };
enum { AT_ZERO(CONSTANT) };
enum { X, V, Z, W, L, STATES };
enum { MOST_DELAY = 1001, MOST_WAIT = 100000, MOST_SAMPLES = 400000 };
#define LEAST_MOVE 1e-12 /* rad; a smaller move in a sample counts as none: SB_LEAST_MOVE in control.h */

/* One cell; mirrored in cells.py. friction: C0, C1, C2, alpha forward, then backward; starts: error and velocity of up to
 * three starts; the first decides; NaN for none. */
#define CELL(X)                                                                                                 \
    X(double inertia) X(double kp) X(double kv) X(double ki) X(double filter) X(double lag) X(double limit)     \
    X(double ratio) X(double dead_band) X(double rate) X(double sample) X(double delay) X(double friction[8])   \
    X(double kind) X(double at_zero) X(double true_velocity) X(double starts[6])
typedef struct {
    CELL(FIELD)
} cell;

typedef struct {
    double y[STATES], t;
    int mode, held;          /* mode 0 sticks; the last sign other than 0 of the velocity as a continuous law takes it */
    double since;            /* time stuck since the round began */
    double sign;             /* of the reference's velocity */
    int above;
    double low, high;        /* of the present round, of the deviation in the reference's direction, as all below */
    double peak, at, range;  /* the turn at which it began; how far the one before went */
    int shallow;             /* turns since that were none */
    double shallow_low, shallow_high;
    int rounds;
    double amplitude[3], period[3], stuck[3]; /* of the last rounds, newest first */
    double sums[2][3]; /* over the present block of rounds, and the block before */
    double smallest, largest; /* amplitude in the present block */
    int in_block, blocks;
    double u; /* sampled: the torque in force */
} track;

static double sign_of(double a) { return (a > 0.0) - (a < 0.0); }

static double level(const cell *c, double direction, double speed) {
    const double *f = c->friction + (direction < 0.0 ? 4 : 0);
    return f[0] + f[1] * exp(-speed / f[3]) + f[2] * speed;
}

static double break_away(const cell *c, double direction) {
    const double *f = c->friction + (direction < 0.0 ? 4 : 0);
    return f[0] + f[1];
}

/* The error at which the drive just moves the joint, and the loop's own frequency: a cell is measured by these, so that
 * a slow one or a small one is followed as finely as any other. */
static double reach(const cell *c) {
    const double torque = fmax(break_away(c, 1.0), break_away(c, -1.0));
    return torque > 0.0 ? torque / c->kp : 1e-3;
}

static double own(const cell *c) { return sqrt(c->kp / c->inertia); }

static double limited(const cell *c, double torque) { return fmax(-c->limit, fmin(c->limit, torque)); }

/* Torque of the law; direction as the law takes it, at rest by the rule. */
static double law(const cell *c, double e, double velocity, double integral, double direction, int held) {
    const double pid = c->kp * e + c->kv * (c->rate - velocity) + c->ki * integral;
    if (c->kind == FEEDFORWARD) {
        const double s = sign_of(c->rate);
        return s != 0.0 ? pid + c->ratio * s * level(c, s, s * c->rate) : pid;
    }
    if (c->kind != FEEDBACK || c->ratio == 0.0) return pid;
    double s = direction;
    if (s == 0.0) {
        const int rule = (int)c->at_zero;
        s = rule == HOLD ? held : rule == ERROR_SIGN ? sign_of(e) : rule == SET_VALUED ? sign_of(pid) : 0.0;
    }
    return pid + c->ratio * s * level(c, s, direction * velocity);
}

/* The sign of a velocity as a continuous law takes it: the mode, where neither filter nor dead-band comes between. */
static double direction_of(const cell *c, double seen, int mode) {
    if (c->filter == 0.0 && c->dead_band == 0.0) return mode;
    return fabs(seen) > c->dead_band ? sign_of(seen) : 0.0;
}

static void hold_sign(const cell *c, track *k) {
    const double sign = direction_of(c, c->filter > 0.0 ? k->y[W] : k->y[V], k->mode);
    if (sign != 0.0) k->held = (int)sign;
}

/* --- rounds --------------------------------------------------------------------------------------------------- */

static void round_done(track *k, double amplitude, double period, double stuck) {
    for (int i = 2; i > 0; i--)
        k->amplitude[i] = k->amplitude[i - 1], k->period[i] = k->period[i - 1], k->stuck[i] = k->stuck[i - 1];
    k->amplitude[0] = amplitude, k->period[0] = period, k->stuck[0] = stuck;
    k->rounds++;
    double *now = k->sums[0];
    k->smallest = k->in_block ? fmin(k->smallest, amplitude) : amplitude;
    k->largest = k->in_block ? fmax(k->largest, amplitude) : amplitude;
    now[0] += amplitude, now[1] += period, now[2] += stuck, k->in_block++;
}

/* At a largest deviation: does a round end here? Small turns on the way do not count. */
static void turn(track *k) {
    const double dev = k->sign * k->y[X], least = 0.25 * k->range;
    k->high = fmax(k->high, dev);
    if (k->at < 0.0 || (k->peak - k->low >= least && dev - k->low >= least)) {
        if (k->at >= 0.0) {
            round_done(k, 0.5 * (k->high - k->low), k->t - k->at, k->since);
            k->range = k->high - k->low;
        }
        k->at = k->t, k->peak = k->low = k->high = dev, k->since = 0.0, k->shallow = 0;
        k->shallow_low = k->shallow_high = dev;
        return;
    }
    if (dev > k->peak && k->peak - k->low < least) k->peak = dev, k->low = dev; /* the round began at its first top */
    if (++k->shallow >= 8) {
        const double swing = k->shallow_high - k->shallow_low;
        if (swing < least) /* the swings have become small ones; else a joint turns often where it stops */
            k->range = swing, k->peak = k->low = k->high = dev;
        k->shallow = 0, k->shallow_low = k->shallow_high = dev;
    }
}

static void look(const cell *c, track *k) {
    const double relative = k->sign * (k->y[V] - c->rate), dev = k->sign * k->y[X];
    k->low = fmin(k->low, dev), k->high = fmax(k->high, dev);
    if (k->shallow) k->shallow_low = fmin(k->shallow_low, dev), k->shallow_high = fmax(k->shallow_high, dev);
    if (k->above && !(relative > 0.0)) turn(k);
    k->above = relative > 0.0;
}

/* Whether the rounds repeat: exactly, or on average over blocks of them. Gives a verdict's numbers. */
static int repeats(track *k, double *amplitude, double *period, double *stuck, int exact, int scatters) {
    enum { BLOCK = 6 };
    if (k->rounds >= 3) {
        const double close = exact ? 2e-5 : 1e-4; /* most sampled loops lock onto their samples */
        const double now = fabs(k->amplitude[0] - k->amplitude[1]), then = fabs(k->amplitude[1] - k->amplitude[2]);
        int same = now <= then || now < 1e-7 * k->amplitude[0]; /* what grows slowly is no cycle yet */
        for (int i = 0; i < 2; i++)
            same &= fabs(k->amplitude[i] - k->amplitude[i + 1]) < close * k->amplitude[i] &&
                    fabs(k->period[i] - k->period[i + 1]) < close * k->period[i];
        if (same) {
            *amplitude = k->amplitude[0], *period = k->period[0], *stuck = k->stuck[0];
            return 1;
        }
    }
    if (k->in_block < (exact ? 6 : 1) * BLOCK) return 0;
    double *now = k->sums[0], *before = k->sums[1];
    const int n = k->in_block;
    const double share = exact ? 1e-4 : now[0] > before[0] ? 2e-4 : 2e-3; /* what grows slowly is no cycle yet */
    int same = k->blocks > 0 && fabs(now[0] - before[0]) < share * now[0] && fabs(now[1] - before[1]) < share * now[1];
    /* where a velocity dies out the samples' phase scatters the next period, but not the amplitude */
    same |= k->blocks > 0 && scatters && k->largest - k->smallest < 1e-5 * k->largest && fabs(now[0] - before[0]) < 1e-5 * now[0];
    const int still = fabs(now[0] - before[0]) < 0.01 * now[0];
    *amplitude = now[0] / n, *period = now[1] / n, *stuck = now[2] / n;
    memcpy(before, now, 3 * sizeof(double)), memset(now, 0, 3 * sizeof(double));
    k->in_block = 0, k->blocks++;
    return same || (k->blocks > 40 && still); /* scattered rounds, their averages at least */
}

/* --- sliding -------------------------------------------------------------------------------------------------- */

/* Rates of a sliding joint under a continuous law, or under the constant command u of a sampled one. */
static void rates(const cell *c, const track *k, const double *y, double *dy) {
    double torque;
    if (c->sample > 0.0) {
        torque = c->lag > 0.0 ? y[L] : k->u;
        dy[Z] = dy[W] = 0.0, dy[L] = c->lag > 0.0 ? (k->u - y[L]) / c->lag : 0.0;
    } else {
        const double seen = c->filter > 0.0 ? y[W] : y[V];
        const double wanted = law(c, -y[X], seen, y[Z], direction_of(c, seen, k->mode), k->held), u = limited(c, wanted);
        torque = c->lag > 0.0 ? y[L] : u;
        dy[Z] = c->ki > 0.0 && !(wanted != u && wanted * -y[X] > 0.0) ? -y[X] : 0.0;
        dy[W] = c->filter > 0.0 ? (y[V] - y[W]) / c->filter : 0.0;
        dy[L] = c->lag > 0.0 ? (u - y[L]) / c->lag : 0.0;
    }
    dy[X] = y[V] - c->rate;
    dy[V] = k->mode == 0 ? 0.0 : (torque - k->mode * level(c, k->mode, k->mode * y[V])) / c->inertia;
}

/* One Bogacki-Shampine step, 3(2). Gives the scaled error. */
static double step(const cell *c, const track *k, const double *k1, double h, double *after, double *k4) {
    double k2[STATES], k3[STATES], y[STATES], worst = 0.0;
    const double far = reach(c), w = own(c), unit[STATES] = {far, far * w, far / w, far * w, far * c->kp};
    for (int i = 0; i < STATES; i++) y[i] = k->y[i] + 0.5 * h * k1[i];
    rates(c, k, y, k2);
    for (int i = 0; i < STATES; i++) y[i] = k->y[i] + 0.75 * h * k2[i];
    rates(c, k, y, k3);
    for (int i = 0; i < STATES; i++) after[i] = k->y[i] + h * (2 * k1[i] + 3 * k2[i] + 4 * k3[i]) / 9;
    rates(c, k, after, k4);
    for (int i = 0; i < STATES; i++) {
        const double error = h * (-5 * k1[i] / 72 + k2[i] / 12 + k3[i] / 9 - k4[i] / 8);
        const double size = fmax(fabs(k->y[i]), fabs(after[i]));
        worst = fmax(worst, fabs(error) / (1e-10 * unit[i] + 1e-5 * size));
    }
    return worst;
}

/* Fraction of a step at which a cubic with ends a, b and end slopes da, db (times the step) passes zero; a, b differ. */
static double crossing(double a, double da, double b, double db) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 30; i++) {
        const double x = 0.5 * (low + high);
        const double p = a + x * (da + x * ((3 * (b - a) - 2 * da - db) + x * (2 * (a - b) + da + db)));
        if ((p > 0.0) == (a > 0.0) && p != 0.0) low = x;
        else high = x;
    }
    return high;
}

/* At velocity zero: does it stick, or which way does it slide? As the engine decides: rest first. */
static void settle(const cell *c, track *k) {
    double torque[3];
    for (int m = -1; m <= 1; m++) {
        if (c->sample > 0.0) torque[m + 1] = c->lag > 0.0 ? k->y[L] : k->u;
        else if (c->lag > 0.0) torque[m + 1] = k->y[L];
        else {
            const double seen = c->filter > 0.0 ? k->y[W] : 0.0;
            torque[m + 1] = limited(c, law(c, -k->y[X], seen, k->y[Z], direction_of(c, seen, m), k->held));
        }
    }
    const double over[3] = {break_away(c, -1.0) + torque[0],
                            fmax(torque[1] - break_away(c, 1.0), -torque[1] - break_away(c, -1.0)),
                            break_away(c, 1.0) - torque[2]}; /* up to 0: it holds */
    k->mode = 0;
    const double rounding = 1e-12 * fmax(break_away(c, 1.0), break_away(c, -1.0)); /* a creep ends at the level itself */
    if (over[1] > rounding) k->mode = over[2] < over[0] ? 1 : -1; /* where both hold, the one that holds for certain */
    hold_sign(c, k);
}

/* The rest of the way of a sliding joint that hardly moves under PD alone: time till its velocity is zero, or -1. */
static double linear_return(const cell *c, const track *k, const double *dy) {
    if (c->ki > 0.0 || c->filter > 0.0 || c->lag > 0.0 || c->dead_band > 0.0) return -1.0;
    const double *f = c->friction + (k->mode < 0 ? 4 : 0);
    const double kept = c->kind == FEEDBACK ? 1.0 - c->ratio : 1.0;
    const double half = 0.5 * (c->kv + kept * (f[2] - f[1] / f[3])) / c->inertia;
    const double square = c->kp / c->inertia - half * half;
    if (!(square > 0.0)) return -1.0;
    const double omega = sqrt(square), v = k->y[V], a = dy[V];
    /* v(t) = e^(-half t) (v cos(omega t) + (a + half v)/omega sin(omega t)) */
    double phase = atan2(-v, (a + half * v) / omega);
    while (phase <= 0.0) phase += 3.14159265358979323846;
    return phase / omega;
}

/* Whether a sliding joint hardly moves relative to its reference any more: slowly even beside the speed over which its
 * friction bends, and beside its ramp, which it is not to be taken for following while it only breaks away. */
static int calm(const cell *c, const track *k, const double *dy) {
    const double far = reach(c), w = own(c), bend = c->friction[k->mode < 0 ? 7 : 3];
    const double ramp = c->rate != 0.0 ? 1e-3 * fabs(c->rate) : HUGE_VAL;
    const double slow = fmin(fmin(1e-5 * far * w, 2e-4 * bend), ramp), change = fmin(2e-5 * far * w, ramp) * w;
    return fabs(k->y[V] - c->rate) < slow && fabs(dy[V]) < change && fabs(dy[W]) < change &&
           fabs(dy[L]) < 3e-5 * far * c->kp * w && (c->ki == 0.0 || fabs(k->y[X]) < 5e-6 * far);
}

/* Slide until `end`, the velocity's zero or a turn; gives 1 at rest (asymptotically), 2 where it cannot. */
static int slide(const cell *c, track *k, double end, double *h, int continuous) {
    double k1[STATES], k4[STATES], after[STATES];
    rates(c, k, k->y, k1);
    int begun = k->y[V] == 0.0;
    /* near its end a swing is small beside the position, by which a step's error is measured */
    const double longest = continuous ? 0.15 * sqrt(c->inertia / c->kp) : HUGE_VAL;
    for (long n = 0; k->t < end; n++) {
        if (n > 20000) return 2;
        double g = fmin(fmin(*h, end - k->t), longest);
        double error = step(c, k, k1, g, after, k4);
        if (!(error <= 1.0)) {
            *h = g * (error < 1e30 ? fmax(0.2, 0.9 / cbrt(error)) : 0.1);
            if (*h < 1e-13) return 2;
            continue;
        }
        const double next = g * fmin(4.0, 0.9 / cbrt(fmax(error, 1e-9)));
        *h = g < *h ? fmax(*h, next) : next;
        const double before = k->y[V], m = k->mode;
        const int stops = m * after[V] < 0.0 || (m * after[V] == 0.0 && !begun);
        const double r0 = before - c->rate, r1 = after[V] - c->rate;
        const int turns = c->rate != 0.0 && k->above != (k->sign * r1 > 0.0) && r0 != 0.0 && !stops;
        if (stops || turns) {
            const double target = stops ? 0.0 : c->rate;
            double x = stops && begun ? 1.0 : crossing(before - target, g * k1[V], after[V] - target, g * k4[V]);
            g *= x;
            for (int i = 0; i < 2; i++) { /* the step again, only that far; the rest by its slope */
                step(c, k, k1, g, after, k4);
                if (fabs(after[V] - target) < 1e-13 || k4[V] == 0.0) break;
                const double correction = (target - after[V]) / k4[V];
                if (fabs(correction) > 0.2 * g) break;
                g += correction;
            }
            after[V] = target;
        }
        memcpy(k->y, after, sizeof after), memcpy(k1, k4, sizeof k4);
        k->t += g, begun = 0;
        hold_sign(c, k);
        look(c, k);
        if (stops) {
            settle(c, k);
            return 0;
        }
        if (!(fabs(k->y[X]) < 1e4 && fabs(k->y[V]) < 1e4)) return 0;
        if (continuous && calm(c, k, k1)) {
            const double wait = c->rate == 0.0 ? linear_return(c, k, k1) : -1.0;
            if (wait < 0.0) return 1;
            k->y[X] += k1[V] / (c->kp / c->inertia), k->y[V] = 0.0, k->t += wait; /* on to the resting point */
            look(c, k);
            settle(c, k);
            return 0;
        }
    }
    return 0;
}

/* --- sticking under a continuous law -------------------------------------------------------------------------- */

static double stuck_torque(const cell *c, const track *k) {
    const double seen = c->filter > 0.0 ? k->y[W] : 0.0;
    const double direction = fabs(seen) > c->dead_band ? sign_of(seen) : 0.0;
    return limited(c, law(c, -k->y[X], seen, k->y[Z], direction, k->held));
}

/* How far the torque is beyond the break-away level. */
static double beyond(const cell *c, double torque) {
    return fmax(torque - break_away(c, 1.0), -torque - break_away(c, -1.0));
}

static void wait_for(const cell *c, track *k, double h) {
    const double e = -k->y[X];
    const double before = stuck_torque(c, k);
    if (c->ki > 0.0 && fabs(before) < c->limit) k->y[Z] += e * h + 0.5 * c->rate * h * h;
    k->y[X] -= c->rate * h;
    if (c->filter > 0.0) k->y[W] *= exp(-h / c->filter);
    if (c->lag > 0.0) { /* the command is a line over a short step */
        const double after = stuck_torque(c, k), slope = (after - before) / h, q = exp(-h / c->lag);
        k->y[L] = after - slope * c->lag + (k->y[L] - before + slope * c->lag) * q;
    }
    k->t += h, k->since += h;
}

/* Wait until the drive breaks the joint away. Gives 1 where it never does. */
static int stick(const cell *c, track *k, double longest) {
    const double slow = fmax(c->filter, c->lag);
    const double begin = k->t;
    double h = slow > 0.0 ? 0.1 * fmin(c->filter > 0.0 ? c->filter : slow, c->lag > 0.0 ? c->lag : slow) : longest;
    const double turned = k->sign * (0.0 - c->rate) > 0.0;
    k->above = turned != 0.0;
    if (c->ki == 0.0 && c->rate == 0.0 && slow == 0.0) return 1;
    for (long n = 0; k->t - begin < longest; n++) {
        if (n > 4000) return 2;
        if (slow == 0.0 || k->t - begin > 30.0 * slow) {
            /* u(t) = u + b t + a t^2 in closed form; a lag only shifts it */
            const double e = -k->y[X], b = c->kp * c->rate + c->ki * e, a = 0.5 * c->ki * c->rate;
            const double u = (slow > 0.0 && c->lag > 0.0 ? k->y[L] : stuck_torque(c, k));
            if (a == 0.0 && fabs(b) < 1e-12) return 1;
            double first = HUGE_VAL;
            for (int s = -1; s <= 1; s += 2) { /* s (u + b t + a t^2) = break-away */
                const double gap = break_away(c, s) - s * u, sb = s * b, sa = s * a;
                if (sa == 0.0) {
                    if (sb > 0.0) first = fmin(first, gap / sb);
                    continue;
                }
                const double root = sb * sb + 4 * sa * gap;
                if (root < 0.0) continue;
                const double t1 = (-sb + sqrt(root)) / (2 * sa), t2 = (-sb - sqrt(root)) / (2 * sa);
                if (t1 > 0.0) first = fmin(first, t1);
                if (t2 > 0.0) first = fmin(first, t2);
            }
            if (!(first < longest)) return 1;
            k->y[Z] += c->ki > 0.0 ? e * first + 0.5 * c->rate * first * first : 0.0, k->y[X] -= c->rate * first;
            k->t += first, k->since += first;
            if (c->lag > 0.0) k->y[L] += b * first + a * first * first;
            if (c->filter > 0.0) k->y[W] = 0.0;
            break;
        }
        const track kept = *k;
        wait_for(c, k, h);
        if (beyond(c, c->lag > 0.0 ? k->y[L] : stuck_torque(c, k)) > 0.0) {
            double low = 0.0, high = h;
            for (int i = 0; i < 30; i++) {
                const double middle = 0.5 * (low + high);
                *k = kept;
                wait_for(c, k, middle);
                if (beyond(c, c->lag > 0.0 ? k->y[L] : stuck_torque(c, k)) > 0.0) high = middle;
                else low = middle;
            }
            *k = kept;
            wait_for(c, k, high);
            break;
        }
    }
    if (k->t - begin >= longest) return 1;
    look(c, k);
    const double torque = c->lag > 0.0 ? k->y[L] : stuck_torque(c, k);
    settle(c, k);
    if (k->mode == 0) k->mode = torque > 0.0 ? 1 : -1; /* at the level itself: rounding only */
    hold_sign(c, k);
    return 0;
}

/* --- one start of one cell ------------------------------------------------------------------------------------ */

static void begin(const cell *c, track *k, double error, double velocity) {
    memset(k, 0, sizeof *k);
    k->y[X] = -error, k->y[V] = velocity;
    k->sign = c->rate < 0.0 ? -1.0 : 1.0;
    k->above = k->sign * (velocity - c->rate) > 0.0;
    k->low = k->high = k->sign * k->y[X], k->at = -1.0;
    k->shallow_low = k->shallow_high = k->low;
    k->mode = velocity > 0.0 ? 1 : velocity < 0.0 ? -1 : 0;
    hold_sign(c, k);
}

static int named(const cell *c, double period, double stuck) {
    const double reaction = (c->delay + 2) * c->sample;
    if (c->sample > 0.0 && period <= 4 * (c->delay + 2) * c->sample) return CHATTER;
    if (stuck <= fmax(2 * reaction, 1e-9 * period)) return SLIDING_CYCLE;
    return c->rate == 0.0 ? HUNTING : STICK_SLIP;
}

static int over(const track *k) { return !(fabs(k->y[X]) < 1e4 && fabs(k->y[V]) < 1e4); }

static int run_continuous(const cell *c, double error, double velocity, double *out) {
    track k;
    double h = 1e-4, stuck = 0.0;
    begin(c, &k, error, velocity);
    if (c->lag > 0.0) k.y[L] = 0.0;
    if (k.mode == 0) settle(c, &k);
    int seen = 0;
    for (long n = 0; n < 4000; n++) {
        const int why = k.mode == 0 ? stick(c, &k, 1e6) : slide(c, &k, k.t + 1e5, &h, 1);
        if (why == 2) return UNDETERMINED;
        if (why == 1) return REST;
        if (over(&k)) return UNBOUNDED;
        if (k.rounds == seen) continue;
        seen = k.rounds;
        if (k.amplitude[0] < 1e-7 && seen > 1 && k.amplitude[0] < k.amplitude[1]) return REST;
        if (repeats(&k, out, out + 1, &stuck, 1, 0)) return out[2] = stuck / out[1], named(c, out[1], stuck);
    }
    return UNDETERMINED;
}

/* One step of third order (Bogacki & Shampine) of a joint that slides under a constant torque. Past a stop friction keeps
 * its level, so that a step too far still points back to where it is. */
static double held_step(const cell *c, const track *k, const double *f, double m, double k1, double h, double *x) {
    const double v = k->y[V], j = 1.0 / c->inertia, u = k->u - m * f[0], bend = -1.0 / f[3];
    const double v2 = v + 0.5 * h * k1, k2 = j * (u - m * f[1] * exp(bend * fmax(m * v2, 0.0)) - f[2] * v2);
    const double v3 = v + 0.75 * h * k2, k3 = j * (u - m * f[1] * exp(bend * fmax(m * v3, 0.0)) - f[2] * v3);
    *x = k->y[X] + h * (v - c->rate) + h * h * (k1 + 2 * k2) / 6;
    return v + h * (2 * k1 + 3 * k2 + 4 * k3) / 9;
}

static double held_rate(const cell *c, const track *k, const double *f, double m, double v) {
    return (k->u - m * (f[0] + f[1] * exp(-fmax(m * v, 0.0) / f[3])) - f[2] * v) / c->inertia;
}

/* As slide, under a constant torque: two states, steps as short as the bend of the friction wants them. */
static void slide_held(const cell *c, track *k, double end) {
    const double m = k->mode;
    const double *f = c->friction + (m < 0.0 ? 4 : 0);
    const double longest = 0.25 * c->inertia / (f[1] / f[3] + f[2] + 1e-300);
    int begun = k->y[V] == 0.0;
    while (k->t < end) {
        const double k1 = held_rate(c, k, f, m, k->y[V]), before = k->y[V];
        const double left = end - k->t;
        /* well above the bend of the friction the whole rest is one step */
        const int fast = m * before > 10.0 * f[3] && m * (before + k1 * left) > 8.0 * f[3];
        double h = fast ? left : fmin(left, longest), x, v = held_step(c, k, f, m, k1, h, &x);
        const int stops = m * v < 0.0 || (v == 0.0 && !begun);
        const int turns = c->rate != 0.0 && !stops && k->above != (k->sign * (v - c->rate) > 0.0) && before != c->rate;
        if (stops || turns) {
            const double target = stops ? 0.0 : c->rate;
            h *= stops && begun ? 1.0 : crossing(before - target, h * k1, v - target, h * held_rate(c, k, f, m, v));
            const double most = fmin(end - k->t, longest);
            for (int i = 0; i < 3; i++) {
                v = held_step(c, k, f, m, k1, h, &x);
                const double slope = held_rate(c, k, f, m, v);
                if (slope == 0.0 || fabs(v - target) < 1e-12) break;
                h = fmax(0.0, fmin(h + (target - v) / slope, most));
            }
            held_step(c, k, f, m, k1, h, &x);
            v = target;
        }
        k->y[X] = x, k->y[V] = v, k->t = end - k->t - h < 1e-13 ? end : k->t + h, begun = 0;
        look(c, k);
        if (stops) {
            settle(c, k);
            return;
        }
    }
}

/* Go on to `end` under the command in force. */
static int sampled_interval(const cell *c, track *k, double end, double *h) {
    for (int n = 0; k->t < end; n++) {
        if (n > 1000) return 2;
        if (k->mode == 0) {
            double left = end - k->t;
            if (c->lag > 0.0 && beyond(c, k->u) > 0.0) {
                const double level_at = k->u > 0.0 ? break_away(c, 1.0) : -break_away(c, -1.0);
                const double ratio = (k->u - k->y[L]) / (k->u - level_at);
                if (ratio > 0.0) left = fmin(left, c->lag * log(ratio));
            }
            if (c->lag > 0.0) k->y[L] = k->u + (k->y[L] - k->u) * exp(-left / c->lag);
            k->y[X] -= c->rate * left, k->t += left, k->since += left;
            look(c, k);
            if (k->t < end) k->mode = k->u > 0.0 ? 1 : -1;
        } else if (c->lag == 0.0) slide_held(c, k, end);
        else if (slide(c, k, end, h, 0) == 2) return 2;
        if (end - k->t < 1e-12 * (1.0 + end)) k->t = end;
    }
    return 0;
}

/* Velocities that die away, by their last two modes: in how many samples they are below `least`, or come back through
 * zero (then `swings`). -1 where they grow, MOST_WAIT where they take longer. */
static double dies_in(const double *past, long n, double least, int *swings) {
    const double v0 = past[(n - 24) & 31], v1 = past[(n - 16) & 31], v2 = past[(n - 8) & 31], v3 = past[n & 31];
    const double d = v1 * v1 - v0 * v2;
    const int two = fabs(d) > 1e-9 * v1 * v1;
    const double a = two ? (v1 * v2 - v0 * v3) / d : v2 != 0.0 ? v3 / v2 : 0.0, b = two ? (v1 * v3 - v2 * v2) / d : 0.0;
    double before = v2, now = v3;
    *swings = 0;
    if (!(fabs(now) >= least)) return 0.0;
    for (long k = 0; 8 * k < MOST_WAIT; k++) {
        const double next = a * now + b * before;
        if (next * now <= 0.0) return *swings = 1, 8 * (k + now / (now - next));
        if (fabs(next) < least) return 8 * (k + log(fabs(now) / least) / log(now / next));
        if (!(fabs(next) < 2 * fabs(v3))) return -1.0;
        before = now, now = next;
    }
    return MOST_WAIT;
}

/* Whether a joint that creeps to rest stays there once its velocity counts as none, by the rule for rest. */
static int holds(const cell *c, const track *k, double integral, int held) {
    if ((c->true_velocity != 0.0 && c->filter == 0.0) || c->rate != 0.0) return 1;
    return beyond(c, limited(c, law(c, -k->y[X], 0.0, integral, 0.0, held))) <= 0.0;
}

static int run_sampled(const cell *c, double error, double velocity, double *out) {
    track k;
    double queue[MOST_DELAY] = {0}, past[32] = {0}, h = 1e-3, last = 0.0, filtered = 0.0, integral = 0.0, previous = 0.0, stuck = 0.0;
    const double smooth = c->filter > 0.0 ? -expm1(-c->sample / c->filter) : 1.0;
    const int delay = (int)c->delay, calm_enough = 25 + delay;
    int held = 0, calm = 0, seen = 0, place = 0, scatters = 0;
    begin(c, &k, error, velocity);
    for (long n = 0; n < MOST_SAMPLES; n++) {
        const double e = -k.y[X], q = k.y[X] + c->rate * k.t;
        double measured = k.y[V];
        if (!(c->true_velocity != 0.0)) measured = n > 0 && fabs(q - last) >= LEAST_MOVE ? (q - last) / c->sample : 0.0;
        last = q;
        if (c->filter > 0.0) {
            filtered += smooth * (measured - filtered);
            measured = fabs(filtered) * c->sample < LEAST_MOVE ? 0.0 : filtered;
        }
        const double direction = fabs(measured) > c->dead_band ? sign_of(measured) : 0.0;
        const double wanted = law(c, e, measured, integral, direction, held);
        if (!(fabs(wanted) > c->limit && wanted * e > 0.0)) integral += e * c->sample;
        if (direction != 0.0) held = (int)direction;
        const double command = limited(c, wanted);
        const double change = fmax(fabs(k.y[V] - c->rate), fabs(command - previous));
        const int outlasts = c->filter > 0.0 && k.mode == 0 && direction != 0.0; /* its sign is that of a motion before */
        calm = n > 0 && !outlasts && change < (k.mode ? 1e-6 : 1e-10) ? calm + 1 : 0, previous = command;
        past[n & 31] = k.y[V];
        if (calm > calm_enough) {
            int swings = 0;
            const double wait = c->rate == 0.0 && k.mode != 0 ? dies_in(past, n, LEAST_MOVE / c->sample, &swings) : 0.0;
            if (!swings && wait >= 0.0 && (k.mode == 0 || holds(c, &k, integral, held))) return REST;
            calm = 0, scatters |= c->filter > 0.0;
            /* on to where it comes back, or to where no step of it counts any more; an integral goes on by itself */
            if (wait >= 0.0 && !(c->ki > 0.0) && !(c->filter > 0.0 && wait < 20000.0)) {
                if (wait >= MOST_WAIT) return UNDETERMINED;
                scatters = 1, n += (long)wait, k.t = (n + 1) * c->sample, last = k.y[X];
                filtered = c->filter > 0.0 ? filtered * exp(-wait * c->sample / c->filter) : 0.0, k.y[V] = 0.0, k.mode = 0;
                continue;
            }
        }
        queue[place] = command;
        if (++place > delay) place = 0;
        k.u = queue[place]; /* what was asked for `delay` samples ago; nothing before the first */
        if (k.y[V] == 0.0) settle(c, &k);
        if (sampled_interval(c, &k, (n + 1) * c->sample, &h)) return UNDETERMINED;
        if (over(&k)) return UNBOUNDED;
        if (k.rounds == seen) continue;
        seen = k.rounds;
        if (k.amplitude[0] < 1e-7 && seen > 1 && k.amplitude[0] < k.amplitude[1]) return REST;
        if (!repeats(&k, out, out + 1, &stuck, 0, scatters)) continue;
        return out[2] = stuck / out[1], named(c, out[1], stuck);
    }
    return UNDETERMINED;
}

/* Exported. Cells one after the other: verdicts, and amplitude, period and share of time stuck (., 3). */
SB_EXPORT void sb_cells(const cell *cells, long long count, signed char *verdict, double *out) {
    for (long long i = 0; i < count; i++) {
        const cell *c = cells + i;
        verdict[i] = UNDETERMINED;
        for (int s = 0; s < 3; s++) {
            const double *start = c->starts + 2 * s;
            double *mine = out + 3 * i, found[3] = {NAN, NAN, NAN};
            if (!(start[0] == start[0])) continue;
            const int is = c->sample > 0.0 ? run_sampled(c, start[0], start[1], found)
                                           : run_continuous(c, start[0], start[1], found);
            const int cycles = is >= STICK_SLIP && is <= CHATTER;
            if (s == 0 || cycles) verdict[i] = (signed char)is;
            mine[0] = mine[1] = mine[2] = NAN;
            if (cycles) memcpy(mine, found, sizeof found);
            if (cycles || (s == 0 && is == UNBOUNDED)) break;
        }
    }
}

/* Exported. How the structure and the names above are laid out: mirrored.py compares them with those of Python. */
SB_EXPORT const char *cell_fields(void) { return CELL(QUOTE); }
SB_EXPORT long long cell_size(void) { return (long long)sizeof(cell); }
SB_EXPORT const char *verdicts_names(void) { return VERDICTS(QUOTE); }
SB_EXPORT const char *kinds_names(void) { return KINDS(QUOTE); }
SB_EXPORT const char *at_zero_names(void) { return AT_ZERO(QUOTE); }
