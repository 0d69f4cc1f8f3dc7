/* Timing of small pieces: each is run in short passes, the passes of all interleaved, so that a
 * slow spell hits all alike. Leaves to others: what is timed (bench_*.c), load over sockets.
 * Invariant: one thread; the figure is the median of the passes, the smallest stands beside it,
 * both in the thread's processor time. */
#pragma once

enum { BENCH_PASSES = 9 };

struct bench {
    const char *name, *unit;
    void (*run)(struct bench *bench);
    struct bench *next;
    long done;                   /* units of this pass */
    double begin;                /* s of processor time */
    double figure[BENCH_PASSES]; /* ns a unit */
    int passes;
};

void bench_register(struct bench *bench);

/** Defines a benchmark: BENCH(name, "request") { prepare; while (bench_go(bench, 1)) work; clear
 * up; } */
#define BENCH(name_, unit_)                                                                        \
    static void bench_##name_(struct bench *bench);                                                \
    static struct bench case_##name_ = {.name = #name_, .unit = unit_, .run = bench_##name_};      \
    __attribute__((constructor)) static void register_##name_(void) {                              \
        bench_register(&case_##name_);                                                             \
    }                                                                                              \
    static void bench_##name_(struct bench *bench)

/**
 * True while the pass goes on, for 50 ms of processor time; the clock starts at the first call.
 *
 * units  how many units of work one turn of the loop does.
 */
int bench_go(struct bench *bench, long units);

/** Ends the program with a message: what is timed did not work. */
_Noreturn void bench_broken(const char *what);
