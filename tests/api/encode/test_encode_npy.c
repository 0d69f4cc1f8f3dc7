#include "api/encode/encode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/api/table.h"
#include "tests/harness/test.h"

#define TWO "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"

/* the rows behind the head, whose description and length are checked */
static const char *records(const struct api_buffer *out, const char *description, size_t bytes) {
    const unsigned char *head = (const unsigned char *)out->data;
    size_t length = head[8] + 256u * head[9], begin = 12 + length;
    CHECK(out->bytes > 128 && !memcmp(head, "\x93NUMPY\x02\0", 8) && !head[10] && !head[11]);
    CHECK(begin % 64 == 0 && out->data[begin - 1] == '\n');
    CHECK_SAYING(strstr(out->data + 12, description) == out->data + 12, "%.*s", (int)length,
                 out->data + 12);
    CHECK_INT((long long)(out->bytes - begin), (long long)bytes);
    return out->data + begin;
}

TEST(npy_is_one_array_of_records_however_its_rows_are_cut) {
    enum { ROWS = 700, ARMS = 3 };
    struct test_table table = test_table_new(ROWS, ARMS);
    struct api_buffer whole, cut;
    size_t row = 8 * (1 + ARMS + 2 * ARMS + 2);
    api_buffer_init(&whole, 1 << 24);
    api_buffer_init(&cut, 1 << 24);
    CHECK(test_table_encode(&table, &api_format_npy, ROWS, &whole) == PEND_OK);
    CHECK(test_table_encode(&table, &api_format_npy, 7, &cut) == PEND_OK);
    CHECK(whole.bytes == cut.bytes && !memcmp(whole.data, cut.data, whole.bytes));
    CHECK_INT((long long)whole.bytes, (long long)api_format_npy.bytes(&table.table));
    const char *at =
        records(&whole,
                "{'descr': [('t', '<f8'), ('phi', '<f8', (3,)), ('z', '<c16', (3,)), "
                "('energy_kinetic', '<f8'), ('energy_total', '<f8')], 'fortran_order': False, "
                "'shape': (700,), }",
                ROWS * row);
    // the third arm's place in the last row
    at += (ROWS - 1) * row + 8 + ARMS * 8 + 2 * 16;
    CHECK(!memcmp(at, &table.data[TEST_RE][ROWS * ARMS - 1], 8) &&
          !memcmp(at + 8, &table.data[TEST_IM][ROWS * ARMS - 1], 8));
    api_buffer_clear(&whole);
    api_buffer_clear(&cut);
    test_table_clear(&table);
}

TEST(npy_says_how_many_rows_there_are_where_that_is_known_at_the_end) {
    const char *body =
        "{" TWO ",\"initial\":{\"theta\":[1,2]},\"duration\":8,\"section\":{\"arm\":1,"
        "\"theta\":0}}";
    struct test_reply npy = test_post_as(API_OP_SECTIONS, body, "application/x-npy", NULL),
                      octets =
                          test_post_as(API_OP_SECTIONS, body, "application/octet-stream", NULL);
    CHECK_INT(npy.status, 200);
    CHECK(octets.out.bytes > 100);
    char shape[40];
    snprintf(shape, sizeof shape, "'shape': (%zu,), }", octets.out.bytes / (8 * 6));
    CHECK_SAYING(strstr(npy.out.data + 12, shape) != NULL, "%.200s", npy.out.data + 12);
    CHECK(!memcmp(npy.out.data + npy.out.bytes - octets.out.bytes, octets.out.data,
                  octets.out.bytes));
    test_reply_free(&npy);
    test_reply_free(&octets);
}

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
#define FORM ",\"number\":\"float32\",\"none\":\"nan\",\"columns\":[\"member\",\"first_flip_time\"]"
    double full[2][4];
    float narrow[2][2];
    struct test_reply plain = flips("", "application/octet-stream"),
                      asked = flips(FORM, "application/octet-stream"),
                      npy = flips(FORM, "application/x-npy"),
                      npz = flips(FORM, "application/x-npz"), json = flips(FORM, NULL);
    CHECK_INT((int)plain.out.bytes, 64);
    CHECK_INT((int)asked.out.bytes, 16);
    memcpy(full, plain.out.data, sizeof full);
    memcpy(narrow, asked.out.data, sizeof narrow);
    CHECK(full[1][2] == -1 && isnan(narrow[1][1]));
    CHECK(narrow[0][0] == 0 && narrow[1][0] == 1 && narrow[0][1] == (float)full[0][2]);
    const char *at =
        records(&npy.out, "{'descr': [('member', '<f8'), ('first_flip_time', '<f4')]", 24);
    CHECK(!memcmp(at + 8, &narrow[0][1], 4) && isnan(*(float *)memcpy(&narrow[0][0], at + 20, 4)));
    CHECK(npz.status == 200 && npz.out.bytes < 4000);
    CHECK(test_reply_count(&json, "/first_flip") == 1 && test_reply_count(&json, "/status") == -1);
    CHECK(test_reply_number(&json, "/first_flip/time/0") == full[0][2]);
    test_reply_free(&plain);
    test_reply_free(&asked);
    test_reply_free(&npy);
    test_reply_free(&npz);
    test_reply_free(&json);
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
    struct test_reply reply = test_post_as(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"length\":[1],\"mass\":[1e100],\"parent\":[0]},\"times\":[0,1],"
        "\"number\":\"float32\"}",
        "application/octet-stream", NULL);
    CHECK_SAYING(reply.out.bytes && strstr(reply.out.data, "float64"), "%s", reply.out.data);
    test_reply_free(&reply);
#define ENSEMBLE "{" TWO ",\"states\":[{}],\"duration\":1,"
    CHECK_REFUSED(API_OP_ENSEMBLES, ENSEMBLE "\"columns\":[\"final_ph\"]}", "/columns/0",
                  "has member,status,final_phi[2],final_phid[2]");
    CHECK_REFUSED(API_OP_ENSEMBLES, ENSEMBLE "\"columns\":[]}", "/columns", "at least one");
    CHECK_REFUSED(API_OP_ENSEMBLES, ENSEMBLE "\"columns\":[3]}", "/columns/0", "is no column");
    CHECK_REFUSED(API_OP_ENSEMBLES, ENSEMBLE "\"number\":\"float16\"}", "/number", "float64");
    CHECK_REFUSED(API_OP_ENSEMBLES, ENSEMBLE "\"none\":0}", "/none", "must be");
}
