#include "api/encode/encode.h"

#include <stdlib.h>
#include <string.h>

#include "tests/api/table.h"
#include "tests/harness/test.h"

/* rows that are assembled from the columns, and rows too long for that */
TEST(csv_of_short_and_long_rows_reads_back) {
    static const int arms[] = {1, 2, 7, 169, 170, 171, 400};
    for (size_t a = 0; a < sizeof arms / sizeof *arms; a++) {
        OWN(test_table, clear) table = test_table_new(40, arms[a]);
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 10000000);
        REQUIRE(!test_table_encode(&table, &api_format_csv, 16, &out) &&
                !api_buffer_add(&out, "", 1));
        char *at = strchr(out.data, '\n') + 1;
        for (long i = 0; i < 40; i++)
            for (int c = 0; c < TEST_COLUMNS; c++) {
                long width = api_column_numbers(&table.table.column[c]);
                for (long k = 0; k < width; k++, at++) {
                    double back = strtod(at, &at);
                    int last = c == TEST_COLUMNS - 1 && k == width - 1;
                    int good = !memcmp(&back, &table.data[c][i * width + k], sizeof back);
                    if (!CHECK(good && *at == (last ? '\n' : ','))) return;
                }
            }
        CHECK(!*at);
    }
}
