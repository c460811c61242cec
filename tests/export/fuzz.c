/* Calls of an FMU in any order with any values, compiled together with its sources under the sanitizers.
 * FMI_VERSION is 2 or 3; arguments: runs, seed. Prints how many calls were accepted and refused. */
#if FMI_VERSION == 2
#include "fmi2.c"
#define CALL(name2, name3, ...) count(fmi2##name2(c, __VA_ARGS__))
#define MORE(n)
typedef fmi2ValueReference reference;
#else
#include "fmi3.c"
#define CALL(name2, name3, ...) count(fmi3##name3(c, __VA_ARGS__))
#define MORE(n) , n
typedef fmi3ValueReference reference;
#endif

#ifdef CT_N /* a controller */
enum { REFERENCES = CT_END, PARAMETER = CT_P, PARAMETERS = CT_N * CT_NUMBERS, INPUT = CT_Q, INPUTS = 2 * CT_N };
#else
enum { REFERENCES = FM_END, PARAMETER = FM_P, PARAMETERS = SB_NP, INPUT = FM_TAU, INPUTS = SB_N };
#endif

static uint64_t seed;
static long accepted, refused, lines;

static uint64_t next(void) {
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return seed;
}
static double unit(void) { return (double)(next() >> 11) / 9007199254740992.0; }
static int chance(double p) { return unit() < p; }
static void count(int status) { status == 0 ? accepted++ : refused++; }

static double wild(void) {
    switch (next() % 9) {
    case 0: return NAN;
    case 1: return unit() < 0.5 ? HUGE_VAL : -HUGE_VAL;
    case 2: return 1e308 * (unit() - 0.5);
    case 3: return 0.0;
    default: return 40.0 * (unit() - 0.5);
    }
}

#if FMI_VERSION == 2
static void say(void *e, fmi2String name, fmi2Status status, fmi2String category, fmi2String format, ...) {
    (void)e, (void)name, (void)status, (void)category, (void)format;
    lines++;
}
#else
static void say(void *e, fmi3Status status, fmi3String category, fmi3String text) {
    (void)e, (void)status, (void)category, (void)text;
    lines++;
}
#endif

static void *make(int exchange) {
#if FMI_VERSION == 2
    static const fmi2CallbackFunctions functions = {say, calloc, free, NULL, NULL};
    return fmi2Instantiate("it", exchange ? fmi2ModelExchange : fmi2CoSimulation, FM_TOKEN, "", &functions, 0, 1);
#else
    if (exchange) return fmi3InstantiateModelExchange("it", FM_TOKEN, "", 0, 1, NULL, say);
    return fmi3InstantiateCoSimulation("it", FM_TOKEN, "", 0, 1, chance(0.5), chance(0.5), NULL, 0, NULL, say, NULL);
#endif
}

static void start(void *c, double time) {
#if FMI_VERSION == 2
    count(fmi2SetupExperiment(c, 1, 1e-6, time, 0, 0.0));
    count(fmi2EnterInitializationMode(c));
#else
    count(fmi3EnterInitializationMode(c, 1, 1e-6, time, 0, 0.0));
#endif
}

static void update(void *c) {
#if FMI_VERSION == 2
    fmi2EventInfo info;
    count(fmi2NewDiscreteStates(c, &info));
#else
    bool flags[5];
    double when;
    count(fmi3UpdateDiscreteStates(c, flags, flags + 1, flags + 2, flags + 3, flags + 4, &when));
#endif
}

static void step(void *c, double t, double h) {
#if FMI_VERSION == 2
    count(fmi2DoStep(c, t, h, 1));
#else
    bool flags[3];
    double when;
    count(fmi3DoStep(c, t, h, 1, flags, flags + 1, flags + 2, &when));
#endif
}

static void blob(void *c) {
    void *state = NULL, *copy = NULL;
    CALL(GetFMUstate, GetFMUState, &state);
    const size_t size = fm_blob_size();
    unsigned char *bytes = malloc(size + 8);
    CALL(SerializeFMUstate, SerializeFMUState, state, (void *)bytes, size);
    size_t given = size;
    if (chance(0.3)) given = next() % (size + 8);
    for (uint64_t i = chance(0.5) ? next() % 5 : 0; i > 0; i--) bytes[next() % size] ^= (unsigned char)next();
    if (chance(0.5)) { /* a forger knows the sum */
        fm_header header = fm_header_of(bytes + sizeof header);
        memcpy(bytes, &header, sizeof header);
    }
    unsigned char *exact = malloc(given + 1); /* so that reading past what is given is seen */
    memcpy(exact, bytes, given < size ? given : size);
    CALL(DeSerializeFMUstate, DeserializeFMUState, (void *)exact, given, &copy);
    if (copy) CALL(SetFMUstate, SetFMUState, copy);
    else CALL(SetFMUstate, SetFMUState, state);
    CALL(FreeFMUstate, FreeFMUState, &copy);
    CALL(FreeFMUstate, FreeFMUState, &state);
    free(bytes), free(exact);
}

