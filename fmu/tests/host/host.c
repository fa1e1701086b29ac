/* A plain C importer for tests: loads a library, runs FMI 3.0 and FMI 2.0 instances, frees all,
 * as often as asked. Runs natively (also under Valgrind) and, cross-built, under wine.
 *
 * usage: host <library> <token> <cycles> <steps> <value reference to print> [<KiB>]
 *
 * With a last number the process must grow by less than that per cycle, from the tenth on.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <stdarg.h>

#ifdef _WIN32
#include <windows.h>
#include <psapi.h>
static void *open_library(const char *p) { return (void *)LoadLibraryA(p); }
static void *symbol(void *l, const char *n) { return (void *)GetProcAddress((HMODULE)l, n); }
static void close_library(void *l) { FreeLibrary((HMODULE)l); }
static double used_kib(void) {
    PROCESS_MEMORY_COUNTERS counters;
    if (!GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters)) return 0;
    return (double)counters.PagefileUsage / 1024;
}
#else
#include <dlfcn.h>
static void *open_library(const char *p) { return dlopen(p, RTLD_NOW | RTLD_LOCAL); }
static void *symbol(void *l, const char *n) { return dlsym(l, n); }
static void close_library(void *l) { dlclose(l); }
static double used_kib(void) {
    long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file) return 0;
    if (fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
    fclose(file);
    return (double)resident * 4;
}
#endif

#define PERIOD 0.1

typedef void (*log3)(void *, int, const char *, const char *);
typedef void (*log2)(void *, const char *, int, const char *, const char *, ...);

static void on_log3(void *env, int status, const char *category, const char *message) {
    if (status > 1) fprintf(stderr, "[%d %s] %s\n", status, category, message);
}

static void on_log2(void *env, const char *name, int status, const char *category,
                    const char *format, ...) {
    va_list rest;
    va_start(rest, format);
    if (status > 1) {
        fprintf(stderr, "[%s %d %s] ", name, status, category);
        vfprintf(stderr, format, rest);
        fputc('\n', stderr);
    }
    va_end(rest);
}

struct callbacks2 {
    log2 logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
};

static void check(int status, const char *what) {
    if (status > 1) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(1);
    }
}

static double run3(void *lib, const char *token, int steps, uint32_t vr) {
    void *(*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool,
                         const uint32_t *, size_t, void *, log3, void *) =
        symbol(lib, "fmi3InstantiateCoSimulation");
    int (*enter)(void *, bool, double, double, bool, double) =
        symbol(lib, "fmi3EnterInitializationMode");
    int (*leave)(void *) = symbol(lib, "fmi3ExitInitializationMode");
    int (*step)(void *, double, double, bool, bool *, bool *, bool *, double *) =
        symbol(lib, "fmi3DoStep");
    int (*get)(void *, const uint32_t *, size_t, double *, size_t) = symbol(lib, "fmi3GetFloat64");
    int (*get_state)(void *, void **) = symbol(lib, "fmi3GetFMUState");
    int (*set_state)(void *, void *) = symbol(lib, "fmi3SetFMUState");
    int (*free_state)(void *, void **) = symbol(lib, "fmi3FreeFMUState");
    void (*release)(void *) = symbol(lib, "fmi3FreeInstance");

    void *fmu = instantiate("three", token, NULL, false, true, false, false, NULL, 0, NULL,
                            on_log3, NULL);
    if (!fmu) exit(1);
    check(enter(fmu, false, 0, 0, false, 0), "enter");
    check(leave(fmu), "exit");
    void *state = NULL;
    check(get_state(fmu, &state), "get state");
    bool event, stop, early;
    double last, value = 0;
    for (int k = 0; k < steps; k++)
        check(step(fmu, k * PERIOD, PERIOD, true, &event, &stop, &early, &last), "step");
    check(get(fmu, &vr, 1, &value, 1), "get");
    check(set_state(fmu, state), "set state");
    check(free_state(fmu, &state), "free state");
    release(fmu);
    return value;
}

static double run2(void *lib, const char *token, int steps, uint32_t vr) {
    void *(*instantiate)(const char *, int, const char *, const char *,
                         const struct callbacks2 *, int, int) = symbol(lib, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = symbol(lib, "fmi2SetupExperiment");
    int (*enter)(void *) = symbol(lib, "fmi2EnterInitializationMode");
    int (*leave)(void *) = symbol(lib, "fmi2ExitInitializationMode");
    int (*step)(void *, double, double, int) = symbol(lib, "fmi2DoStep");
    int (*get)(void *, const uint32_t *, size_t, double *) = symbol(lib, "fmi2GetReal");
    void (*release)(void *) = symbol(lib, "fmi2FreeInstance");

    struct callbacks2 callbacks = {on_log2, calloc, free, NULL, NULL};
    void *fmu = instantiate("two", 1, token, NULL, &callbacks, 0, 1);
    if (!fmu) exit(1);
    check(setup(fmu, 0, 0, 0, 0, 0), "setup");
    check(enter(fmu), "enter");
    check(leave(fmu), "exit");
    for (int k = 0; k < steps; k++) check(step(fmu, k * PERIOD, PERIOD, 1), "step");
    double value = 0;
    check(get(fmu, &vr, 1, &value), "get");
    release(fmu);
    return value;
}

int main(int argc, char **argv) {
    if (argc != 6 && argc != 7) {
        fprintf(stderr, "usage: %s <library> <token> <cycles> <steps> <reference> [<KiB>]\n", argv[0]);
        return 2;
    }
    int cycles = atoi(argv[3]), steps = atoi(argv[4]);
    uint32_t vr = (uint32_t)atoi(argv[5]);
    double before = 0;
    for (int cycle = 0; cycle < cycles; cycle++) {
        if (cycle == 10) before = used_kib();
        void *lib = open_library(argv[1]);
        if (!lib) {
            fprintf(stderr, "cannot load %s\n", argv[1]);
            return 1;
        }
        double three = run3(lib, argv[2], steps, vr), two = run2(lib, argv[2], steps, vr);
        if (cycle == cycles - 1) printf("%.17g %.17g\n", two, three);
        close_library(lib);
    }
    if (argc == 7) {
        double growth = (used_kib() - before) / (cycles - 10);
        printf("%s: %.1f KiB more after each of %d cycles\n", argv[1], growth, cycles);
        if (growth >= atof(argv[6])) return 1;
    }
    return 0;
}
