/* A plain C importer for tests: drives the controller's and the car's library in one loop and prints
 * a hash of every command and measurement, how many steps were learned ones, and the laps finished.
 * Runs on Linux x64 and ARM64 and, cross-built, on Windows. With STATIC_CONTROLLER defined the
 * controller is the static library's: the hash must be the same.
 *
 * usage: race <controller library> <car library> <references> <FMI version> <steps>
 *             [<floating-point state> <when> [<stack of the thread, KiB>]]
 *
 * The file of references holds both tokens, then the value references named at `struct references`.
 * Floating-point states of the host: nearest, up, down, zero, trap, flush; set before everything
 * (0), after initialisation (1) or for every other step (2). It must be the same after each call.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *p) { return (void *)LoadLibraryA(p); }
static void *symbol(void *l, const char *n) { return (void *)GetProcAddress((HMODULE)l, n); }
#else
#include <dlfcn.h>
#include <pthread.h>
static void *open_library(const char *p) {
    void *library = dlopen(p, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "%s\n", dlerror());
    return library;
}
static void *symbol(void *l, const char *n) { return dlsym(l, n); }
#endif

#ifdef STATIC_CONTROLLER
#include "lmpc.h"
#endif

#ifdef __x86_64__
#include <immintrin.h>
static uint64_t state_now(void) { return _mm_getcsr() & 0xffc0; }
static void state_set(uint64_t s) { _mm_setcsr((unsigned)s); }
static const struct { const char *name; uint64_t bits; } states[] = {
    {"nearest", 0x1f80}, {"down", 0x3f80}, {"up", 0x5f80},
    {"zero", 0x7f80}, {"trap", 0x1000}, {"flush", 0x9fc0},
};
#else
static uint64_t state_now(void) { uint64_t s; __asm__ volatile("mrs %0, fpcr" : "=r"(s)); return s; }
static void state_set(uint64_t s) { __asm__ volatile("msr fpcr, %0" : : "r"(s)); }
static const struct { const char *name; uint64_t bits; } states[] = {
    {"nearest", 0}, {"up", 1 << 22}, {"down", 2 << 22}, {"zero", 3 << 22},
    {"trap", 0x0f00}, {"flush", 1 << 24},
};
#endif

enum { STATE = 6, COMMAND = 2, NOISE = 6 };
static const double PERIOD = 0.1;

static struct references {
    uint32_t state_in[STATE], command_out[COMMAND];           /* of the controller */
    uint32_t warm_up_laps, action, finished;
    uint32_t state_out[STATE], command_in[COMMAND];           /* of the car */
    uint32_t noise[NOISE];
} r;
static char tokens[2][64];
static uint64_t default_state, host_state;

struct fmu { int version; void *library, *instance; };

static void fail(const char *what) { fprintf(stderr, "%s\n", what); exit(1); }

static void check(int status, const char *what) {
    if (state_now() != host_state) {
        state_set(default_state);
        fprintf(stderr, "%s: the floating-point state is changed\n", what);
        exit(1);
    }
    if (status > 1) { fprintf(stderr, "%s: status %d\n", what, status); exit(1); }
}

static void *need(struct fmu *f, const char *two, const char *three) {
    void *found = symbol(f->library, f->version == 2 ? two : three);
    if (!found) fail(f->version == 2 ? two : three);
    return found;
}

static void host(uint64_t state) { host_state = state; state_set(state); }

static void on_log2(void *e, const char *n, int s, const char *c, const char *m, ...) {
    if (state_now() != host_state) fail("the log function runs in another floating-point state");
    (void)e; (void)n; (void)s; (void)c; (void)m;
}
static void on_log3(void *e, int s, const char *c, const char *m) {
    on_log2(e, "", s, c, "%s", m);
    if (s > 1) fprintf(stderr, "%s\n", m);
}

static struct { void *logger, *allocate, *release, *finished, *environment; } callbacks;

static struct fmu instantiate(const char *path, int version, const char *token) {
    struct fmu f = {version, open_library(path), NULL};
    if (!f.library) fail(path);
    callbacks.logger = (void *)on_log2;
    if (version == 2) {
        void *(*make)(const char *, int, const char *, const char *, void *, int, int) =
            need(&f, "fmi2Instantiate", "");
        f.instance = make("race", 1, token, NULL, &callbacks, 0, 1);
    } else {
        void *(*make)(const char *, const char *, const char *, bool, bool, bool, bool,
                      const uint32_t *, size_t, void *,
                      void (*)(void *, int, const char *, const char *), void *) =
            need(&f, "", "fmi3InstantiateCoSimulation");
        f.instance = make("race", token, NULL, false, true, false, false, NULL, 0, NULL, on_log3, NULL);
    }
    if (!f.instance) fail("no instance");
    check(0, "instantiate");
    return f;
}

