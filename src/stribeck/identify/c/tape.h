/* A straight-line program over many samples at once: one operation at a time, each over a short row of samples, so that
 * the compiler turns every operation into vector instructions and nothing is compiled per model. */
#include <math.h>
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

/* The same order as OPERATIONS in operations.py, and then FUSED. */
enum {
    LOAD, CONST, STORE, ADD, SUB, MUL, DIV, NEG, INV, SQ, TWICE, SQRT, EXP, LOG, POW, SIN, COS, TAN, ASIN, ACOS, ATAN,
    SINH, COSH, TANH, ASINH, ACOSH, ATANH, EXPM1, LOG1P, ERF, ATAN2, HYPOT, FLOOR, CEIL, FMOD, FABS, SIGN, COPYSIGN,
    LT, LE, EQ, NE, NOT, AND, OR, FMIN, FMAX, CHOOSE, COPY,
    MUL_ADD, MUL_SUB, SUB_MUL /* x y + z, x y - z, z - x y */
};

/* One argument: element i of sample s stands at base[i * row + s * column]. */
typedef struct {
    const double *base;
    long long row, column;
} argument;

#define ONE(F) for (l = 0; l < n; l++) { const double x = a[l]; o[l] = (F); } break
#define TWO(F) for (l = 0; l < n; l++) { const double x = a[l], y = b[l]; o[l] = (F); } break
#define THREE(F) for (l = 0; l < n; l++) { const double x = a[l], y = b[l], z = d[l]; o[l] = (F); } break

/* Run the program over n samples from sample s on, the working values `stride` apart; `code` has five numbers an
 * operation: kind, target, operands. */
INLINE void row(const int *code, long long length, const double *constants, const argument *in, double *out,
                long long out_row, long long s, int n, int stride, double *work) {
    int l;
    for (long long k = 0; k < length; k++) {
        const int *c = code + 5 * k;
        double *o = work + (long long)c[1] * stride;
        const double *a = work + (long long)c[2] * stride, *b = work + (long long)c[3] * stride;
        const double *d = work + (long long)c[4] * stride;
        switch (c[0]) {
        case LOAD: {
            const argument *x = in + c[2];
            const double *from = x->base + c[3] * x->row + s * x->column;
            if (x->column == 1)
                for (l = 0; l < n; l++) o[l] = from[l];
            else
                for (l = 0; l < n; l++) o[l] = from[l * x->column];
            break;
        }
        case CONST: { const double v = constants[c[2]]; for (l = 0; l < n; l++) o[l] = v; break; }
        case STORE: { double *to = out + c[1] * out_row + s; for (l = 0; l < n; l++) to[l] = a[l]; break; }
        case ADD: TWO(x + y);
        case SUB: TWO(x - y);
        case MUL: TWO(x * y);
        case DIV: TWO(x / y);
        case NEG: ONE(-x);
        case INV: ONE(1.0 / x);
        case SQ: ONE(x * x);
        case TWICE: ONE(2.0 * x);
        case SQRT: ONE(sqrt(x));
        case EXP: ONE(exp(x));
        case LOG: ONE(log(x));
        case POW: TWO(pow(x, y));
        case SIN: ONE(sin(x));
        case COS: ONE(cos(x));
        case TAN: ONE(tan(x));
        case ASIN: ONE(asin(x));
        case ACOS: ONE(acos(x));
        case ATAN: ONE(atan(x));
        case SINH: ONE(sinh(x));
        case COSH: ONE(cosh(x));
        case TANH: ONE(tanh(x));
        case ASINH: ONE(asinh(x));
        case ACOSH: ONE(acosh(x));
        case ATANH: ONE(atanh(x));
        case EXPM1: ONE(expm1(x));
        case LOG1P: ONE(log1p(x));
        case ERF: ONE(erf(x));
        case ATAN2: TWO(atan2(x, y));
        case HYPOT: TWO(hypot(x, y));
        case FLOOR: ONE(floor(x));
        case CEIL: ONE(ceil(x));
        case FMOD: TWO(fmod(x, y));
        case FABS: ONE(fabs(x));
        case SIGN: ONE(x < 0.0 ? -1.0 : x > 0.0 ? 1.0 : x);
        case COPYSIGN: TWO(copysign(x, y));
        case LT: TWO(x < y ? 1.0 : 0.0);
        case LE: TWO(x <= y ? 1.0 : 0.0);
        case EQ: TWO(x == y ? 1.0 : 0.0);
        case NE: TWO(x != y ? 1.0 : 0.0);
        case NOT: ONE(x == 0.0 ? 1.0 : 0.0);
        case AND: TWO(x != 0.0 && y != 0.0 ? 1.0 : 0.0);
        case OR: TWO(x != 0.0 || y != 0.0 ? 1.0 : 0.0);
        case FMIN: TWO(x < y || y != y ? x : y);
        case FMAX: TWO(x > y || y != y ? x : y);
        case CHOOSE: TWO(x != 0.0 ? y : 0.0);
        case COPY: ONE(x);
        case MUL_ADD: THREE(x * y + z);
        case MUL_SUB: THREE(x * y - z);
        case SUB_MUL: THREE(z - x * y);
        }
    }
}

/* Samples that do not depend on each other. */
WIDE TAPE_EXPORT void tape_map(const int *code, long long length, const double *constants, const argument *in,
                               double *out, long long samples, double *work) {
    long long s = 0;
    for (; s + LANES <= samples; s += LANES)
        row(code, length, constants, in, out, samples, s, LANES, LANES, work);
    if (s < samples) row(code, length, constants, in, out, samples, s, (int)(samples - s), LANES, work);
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