static void some_call(void *c, double *t) {
    reference vr[4];
    double values[4], x[FM_STATES + 1], out[FM_STATES + 8];
    int32_t numbers[4];
    const size_t n = next() % 5;
    for (int i = 0; i < 4; i++) vr[i] = (reference)(chance(0.05) ? next() : next() % REFERENCES), values[i] = wild();
    for (int i = 0; i <= FM_STATES; i++) x[i] = chance(0.05) ? wild() : 2.0 * unit() - 1.0;
    switch (next() % 20) {
    case 0: CALL(SetReal, SetFloat64, vr, n, values MORE(n)); break;
    case 1: CALL(GetReal, GetFloat64, vr, n, values MORE(n)); break;
    case 2: CALL(GetInteger, GetInt32, vr, n, numbers MORE(n)); break;
    case 3: start(c, chance(0.1) ? wild() : *t); break;
#if FMI_VERSION == 2
    case 4: count(fmi2ExitInitializationMode(c)); break;
    case 5: count(fmi2EnterEventMode(c)); break;
    case 6: count(fmi2EnterContinuousTimeMode(c)); break;
    case 7: if (chance(0.05)) count(fmi2Terminate(c)); break;
    case 8: if (chance(0.05)) count(fmi2Reset(c)), *t = 0.0; break;
    case 9: count(fmi2GetDerivatives(c, out, chance(0.9) ? FM_STATES : n)); break;
#else
    case 4: count(fmi3ExitInitializationMode(c)); break;
    case 5: count(fmi3EnterEventMode(c)); break;
    case 6: count(chance(0.5) ? fmi3EnterContinuousTimeMode(c) : fmi3EnterStepMode(c)); break;
    case 7: if (chance(0.05)) count(fmi3Terminate(c)); break;
    case 8: if (chance(0.05)) count(fmi3Reset(c)), *t = 0.0; break;
    case 9: count(fmi3GetContinuousStateDerivatives(c, out, chance(0.9) ? FM_STATES : n)); break;
#endif
    case 10: update(c); break;
    case 11: CALL(SetTime, SetTime, chance(0.1) ? wild() : *t); break;
    case 12: CALL(SetContinuousStates, SetContinuousStates, x, chance(0.9) ? FM_STATES : n); break;
    case 13: CALL(GetEventIndicators, GetEventIndicators, out, chance(0.9) ? FM_INDICATORS : n); break;
    case 14: CALL(GetContinuousStates, GetContinuousStates, out, chance(0.9) ? FM_STATES : n); break;
    case 15: blob(c); break;
    case 16: {
        const size_t m = next() % 5;
        CALL(GetDirectionalDerivative, GetDirectionalDerivative, vr, m, vr, n, x MORE(n), out MORE(m));
#if FMI_VERSION == 3
        count(fmi3GetAdjointDerivative(c, vr, m, vr, n, x, m, out, n));
#endif
        break;
    }
    case 17: CALL(GetReal, GetFloat64, NULL, n, values MORE(n)); break;
    default: {
        const double at = fm_now(&((fm_instance *)c)->core), h = chance(0.05) ? wild() : 0.02 * unit();
        step(c, chance(0.05) ? wild() : at, h);
        *t = fm_now(&((fm_instance *)c)->core);
    }
    }
}

/* A whole simulation with random parameters and torques, as an importer makes it. */
static void simulation(void) {
    void *c = make(0);
    for (int i = 0; i < PARAMETERS; i++) {
        const reference vr = PARAMETER + i;
        double value;
        CALL(GetReal, GetFloat64, &vr, 1, &value MORE(1));
        value *= exp(2.0 * unit() - 1.0);
        CALL(SetReal, SetFloat64, &vr, 1, &value MORE(1));
    }
    start(c, 0.0);
#if FMI_VERSION == 2
    count(fmi2ExitInitializationMode(c));
#else
    count(fmi3ExitInitializationMode(c));
    if (((fm_instance *)c)->core.stands == FM_EVENT) update(c), count(fmi3EnterStepMode(c));
#endif
    for (int k = 0; k < 25; k++) {
        for (int j = 0; j < INPUTS; j++) {
            const reference vr = INPUT + j;
            const double value = 60.0 * (unit() - 0.5);
            CALL(SetReal, SetFloat64, &vr, 1, &value MORE(1));
        }
        step(c, fm_now(&((fm_instance *)c)->core), 0.04 * unit());
#if FMI_VERSION == 3
        if (fm_waits(&((fm_instance *)c)->core))
            count(fmi3EnterEventMode(c)), update(c), count(fmi3EnterStepMode(c));
#endif
    }
    if (chance(0.1)) blob(c);
#if FMI_VERSION == 2
    fmi2FreeInstance(c);
#else
    fmi3FreeInstance(c);
#endif
}

int main(int count_given, char **given) {
    const long runs = count_given > 1 ? atol(given[1]) : 100;
    seed = 88172645463325252u + (count_given > 2 ? (uint64_t)atol(given[2]) : 0u);
    for (long run = 0; run < runs; run++) {
        simulation();
        void *c = make(chance(0.5));
        double t = 0.0;
        if (!c) continue; /* a delay forbids exchange, as does a controller */
        for (uint64_t k = next() % 60; k > 0; k--) some_call(c, &t);
#if FMI_VERSION == 2
        fmi2FreeInstance(c);
#else
        fmi3FreeInstance(c);
#endif
    }
    printf("%ld accepted, %ld refused, %ld lines\n", accepted, refused, lines);
    return 0;
}
