/* Rounds of a loop: from one turn of a joint to the next, with a place to stop at and to go on from.
 *
 * Included after the engine's runtime. A joint turns where its velocity less its reference's falls through zero (rises,
 * for a reference that moves backward), so that it is furthest ahead of its reference there. In regulation that is
 * where it stops or reverses, which the engine meets exactly; along a ramp it is found by repeating the step.
 */

#define HUGE_COUNT 1000000000000000LL

enum { SB_QUIET = 20, SB_ENOUGH, SB_END }; /* further ways to stop, beside the engine's */
#define SB_FORGOTTEN 40.0 /* time constants after which a drive's lag follows a dither alone */
#define SB_AHEAD 1e5 /* s: friction that fades has done so long before */
#define SB_FEW 20000 /* steps, after which what is fast has faded */
enum { SB_ANY = -1 };                      /* joint whose turns count: any; below it none */

/* One turn: the joint, when, its deviation q - r, counted in the direction of the reference, so that a turn is a largest
 * one; since the turn before: extremes of the deviation, top speed, time stuck. As TURN in wish.py. */
#define SB_A_TURN(X) \
    X(double time) X(double deviation) X(double low) X(double high) X(double speed) X(double stuck) X(double joint)
typedef struct {
    SB_A_TURN(SB_FIELD)
} sb_turn;

typedef struct {
    sb_sim *s;
    const sb_loop *loop;
    double sign[SB_N], rate[SB_N]; /* of each reference */
    int above[SB_N], watch;
    double low[SB_N], high[SB_N], stuck[SB_N];
    double quiet, quiet_slide;
    double calm, moved; /* how long nothing must move, over all that a dither does; when something last did */
    sb_turn *turns;
    int still; /* nothing moves any more */
    long long count, size, most, seen;
} sb_rounds;

/* Of the measured position. */
static double sb_deviation(const sb_rounds *w, int j) {
    double q[SB_N], dq[SB_N], r, dr, ddr;
    sb_measure(w->s, w->s->t, w->s->y, q, dq);
    sb_reference(w->loop->axis + j, w->s->t, &r, &dr, &ddr);
    return q[j] - r;
}

static double sb_relative(const sb_rounds *w, const double *y, int j) {
    return w->sign[j] * (y[SB_N + j] - w->rate[j]);
}

/* Sets out from the marks (above, low, high, time stuck, top speed) of each joint; above 2 has none yet. */
static void sb_rounds_start(sb_rounds *w, sb_sim *s, const sb_loop *loop, const double *marks) {
    double r, ddr;
    w->s = s, w->loop = loop, w->moved = s->t;
    for (int j = 0; j < SB_N; j++, marks += 5) {
        const sb_axis *a = loop->axis + j;
        if (!a->controlled) continue;
        sb_reference(a, s->t, &r, w->rate + j, &ddr);
        s->ramp[j] = w->rate[j];
        if (sb_dithered(a)) w->calm = fmax(w->calm, SB_TURN / fabs(a->omega) + SB_FORGOTTEN * a->lag);
        w->sign[j] = w->rate[j] < 0.0 ? -1.0 : 1.0;
        if (marks[0] == 2.0) {
            w->above[j] = sb_relative(w, s->y, j) > 0.0;
            w->low[j] = w->high[j] = sb_deviation(w, j);
        } else {
            w->above[j] = marks[0] == 1.0, w->low[j] = marks[1], w->high[j] = marks[2];
            s->stuck_time[j] = marks[3], s->top_speed[j] = marks[4];
        }
    }
}

static void sb_rounds_stop(const sb_rounds *w, double *marks) {
    for (int j = 0; j < SB_N; j++, marks += 5) {
        marks[0] = w->above[j], marks[1] = w->low[j], marks[2] = w->high[j];
        marks[3] = w->s->stuck_time[j] - w->stuck[j], marks[4] = w->s->top_speed[j];
    }
}

