#include "tests/harness/runs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

/* the arrays of samples: their offset in the struct, and whether a row has n values or one */
static const struct {
    size_t offset;
    int wide;
} runs_array[] = {
    {offsetof(struct pend_samples, t), 0},         {offsetof(struct pend_samples, phi), 1},
    {offsetof(struct pend_samples, rate), 1},      {offsetof(struct pend_samples, acc), 1},
    {offsetof(struct pend_samples, force), 1},     {offsetof(struct pend_samples, z_re), 1},
    {offsetof(struct pend_samples, z_im), 1},      {offsetof(struct pend_samples, zd_re), 1},
    {offsetof(struct pend_samples, zd_im), 1},     {offsetof(struct pend_samples, kinetic), 0},
    {offsetof(struct pend_samples, potential), 0},
};

enum { RUNS_ARRAYS = sizeof runs_array / sizeof *runs_array };

static double **runs_at(const struct pend_samples *samples, int i) {
    return (double **)((char *)samples + runs_array[i].offset);
}

static size_t runs_width(const struct test_record *record, int i) {
    return runs_array[i].wide ? (size_t)record->n : 1;
}

/* the arrays are exactly as long as the samples, so that a sanitizer detects an access beyond */
static void runs_allocate(struct test_record *record, long count) {
    for (int i = 0; i < RUNS_ARRAYS; i++) {
        double *array = malloc((size_t)count * runs_width(record, i) * sizeof(double));
        if (!array) abort();
        *runs_at(&record->samples, i) = array;
    }
}

static struct pend_samples runs_view(const struct test_record *record, long at, long cap) {
    struct pend_samples view = {.cap = cap};
    for (int i = 0; i < RUNS_ARRAYS; i++)
        *runs_at(&view, i) = *runs_at(&record->samples, i) + (size_t)at * runs_width(record, i);
    return view;
}

/* replaces a run by a new one, through its checkpoint */
static void runs_carry(struct test_record *record, struct pend_run **run,
                       const struct pend_method *method, const struct pend_problem *problem) {
    struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
    struct pend_run *next;
    if (!CHECK(pend_run_carry(*run, &checkpoint) == PEND_OK)) return;
    checkpoint = (struct pend_checkpoint){
        .way = PEND_CHECKPOINT_TAKE, .bytes = checkpoint.used, .at = malloc(checkpoint.used)};
    if (!checkpoint.at) abort();
    CHECK(pend_run_carry(*run, &checkpoint) == PEND_OK && pend_checkpoint_whole(&checkpoint));
    pend_run_free(run);
    record->status = pend_run_new(&next, method, problem, &record->error);
    *run = next;
    if (record->status != PEND_OK) abort();
    checkpoint.way = PEND_CHECKPOINT_PUT;
    checkpoint.used = 0;
    CHECK(pend_run_carry(*run, &checkpoint) == PEND_OK && pend_checkpoint_whole(&checkpoint));
    free(checkpoint.at);
}

/* carried: the problem, if each call gets a run of its own; else NULL */
static void runs_loop(struct test_record *record, struct pend_run **run,
                      const struct pend_method *method, const struct pend_problem *carried,
                      long count, long block, double work) {
    long *at = &record->samples.count;
    int done = 0;
    while (!done && record->status == PEND_OK) {
        struct pend_samples view =
            runs_view(record, *at, block < count - *at ? block : count - *at);
        record->status = pend_run_next(*run, &view, work, &done, &record->error);
        record->calls++;
        *at += view.count;
        if (carried && !done && record->status == PEND_OK) runs_carry(record, run, method, carried);
    }
    record->stats = pend_run_stats(*run);
}

static void runs_record(struct test_record *record, const struct pend_method *method,
                        const struct pend_problem *problem, int carried, long block, double work) {
    OWN(pend_run, free) *run;
    *record = (struct test_record){.n = problem->tree->n};
    record->status = pend_run_new(&run, method, problem, &record->error);
    if (record->status != PEND_OK) return;
    runs_allocate(record, problem->times.count);
    runs_loop(record, &run, method, carried ? problem : NULL, problem->times.count, block, work);
}

void test_record_blocks(struct test_record *record, const struct pend_method *method,
                        const struct pend_problem *problem, long block, double work) {
    runs_record(record, method, problem, 0, block, work);
}

