#include "api/encode/stats_text.h"

#include <stdlib.h>
#include <string.h>

#include "api/encode/encode_raw.h"
#include "tests/api/table.h"
#include "tests/harness/test.h"

static const char first[] = "digits are lost: beyond t = 8.5 s", second[] = "energy is lost";

static struct test_table warned(long rows) {
    struct test_table table = test_table_new(rows, 2);
    api_stats_number(&table.stats, "horizon", 8.5);
    api_stats_number(&table.stats, "trust_until", 8.75);
    api_stats_warning(&table.stats, "warning_horizon", first);
    api_stats_warning(&table.stats, "warning_energy", second);
    return table;
}

/* the table in a representation, followed by a NUL */
static struct api_buffer encode(const struct test_table *table, const struct api_format *format) {
    struct api_buffer out;
    api_buffer_init(&out, 1000000);
    CHECK(!test_table_encode(table, format, 2, &out) && !api_buffer_add(&out, "", 1));
    CHECK((double)out.bytes <= format->bytes(&table->table));
    return out;
}

TEST(warnings_follow_the_stats_in_json) {
    static const char want[] =
        "\"horizon\":8.5,\"trust_until\":8.75},\"warnings\":[\"digits are lost: beyond t = 8.5 s\","
        "\"energy is lost\"]}";
    const struct api_format *const formats[] = {&api_format_json, &api_format_ndjson};
    OWN(test_table, clear) table = warned(3);
    for (int i = 0; i < 2; i++) {
        OWN(api_buffer, clear) out = encode(&table, formats[i]);
        CHECK_SAYING(strstr(out.data, want), "%s", out.data);
    }
}

TEST(warnings_are_comments_below_a_csv_table) {
    OWN(test_table, clear) table = warned(3);
    OWN(api_buffer, clear) out = encode(&table, &api_format_csv);
    const char *at = strchr(out.data, '#');
    REQUIRE(at && at[-1] == '\n');
    CHECK_TEXT(at, "# trust_until: 8.75\n# warning: digits are lost: beyond t = 8.5 s\n# warning: "
                   "energy is lost\n");
    api_buffer_clear(&out);
    test_table_clear(&table);
    table = test_table_new(3, 2);
    out = encode(&table, &api_format_csv);
    CHECK(!strchr(out.data, '#'));
}

TEST(warnings_come_back_from_what_is_kept_of_a_part) {
    OWN(test_table, clear) table = warned(3);
    OWN(api_buffer, clear) out = encode(&table, &api_format_raw);
    OWN_MEMORY struct api_raw_figures *figures = calloc(1, sizeof *figures);
    struct api_stats stats;
    REQUIRE(figures);
    for (char *at = out.data; at < out.data + out.bytes - 1;) {
        enum api_raw kind;
        size_t bytes;
        REQUIRE(api_raw_head(at, &kind, &bytes));
        // two parts with the same warning give one warning
        for (int i = 0; kind == API_RAW_STATS && i < 2; i++)
            CHECK(api_raw_add(figures, at + API_RAW_HEAD, bytes));
        at += API_RAW_HEAD + bytes;
    }
    api_raw_stats(figures, &stats);
    CHECK_INT(api_stats_warnings(&stats), 2);
    CHECK_INT(stats.count, table.stats.count);
    CHECK_TEXT(stats.stat[stats.count - 2].text, first);
    CHECK_TEXT(stats.stat[stats.count - 1].text, second);
}

TEST(fields_of_a_header_tell_figures_and_warnings) {
    OWN(test_table, clear) table = warned(1);
    struct api_stats_headers told;
    api_stats_fields(&told, &table.stats);
    REQUIRE(told.count == 4);
    static const char *const want[][2] = {{"X-Horizon", "8.5"},
                                          {"X-Trust-Until", "8.75"},
                                          {"X-Warning", first},
                                          {"X-Warning", second}};
    for (int i = 0; i < 4; i++) {
        CHECK_TEXT(told.field[i].name, want[i][0]);
        CHECK_TEXT(told.field[i].value, want[i][1]);
        CHECK(strstr(api_stats_field_names, want[i][0]));
    }
    api_stats_fields(&told, NULL);
    CHECK_INT(told.count, 0);
}
