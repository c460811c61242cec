/* Drive an arm's FMI 2.0 binary from C, on Linux or Windows:
 *
 *   harness LIBRARY GUID input.csv output.csv JOINTS tau-references... q-references...
 *
 * The value references stand in modelDescription.xml. Torques of each row of input.csv (t, tau1, ...) are held to the
 * next; output.csv gets t, q1, ... with 17 digits.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(file) LoadLibraryA(file)
#define FIND(library, name) ((void *)GetProcAddress(library, name))
typedef HMODULE handle;
#else
#include <dlfcn.h>
#define OPEN(file) dlopen(file, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
typedef void *handle;
#endif

enum { MOST = 16 };

#define NEED(name)                                                                                                     \
    name##TYPE *name##_ = (name##TYPE *)FIND(library, #name);                                                         \
    if (!name##_) return fprintf(stderr, "no function %s\n", #name), 1
#define MUST(call)                                                                                                     \
    if ((call) != fmi2OK) return fprintf(stderr, "failed: %s\n", #call), 1

static void say(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                fmi2String text, ...) {
    (void)environment;
    fprintf(stderr, "%s [%s] %d: %s\n", name, category, (int)status, text);
}

int main(int count, char **argument) {
    const int n = count > 5 ? atoi(argument[5]) : 0;
    if (n < 1 || n > MOST || count != 6 + 2 * n) return fprintf(stderr, "see the head of harness.c\n"), 2;
    fmi2ValueReference tau[MOST], q[MOST];
    for (int k = 0; k < n; k++) tau[k] = (unsigned)atoi(argument[6 + k]), q[k] = (unsigned)atoi(argument[6 + n + k]);

    handle library = OPEN(argument[1]);
    if (!library) return fprintf(stderr, "cannot load %s\n", argument[1]), 1;
    NEED(fmi2Instantiate);
    NEED(fmi2SetupExperiment);
    NEED(fmi2EnterInitializationMode);
    NEED(fmi2ExitInitializationMode);
    NEED(fmi2SetReal);
    NEED(fmi2GetReal);
    NEED(fmi2DoStep);
    NEED(fmi2Terminate);
    NEED(fmi2FreeInstance);

    const fmi2CallbackFunctions functions = {say, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate_("arm", fmi2CoSimulation, argument[2], "", &functions, fmi2False, fmi2False);
    if (!c) return fprintf(stderr, "no instance\n"), 1;
    MUST(fmi2SetupExperiment_(c, fmi2True, 1e-8, 0.0, fmi2False, 0.0));
    MUST(fmi2EnterInitializationMode_(c));
    MUST(fmi2ExitInitializationMode_(c));

    FILE *in = fopen(argument[3], "r"), *out = fopen(argument[4], "w");
    char line[4096];
    if (!in || !out || !fgets(line, sizeof line, in)) return fprintf(stderr, "cannot open the files\n"), 1;
    fprintf(out, "t");
    for (int k = 0; k < n; k++) fprintf(out, ",q%d", k + 1);
    fprintf(out, "\n");
    double held[MOST], before = 0.0;
    for (int row = 0; fgets(line, sizeof line, in); row++) {
        char *at = line;
        double value[MOST], t = strtod(at, &at);
        if (row > 0) {
            MUST(fmi2SetReal_(c, tau, (size_t)n, held));
            MUST(fmi2DoStep_(c, before, t - before, fmi2True));
        }
        MUST(fmi2GetReal_(c, q, (size_t)n, value));
        fprintf(out, "%.17g", t);
        for (int k = 0; k < n; k++) fprintf(out, ",%.17g", value[k]), held[k] = strtod(at + 1, &at);
        fprintf(out, "\n");
        before = t;
    }
    fclose(in), fclose(out);
    MUST(fmi2Terminate_(c));
    fmi2FreeInstance_(c);
    return 0;
}
