/* Whole integrations for tests: a problem with its tree, all its samples at once, and the
 * paper's example.
 * Leaves to others: the integration (core/integrate/run/run), random trees (harness/trees).
 * Invariant: aborts if memory is short; checks nothing by itself. */
#pragma once

#include "core/integrate/run/run.h"

/* All outputs of a run, with as many samples as it computed; arrays in the caller's order. */
struct test_record {
    int n;
    struct pend_samples samples; /* count is their total number */
    enum pend_status status;
    struct pend_error error;
    struct pend_run_stats stats;
    long calls; /* of pend_run_next */
};

/**
 * Runs a problem to its end or failure, with all outputs, in blocks of `block` samples and `work`
 * arm-evaluations. A failure of pend_run_new is recorded too. Ends with test_record_clear.
 */
void test_record_blocks(struct test_record *record, const struct pend_method *method,
                        const struct pend_problem *problem, long block, double work);

/** The same, but after every call of pend_run_next the checkpoint is loaded into a new run of the
 * problem, which continues. */
void test_record_carried(struct test_record *record, const struct pend_method *method,
                         const struct pend_problem *problem, long block, double work);

/** The same with one big block; the method by its name. */
void test_record(struct test_record *record, const char *method,
                 const struct pend_problem *problem);

void test_record_clear(struct test_record *record);

/** Largest |a - b| over phi, over rate and over force of two records with the same instants. */
struct test_record_gap {
    double phi, rate, force;
};
struct test_record_gap test_record_gap(const struct test_record *a, const struct test_record *b);

/** Returns non-zero if all samples of both are the same, bit for bit. */
int test_record_same(const struct test_record *a, const struct test_record *b);

/* The paper's four arms, released from phi = 0 at rest. */
struct test_paper {
    struct pend_tree *tree;
    double phi[4], rate[4];
    struct pend_problem problem; /* count instants from 0 to 5 s */
};

void test_paper_init(struct test_paper *paper, long count);
void test_paper_clear(struct test_paper *paper);

enum { TEST_PAPER_ROWS = 51 };

/* The exact motion every 0.1 s, in the caller's order. */
struct test_paper_row {
    double t, phi[4], rate[4], force[4];
};

/** Reads tests/golden/paper_example.txt; 0 on failure. */
int test_paper_read(struct test_paper_row row[TEST_PAPER_ROWS]);

/** Largest error of a record whose instants include every 0.1 s, `stride` instants apart. */
struct test_record_gap test_paper_gap(const struct test_record *record, long stride,
                                      const struct test_paper_row row[TEST_PAPER_ROWS]);