static void sb_turned(sb_rounds *w, int j) {
    sb_sim *s = w->s;
    if (w->count < w->size) {
        sb_turn *turn = w->turns + w->count++;
        const double ends[2] = {w->sign[j] * w->low[j], w->sign[j] * w->high[j]};
        turn->time = s->t, turn->deviation = w->sign[j] * sb_deviation(w, j);
        turn->low = fmin(ends[0], ends[1]), turn->high = fmax(ends[0], ends[1]);
        turn->speed = s->top_speed[j], turn->stuck = s->stuck_time[j] - w->stuck[j], turn->joint = j;
    }
    w->low[j] = w->high[j] = sb_deviation(w, j);
    w->stuck[j] = s->stuck_time[j], s->top_speed[j] = 0.0;
    w->seen += w->watch == SB_ANY || j == w->watch;
}

static void sb_look(sb_rounds *w) {
    for (int j = 0; j < SB_N; j++) {
        if (!w->loop->axis[j].controlled) continue;
        const double d = sb_deviation(w, j);
        const int above = sb_relative(w, w->s->y, j) > 0.0;
        w->low[j] = fmin(w->low[j], d), w->high[j] = fmax(w->high[j], d);
        if (w->above[j] && !above) sb_turned(w, j);
        w->above[j] = above;
    }
}

/* The step just taken from `before` passed a turn that is no event of the engine: take it again, only that far. */
static void sb_refine(sb_rounds *w, const sb_sim *before) {
    sb_sim *s = w->s;
    double y[SB_NY], f[SB_NY], margin[2 * SB_N], first = s->t - before->t;
    const double whole = first;
    int passed = 0;
    for (int j = 0; j < SB_N; j++) {
        if (!w->loop->axis[j].controlled || (w->rate[j] == 0.0 && !sb_bristle[j])) continue;
        const double after = sb_relative(w, s->y, j);
        if (w->above[j] != (after > 0.0) && fabs(after) > 1e-14) passed = 1;
    }
    if (!passed) return;
    const sb_sim done = *s;
    *s = *before;
    if (!s->fresh) sb_rhs(s, s->t, s->y, s->f, s->margin), s->fresh = 1;
    if (s->stiff) sb_slopes(s, s->matrix, s->dfdt);
    for (int j = 0; j < SB_N; j++) {
        if (!w->loop->axis[j].controlled || (w->rate[j] == 0.0 && !sb_bristle[j])) continue;
        double low = 0.0, high = first, at_low = sb_relative(w, s->y, j), at_high;
        if (first == whole) at_high = sb_relative(w, done.y, j);
        else sb_try(s, first, y, f, margin), at_high = sb_relative(w, y, j);
        if (w->above[j] == (at_high > 0.0) || fabs(at_high) < 1e-14) continue;
        for (int i = 0; i < 100 && high - low > 1e-14 + 1e-15 * fabs(s->t); i++) {
            double at = i % 3 != 2 ? low + (high - low) * at_low / (at_low - at_high) : 0.5 * (low + high);
            if (!(at > low && at < high)) at = 0.5 * (low + high);
            sb_try(s, at, y, f, margin);
            const double value = sb_relative(w, y, j);
            if ((value > 0.0) == w->above[j]) low = at, at_low = value;
            else high = at, at_high = value;
        }
        first = high;
    }
    if (first >= whole) {
        *s = done;
        return;
    }
    sb_try(s, first, y, f, margin);
    sb_accept(s, s->t + first, y, f, margin);
}

/* Whether nothing moves relative to the references any more: to the last digits where the joints stick, and so little
 * where one slides that the rest of the way is linear. Under a dither that may be so for an instant alone. */
static int sb_is_quiet(sb_rounds *w) {
    sb_sim *s = w->s;
    double worst = 0.0, quiet = w->quiet;
    for (int j = 0; j < SB_N; j++) {
        if (!w->loop->axis[j].controlled) continue;
        worst = fmax(worst, fabs(s->y[SB_N + j] - w->rate[j]));
        if (s->mode[j] != 0.0 && !sb_bristle[j]) quiet = w->quiet_slide;
    }
    if (!(worst < quiet)) return 0;
    if (!s->fresh) sb_rhs(s, s->t, s->y, s->f, s->margin), s->fresh = 1;
    for (int i = SB_N; i < SB_NS; i++) worst = fmax(worst, fabs(s->f[i]));
    for (int j = 0; j < SB_N && s->ny == SB_NS + SB_NZ; j++) {
        const sb_axis *a = w->loop->axis + j;
        const double *f = s->f + SB_NS + SB_OWN * j;
        if (a->ki > 0.0) worst = fmax(worst, fabs(f[SB_INTEGRAL]));
        for (int i = SB_FILTER; i < (a->kind == SB_ADAPTIVE ? SB_OWN : SB_THETA); i++)
            if (i != SB_LAG || !sb_dithered(a)) worst = fmax(worst, fabs(f[i]));
    }
    return worst < quiet;
}

