/* A table of samples for tests: every kind of column, filled with random doubles.
 * Leaves to others: the expected bytes (test_encode_*). Invariant: every finite double may
 * occur. */
#pragma once

#include "api/encode/encode.h"

enum { TEST_T, TEST_PHI, TEST_RE, TEST_IM, TEST_KINETIC, TEST_TOTAL, TEST_COLUMNS };

struct test_table {
    struct api_table table;
    struct api_stats stats; /* method "taylor", steps 100000, drift 2.5e-16 */
    double *data[TEST_COLUMNS];
};

/** Columns t, phi, z re and im, energy kinetic and total, for the given number of arms. */
struct test_table test_table_new(long rows, int arms);

void test_table_clear(struct test_table *table);

/** Any finite double, with all bit patterns equally likely. */
double test_wild(unsigned long long *seed);

/** Encodes the table in blocks of `cut` rows. */
enum pend_status test_table_encode(const struct test_table *table, const struct api_format *format,
                                   long cut, struct api_buffer *out);
