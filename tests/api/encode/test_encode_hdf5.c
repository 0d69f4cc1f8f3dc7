#include "api/encode/encode.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/hdf5.h"
#include "tests/api/table.h"
#include "tests/harness/test.h"

/* What the tools of the HDF Group and h5py read is tested in tests/rules/readback; this tests the
 * addresses, which a short reader follows. */

static uint64_t whole(const char *at, int bytes) {
    uint64_t x = 0;
    while (bytes--) x = x << 8 | (unsigned char)at[bytes];
    return x;
}

/* the body of the first message of a kind at or after `from`; NULL if there is none */
static const char *message(const char *head, int kind, const char *from) {
    const char *end = head + 10 + whole(head + 6, 4);
    for (const char *at = from ? from : head + 10; at < end; at += 4 + whole(at + 1, 2))
        if (at[0] == kind) return at + 4;
    return NULL;
}

/* the header of the array of a name */
static const char *array(const struct api_buffer *file, const char *name) {
    const char *root = file->data + whole(file->data + 36, 8), *link = NULL;
    if (!CHECK(!memcmp(root, "OHDR", 4))) return NULL;
    while ((link = message(root, 6, link ? link + whole(link - 3, 2) : NULL)) != NULL)
        if (whole(link + 2, 1) == strlen(name) && !memcmp(link + 3, name, strlen(name)))
            return file->data + whole(link + 3 + strlen(name), 8);
    CHECK_SAYING(0, "no %s", name);
    return NULL;
}

/* the start of piece i of an array, by its tree */
static const char *piece(const struct api_buffer *file, const char *layout, uint64_t i, int axes) {
    size_t key = 8 + 8 * ((size_t)axes + 1);
    uint64_t rows = whole(layout + 11, 4);
    const char *node = file->data + whole(layout + 3, 8);
    for (;;) {
        uint64_t used = whole(node + 6, 2), k = 0;
        if (!CHECK(!memcmp(node, "TREE\1", 5) && used >= 1 && used <= 64)) return NULL;
        while (k + 1 < used && whole(node + 24 + (k + 1) * (key + 8) + 8, 8) <= i * rows) k++;
        // the keys on both sides
        const char *entry = node + 24 + k * (key + 8);
        CHECK(whole(entry + 8, 8) <= i * rows && whole(entry + key + 8 + 8, 8) > i * rows);
        const char *at = file->data + whole(entry + key, 8);
        if (!node[5]) return at;
        node = at;
    }
}

static struct api_buffer encoded(const struct test_table *table, long cut) {
    struct api_buffer out;
    api_buffer_init(&out, (size_t)1 << 28);
    CHECK(test_table_encode(table, &api_format_hdf5, cut, &out) == PEND_OK);
    CHECK_INT((long long)out.bytes, (long long)api_format_hdf5.bytes(&table->table));
    CHECK(!memcmp(out.data, "\x89HDF\r\n\x1a\n\2\x8\x8", 12));
    CHECK_INT((long long)whole(out.data + 28, 8), (long long)out.bytes);
    return out;
}

TEST(hdf5_of_few_rows_has_each_array_in_one_place) {
    enum { ROWS = 300, ARMS = 2 };
    OWN(test_table, clear) table = test_table_new(ROWS, ARMS);
    OWN(api_buffer, clear) out = encoded(&table, 64);
    const char *phi = array(&out, "phi"), *im = array(&out, "z_im");
    REQUIRE(phi && im && array(&out, "energy_total"));
    const char *space = message(phi, 1, NULL), *layout = message(phi, 8, NULL);
    REQUIRE(space && layout);
    CHECK(whole(space, 4) == 0x01000202 && whole(space + 4, 8) == ROWS);
    CHECK(whole(space + 12, 8) == ARMS && whole(layout, 2) == 0x103);
    CHECK_INT((long long)whole(layout + 10, 8), ROWS * ARMS * 8);
    CHECK(!memcmp(out.data + whole(layout + 2, 8), table.data[TEST_PHI], ROWS * ARMS * 8));
    const char *type = message(im, 3, NULL), *parts = message(im, 8, NULL);
    REQUIRE(type && parts && whole(type, 4) == 0x3f2011 && whole(type + 4, 4) == 8);
    CHECK(!memcmp(out.data + whole(parts + 2, 8), table.data[TEST_IM], ROWS * ARMS * 8));
}