/* As sb_advance, looking for turns; stops short where there are enough of them. */
static int sb_advance_rounds(sb_rounds *w, double end) {
    sb_sim *s = w->s;
    const long steps = s->steps;
    while (s->status == SB_OK && s->t < end && w->seen < w->most && !w->still) {
        const sb_sim before = *s;
        if (!sb_step(s, end - s->t)) break;
        if (s->status == SB_OK) sb_refine(w, &before);
        if (end - s->t < 1e-14 * (1.0 + fabs(end))) s->t = end;
        sb_look(w);
        const int rests = s->status == SB_OK && s->control == sb_continuous && sb_is_quiet(w);
        if (!rests) w->moved = s->t;
        w->still = rests && s->t - w->moved >= w->calm;
        if (s->steps - steps > 3000000) s->status = SB_TOO_MANY_STEPS;
    }
    return s->status;
}

static void sb_keep(sb_rounds *w, double *record, long row) {
    double *out = record + row * 3 * SB_N;
    for (int j = 0; j < SB_N; j++) {
        out[j] = w->loop->axis[j].controlled ? sb_deviation(w, j) : w->s->y[j];
        out[SB_N + j] = w->s->y[SB_N + j];
        out[2 * SB_N + j] = w->s->mode[j];
    }
}

static int sb_rounds_continuous(sb_rounds *w, double end, double *record, double step, long rows) {
    sb_sim *s = w->s;
    const double begin = s->t;
    if (rows > 0) sb_keep(w, record, 0);
    for (long row = 1; row < rows; row++) {
        if (sb_advance_rounds(w, begin + row * step) != SB_OK) return s->status;
        sb_keep(w, record, row);
    }
    if (rows == 0) sb_advance_rounds(w, end);
    return s->status != SB_OK ? s->status : w->still ? SB_QUIET : w->seen >= w->most ? SB_ENOUGH : SB_END;
}

/* When an arm that sticks lets go of itself under the command that it is held by, as friction fades, where it does so
 * ahead; else the present. What slides is left to the samples. */
static double sb_lets_go(const sb_sim *now) {
    sb_sim ahead = *now;
    for (int j = 0; j < SB_N; j++)
        if (ahead.mode[j] != 0.0 && !sb_bristle[j]) return now->t;
    const double end = now->t + SB_AHEAD;
    const long steps = ahead.steps;
    ahead.defer = 1;
    while (ahead.status == SB_OK && ahead.t < end && !ahead.waiting && ahead.steps - steps < SB_FEW)
        if (!sb_step(&ahead, end - ahead.t)) break;
    return ahead.waiting ? ahead.t : now->t;
}

/* Whether a filter still has a sign of a joint that stands: its law will be another once it has not. */
static int sb_outlasts(const sb_sim *s, const sb_axis *a, const sb_memory *m, double sample, double rate, int j) {
    const int stands = rate == 0.0 && (s->mode[j] == 0.0 || sb_bristle[j]);
    return stands && a->filter > 0.0 && fabs(sb_filtered(m, sample)) > a->dead_band;
}

