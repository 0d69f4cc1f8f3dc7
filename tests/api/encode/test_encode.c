#include "api/encode/encode.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_in.h"
#include "tests/api/post.h"
#include "tests/api/table.h"
#include "tests/harness/test.h"

/* t, two columns of three arms, a name with two parts, one of single numbers */
static struct api_table table_of(long rows, int digits) {
    struct api_table table = {.rows = rows, .digits = digits};
    api_table_add(&table, "t", NULL, 0);
    api_table_add(&table, "phi", NULL, 3);
    api_table_add(&table, "z", "re", 2);
    api_table_add(&table, "z", "im", 2);
    api_table_add(&table, "energy", NULL, 0);
    return table;
}

/* writes the rows of the table in blocks of `cut`; data[c] has all rows */
static enum pend_status encode(const struct api_format *format, const struct api_table *table,
                               const double *const data[], long cut, const struct api_stats *stats,
                               struct api_buffer *out, struct pend_error *error) {
    struct api_writer *writer;
    PEND_TRY(api_writer_new(&writer, format, table, out));
    enum pend_status status = PEND_OK;
    for (long at = 0; at < table->rows && status == PEND_OK; at += cut) {
        const double *block[API_COLUMNS];
        for (int c = 0; c < table->count; c++) {
            int width = table->column[c].width;
            block[c] = data[c] + at * (width ? width : 1);
        }
        status = api_writer_block(writer, table->rows - at < cut ? table->rows - at : cut, block,
                                  out, error);
    }
    for (int done = 0; !done && status == PEND_OK;)
        status = api_writer_finish(writer, stats, out, &done);
    api_writer_free(&writer);
    if (status == PEND_OK) status = api_buffer_add(out, "", 1);
    return status;
}

static const double t[] = {0, 0.5}, phi[] = {1, -2.5, 1e-7, 4, 5, 1. / 3}, re[] = {1, 2, 3, 4},
                    im[] = {5, 6, 7, 8};
static const double energy[] = {-9.81, 1e300};
static const double *const data[] = {t, phi, re, im, energy};

TEST(a_table_becomes_one_object_of_arrays) {
    struct api_table table = table_of(2, 0);
    struct api_stats stats = {0};
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000);
    api_stats_text(&stats, "method", "taylor");
    api_stats_whole(&stats, "steps", 100000);
    api_stats_number(&stats, "drift", 2.5e-16);
    CHECK(!encode(&api_format_json, &table, data, 2, &stats, &out, NULL));
    CHECK_TEXT(out.data,
               "{\"t\":[0,0.5],\"phi\":[[1,-2.5,1e-7],[4,5,0.3333333333333333]],"
               "\"z\":{\"re\":[[1,2],[3,4]],\"im\":[[5,6],[7,8]]},\"energy\":[-9.81,1e300],"
               "\"stats\":{\"method\":\"taylor\",\"steps\":100000,\"drift\":2.5e-16}}");
}

TEST(a_single_row_stands_without_the_outer_array) {
    struct api_table table = table_of(1, 4);
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000);
    table.single = 1;
    CHECK(!encode(&api_format_json, &table, data, 1, NULL, &out, NULL));
    CHECK_TEXT(
        out.data,
        "{\"t\":0,\"phi\":[1,-2.5,1e-7],\"z\":{\"re\":[1,2],\"im\":[5,6]},\"energy\":-9.81}");
}

TEST(a_table_without_rows_has_empty_arrays) {
    struct api_table table = table_of(0, 0);
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000);
    CHECK(!encode(&api_format_json, &table, data, 1, NULL, &out, NULL));
    CHECK_TEXT(out.data, "{\"t\":[],\"phi\":[],\"z\":{\"re\":[],\"im\":[]},\"energy\":[]}");
}