static void set(struct fmu *f, const uint32_t *vr, size_t n, const double *x) {
    if (f->version == 2) {
        int (*call)(void *, const uint32_t *, size_t, const double *) = need(f, "fmi2SetReal", "");
        check(call(f->instance, vr, n, x), "set");
    } else {
        int (*call)(void *, const uint32_t *, size_t, const double *, size_t) =
            need(f, "", "fmi3SetFloat64");
        check(call(f->instance, vr, n, x, n), "set");
    }
}

static void get(struct fmu *f, const uint32_t *vr, size_t n, double *x) {
    if (f->version == 2) {
        int (*call)(void *, const uint32_t *, size_t, double *) = need(f, "fmi2GetReal", "");
        check(call(f->instance, vr, n, x), "get");
    } else {
        int (*call)(void *, const uint32_t *, size_t, double *, size_t) =
            need(f, "", "fmi3GetFloat64");
        check(call(f->instance, vr, n, x, n), "get");
    }
}

static void initialise(struct fmu *f) {
    if (f->version == 2) {
        int (*setup)(void *, int, double, double, int, double) = need(f, "fmi2SetupExperiment", "");
        int (*enter)(void *) = need(f, "fmi2EnterInitializationMode", "");
        check(setup(f->instance, 0, 0, 0, 0, 0), "setup");
        check(enter(f->instance), "enter");
    } else {
        int (*enter)(void *, bool, double, double, bool, double) =
            need(f, "", "fmi3EnterInitializationMode");
        check(enter(f->instance, false, 0, 0, false, 0), "enter");
    }
    int (*leave)(void *) = need(f, "fmi2ExitInitializationMode", "fmi3ExitInitializationMode");
    check(leave(f->instance), "exit");
}

static void step(struct fmu *f, double time) {
    if (f->version == 2) {
        int (*call)(void *, double, double, int) = need(f, "fmi2DoStep", "");
        check(call(f->instance, time, PERIOD, 1), "step");
    } else {
        bool event, stop, early;
        double last;
        int (*call)(void *, double, double, bool, bool *, bool *, bool *, double *) =
            need(f, "", "fmi3DoStep");
        check(call(f->instance, time, PERIOD, true, &event, &stop, &early, &last), "step");
    }
}

static void release(struct fmu *f) {
    void (*call)(void *) = need(f, "fmi2FreeInstance", "fmi3FreeInstance");
    call(f->instance);
    check(0, "free");
}

/* Saves the state, writes it to bytes, reads those back and restores that: nothing may change. */
static void there_and_back(struct fmu *f) {
    int (*save)(void *, void **) = need(f, "fmi2GetFMUstate", "fmi3GetFMUState");
    int (*size)(void *, void *, size_t *) =
        need(f, "fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize");
    int (*write)(void *, void *, unsigned char *, size_t) =
        need(f, "fmi2SerializeFMUstate", "fmi3SerializeFMUState");
    int (*read)(void *, const unsigned char *, size_t, void **) =
        need(f, "fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState");
    int (*restore)(void *, void *) = need(f, "fmi2SetFMUstate", "fmi3SetFMUState");
    int (*drop)(void *, void **) = need(f, "fmi2FreeFMUstate", "fmi3FreeFMUState");
    void *saved = NULL, *copy = NULL;
    size_t n = 0;
    check(save(f->instance, &saved), "get state");
    check(size(f->instance, saved, &n), "size of state");
    unsigned char *bytes = malloc(n);
    if (!bytes) fail("no memory");
    check(write(f->instance, saved, bytes, n), "serialize");
    check(read(f->instance, bytes, n, &copy), "deserialize");
    check(restore(f->instance, copy), "set state");
    check(drop(f->instance, &saved), "free state");
    check(drop(f->instance, &copy), "free state");
    free(bytes);
}

static uint64_t hash = 0xcbf29ce484222325;

static void digest(const double *x, size_t n) {
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        for (int byte = 0; byte < 8; byte++)
            hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3;
    }
}

