#include "tests/api/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

double test_wild(unsigned long long *seed) {
    for (;;) {
        unsigned long long bits = (unsigned long long)(test_random(seed) * 0x1p32) << 32 |
                                  (unsigned long long)(test_random(seed) * 0x1p32);
        double x;
        memcpy(&x, &bits, sizeof x);
        if (isfinite(x)) return x;
    }
}

struct test_table test_table_new(long rows, int arms) {
    struct test_table made = {.table = {.rows = rows}};
    unsigned long long seed = 77;
    api_table_add(&made.table, "t", NULL, 0);
    api_table_add(&made.table, "phi", NULL, arms);
    api_table_add(&made.table, "z", "re", arms);
    api_table_add(&made.table, "z", "im", arms);
    api_table_add(&made.table, "energy", "kinetic", 0);
    api_table_add(&made.table, "energy", "total", 0);
    api_stats_text(&made.stats, "method", "taylor");
    api_stats_whole(&made.stats, "steps", 100000);
    api_stats_number(&made.stats, "drift", 2.5e-16);
    for (int c = 0; c < TEST_COLUMNS; c++) {
        long count = rows * api_column_numbers(&made.table.column[c]);
        made.data[c] = malloc((size_t)count * sizeof(double) + 1);
        for (long i = 0; made.data[c] && i < count; i++) made.data[c][i] = test_wild(&seed);
    }
    return made;
}

void test_table_clear(struct test_table *table) {
    for (int c = 0; c < TEST_COLUMNS; c++) free(table->data[c]);
}

enum pend_status test_table_encode(const struct test_table *table, const struct api_format *format,
                                   long cut, struct api_buffer *out) {
    OWN(api_writer, free) *writer;
    PEND_TRY(api_writer_new(&writer, format, &table->table, out));
    enum pend_status status = PEND_OK;
    for (long at = 0; at < table->table.rows && status == PEND_OK; at += cut) {
        const double *block[TEST_COLUMNS];
        long rows = table->table.rows - at < cut ? table->table.rows - at : cut;
        for (int c = 0; c < TEST_COLUMNS; c++)
            block[c] = table->data[c] + at * api_column_numbers(&table->table.column[c]);
        status = api_writer_block(writer, rows, block, out, NULL);
    }
    for (int done = 0; !done && status == PEND_OK;)
        status = api_writer_finish(writer, &table->stats, out, &done);
    return status;
}
