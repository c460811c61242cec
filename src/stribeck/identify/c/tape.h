/* A straight-line program over many samples at once: one operation at a time, each over a short row of samples, so that
 * the compiler turns every operation into vector instructions and nothing is compiled per model. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define LANES 64 /* samples a row: the working values of a model stay in the first-level cache */
#define FEW 4    /* lanes of a recursion over a few runs: one wide register */

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

/* What Python mirrors is written as a list, which a function at the end tells. */
#define FIELD(declaration) declaration;
#define CONSTANT(name) name,
#define QUOTE(text) #text ";"

/* As KINDS in operations.py; the last three: x y + z, x y - z, z - x y. */
#define KINDS(X)                                                                                                  \
    X(LOAD) X(CONST) X(STORE) X(ADD) X(SUB) X(MUL) X(DIV) X(NEG) X(INV) X(SQ) X(TWICE) X(SQRT) X(EXP) X(LOG)      \
    X(POW) X(SIN) X(COS) X(TAN) X(ASIN) X(ACOS) X(ATAN) X(SINH) X(COSH) X(TANH) X(ASINH) X(ACOSH) X(ATANH)        \
    X(EXPM1) X(LOG1P) X(ERF) X(ATAN2) X(HYPOT) X(FLOOR) X(CEIL) X(FMOD) X(FABS) X(SIGN) X(COPYSIGN) X(LT) X(LE)   \
    X(EQ) X(NE) X(NOT) X(AND) X(OR) X(FMIN) X(FMAX) X(IF_ELSE_ZERO) X(ASSIGN) X(MUL_ADD) X(MUL_SUB) X(SUB_MUL)
enum { KINDS(CONSTANT) };

/* One argument: element i of sample s stands at base[i * row + (s % period) * column]; without a period, at
 * base[i * row + s * column]. As Argument in program.py. */
#define ARGUMENT(X) X(const double *base) X(long long row) X(long long column) X(long long period)
typedef struct {
    ARGUMENT(FIELD)
} argument;

#define FAR 1e5                  /* rad, from where on sines are the library's */
#define ROUND 6755399441055744.0 /* 1.5 2^52: added to a number, it leaves no room behind the point */

/* The sine of x, or its cosine, without a branch, so that it is computed of several x at once: within 0.8 units in the
 * last place up to FAR. x less whole quarters of a turn (Cody & Waite 1980), of three parts of which the first two have
 * 33 bits; then the polynomials of Sun's fdlibm (k_sin.c, k_cos.c). */
INLINE double turned(double x, int cosine) {
    const double shifted = x * 6.36619772367581382433e-01 + ROUND, quarters = shifted - ROUND;
    const double first = x - quarters * 1.57079632673412561417e+00, second = quarters * 6.07710050630396597660e-11;
    const double whole = first - second, rest = ((first - whole) - second) - quarters * 2.02226624879595063154e-21;
    const double y = whole + rest, left = (whole - y) + rest, z = y * y, half = 0.5 * z, less = 1.0 - half;
    const double s5 = -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10;
    const double s3 = -1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * s5);
    const double s1 = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * s3);
    const double c5 = 2.08757232129817482790e-09 + z * -1.13596475577881948265e-11;
    const double c3 = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * c5);
    const double c1 = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * c3);
    const double sine = y + (y * z * s1 + left * less);
    const double other = less + (((1.0 - less) - half) + (z * z * c1 - y * left));
    uint64_t quadrant, one, two, odd;
    double out;
    memcpy(&quadrant, &shifted, sizeof quadrant);
    memcpy(&one, &sine, sizeof one);
    memcpy(&two, &other, sizeof two);
    quadrant += (uint64_t)cosine;
    odd = 0 - (quadrant & 1);
    one = ((one & ~odd) | (two & odd)) ^ ((quadrant & 2) << 62);
    memcpy(&out, &one, sizeof out);
    return out;
}

/* Whether numbers are near enough for that. */
INLINE int near(const double *x, int count) {
    int far = 0;
    for (int l = 0; l < count; l++) far |= !(fabs(x[l]) <= FAR);
    return !far;
}

/* All operations of kind F that follow one another; G where a and b are not NEAR. FEW results at a time, all of them
 * before the first is stored: the compiler need not fear that they overlap. A row is as long as its stride: what n is
 * rounded up to has room there. */
#define EACH_NEAR(NEAR, F, G)                                                                                          \
    do {                                                                                                               \
        double *o = work + (long long)c[1] * stride;                                                                   \
        const double *a = work + (long long)c[2] * stride, *b = work + (long long)c[3] * stride;                       \
        const double *d = work + (long long)c[4] * stride;                                                             \
        const int count = n == 1 ? 1 : FEW;                                                                            \
        (void)b, (void)d, (void)count;                                                                                 \
        if (n == 1) {                                                                                                  \
            const int l = 0, few = 0;                                                                                  \
            (void)few;                                                                                                 \
            o[0] = (NEAR) ? (F) : (G);                                                                                 \
        } else                                                                                                         \
            for (int few = 0; few < n; few += FEW) {                                                                   \
                double results[FEW];                                                                                   \
                if (NEAR)                                                                                              \
                    for (int l = few; l < few + FEW; l++) results[l - few] = (F);                                      \
                else                                                                                                   \
                    for (int l = few; l < few + FEW; l++) results[l - few] = (G);                                      \
                for (int l = few; l < few + FEW; l++) o[l] = results[l - few];                                         \
            }                                                                                                          \
        c += 5;                                                                                                        \
    } while (c < end && *c == kind);                                                                                   \
    break
#define EACH(F) EACH_NEAR(1, F, F)
#define X a[l]
#define Y b[l]
#define Z d[l]

