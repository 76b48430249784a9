// Measures the cost of reading the latest message in C.
//
// Prints rows of `lariat-bench readers`, separated by tabs. Argument: seconds for each row.

#define _GNU_SOURCE
#include <lariat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MOST 20000

typedef struct {
    uint64_t at[MOST], count, max;
} counts;

static void add(counts *c, uint64_t ns) {
    c->at[ns < MOST ? ns : MOST - 1]++;
    c->count++;
    if (ns > c->max) c->max = ns;
}

static uint64_t percentile(const counts *c, double share) {
    uint64_t rank = (uint64_t)(share * (double)c->count + 0.999999), passed = 0;
    for (uint64_t ns = 0; ns < MOST; ns++)
        if ((passed += c->at[ns]) >= rank && passed > 0) return ns;
    return c->max;
}

static void row(const char *name, const counts *c) {
    printf("C: %s\t%llu\t%llu\t%llu\t%llu\t%llu\n", name, (unsigned long long)percentile(c, 0.5),
           (unsigned long long)percentile(c, 0.99), (unsigned long long)percentile(c, 0.999),
           (unsigned long long)c->max, (unsigned long long)c->count);
}

static uint64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static counts same, new, whole, rested;

int main(int count, char **arguments) {
    uint64_t time = (uint64_t)((count > 1 ? atof(arguments[1]) : 1) * 1e9);
    lariat_reader *reader;
    lariat_rope rope;
    double at[2], sum = 0;
    if (lariat_open("default", &reader) < 0 || lariat_wait(reader, 20000LL * LARIAT_MS) != 1) {
        fprintf(stderr, "nothing came: %s\n", lariat_error());
        return 1;
    }
    for (uint64_t before = now(), after = before, end = before + time; after < end;) {
        before = now();
        int is_new = lariat_latest(reader);
        after = now();
        add(is_new ? &new : &same, after - before);
    }
    for (uint64_t before = now(), after = before, end = before + time; after < end;) {
        before = now();
        int is_new = lariat_latest(reader);
        if (lariat_only_rope(reader, UINT64_MAX, &rope) == LARIAT_FRESH && lariat_point_at(rope.fresh, 0.5, at) == 0)
            sum += at[0];
        after = now();
        if (is_new) add(&whole, after - before);
    }
    for (uint64_t before = now(), after = before, end = before + time; after < end;) {
        nanosleep(&(struct timespec){0, LARIAT_MS}, NULL);
        before = now();
        if (lariat_latest(reader) < 0) return 1;
        after = now();
        add(&rested, after - before);
    }
    row("nothing new", &same);
    row("a new message", &new);
    row("and the rope's middle", &whole);
    row("after 1 ms of sleep", &rested);
    lariat_close(reader);
    return sum == -1;
}
