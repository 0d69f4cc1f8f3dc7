#include "api/encode/encode.h"

#include <string.h>

#include "api/json/json_in.h"
#include "tests/api/table.h"
#include "tests/harness/test.h"

TEST(ndjson_is_an_object_a_row) {
    static double t[] = {0, 0.5}, phi[] = {1, -2.5, 3, 1e-7}, re[] = {1, 2, 3, 4},
                  im[] = {5, 6, 7, 8}, e[] = {9, 1e300};
    OWN(test_table, clear) table = test_table_new(2, 2);
    struct test_table shown = {
        .table = table.table, .stats = table.stats, .data = {t, phi, re, im, e, e}};
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000);
    REQUIRE(!test_table_encode(&shown, &api_format_ndjson, 1, &out));
    CHECK(!api_buffer_add(&out, "", 1));
    CHECK_TEXT(out.data,
               "{\"t\":0,\"phi\":[1,-2.5],\"z\":{\"re\":[1,2],\"im\":[5,6]},"
               "\"energy\":{\"kinetic\":9,\"total\":9}}\n"
               "{\"t\":0.5,\"phi\":[3,1e-7],\"z\":{\"re\":[3,4],\"im\":[7,8]},"
               "\"energy\":{\"kinetic\":1e300,\"total\":1e300}}\n"
               "{\"stats\":{\"method\":\"taylor\",\"steps\":100000,\"drift\":2.5e-16}}\n");
}

TEST(every_line_of_ndjson_reads_back) {
    OWN(test_table, clear) table = test_table_new(300, 2);
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000000);
    REQUIRE(!test_table_encode(&table, &api_format_ndjson, 64, &out));
    const char *at = out.data, *end = out.data + out.bytes;
    for (long i = 0; i < 300; i++) {
        const char *line_end = memchr(at, '\n', (size_t)(end - at));
        struct api_json *document = NULL;
        struct api_problem problem;
        int count = 0;
        api_problem_init(&problem);
        REQUIRE(line_end && !api_json_new(&document, at, (size_t)(line_end - at), 9, &problem));
        struct api_value root = api_json_root(document), z = api_value_member(&root, "z");
        struct api_value im = api_value_member(&z, "im"),
                         energy = api_value_member(&root, "energy");
        struct api_value total = api_value_member(&energy, "total");
        const double *back = api_value_numbers(&im, &count), sum = api_value_number(&total);
        CHECK(back && count == 2 && !memcmp(back, table.data[TEST_IM] + 2 * i, 2 * sizeof *back));
        CHECK(!memcmp(&sum, &table.data[TEST_TOTAL][i], sizeof sum));
        api_json_free(&document);
        at = line_end + 1;
    }
    CHECK(!memcmp(at, "{\"stats\":{", 10) && memchr(at, '\n', (size_t)(end - at)) == end - 1);
}