static int read_references(const char *path) {
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    int good = fscanf(file, "%63s %63s", tokens[0], tokens[1]) == 2;
    uint32_t *next = (uint32_t *)&r;
    for (size_t i = 0; i < sizeof r / sizeof *next; i++)
        good &= fscanf(file, "%" SCNu32, &next[i]) == 1;
    fclose(file);
    return good;
}

static char **arguments;
static int argument_count;

static void *race(void *unused) {
    int version = atoi(arguments[4]), steps = atoi(arguments[5]), when = 0;
    uint64_t wanted = default_state = state_now();
    if (argument_count > 7) {
        size_t known = 0;
        while (known < sizeof states / sizeof *states && strcmp(states[known].name, arguments[6]))
            known++;
        if (known == sizeof states / sizeof *states) fail("unknown floating-point state");
        wanted = states[known].bits;
        when = atoi(arguments[7]);
    }
    /* The host's own arithmetic is not what is under test: times from before. */
    double *times = malloc((size_t)steps * sizeof *times);
    if (!times) fail("no memory");
    for (int k = 0; k < steps; k++) times[k] = k * PERIOD;
    const double one = 1, noise[NOISE] = {0.01, 0.01, 0.01, 1e-3, 1e-3, 1e-3};
    double state[STATE], command[COMMAND], action, finished;
    (void)one;
    int learned = 0;
#ifdef STATIC_CONTROLLER
    int laps = 0;
#endif

    host(when == 0 ? wanted : default_state);
#ifdef STATIC_CONTROLLER
    char error[256];
    lmpc_controller *controller = lmpc_create("preset = \"race\"\n[warm_up]\nlaps = 1\n", "barc",
                                              "l", error, sizeof error);
    if (!controller) fail(error);
#else
    struct fmu controller = instantiate(arguments[1], version, tokens[0]);
#endif
    struct fmu car = instantiate(arguments[2], version, tokens[1]);
#ifndef STATIC_CONTROLLER
    set(&controller, &r.warm_up_laps, 1, &one);
    initialise(&controller);
#endif
    set(&car, r.noise, NOISE, noise);
    initialise(&car);
    for (int k = 0; k < steps; k++) {
        if (when == 1 || (when == 2 && k % 2)) host(wanted);
        if (when == 2 && k % 2 == 0) host(default_state);
        get(&car, r.state_out, STATE, state);
#ifdef STATIC_CONTROLLER
        lmpc_command answer;
        check(lmpc_step(controller, times[k], (const lmpc_state *)state, NULL, &answer) * 3, "step");
        check(lmpc_prepare(controller) * 3, "prepare");
        command[0] = answer.input.a;
        command[1] = answer.input.delta;
        action = answer.action;
        laps += answer.lap_finished;
#else
        set(&controller, r.state_in, STATE, state);
        step(&controller, times[k]);
        get(&controller, r.command_out, COMMAND, command);
        get(&controller, &r.action, 1, &action);
#endif
        set(&car, r.command_in, COMMAND, command);
        step(&car, times[k]);
        learned += action == 1;
        if (k == steps / 2) {
#ifndef STATIC_CONTROLLER
            there_and_back(&controller);
#endif
            there_and_back(&car);
        }
        digest(state, STATE);
        digest(command, COMMAND);
    }
#ifdef STATIC_CONTROLLER
    finished = laps;
    lmpc_free(controller);
    check(0, "free");
#else
    get(&controller, &r.finished, 1, &finished);
    release(&controller);
#endif
    release(&car);
    state_set(default_state);
    free(times);
    printf("%016" PRIx64 " %d %d\n", hash, learned, (int)finished);
    return unused;
}

int main(int count, char **given) {
    if (count < 6 || !read_references(given[3])) {
        fprintf(stderr, "usage: see the head of race.c\n");
        return 2;
    }
    arguments = given;
    argument_count = count;
#ifndef _WIN32
    if (count > 8) {
        pthread_t thread;
        pthread_attr_t attributes;
        pthread_attr_init(&attributes);
        if (pthread_attr_setstacksize(&attributes, (size_t)atoi(given[8]) * 1024) ||
            pthread_create(&thread, &attributes, race, NULL) || pthread_join(thread, NULL))
            fail("no thread");
        return 0;
    }
#endif
    race(NULL);
    return 0;
}
