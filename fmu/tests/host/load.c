/* A plain C importer for tests of what a library costs its host, on Linux.
 *
 * usage: load <library> <token> same|copies <cycles>
 *        load <library> <token> stack <steps>
 *
 * same, copies: loads the library, takes a few FMI 3.0 steps, frees all and unloads, as often as
 * asked; `copies` from a new file each time, as importers do that unpack an FMU for every instance.
 * Prints by how many kB each cycle grows the process, the first tenth left out.
 * stack: the deepest stack of each kind of call [bytes], in a thread whose stack was painted before.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const double PERIOD = 0.1;
enum { STACK = 1 << 20, PAINT = 0xa5 };

static void fail(const char *what) { fprintf(stderr, "%s\n", what); exit(1); }

static void check(int status, const char *what) { if (status > 1) fail(what); }

static void on_log(void *env, int status, const char *category, const char *message) {
    if (status > 1) fprintf(stderr, "[%d %s] %s\n", status, category, message);
}

static void *need(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) fail(name);
    return found;
}

struct calls {
    void *(*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool,
                         const uint32_t *, size_t, void *,
                         void (*)(void *, int, const char *, const char *), void *);
    int (*enter)(void *, bool, double, double, bool, double);
    int (*leave)(void *);
    int (*step)(void *, double, double, bool, bool *, bool *, bool *, double *);
    int (*save)(void *, void **);
    int (*restore)(void *, void *);
    int (*size)(void *, void *, size_t *);
    int (*write)(void *, void *, uint8_t *, size_t);
    int (*read)(void *, const uint8_t *, size_t, void **);
    void (*release)(void *);
};

static struct calls find(void *library) {
    struct calls c;
    c.instantiate = need(library, "fmi3InstantiateCoSimulation");
    c.enter = need(library, "fmi3EnterInitializationMode");
    c.leave = need(library, "fmi3ExitInitializationMode");
    c.step = need(library, "fmi3DoStep");
    c.save = need(library, "fmi3GetFMUState");
    c.restore = need(library, "fmi3SetFMUState");
    c.size = need(library, "fmi3SerializedFMUStateSize");
    c.write = need(library, "fmi3SerializeFMUState");
    c.read = need(library, "fmi3DeserializeFMUState");
    c.release = need(library, "fmi3FreeInstance");
    return c;
}

static void *open_library(const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fail(dlerror());
    return library;
}

static void *instance_of(const struct calls *c, const char *token) {
    void *fmu = c->instantiate("load", token, NULL, false, true, false, false, NULL, 0, NULL, on_log,
                               NULL);
    if (!fmu) fail("no instance");
    return fmu;
}

static void step(const struct calls *c, void *fmu, int k) {
    bool event, stop, early;
    double last;
    check(c->step(fmu, k * PERIOD, PERIOD, true, &event, &stop, &early, &last), "step");
}

static long resident(void) {
    long all, here = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &all, &here) != 2) fail("/proc/self/statm");
    fclose(file);
    return here * (sysconf(_SC_PAGESIZE) / 1024);
}

static void copy(const char *from, const char *to) {
    static char buffer[1 << 16];
    FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
    if (!in || !out) fail("cannot copy the library");
    for (size_t n; (n = fread(buffer, 1, sizeof buffer, in)) > 0;)
        if (fwrite(buffer, 1, n, out) != n) fail("cannot copy the library");
    fclose(in);
    if (fclose(out)) fail("cannot copy the library");
}

static void cycles(const char *path, const char *token, bool copies, int count) {
    char folder[] = "/tmp/lmpc-load-XXXXXX", place[64];
    if (!mkdtemp(folder)) fail("no folder for copies");
    long start = 0;
    for (int i = 0; i < count; i++) {
        if (i == count / 10) start = resident();
        snprintf(place, sizeof place, "%s/%d.so", folder, i);
        if (copies) copy(path, place);
        void *library = open_library(copies ? place : path);
        struct calls c = find(library);
        void *fmu = instance_of(&c, token);
        check(c.enter(fmu, false, 0, 0, false, 0), "enter");
        check(c.leave(fmu), "exit");
        for (int k = 0; k < 5; k++) step(&c, fmu, k);
        c.release(fmu);
        dlclose(library);
        if (copies) unlink(place);
    }
    rmdir(folder);
    printf("%ld\n", (resident() - start) / (count - count / 10));
}

static unsigned char *stack;

/* Bytes used since the last call, and paint again below the frame of the caller. */
static size_t deepest(void) {
    unsigned char *here = __builtin_frame_address(0), *end = here - 256;
    size_t untouched = 0;
    while (untouched < (size_t)(end - stack) && stack[untouched] == PAINT) untouched++;
    size_t used = (size_t)(here - stack) - untouched;
    for (unsigned char *p = stack + untouched; p < end; p++) *(volatile unsigned char *)p = PAINT;
    return used;
}

static char **arguments;

static void *measured(void *unused) {
    deepest();
    void *library = open_library(arguments[1]);
    struct calls c = find(library);
    size_t loading = deepest();
    void *fmu = instance_of(&c, arguments[2]);
    size_t instantiation = deepest();
    check(c.enter(fmu, false, 0, 0, false, 0), "enter");
    check(c.leave(fmu), "exit");
    size_t initialisation = deepest(), steps = 0, states = 0;
    for (int k = 0; k < atoi(arguments[4]); k++) {
        step(&c, fmu, k);
        size_t used = deepest();
        if (used > steps) steps = used;
    }
    void *state = NULL, *again = NULL;
    size_t size;
    check(c.save(fmu, &state), "get state");
    check(c.size(fmu, state, &size), "size");
    uint8_t *bytes = malloc(size);
    if (!bytes) fail("no memory");
    check(c.write(fmu, state, bytes, size), "serialize");
    check(c.read(fmu, bytes, size, &again), "deserialize");
    check(c.restore(fmu, again), "set state");
    states = deepest();
    c.release(fmu);
    size_t release = deepest();
    free(bytes);
    printf("load %zu instantiate %zu initialise %zu step %zu state %zu free %zu\n", loading,
           instantiation, initialisation, steps, states, release);
    return unused;
}

int main(int count, char **given) {
    if (count != 5) fail("usage: see the head of load.c");
    arguments = given;
    if (strcmp(given[3], "stack")) {
        cycles(given[1], given[2], !strcmp(given[3], "copies"), atoi(given[4]));
        return 0;
    }
    stack = mmap(NULL, STACK, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (stack == MAP_FAILED) fail("no memory");
    memset(stack, PAINT, STACK);
    pthread_t thread;
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    if (pthread_attr_setstack(&attributes, stack, STACK) ||
        pthread_create(&thread, &attributes, measured, NULL) || pthread_join(thread, NULL))
        fail("no thread");
    return 0;
}