/* Samples first .. count - 1; rows before `first` of computed and command are the past. */
static int sb_rounds_sampled(sb_rounds *w, sb_loop *loop, sb_memory *memory, double *computed, long first,
                             double *record, long calm, long long *reached) {
    sb_sim *s = w->s;
    sb_memory before[SB_N];
    sb_hold hold;
    double next, lets_go = -HUGE_VAL;
    long still = 0;
    sb_hold_start(&hold, loop->times, loop->command, first > 0 ? first : 1, s->p, s->t);
    for (long k = first; k < loop->count; k++) {
        memcpy(before, memory, sizeof before);
        sb_sample(s, loop, memory, computed, k);
        hold.count = k + 1;
        sb_hold_at(&hold, s->t, s->u, &next);
        s->fresh = 0;
        sb_settle(s);
        if (record) sb_keep(w, record, k - first);
        double change = 0.0, quiet = w->quiet;
        for (int j = 0; k > 0 && j < SB_N; j++) {
            if (!loop->axis[j].controlled) continue;
            if (s->mode[j] != 0.0 && !sb_bristle[j]) quiet = w->quiet_slide;
            change = fmax(change, fabs(s->y[SB_N + j] - w->rate[j]));
            change = fmax(change, fabs(computed[k * SB_N + j] - computed[(k - 1) * SB_N + j]));
            if (sb_outlasts(s, loop->axis + j, memory + j, loop->sample, w->rate[j], j)) change = HUGE_VAL;
        }
        still = k > first && change < quiet ? still + 1 : 0;
        *reached = k;
        if (still > calm && s->t >= lets_go) lets_go = sb_lets_go(s);
        if (still > calm && s->t < lets_go) still = 0;
        if (still > calm) { /* who goes on from here takes this sample again */
            memcpy(memory, before, sizeof before);
            return SB_QUIET;
        }
        while (s->t < loop->times[k + 1]) {
            if (sb_advance_rounds(w, fmin(loop->times[k + 1], next)) != SB_OK) return s->status;
            if (w->seen >= w->most) w->most = HUGE_COUNT, loop->count = k + 1; /* on to the sample's end */
            if (s->t < loop->times[k + 1] && sb_hold_at(&hold, s->t, s->u, &next)) s->fresh = 0, sb_settle(s);
        }
        *reached = k + 1;
    }
    return w->most == HUGE_COUNT ? SB_ENOUGH : SB_END;
}

/* The place where a loop is: t, whether modes are to be found, y (SB_NY), modes, held directions and torques (SB_N each),
 * memories (7 SB_N), marks of the present rounds (5 SB_N). */
static void sb_enter(sb_sim *s, sb_memory *memory, const double *place) {
    s->t = *place, place += 2;
    memcpy(s->y, place, sizeof s->y), place += SB_NY;
    memcpy(s->mode, place, sizeof s->mode), place += SB_N;
    memcpy(s->held, place, sizeof s->held), place += SB_N;
    memcpy(s->u, place, sizeof s->u), place += SB_N;
    memcpy(memory, place, sizeof(sb_memory) * SB_N);
}

static void sb_leave(sb_sim *s, const sb_memory *memory, double *place) {
    double dz[SB_NZ];
    if (s->control == sb_continuous) sb_continuous(s, s->t, s->y, s->u, dz);
    *place++ = s->t, *place++ = 0.0;
    memcpy(place, s->y, sizeof s->y), place += SB_NY;
    memcpy(place, s->mode, sizeof s->mode), place += SB_N;
    memcpy(place, s->held, sizeof s->held), place += SB_N;
    memcpy(place, s->u, sizeof s->u), place += SB_N;
    memcpy(place, memory, sizeof(sb_memory) * SB_N);
}

/* What a call is asked for, mirrored in wish.py. */
#define SB_WISH(X)                                                                                           \
    X(double rtol) X(double atol) X(double bound) X(double quiet) X(double quiet_slide) X(double sample)     \
    X(double end) X(double record_step) X(long long watch) X(long long most) X(long long first)              \
    X(long long count) X(long long rows) X(long long size) X(long long calm)
typedef struct {
    SB_WISH(SB_FIELD)
} sb_wish;

SB_TELL_STRUCTURE(sb_turn, SB_A_TURN)
SB_TELL_STRUCTURE(sb_wish, SB_WISH)

