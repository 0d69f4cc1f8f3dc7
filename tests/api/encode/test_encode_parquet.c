#include "api/encode/encode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/api/table.h"
#include "tests/harness/test.h"

/* a reader of Thrift's compact form that is independent of the writer: it reads structs and stores
 * the fields of some paths */
struct walk {
    const unsigned char *at, *end;
    int bad;
    long long rows, root_rows; /* of all groups together; as in the description */
    long columns, chunks;
    struct chunk {
        long long values, bytes, offset;
        int type;
    } chunk[200];
};

static unsigned long long varint(struct walk *walk) {
    unsigned long long x = 0;
    for (int shift = 0; shift < 64; shift += 7) {
        if (walk->at == walk->end) break;
        unsigned char byte = *walk->at++;
        x |= (unsigned long long)(byte & 0x7f) << shift;
        if (!(byte & 0x80)) return x;
    }
    walk->bad = 1;
    return 0;
}

static long long zigzag(struct walk *walk) {
    unsigned long long x = varint(walk);
    return (long long)(x >> 1) ^ -(long long)(x & 1);
}

/* stores a field of a path, such as "4.1.3.9" for a chunk's offset */
static void note(struct walk *walk, const char *path, long long x) {
    struct chunk *chunk = &walk->chunk[walk->chunks % 200];
    if (!strcmp(path, ".3")) walk->root_rows = x;
    if (!strcmp(path, ".4.3")) walk->rows += x;
    if (!strcmp(path, ".2.1")) walk->columns++;
    if (!strcmp(path, ".4.1.3.1")) chunk->type = (int)x;
    if (!strcmp(path, ".4.1.3.5")) chunk->values = x;
    if (!strcmp(path, ".4.1.3.7")) chunk->bytes = x;
    if (!strcmp(path, ".4.1.3.9")) chunk->offset = x, walk->chunks++;
}

static void walk_value(struct walk *walk, int type, const char *path);

static void walk_struct(struct walk *walk, const char *path) {
    int field = 0;
    while (!walk->bad && walk->at < walk->end && *walk->at) {
        char inner[64];
        int type = *walk->at & 15;
        field += *walk->at++ >> 4;
        if (snprintf(inner, sizeof inner, "%s.%d", path, field) < (int)sizeof inner)
            walk_value(walk, type, inner);
        else
            walk->bad = 1;
    }
    if (walk->at++ >= walk->end) walk->bad = 1;
}

static void walk_value(struct walk *walk, int type, const char *path) {
    if (type == 5 || type == 6) {
        note(walk, path, zigzag(walk));
    } else if (type == 8) {
        unsigned long long bytes = varint(walk);
        if (bytes > (unsigned long long)(walk->end - walk->at)) walk->bad = 1;
        if (!walk->bad) walk->at += bytes;
    } else if (type == 9) {
        unsigned char head = *walk->at++;
        unsigned long long count = head >> 4 == 15 ? varint(walk) : head >> 4;
        while (count-- && !walk->bad) walk_value(walk, head & 15, path);
    } else if (type == 12) {
        walk_struct(walk, path);
    } else {
        walk->bad = 1;
    }
}

/* reads the description at the end of a file */
static struct walk description(const struct api_buffer *out) {
    const unsigned char *data = (const unsigned char *)out->data, *tail = data + out->bytes - 8;
    struct walk walk = {.bad = 1};
    if (!CHECK(out->bytes > 12 && !memcmp(data, "PAR1", 4) && !memcmp(tail + 4, "PAR1", 4)))
        return walk;
    size_t length = tail[0] | (size_t)tail[1] << 8 | (size_t)tail[2] << 16 | (size_t)tail[3] << 24;
    if (!CHECK(length <= out->bytes - 12)) return walk;
    walk = (struct walk){.at = tail - length, .end = tail};
    walk_struct(&walk, "");
    CHECK(!walk.bad && walk.at == walk.end);
    return walk;
}

/* the numbers of a chunk's page, whose head gives its length */
static const char *page(const struct api_buffer *out, const struct chunk *chunk) {
    struct walk walk = {.at = (const unsigned char *)out->data + chunk->offset,
                        .end = (const unsigned char *)out->data + chunk->offset + chunk->bytes};
    walk_struct(&walk, "page");
    CHECK(!walk.bad);
    CHECK_INT(walk.end - walk.at, chunk->values * (chunk->type == 5 ? 8 : 4));
    return (const char *)walk.at;
}

