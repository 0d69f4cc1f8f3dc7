/* Timing of pieces of code in short passes, interleaved so that a slow spell affects all equally.
 * Leaves to others: what is timed (bench_*.c), load over sockets.
 * Invariant: one thread; the figure is the median of the passes, printed with the smallest, both in
 * the thread's processor time. */
#pragma once

enum { BENCH_PASSES = 9 };

struct bench {
    const char *name, *unit;
    void (*run)(struct bench *bench);
    struct bench *next;
    long done;                   /* units of this pass */
    double begin;                /* s of processor time */
    double figure[BENCH_PASSES]; /* ns per unit */
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
 * Returns true for 50 ms of processor time after the first call of a pass.
 *
 * units  number of units of work per iteration of the loop.
 */
int bench_go(struct bench *bench, long units);

/** Ends the program with a message if the timed code failed. */
_Noreturn void bench_broken(const char *what);