void test_record_carried(struct test_record *record, const struct pend_method *method,
                         const struct pend_problem *problem, long block, double work) {
    runs_record(record, method, problem, 1, block, work);
}

void test_record(struct test_record *record, const char *method,
                 const struct pend_problem *problem) {
    test_record_blocks(record, pend_method_find(method), problem, problem->times.count, INFINITY);
}

void test_record_clear(struct test_record *record) {
    for (int i = 0; i < RUNS_ARRAYS; i++) free(*runs_at(&record->samples, i));
    *record = (struct test_record){0};
}

static double runs_gap(const double a[], const double b[], size_t count) {
    double worst = 0;
    for (size_t i = 0; i < count; i++)
        if (!(fabs(a[i] - b[i]) <= worst)) worst = fabs(a[i] - b[i]);
    return worst;
}

struct test_record_gap test_record_gap(const struct test_record *a, const struct test_record *b) {
    size_t count = (size_t)(a->samples.count * a->n);
    if (a->samples.count != b->samples.count || a->n != b->n)
        return (struct test_record_gap){NAN, NAN, NAN};
    return (struct test_record_gap){runs_gap(a->samples.phi, b->samples.phi, count),
                                    runs_gap(a->samples.rate, b->samples.rate, count),
                                    runs_gap(a->samples.force, b->samples.force, count)};
}

int test_record_same(const struct test_record *a, const struct test_record *b) {
    if (a->samples.count != b->samples.count || a->n != b->n || a->status != b->status) return 0;
    for (int i = 0; i < RUNS_ARRAYS; i++) {
        size_t bytes = (size_t)a->samples.count * runs_width(a, i) * sizeof(double);
        if (bytes && memcmp(*runs_at(&a->samples, i), *runs_at(&b->samples, i), bytes) != 0)
            return 0;
    }
    return 1;
}

void test_paper_init(struct test_paper *paper, long count) {
    static const double length[] = {2, 1.5, 0.75, 1.25}, mass[] = {1, 1, 1, 0.1};
    static const int parent[] = {-1, 0, 1, 1};
    *paper = (struct test_paper){0};
    if (pend_tree_new(&paper->tree, 4, length, mass, parent, NULL) != PEND_OK) abort();
    paper->problem = (struct pend_problem){
        .tree = paper->tree,
        .loads.gravity = 9.81,
        .phi = paper->phi,
        .rate = paper->rate,
        .times = {.count = count, .span = 5, .divisor = count > 1 ? (double)(count - 1) : 1}};
}

void test_paper_clear(struct test_paper *paper) { pend_tree_free(&paper->tree); }

static int runs_read_numbers(FILE *file, double x[], int count) {
    for (int i = 0; i < count; i++)
        if (fscanf(file, "%lf", &x[i]) != 1) return 0;
    return 1;
}

int test_paper_read(struct test_paper_row row[TEST_PAPER_ROWS]) {
    FILE *file = fopen("tests/golden/paper_example.txt", "r");
    int read = 0;
    if (!file) return 0;
    for (int c; (c = getc(file)) == '#';)
        while (c != '\n' && c != EOF) c = getc(file);
    fseek(file, -1, SEEK_CUR);
    for (; read < TEST_PAPER_ROWS; read++) {
        struct test_paper_row *r = &row[read];
        if (!runs_read_numbers(file, &r->t, 1) || !runs_read_numbers(file, r->phi, 4) ||
            !runs_read_numbers(file, r->rate, 4) || !runs_read_numbers(file, r->force, 4))
            break;
    }
    fclose(file);
    return read == TEST_PAPER_ROWS;
}

struct test_record_gap test_paper_gap(const struct test_record *record, long stride,
                                      const struct test_paper_row row[TEST_PAPER_ROWS]) {
    struct test_record_gap worst = {0, 0, 0};
    if (record->samples.count < (TEST_PAPER_ROWS - 1) * stride + 1)
        return (struct test_record_gap){NAN, NAN, NAN};
    for (int i = 0; i < TEST_PAPER_ROWS; i++) {
        size_t at = (size_t)(i * stride) * 4;
        worst.phi = fmax(worst.phi, runs_gap(record->samples.phi + at, row[i].phi, 4));
        worst.rate = fmax(worst.rate, runs_gap(record->samples.rate + at, row[i].rate, 4));
        worst.force = fmax(worst.force, runs_gap(record->samples.force + at, row[i].force, 4));
    }
    return worst;
}
