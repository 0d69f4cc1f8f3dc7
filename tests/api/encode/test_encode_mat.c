#include "api/encode/encode.h"

#include <string.h>

#include "tests/api/table.h"
#include "tests/harness/test.h"

static unsigned long whole(const char *at, int bytes) {
    unsigned long x = 0;
    while (bytes--) x = x << 8 | (unsigned char)at[bytes];
    return x;
}

/* an element of a MAT-file: the data after its tag, and the start of the next one */
struct element {
    unsigned long type;
    size_t bytes;
    const char *data, *next;
};

static struct element element_at(const char *at) {
    unsigned long type = whole(at, 4), bytes = whole(at + 4, 4);
    if (type >> 16) return (struct element){type & 0xffff, type >> 16, at + 4, at + 8};
    return (struct element){type, bytes, at + 8, at + 8 + (bytes + 7) / 8 * 8};
}

/* a parsed matrix */
struct matrix {
    unsigned long flags;
    long rows, columns;
    char name[32];
    const char *rest, *end; /* the parts, or the fields of a structure */
};

static int matrix_read(const char *at, struct matrix *matrix) {
    struct element whole_one = element_at(at), flags = element_at(whole_one.data),
                   size = element_at(flags.next), name = element_at(size.next);
    if (whole_one.type != 14 || flags.type != 6 || flags.bytes != 8 || size.type != 5 ||
        size.bytes != 8 || name.type != 1 || name.bytes >= sizeof matrix->name)
        return 0;
    *matrix = (struct matrix){whole(flags.data, 4),
                              (long)whole(size.data, 4),
                              (long)whole(size.data + 4, 4),
                              "",
                              name.next,
                              whole_one.next};
    memcpy(matrix->name, name.data, name.bytes);
    return 1;
}

/* the variable of a name; the file must consist of matrices to its end */
static int variable(const struct api_buffer *mat, const char *name, struct matrix *found) {
    const char *at = mat->data + 128, *end = mat->data + mat->bytes;
    struct matrix matrix;
    int there = 0;
    while (at < end && CHECK(matrix_read(at, &matrix))) {
        at = matrix.end;
        if (strcmp(matrix.name, name)) continue;
        *found = matrix;
        there++;
    }
    return CHECK(at == end) && CHECK_INT(there, 1);
}

/* the numbers of one part, arm by arm, against those of a column, row by row; returns what
 * follows */
static const char *check_part(const struct matrix *matrix, const char *at, const double column[]) {
    struct element part = element_at(at);
    CHECK_INT((long long)part.type, 9);
    CHECK_INT((long long)part.bytes, 8 * matrix->rows * matrix->columns);
    int same = 1;
    for (long i = 0; i < matrix->rows; i++)
        for (long k = 0; k < matrix->columns; k++)
            same &= !memcmp(part.data + 8 * (k * matrix->rows + i),
                            &column[i * matrix->columns + k], 8);
    CHECK(same);
    return part.next;
}

/* field `name` of a structure */
static int field(const struct matrix *matrix, const char *name, struct matrix *found) {
    struct element width = element_at(matrix->rest), names = element_at(width.next);
    const char *at = names.next;
    CHECK_INT((long long)matrix->flags, 2);
    CHECK_INT((long long)whole(width.data, 4), 32);
    for (size_t i = 0; i < names.bytes; i += 32, at = element_at(at).next)
        if (!strcmp(names.data + i, name))
            return CHECK(matrix_read(at, found)) && CHECK_TEXT(found->name, "");
    return CHECK_SAYING(0, "no field %s", name);
}

TEST(mat_holds_every_array_under_its_name) {
    OWN(test_table, clear) table = test_table_new(3000, 5);
    OWN(api_buffer, clear) mat;
    struct matrix found, part;
    api_buffer_init(&mat, 10000000);
    REQUIRE(!test_table_encode(&table, &api_format_mat, 256, &mat));
    CHECK(!memcmp(mat.data, "MATLAB 5.0 MAT-file", 19) && !memcmp(mat.data + 124, "\0\1IM", 4));
    REQUIRE(variable(&mat, "t", &found));
    CHECK(found.rows == 3000 && found.columns == 1 && found.flags == 6);
    CHECK(check_part(&found, found.rest, table.data[TEST_T]) == found.end);
    REQUIRE(variable(&mat, "phi", &found));
    CHECK(found.rows == 3000 && found.columns == 5 && found.flags == 6);
    CHECK(check_part(&found, found.rest, table.data[TEST_PHI]) == found.end);
    REQUIRE(variable(&mat, "z", &found));
    CHECK(found.rows == 3000 && found.columns == 5 && found.flags == (6 | 1 << 11));
    CHECK(check_part(&found, check_part(&found, found.rest, table.data[TEST_RE]),
                     table.data[TEST_IM]) == found.end);
    REQUIRE(variable(&mat, "energy", &found) && field(&found, "kinetic", &part));
    check_part(&part, part.rest, table.data[TEST_KINETIC]);
    REQUIRE(field(&found, "total", &part));
    check_part(&part, part.rest, table.data[TEST_TOTAL]);
    CHECK(part.end == found.end);
}

TEST(mat_tells_the_statistics_as_a_structure) {
    static const double steps = 100000, drift = 2.5e-16;
    OWN(test_table, clear) table = test_table_new(1, 1);
    OWN(api_buffer, clear) mat;
    struct matrix stats, part;
    api_buffer_init(&mat, 1000000);
    REQUIRE(!test_table_encode(&table, &api_format_mat, 1, &mat));
    REQUIRE(variable(&mat, "stats", &stats) && field(&stats, "method", &part));
    struct element text = element_at(part.rest);
    CHECK(part.flags == 4 && part.rows == 1 && part.columns == 6 && text.type == 4 &&
          text.bytes == 12);
    CHECK(!memcmp(text.data, "t\0a\0y\0l\0o\0r\0", 12));
    REQUIRE(field(&stats, "steps", &part));
    check_part(&part, part.rest, &steps);
    REQUIRE(field(&stats, "drift", &part));
    check_part(&part, part.rest, &drift);
    CHECK(part.end == stats.end);
}