/* Exported. Runs a loop from a place to its next turns; gives why it stopped. out: turns found, sample reached, steps. */
SB_EXPORT int sb_run_rounds(const sb_wish *wish, const double *p, const sb_axis *axis, double *place, const double *times,
                            const double *noise, double *command, double *computed, double *seen, sb_turn *turns,
                            double *record, long long *out) {
    sb_sim s;
    sb_loop loop;
    sb_memory memory[SB_N];
    sb_rounds w;
    double *marks = place + 2 + SB_NY + 10 * SB_N;
    const int unsettled = place[1] != 0.0;
    int lagged = 0, why;
    sb_init(&s, p, 1e-8);
    s.rtol = wish->rtol, s.atol = wish->atol, s.bound = wish->bound, s.h = 1e-4;
    memset(&loop, 0, sizeof loop), memset(&w, 0, sizeof w);
    loop.axis = axis, loop.sample = wish->sample, loop.count = wish->count, loop.times = times, loop.noise = noise;
    loop.command = command, loop.seen = seen;
    s.loop = &loop;
    sb_enter(&s, memory, place);
    for (int j = 0; j < SB_N; j++) s.clamped[j] = !axis[j].controlled, lagged |= axis[j].controlled && axis[j].lag > 0.0;
    w.watch = (int)wish->watch, w.quiet = wish->quiet, w.quiet_slide = wish->quiet_slide, w.turns = turns, w.size = wish->size, w.most = wish->most;
    out[1] = 0;
    if (!sb_finite(s.y, SB_NS)) return SB_NOT_FINITE;
    if (wish->sample > 0.0) {
        if (lagged) s.control = sb_sampled_lag, s.ny = SB_NS + SB_N;
        sb_rounds_start(&w, &s, &loop, marks);
        why = sb_rounds_sampled(&w, &loop, memory, computed, (long)wish->first, record, (long)wish->calm, out + 1);
    } else {
        s.control = sb_continuous, s.remember = sb_hold_signs, s.ny = SB_NS + SB_NZ;
        sb_bound_steps(&s, axis);
        if (unsettled) sb_settle(&s);
        sb_rounds_start(&w, &s, &loop, marks);
        sb_look(&w);
        why = sb_rounds_continuous(&w, wish->end, record, wish->record_step, (long)wish->rows);
    }
    sb_leave(&s, memory, place);
    sb_rounds_stop(&w, marks);
    out[0] = w.count, out[2] = s.steps;
    return why;
}

/* Exported. The rate of change (SB_NY) of a continuous loop at a place and its slopes (SB_NY, SB_NY), in its modes. */
SB_EXPORT void sb_place_slopes(const double *p, const sb_axis *axis, const double *place, double *rate, double *matrix) {
    sb_sim s;
    sb_loop loop;
    sb_memory memory[SB_N];
    double moved[SB_NY], up[SB_NY], down[SB_NY];
    sb_init(&s, p, 1e-8);
    memset(&loop, 0, sizeof loop);
    loop.axis = axis, s.loop = &loop;
    sb_enter(&s, memory, place);
    for (int j = 0; j < SB_N; j++) s.clamped[j] = !axis[j].controlled;
    s.control = sb_continuous, s.ny = SB_NS + SB_NZ;
    sb_rhs(&s, s.t, s.y, rate, s.margin);
    for (int c = 0; c < SB_NY; c++) {
        const int own = c >= SB_NS && (c - SB_NS) % SB_OWN == SB_FILTER;
        double step = 1e-6 * fmax(1.0, fabs(s.y[c]));
        memcpy(moved, s.y, sizeof moved);
        if (own && fabs(s.y[c]) < step) { /* a law sees its sign: away from zero, on one side */
            if (s.y[c] < 0.0) step = -step;
            moved[c] = s.y[c] + step, sb_rhs(&s, s.t, moved, up, s.margin);
            moved[c] = s.y[c] + 2 * step, sb_rhs(&s, s.t, moved, down, s.margin);
            for (int r = 0; r < SB_NY; r++) matrix[r * SB_NY + c] = (4 * up[r] - down[r] - 3 * rate[r]) / (2 * step);
            continue;
        }
        moved[c] = s.y[c] + step, sb_rhs(&s, s.t, moved, up, s.margin);
        moved[c] = s.y[c] - step, sb_rhs(&s, s.t, moved, down, s.margin);
        for (int r = 0; r < SB_NY; r++) matrix[r * SB_NY + c] = (up[r] - down[r]) / (2 * step);
    }
}