TEST(parquet_has_every_number_in_its_column_however_its_rows_are_cut) {
    enum { ROWS = 12000, ARMS = 3, WIDTH = 1 + ARMS + 2 * ARMS + 2 };
    OWN(test_table, clear) table = test_table_new(ROWS, ARMS);
    OWN(api_buffer, clear) whole, cut;
    api_buffer_init(&whole, 1 << 24);
    api_buffer_init(&cut, 1 << 24);
    CHECK(test_table_encode(&table, &api_format_parquet, ROWS, &whole) == PEND_OK);
    CHECK(test_table_encode(&table, &api_format_parquet, 7, &cut) == PEND_OK);
    CHECK(whole.bytes == cut.bytes && !memcmp(whole.data, cut.data, whole.bytes));
    CHECK((double)whole.bytes <= api_format_parquet.bytes(&table.table));
    struct walk walk = description(&whole);
    CHECK_INT(walk.root_rows, ROWS);
    CHECK_INT(walk.rows, ROWS);
    CHECK_INT(walk.columns, WIDTH);
    CHECK(walk.chunks > WIDTH && walk.chunks % WIDTH == 0);
    long row = 0;
    for (long c = 0; c < walk.chunks; c++) {
        const struct chunk *chunk = &walk.chunk[c];
        long k = c % WIDTH, wrong = 0;
        const char *at = page(&whole, chunk);
        int column = k < 1              ? TEST_T
                     : k < 1 + ARMS     ? TEST_PHI
                     : k < 1 + 2 * ARMS ? TEST_RE
                     : k < 1 + 3 * ARMS ? TEST_IM
                                        : TEST_KINETIC + (int)(k - 1 - 3 * ARMS);
        long width = k >= 1 && k < 1 + 3 * ARMS ? ARMS : 1, arm = width > 1 ? (k - 1) % ARMS : 0;
        for (long i = 0; i < chunk->values; i++)
            wrong += memcmp(at + 8 * i, &table.data[column][(row + i) * width + arm], 8) != 0;
        CHECK_INT(wrong, 0);
        if (k == WIDTH - 1) row += chunk->values;
    }
    CHECK_INT(row, ROWS);
}

TEST(parquet_of_no_rows_of_floats_and_of_rows_wider_than_a_group_is_read) {
    static const struct {
        long rows;
        int arms, floats;
    } cases[] = {{0, 2, 0}, {3, 2, 1}, {2, 30000, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        OWN(test_table, clear) table = test_table_new(cases[i].rows, cases[i].arms);
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 1 << 26);
        table.table.float32 = cases[i].floats;
        for (int c = 0; c < TEST_COLUMNS; c++)
            for (long k = 0; k < cases[i].rows * (cases[i].floats ? 1 : 0); k++)
                for (int arm = 0; arm < (table.table.column[c].width ? 2 : 1); arm++)
                    table.data[c][k * (table.table.column[c].width ? 2 : 1) + arm] =
                        0.1 * (double)k;
        CHECK(test_table_encode(&table, &api_format_parquet, 100, &out) == PEND_OK);
        struct walk walk = description(&out);
        CHECK_INT(walk.rows, cases[i].rows);
        CHECK_INT(walk.columns, (long)api_table_numbers(&table.table, 0));
        if (cases[i].floats) {
            // t stays a double
            float third;
            CHECK(walk.chunk[0].type == 5 && walk.chunk[1].type == 4);
            memcpy(&third, page(&out, &walk.chunk[1]) + 8, 4);
            CHECK(third == 0.2f);
        }
    }
}

TEST(parquet_of_an_ensemble_has_nan_where_that_is_asked_for) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_ENSEMBLES,
        "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"states\":[{\"theta\":["
        "2,2.5]},{\"theta\":[1,0]}],\"duration\":20,\"observables\":[\"first_flip\"],\"none\":"
        "\"nan\",\"columns\":[\"first_flip_time\"]}",
        "application/vnd.apache.parquet", NULL);
    CHECK_INT(reply.status, 200);
    struct walk walk = description(&reply.out);
    double time[2];
    CHECK_INT(walk.chunks, 1);
    memcpy(time, page(&reply.out, &walk.chunk[0]), sizeof time);
    CHECK(time[0] > 4 && time[0] < 5 && isnan(time[1]));
}

/* the first start has more potential energy than the members may have: it fails */
TEST(parquet_has_nan_for_a_member_that_failed) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_ENSEMBLES,
        "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"states\":[{\"theta\":["
        "3,3],\"thetad\":[1,0]},{\"theta\":[0.1,0],\"thetad\":[1,0]}],\"energy\":-20,\"duration\":"
        "1,\"observables\":[\"lyapunov\",\"final\"],\"columns\":[\"status\",\"lyapunov\",\"final_"
        "phi\"]}",
        "application/vnd.apache.parquet", NULL);
    CHECK_INT(reply.status, 200);
    struct walk walk = description(&reply.out);
    CHECK_INT(walk.chunks, 4);
    for (int i = 0; i < walk.chunks; i++) {
        double member[2];
        memcpy(member, page(&reply.out, &walk.chunk[i]), sizeof member);
        CHECK(i ? isnan(member[0]) : member[0] == 1);
        CHECK(i ? isfinite(member[1]) && member[1] != 0 : member[1] == 0);
    }
}