TEST(hdf5_of_many_rows_has_pieces_that_its_trees_find_however_the_rows_are_cut) {
    // a row of 3 + 3 * 3000 numbers, seven of which are a piece: more pieces than a node holds
    enum { ROWS = 701, ARMS = 3000 };
    OWN(test_table, clear) table = test_table_new(ROWS, ARMS);
    OWN(api_buffer, clear) out = encoded(&table, ROWS), cut = encoded(&table, 3);
    CHECK(out.bytes == cut.bytes && !memcmp(out.data, cut.data, out.bytes));
    const char *phi = array(&out, "phi"), *t = array(&out, "t");
    REQUIRE(phi && t);
    const char *wide = message(phi, 8, NULL), *narrow = message(t, 8, NULL);
    REQUIRE(wide && narrow && whole(wide, 3) == 0x30203 && whole(narrow, 3) == 0x20203);
    uint64_t rows = whole(wide + 11, 4);
    CHECK(rows == whole(narrow + 11, 4) && rows >= 2 && ROWS / rows > 64 && ROWS % rows);
    CHECK(whole(wide + 15, 4) == ARMS && whole(wide + 19, 4) == 8 && whole(narrow + 15, 4) == 8);
    for (uint64_t row = 0; row < ROWS; row++) {
        const char *at = piece(&out, wide, row / rows, 2),
                   *time = piece(&out, narrow, row / rows, 1);
        REQUIRE(at && time);
        at += row % rows * ARMS * 8;
        CHECK(!memcmp(at, &table.data[TEST_PHI][row * ARMS], ARMS * 8));
        CHECK(!memcmp(time + row % rows * 8, &table.data[TEST_T][row], 8));
    }
}

TEST(hdf5_of_a_row_wider_than_a_piece_has_a_piece_a_row) {
    enum { ROWS = 3, ARMS = 30000 };
    OWN(test_table, clear) table = test_table_new(ROWS, ARMS);
    OWN(api_buffer, clear) out = encoded(&table, 2);
    const char *phi = array(&out, "phi");
    const char *layout = phi ? message(phi, 8, NULL) : NULL;
    REQUIRE(layout && whole(layout + 11, 4) == 1);
    for (uint64_t row = 0; row < ROWS; row++) {
        const char *at = piece(&out, layout, row, 2);
        CHECK(at && !memcmp(at, &table.data[TEST_PHI][row * ARMS], ARMS * 8));
    }
}

TEST(hdf5_has_figures_as_attributes_of_its_root) {
    OWN(test_table, clear) table = test_table_new(2, 1);
    OWN(api_buffer, clear) out = encoded(&table, 1);
    const char *root = out.data + whole(out.data + 36, 8), *at = NULL;
    int found = 0;
    while ((at = message(root, 12, at ? at + whole(at - 3, 2) : NULL)) != NULL) {
        const char *value = at + 9 + whole(at + 2, 2) + whole(at + 4, 2) + whole(at + 6, 2);
        if (!strcmp(at + 9, "method")) found += !strcmp(value, "taylor");
        if (!strcmp(at + 9, "steps")) found += whole(value, 8) == 100000;
        double drift = 2.5e-16;
        if (!strcmp(at + 9, "drift")) found += !memcmp(value, &drift, 8);
    }
    CHECK_INT(found, 3);
}

TEST(a_tree_of_pieces_has_as_many_nodes_as_its_levels_take) {
    CHECK(api_hdf5_nodes(0) == 0 && api_hdf5_nodes(1) == 1 && api_hdf5_nodes(64) == 1);
    CHECK(api_hdf5_nodes(65) == 3 && api_hdf5_nodes(4096) == 65 && api_hdf5_nodes(4097) == 68);
}

TEST(pieces_beyond_three_levels_of_a_tree_are_found) {
    // 4100 pieces of 10 rows each: 65 leaves, two nodes above them, one root
    const struct api_hdf5_array facts = {
        .type = API_HDF5_DOUBLE, .axes = 1, .length = {40995}, .piece = 10};
    size_t bytes = api_hdf5_node_bytes(1);
    uint64_t nodes = api_hdf5_nodes(4100);
    REQUIRE(nodes == 68);
    OWN_MEMORY char *tree = calloc(nodes, bytes);
    REQUIRE(tree != NULL);
    for (uint64_t i = 0; i < nodes; i++) api_hdf5_node(tree + i * bytes, &facts, i, 0, 48, 80);
    for (uint64_t i = 0; i < 4100; i++) {
        const char *node = tree + (nodes - 1) * bytes;
        CHECK_INT(node[5], 2);
        for (int level = 2; level > 0; level--) {
            uint64_t k = i / (level == 2 ? 4096 : 64) % 64;
            CHECK(k < whole(node + 6, 2) && whole(node + 24 + 32 * k + 8, 8) % 640 == 0);
            node = tree + whole(node + 24 + 32 * k + 24, 8);
            CHECK_INT(node[5], level - 1);
        }
        CHECK(whole(node + 24 + 32 * (i % 64) + 8, 8) == i * 10);
        CHECK(whole(node + 24 + 32 * (i % 64) + 24, 8) == 48 + 80 * i);
    }
}