TEST(csv_has_a_header_and_a_line_a_row) {
    struct api_table table = table_of(2, 3);
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 10000);
    CHECK(!encode(&api_format_csv, &table, data, 1, NULL, &out, NULL));
    CHECK_TEXT(out.data, "t,phi_1,phi_2,phi_3,z_re_1,z_re_2,z_im_1,z_im_2,energy\n"
                         "0,1,-2.5,1e-7,1,2,5,6,-9.81\n"
                         "0.5,4,5,0.333,3,4,7,8,1e300\n");
}

TEST(the_bytes_do_not_depend_on_the_blocks_and_stay_below_the_estimate) {
    enum { ROWS = 50 };
    unsigned long long seed = 11;
    double numbers[5][3 * ROWS];
    const double *columns[5];
    for (int c = 0; c < 5; c++) {
        for (int i = 0; i < 3 * ROWS; i++) numbers[c][i] = test_wild(&seed);
        columns[c] = numbers[c];
    }
    for (int digits = 0; digits <= 17; digits++)
        for (int f = 0; api_format_at(f); f++) {
            if (api_format_at(f)->picture) continue;
            struct api_table table = table_of(ROWS, digits);
            OWN(api_buffer, clear) whole, cut;
            api_buffer_init(&whole, 1000000);
            api_buffer_init(&cut, 1000000);
            CHECK(!encode(api_format_at(f), &table, columns, ROWS, NULL, &whole, NULL));
            CHECK(!encode(api_format_at(f), &table, columns, 7, NULL, &cut, NULL));
            const struct api_format *format = api_format_at(f);
            CHECK(cut.bytes == whole.bytes && !memcmp(cut.data, whole.data, whole.bytes));
            double bytes = (double)whole.bytes - 1, most = format->bytes(&table);
            CHECK_SAYING(format->exact ? bytes == most : bytes <= most,
                         "%.0f bytes of %s, estimated %.0f", bytes, format->media_type, most);
        }
}

TEST(every_double_reads_back_from_json_and_csv) {
    enum { ROWS = 300 };
    unsigned long long seed = 5;
    double numbers[3 * ROWS];
    const double *columns[] = {numbers};
    struct api_table table = {.rows = ROWS};
    OWN(api_buffer, clear) json, csv;
    OWN(api_json, free) *document = NULL;
    struct api_problem problem;
    int count = 0;
    for (int i = 0; i < 3 * ROWS; i++) numbers[i] = test_wild(&seed);
    numbers[0] = DBL_MAX, numbers[1] = DBL_MIN, numbers[2] = 0x1p-1074, numbers[3] = -0.0;
    api_table_add(&table, "x", NULL, 3);
    api_buffer_init(&json, 1000000);
    api_buffer_init(&csv, 1000000);
    api_problem_init(&problem);
    REQUIRE(!encode(&api_format_json, &table, columns, 64, NULL, &json, NULL));
    REQUIRE(!encode(&api_format_csv, &table, columns, 64, NULL, &csv, NULL));
    REQUIRE(!api_json_new(&document, json.data, json.bytes - 1, 9, &problem));
    struct api_value root = api_json_root(document), x = api_value_member(&root, "x"),
                     row = api_value_item(&x, 0);
    for (int i = 0; i < ROWS; i++, row = api_value_next(&row)) {
        const double *back = api_value_numbers(&row, &count);
        if (!CHECK(back && count == 3 && !memcmp(back, numbers + 3 * i, 3 * sizeof *back))) break;
    }
    char *at = strchr(csv.data, '\n') + 1;
    for (int i = 0; i < 3 * ROWS; i++, at++) {
        double back = strtod(at, &at);
        if (!CHECK_SAYING(!memcmp(&back, &numbers[i], sizeof back) &&
                              *at == (i % 3 == 2 ? '\n' : ','),
                          "number %d is %.17g, not %.17g", i, back, numbers[i]))
            break;
    }
}