/* Run the program over n samples from sample s on, the working values `stride` apart; `code` has five numbers an
 * operation: kind, target, operands. */
INLINE void row(const int *code, long long length, const double *constants, const argument *in, double *out,
                long long out_row, long long s, int n, int stride, double *work) {
    const int *c = code, *const end = code + 5 * length;
    while (c < end) {
        const int kind = *c;
        switch (kind) {
        case LOAD: {
            const argument *x = in + c[2];
            const double *from = x->base + c[3] * x->row + s * x->column;
            double *o = work + (long long)c[1] * stride;
            if (x->period)
                for (int l = 0, k = 0; l < n; l++, k = k + 1 < x->period ? k + 1 : 0) o[l] = from[k * x->column];
            else if (x->column == 1)
                for (int l = 0; l < n; l++) o[l] = from[l];
            else
                for (int l = 0; l < n; l++) o[l] = from[l * x->column];
            c += 5;
            break;
        }
        case CONST: {
            double *o = work + (long long)c[1] * stride;
            for (int l = 0; l < n; l++) o[l] = constants[c[2]];
            c += 5;
            break;
        }
        case STORE: {
            double *to = out + c[1] * out_row + s;
            const double *a = work + (long long)c[2] * stride;
            for (int l = 0; l < n; l++) to[l] = a[l];
            c += 5;
            break;
        }
        case ADD: EACH(X + Y);
        case SUB: EACH(X - Y);
        case MUL: EACH(X * Y);
        case DIV: EACH(X / Y);
        case NEG: EACH(-X);
        case INV: EACH(1.0 / X);
        case SQ: EACH(X * X);
        case TWICE: EACH(2.0 * X);
        case SQRT: EACH(sqrt(X));
        case EXP: EACH(exp(X));
        case LOG: EACH(log(X));
        case POW: EACH(pow(X, Y));
        case SIN: EACH_NEAR(near(a + few, count), turned(X, 0), sin(X));
        case COS: EACH_NEAR(near(a + few, count), turned(X, 1), cos(X));
        case TAN: EACH(tan(X));
        case ASIN: EACH(asin(X));
        case ACOS: EACH(acos(X));
        case ATAN: EACH(atan(X));
        case SINH: EACH(sinh(X));
        case COSH: EACH(cosh(X));
        case TANH: EACH(tanh(X));
        case ASINH: EACH(asinh(X));
        case ACOSH: EACH(acosh(X));
        case ATANH: EACH(atanh(X));
        case EXPM1: EACH(expm1(X));
        case LOG1P: EACH(log1p(X));
        case ERF: EACH(erf(X));
        case ATAN2: EACH(atan2(X, Y));
        case HYPOT: EACH(hypot(X, Y));
        case FLOOR: EACH(floor(X));
        case CEIL: EACH(ceil(X));
        case FMOD: EACH(fmod(X, Y));
        case FABS: EACH(fabs(X));
        case SIGN: EACH(X < 0.0 ? -1.0 : X > 0.0 ? 1.0 : X);
        case COPYSIGN: EACH(copysign(X, Y));
        case LT: EACH(X < Y ? 1.0 : 0.0);
        case LE: EACH(X <= Y ? 1.0 : 0.0);
        case EQ: EACH(X == Y ? 1.0 : 0.0);
        case NE: EACH(X != Y ? 1.0 : 0.0);
        case NOT: EACH(X == 0.0 ? 1.0 : 0.0);
        case AND: EACH(X != 0.0 && Y != 0.0 ? 1.0 : 0.0);
        case OR: EACH(X != 0.0 || Y != 0.0 ? 1.0 : 0.0);
        case FMIN: EACH(X < Y || Y != Y ? X : Y);
        case FMAX: EACH(X > Y || Y != Y ? X : Y);
        case IF_ELSE_ZERO: EACH(X != 0.0 ? Y : 0.0);
        case ASSIGN: EACH(X);
        case MUL_ADD: EACH(X * Y + Z);
        case MUL_SUB: EACH(X * Y - Z);
        case SUB_MUL: EACH(Z - X * Y);
        default: return; /* no such operation */
        }
    }
}

/* Samples that do not depend on each other. */
WIDE TAPE_EXPORT void tape_map(const int *code, long long length, const double *constants, const argument *in,
                               double *out, long long samples, double *work) {
    for (long long s = 0; s < samples; s += LANES)
        row(code, length, constants, in, out, samples, s, samples - s < LANES ? (int)(samples - s) : LANES, LANES, work);
}

/* A recursion of `width` states over `steps` steps, `runs` (FEW, or at most LANES) side by side. in[0] are the states,
 * in[told] what each step is told, `pitch` numbers a step; out (steps + 1, width, runs) starts with the start. */
WIDE TAPE_EXPORT void tape_march(const int *code, long long length, const double *constants, argument *in, double *out,
                                 long long steps, long long width, long long told, long long pitch, long long runs,
                                 double *work) {
    const double *first = in[told].base;
    for (long long t = 0; t < steps; t++) {
        double *after = out + (t + 1) * width * runs;
        in[0].base = out + t * width * runs;
        in[0].row = runs;
        in[0].column = 1;
        in[told].base = first + t * pitch;
        if (runs == FEW)
            row(code, length, constants, in, after, FEW, 0, FEW, FEW, work);
        else
            row(code, length, constants, in, after, runs, 0, (int)runs, (int)runs, work);
    }
}

/* Exported. How the structure and the names above are laid out: mirrored.py compares them with those of Python. */
TAPE_EXPORT const char *argument_fields(void) { return ARGUMENT(QUOTE); }
TAPE_EXPORT long long argument_size(void) { return (long long)sizeof(argument); }
TAPE_EXPORT const char *kinds_names(void) { return KINDS(QUOTE); }
