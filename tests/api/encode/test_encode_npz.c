#include "api/encode/encode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/table.h"
#include "tests/harness/test.h"

static unsigned long whole(const char *at, int bytes) {
    unsigned long x = 0;
    while (bytes--) x = x << 8 | (unsigned char)at[bytes];
    return x;
}

/* the checksum of zip, a bit at a time */
static unsigned long crc(const char *at, size_t bytes) {
    unsigned long sum = 0xffffffff;
    for (size_t i = 0; i < bytes; i++) {
        sum ^= (unsigned char)at[i];
        for (int bit = 0; bit < 8; bit++) sum = sum >> 1 ^ (sum & 1 ? 0xedb88320 : 0);
    }
    return sum ^ 0xffffffff;
}

/* a member of an archive */
struct found {
    const char *data;
    size_t bytes;
};

/* finds a member by the directory, and checks both of its headers and its checksum */
static struct found member(const struct api_buffer *zip, const char *name) {
    const char *end = zip->data + zip->bytes - 22;
    struct found none = {NULL, 0};
    if (!CHECK(zip->bytes > 22 && !memcmp(end, "PK\5\6", 4))) return none;
    unsigned long count = whole(end + 10, 2), size = whole(end + 12, 4),
                  offset = whole(end + 16, 4);
    if (!CHECK_INT((long long)(offset + size + 22), (long long)zip->bytes)) return none;
    const char *entry = zip->data + offset;
    for (unsigned long i = 0; i < count; i++, entry += 46 + whole(entry + 28, 2)) {
        size_t length = whole(entry + 28, 2);
        CHECK(!memcmp(entry, "PK\1\2", 4));
        if (length != strlen(name) || memcmp(entry + 46, name, length)) continue;
        const char *local = zip->data + whole(entry + 42, 4);
        struct found found = {local + 30 + length, whole(entry + 24, 4)};
        CHECK(!memcmp(local, "PK\3\4", 4) && !memcmp(local + 4, entry + 6, 26) &&
              !memcmp(local + 30, name, length));
        CHECK_INT((long long)whole(entry + 10, 2), 0); /* stored */
        CHECK_INT((long long)whole(entry + 20, 4), (long long)found.bytes);
        CHECK_INT((long long)whole(entry + 16, 4), (long long)crc(found.data, found.bytes));
        return found;
    }
    return none;
}

/* checks the description of a member and returns its data */
static const char *array(const struct api_buffer *zip, const char *name, const char *description,
                         size_t bytes) {
    struct found found = member(zip, name);
    if (!CHECK_SAYING(found.data != NULL, "no %s", name)) return NULL;
    size_t head = 10 + whole(found.data + 8, 2);
    CHECK(!memcmp(found.data, "\x93NUMPY\1\0", 8));
    CHECK_INT((long long)(head % 64), 0);
    CHECK_SAYING(!memcmp(found.data + 10, description, strlen(description)), "%s: %.60s", name,
                 found.data + 10);
    CHECK(found.data[head - 1] == '\n');
    CHECK_INT((long long)(found.bytes - head), (long long)bytes);
    return found.data + head;
}

TEST(npz_holds_every_array_under_its_name) {
    OWN(test_table, clear) table = test_table_new(300, 2);
    OWN(api_buffer, clear) zip;
    api_buffer_init(&zip, 10000000);
    REQUIRE(!test_table_encode(&table, &api_format_npz, 64, &zip));
    const char *t = array(&zip, "t.npy",
                          "{'descr': '<f8', 'fortran_order': False, 'shape': (300,), }", 300 * 8);
    const char *phi = array(
        &zip, "phi.npy", "{'descr': '<f8', 'fortran_order': False, 'shape': (300, 2), }", 600 * 8);
    const char *z = array(
        &zip, "z.npy", "{'descr': '<c16', 'fortran_order': False, 'shape': (300, 2), }", 600 * 16);
    const char *kinetic =
        array(&zip, "energy_kinetic.npy",
              "{'descr': '<f8', 'fortran_order': False, 'shape': (300,), }", 300 * 8);
    REQUIRE(t && phi && z && kinetic);
    CHECK(!memcmp(t, table.data[TEST_T], 300 * 8));
    CHECK(!memcmp(phi, table.data[TEST_PHI], 600 * 8));
    CHECK(!memcmp(kinetic, table.data[TEST_KINETIC], 300 * 8));
    for (int i = 0; i < 600; i++) {
        CHECK(!memcmp(z + 16 * i, &table.data[TEST_RE][i], 8));
        CHECK(!memcmp(z + 16 * i + 8, &table.data[TEST_IM][i], 8));
    }
    CHECK(!member(&zip, "re.npy").data && !member(&zip, "z_re.npy").data);
}