TEST(a_number_that_is_not_finite_ends_a_table_by_its_place) {
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        struct api_table table = table_of(2, 0);
        struct pend_error error = {0};
        OWN(api_buffer, clear) out;
        double wrong[6];
        memcpy(wrong, phi, sizeof wrong);
        wrong[4] = bad[i];
        const double *columns[] = {t, wrong, re, im, energy};
        api_buffer_init(&out, 10000);
        CHECK_INT(encode(&api_format_json, &table, columns, 1, NULL, &out, &error),
                  PEND_NOT_FINITE);
        CHECK(strstr(error.text, "phi of arm 2 at t = 0.5 s"));
        CHECK_INT(error.arm, 1);
        table.column[0].name = "x";
        CHECK_INT(encode(&api_format_csv, &table, columns, 1, NULL, &out, &error), PEND_NOT_FINITE);
        CHECK(strstr(error.text, "phi of arm 2 in row 2"));
    }
}

TEST(a_table_beyond_the_buffers_limit_fails_cleanly) {
    for (int f = 0; api_format_at(f) && !api_format_at(f)->picture; f++)
        for (size_t limit = 0; limit < 400; limit += 7) {
            struct api_table table = table_of(2, 0);
            OWN(api_buffer, clear) out;
            api_buffer_init(&out, limit);
            enum pend_status status = encode(api_format_at(f), &table, data, 2, NULL, &out, NULL);
            CHECK(status == PEND_LIMIT || status == PEND_OK);
            CHECK(out.bytes <= limit);
        }
}

#define TWO "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"

/* an ensemble whose second member never turns over */
static struct test_reply flips(const char *more, const char *accept) {
    char body[400];
    snprintf(body, sizeof body,
             "{" TWO ",\"states\":[{\"theta\":[2,2.5]},{\"theta\":[1,0]}],\"duration\":20,"
             "\"observables\":[\"first_flip\"]%s}",
             more);
    return test_post_as(API_OP_ENSEMBLES, body, accept, NULL);
}

TEST(what_never_comes_is_nan_and_numbers_are_floats_where_that_is_asked_for) {
#define FORM ",\"number\":\"float32\",\"columns\":[\"member\",\"first_flip_time\"]"
    double full[2][4];
    float narrow[2][2];
    OWN(test_reply, free) plain = flips(",\"none\":\"nan\"", "application/octet-stream"),
                          asked = flips(FORM, "application/octet-stream"),
                          npz = flips(FORM, "application/x-npz"), json = flips(FORM, NULL);
    CHECK_INT((int)plain.out.bytes, 64);
    CHECK_INT((int)asked.out.bytes, 16);
    memcpy(full, plain.out.data, sizeof full);
    memcpy(narrow, asked.out.data, sizeof narrow);
    CHECK(isnan(full[1][2]) && isnan(narrow[1][1]));
    CHECK(narrow[0][0] == 0 && narrow[1][0] == 1 && narrow[0][1] == (float)full[0][2]);
    CHECK(npz.status == 200 && npz.out.bytes < 4000);
    CHECK(test_reply_count(&json, "/first_flip") == 1 && test_reply_count(&json, "/status") == -1);
    CHECK(test_reply_number(&json, "/first_flip/time/0") == full[0][2]);
}

TEST(floats_that_cannot_hold_a_number_and_columns_that_are_none_are_refused) {
    struct test_table table = test_table_new(2, 1);
    struct api_buffer out;
    table.table.float32 = 1;
    table.data[TEST_PHI][1] = 1e39;
    api_buffer_init(&out, 1 << 20);
    CHECK(test_table_encode(&table, &api_format_octets, 2, &out) == PEND_NOT_FINITE);
    CHECK(test_table_encode(&table, &api_format_npz, 2, &out) == PEND_NOT_FINITE);
    api_buffer_clear(&out);
    test_table_clear(&table);
    OWN(test_reply, free) reply = test_post_as(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"length\":[1],\"mass\":[1e100],\"parent\":[0]},\"times\":[0,1],"
        "\"number\":\"float32\"}",
        "application/octet-stream", NULL);
    CHECK_SAYING(reply.out.bytes && strstr(reply.out.data, "float64"), "%s", reply.out.data);
}
