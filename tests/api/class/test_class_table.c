#include "api/class/class_table.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

#define NOW INT64_C(1769851800125000)
#define NOW_TEXT "2026-01-31T09:30:00.125Z\r\n"

static struct api_class_item item(const char *name, const char *value) {
    return (struct api_class_item){name, 1, NOW, value, strlen(value)};
}

TEST(a_table_has_a_row_for_each_answer) {
    static const char *const items[][2] = {
        {"pupils/1", "{\"nickname\":\"Ada \\\"L\\\"\"}"},
        {"pupils/40", "{\"nickname\":\"=1+1\"}"},
        {"stages/class", "{\"frozen\":true}"},
        {"stages/1", "{\"state\":\"done\"}"},
        {"questions/q", "{\"kind\":\"number\",\"text\":\"How, long?\"}"},
        {"answers/q/1", "{\"value\":0.1}"},
        {"answers/q/40", "{\"value\":\"@SUM\\n\"}"},
        {"answers/q/2", ""},
        {"worksheets/w", "{\"title\":\"W\"}"},
        {"handins/w/1", "{\"answers\":[{\"step\":\"a\",\"value\":-2},{\"step\":\"b\",\"value\":"
                        "\"-\"}]}"},
    };
    OWN(api_class_names, clear) names = {0};
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1 << 16);
    CHECK_INT(api_class_table_begin(&names, &out), PEND_OK);
    for (size_t i = 0; i < sizeof items / sizeof *items; i++) {
        struct api_class_item at = item(items[i][0], items[i][1]);
        CHECK_INT(api_class_table_add(&at, &names, &out), PEND_OK);
    }
    CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
    CHECK_TEXT(out.data, "item,id,step,pupil,nickname,value,changed\r\n"
                         "stages,1,,1,\"Ada \"\"L\"\"\",\"done\"," NOW_TEXT
                         "questions,q,,,,\"How, long?\"," NOW_TEXT
                         "answers,q,,1,\"Ada \"\"L\"\"\",0.1," NOW_TEXT
                         "answers,q,,40,\"'=1+1\",\"'@SUM\n\"," NOW_TEXT
                         "handins,w,a,1,\"Ada \"\"L\"\"\",-2," NOW_TEXT
                         "handins,w,b,1,\"Ada \"\"L\"\"\",\"'-\"," NOW_TEXT);
    struct api_class_item damaged = item("answers/q/1", "{\"value\":");
    CHECK_INT(api_class_table_add(&damaged, &names, &out), PEND_INVALID);
}

/* a text as the cell of each kind of table */
static void check_cell(const char *text, const char *want) {
    char body[200], row[300];
    snprintf(body, sizeof body, "{\"value\":\"%s\"}", text);
    struct api_class_item at = item("answers/q/1", body);
    for (int sheet = API_CLASS_SHEET_PLAIN; sheet <= API_CLASS_SHEET_COMMA; sheet++) {
        struct api_class_names names = {.sheet = (enum api_class_sheet)sheet};
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 1 << 16);
        CHECK_INT(api_class_table_add(&at, &names, &out), PEND_OK);
        CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
        const char *part = sheet == API_CLASS_SHEET_COMMA ? ";" : ",";
        snprintf(row, sizeof row, "answers%sq%s%s1%s%s\"%s\"%s" NOW_TEXT, part, part, part, part,
                 part, want, part);
        CHECK_TEXT(out.data, row);
    }
}

TEST(no_text_is_a_formula_wherever_a_program_parts_cells) {
    check_cell("a;=1+1", "a;'=1+1");
    check_cell("a;b, c", "a;b, c");
    check_cell("a; \\\"=1", "a;' \"\"=1");
    check_cell("a\\t-2", "a\t'-2");
    check_cell("a,@x", "a,'@x");
    check_cell("a\\r\\n+1", "a\r\n'+1");
    check_cell("\\n=1", "'\n'=1");
    check_cell(" =1", "' =1");
    check_cell("\xef\xbc\x9d"
               "1",
               "'\xef\xbc\x9d"
               "1");
    check_cell("a;\xef\xbc\x8b"
               "1",
               "a;'\xef\xbc\x8b"
               "1");
    check_cell("1=2; 3-4", "1=2; 3-4");
}

