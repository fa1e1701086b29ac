/* A publisher and a subscriber on liblcm: the C side of the latency and loss measurement.
 *
 *   lcm_load sub              prints: received lost p50 p99 max (latencies in us)
 *   lcm_load pub COUNT RATE SIZE
 *
 * A message is its number (u32), its time of sending on CLOCK_MONOTONIC in ns (i64), and padding.
 */
#include <lcm/lcm.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static double *latency_us;
static size_t received, capacity;
static uint32_t highest;
static int ended;

static void on_load(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    int64_t now = now_ns(), sent;
    uint32_t number;
    memcpy(&number, buffer->data, 4);
    memcpy(&sent, (char *) buffer->data + 4, 8);
    if (received == capacity) {
        capacity = capacity ? 2 * capacity : 1 << 16;
        latency_us = realloc(latency_us, capacity * sizeof *latency_us);
    }
    latency_us[received++] = (now - sent) / 1000.0;
    if (number > highest)
        highest = number;
}

static void on_end(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    ended = 1;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static int subscribe(lcm_t *lcm)
{
    lcm_subscription_t *load = lcm_subscribe(lcm, "LOAD", on_load, NULL);
    lcm_subscription_set_queue_capacity(load, 100000);
    lcm_subscribe(lcm, "LOAD_END", on_end, NULL);
    while (!ended)
        lcm_handle(lcm);
    if (!received)
        return 1;
    qsort(latency_us, received, sizeof *latency_us, ascending);
    printf("%zu %zu %.1f %.1f %.1f\n", received, highest + 1 - received,
           latency_us[received / 2], latency_us[received * 99 / 100], latency_us[received - 1]);
    return 0;
}

static int publish(lcm_t *lcm, uint32_t count, double rate, size_t size)
{
    char *message = calloc(1, size);
    int64_t begin = now_ns();
    for (uint32_t number = 0; number < count; number++) {
        int64_t due = begin + (int64_t) (number * 1e9 / rate);
        struct timespec t = {due / 1000000000, due % 1000000000};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        memcpy(message, &number, 4);
        int64_t sent = now_ns();
        memcpy(message + 4, &sent, 8);
        lcm_publish(lcm, "LOAD", message, size);
    }
    for (int i = 0; i < 5; i++) {
        struct timespec t = {0, 100000000};
        nanosleep(&t, NULL);
        lcm_publish(lcm, "LOAD_END", "", 0);
    }
    return 0;
}

int main(int argc, char **argv)
{
    lcm_t *lcm = lcm_create(NULL);
    if (lcm && argc == 2 && !strcmp(argv[1], "sub"))
        return subscribe(lcm);
    if (lcm && argc == 5 && !strcmp(argv[1], "pub") && atoi(argv[4]) >= 12)
        return publish(lcm, atoi(argv[2]), atof(argv[3]), atoi(argv[4]));
    fprintf(stderr, "expected sub, or pub COUNT RATE SIZE (12 or more)\n");
    return 2;
}