TEST(npz_tells_the_statistics_as_arrays_without_an_axis) {
    OWN(test_table, clear) table = test_table_new(2, 1);
    OWN(api_buffer, clear) zip;
    double drift;
    api_buffer_init(&zip, 1000000);
    REQUIRE(!test_table_encode(&table, &api_format_npz, 1, &zip));
    const char *method = array(&zip, "stats_method.npy",
                               "{'descr': '<U6', 'fortran_order': False, 'shape': (), }", 24);
    const char *steps = array(&zip, "stats_steps.npy",
                              "{'descr': '<i8', 'fortran_order': False, 'shape': (), }", 8);
    const char *size = array(&zip, "stats_drift.npy",
                             "{'descr': '<f8', 'fortran_order': False, 'shape': (), }", 8);
    REQUIRE(method && steps && size);
    CHECK(!memcmp(method, "t\0\0\0a\0\0\0y\0\0\0l\0\0\0o\0\0\0r\0\0\0", 24));
    CHECK_INT((long long)whole(steps, 8), 100000);
    memcpy(&drift, size, 8);
    CHECK(drift == 2.5e-16);
}

TEST(npz_of_a_single_row_has_no_axis_for_rows) {
    OWN(test_table, clear) table = test_table_new(1, 3);
    OWN(api_buffer, clear) zip;
    api_buffer_init(&zip, 1000000);
    table.table.single = 1;
    REQUIRE(!test_table_encode(&table, &api_format_npz, 1, &zip));
    CHECK(array(&zip, "t.npy", "{'descr': '<f8', 'fortran_order': False, 'shape': (), }", 8));
    CHECK(array(&zip, "z.npy", "{'descr': '<c16', 'fortran_order': False, 'shape': (3,), }", 48));
}

/* encodes in turns of at most `most` bytes, or from memory; returns the number of passes over the
 * rows */
static int encode_turns(const struct test_table *table, int turns, double most, long cut,
                        struct api_buffer *zip) {
    OWN(api_writer, free) *writer;
    int done = 0, passed = 1;
    if (!CHECK(api_writer_new(&writer, &api_format_npz, &table->table, zip) == PEND_OK)) return 0;
    writer->most = most;
    if (turns) {
        free(writer->kept);
        writer->kept = NULL;
        writer->turns = 1;
    }
    enum pend_status status = PEND_OK;
    while (status == PEND_OK && !done) {
        for (long at = 0; at < table->table.rows && status == PEND_OK; at += cut) {
            const double *data[TEST_COLUMNS];
            long rows = table->table.rows - at < cut ? table->table.rows - at : cut;
            for (int c = 0; c < TEST_COLUMNS; c++)
                data[c] = table->data[c] + at * api_column_numbers(&table->table.column[c]);
            status = api_writer_block(writer, rows, data, zip, NULL);
        }
        while (status == PEND_OK && !done && !writer->again)
            status = api_writer_finish(writer, &table->stats, zip, &done);
        if (status == PEND_OK && !done) {
            api_writer_again(writer);
            passed++;
        }
    }
    CHECK(status == PEND_OK);
    return passed;
}

TEST(npz_in_turns_has_the_bytes_that_it_has_from_memory) {
    enum { ROWS = 3000, ARMS = 3 };
    OWN(test_table, clear) table = test_table_new(ROWS, ARMS);
    /* bytes that are stored: none, an array of one number per row, two of these, all */
    const double most[] = {0, 8 * ROWS, 8 * ROWS * (ARMS + 2), 8 * ROWS * (3 * ARMS + 3) - 1};
    const int turns[] = {5, 4, 2, 1};
    for (int nan = 0; nan < 2; nan++) {
        table.table.float32 = 0;
        table.table.column[TEST_PHI].sparse = nan;
        for (size_t i = 0; i < sizeof most / sizeof *most; i++) {
            OWN(api_buffer, clear) kept, turned;
            api_buffer_init(&kept, 10000000);
            api_buffer_init(&turned, 10000000);
            CHECK_INT(encode_turns(&table, 0, most[i], 100, &kept), 1);
            CHECK_INT(encode_turns(&table, 1, most[i], 77, &turned), turns[i]);
            CHECK_INT((long long)turned.bytes, (long long)kept.bytes);
            CHECK(turned.bytes == kept.bytes && !memcmp(turned.data, kept.data, kept.bytes));
            /* checksums follow the arrays: the flag, and the two that are equal */
            const char *local = turned.data;
            CHECK_INT((long long)whole(local + 6, 2), 8);
            size_t from = 30 + 5 + 20, bytes = 128 + 8 * ROWS;
            CHECK(whole(local + 14, 4) == 0 && whole(local + from + bytes, 4) == 0x08074b50);
            CHECK(whole(local + from + bytes + 4, 4) == crc(local + from, bytes));
        }
    }
}

TEST(only_tables_whose_rows_are_many_and_known_have_turns) {
    OWN(test_table, clear) table = test_table_new(10, 3);
    CHECK(!api_format_turns(&api_format_npz, &table.table));
    table.table.rows = 1 << 21;
    CHECK(api_format_turns(&api_format_npz, &table.table));
    CHECK(!api_format_turns(&api_format_mat, &table.table));
    table.table.rows_later = 1;
    CHECK(!api_format_turns(&api_format_npz, &table.table));
    table.table.rows = 10;
}