TEST(a_table_for_spreadsheets_has_their_signs) {
    static const char *const begin[] = {"item,id,", "\xef\xbb\xbfitem,id,", "\xef\xbb\xbfitem;id;"},
                             *const row[] = {",,-0.25,2", ",,-0.25,2", ";;-0,25;2"};
    for (int sheet = API_CLASS_SHEET_PLAIN; sheet <= API_CLASS_SHEET_COMMA; sheet++) {
        struct api_class_names names = {.sheet = (enum api_class_sheet)sheet};
        struct api_class_item at = item("answers/q/1", "{\"value\":-0.25}");
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 1 << 16);
        CHECK_INT(api_class_table_begin(&names, &out), PEND_OK);
        CHECK(!strncmp(out.data, begin[sheet], strlen(begin[sheet])));
        CHECK_INT(api_class_table_add(&at, &names, &out), PEND_OK);
        CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
        CHECK_SAYING(strstr(out.data, row[sheet]) != NULL, "%s", out.data);
    }
}

/* the histogram of some answers */
static void check_tally(const char *const value[], int count, const char *text) {
    OWN(api_class_tally, clear) tally = {0};
    OWN(api_buffer, clear) out;
    char body[64];
    api_buffer_init(&out, 1 << 16);
    for (int i = 0; i < count; i++) {
        snprintf(body, sizeof body, "{\"value\":%s}", value[i]);
        struct api_class_item at = item("answers/q/1", body);
        CHECK_INT(api_class_tally_add(&at, &tally), PEND_OK);
    }
    CHECK_INT(api_class_tally_write(&tally, &out), PEND_OK);
    CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
    CHECK_TEXT(out.data, text);
}

TEST(a_histogram_counts_values) {
    static const char *const few[] = {"2", "1", "2.0", "3"}, *const words[] = {"\"b\"", "\"a\"",
                                                                               "\"b\""};
    check_tally(NULL, 0, "{\"answers\":0,\"values\":[],\"bins\":[]}");
    check_tally(few, 4,
                "{\"answers\":4,\"values\":[{\"value\":1,\"count\":1},{\"value\":2,\"count\":2},{"
                "\"value\":3,\"count\":1}],\"bins\":[]}");
    check_tally(words, 3,
                "{\"answers\":3,\"values\":[{\"value\":\"b\",\"count\":2},{\"value\":\"a\","
                "\"count\":1}],\"bins\":[]}");
}

/* 0, 1, ..., 120: ten in each bin, and the greatest in the last one */
TEST(a_histogram_of_many_numbers_has_twelve_bins) {
    OWN(api_class_tally, clear) tally = {0};
    OWN(api_buffer, clear) out;
    char body[64];
    int bins = 0;
    api_buffer_init(&out, 1 << 16);
    for (int i = 0; i <= 120; i++) {
        snprintf(body, sizeof body, "{\"value\":%d}", (i * 37) % 121);
        struct api_class_item at = item("answers/q/1", body);
        CHECK_INT(api_class_tally_add(&at, &tally), PEND_OK);
    }
    CHECK_INT(api_class_tally_write(&tally, &out), PEND_OK);
    CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
    for (const char *at = out.data; (at = strstr(at, "\"count\":10}")); at++) bins++;
    CHECK_INT(bins, 11);
    CHECK(strstr(out.data, "\"values\":[]") && strstr(out.data, "{\"from\":0,\"to\":10,"));
    CHECK(strstr(out.data, "\"to\":120,\"count\":11}]}"));
}
