#include "tests/bench/parts/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static struct bench *bench_first, **bench_last = &bench_first;

void bench_register(struct bench *bench) {
    *bench_last = bench;
    bench_last = &bench->next;
}

/* the thread's processor time: other processes may slow it down, but their own time is not counted
 */
static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

int bench_go(struct bench *bench, long units) {
    double time = now();
    if (bench->done < 0) {
        bench->begin = time;
        bench->done = 0;
        return 1;
    }
    bench->done += units;
    if (time - bench->begin <= 0.05) return 1;
    bench->figure[bench->passes++] = (time - bench->begin) * 1e9 / (double)bench->done;
    return 0;
}

void bench_broken(const char *what) {
    fprintf(stderr, "broken: %s\n", what);
    exit(1);
}

static int ascending(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* usage: run [PART-OF-A-NAME ...] */
int main(int argc, char **argv) {
    for (int pass = 0; pass < BENCH_PASSES; pass++)
        for (struct bench *bench = bench_first; bench; bench = bench->next) {
            int wanted = argc < 2;
            for (int i = 1; i < argc; i++) wanted |= strstr(bench->name, argv[i]) != NULL;
            bench->done = -1;
            if (wanted) bench->run(bench);
        }
    printf("%-44s %14s %14s   ns a\n", "", "median", "smallest");
    for (struct bench *bench = bench_first; bench; bench = bench->next) {
        if (!bench->passes) continue;
        qsort(bench->figure, (size_t)bench->passes, sizeof *bench->figure, ascending);
        printf("%-44s %14.1f %14.1f   %s\n", bench->name, bench->figure[bench->passes / 2],
               bench->figure[0], bench->unit);
    }
}
