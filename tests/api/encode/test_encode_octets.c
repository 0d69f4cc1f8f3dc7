#include "api/encode/encode.h"

#include <string.h>

#include "tests/api/table.h"
#include "tests/harness/test.h"

TEST(octets_are_the_doubles_row_after_row) {
    OWN(test_table, clear) table = test_table_new(700, 3);
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000000);
    REQUIRE(!test_table_encode(&table, &api_format_octets, 64, &out));
    CHECK_INT((long long)out.bytes, 700 * 12 * 8);
    const char *at = out.data;
    for (long i = 0; i < 700; i++)
        for (int c = 0; c < TEST_COLUMNS; c++) {
            size_t bytes = (size_t)api_column_numbers(&table.table.column[c]) * 8;
            if (!CHECK(!memcmp(at, (const char *)table.data[c] + (size_t)i * bytes, bytes))) return;
            at += bytes;
        }
}

TEST(the_columns_of_a_table_are_named_in_order) {
    OWN(test_table, clear) table = test_table_new(1, 3);
    char text[API_COLUMNS_TEXT];
    api_table_columns(&table.table, text);
    CHECK_TEXT(text, "t,phi[3],z_re[3],z_im[3],energy_kinetic,energy_total");
}
