/* Tests of server/store/sql_list, and of statements on rows of values in both dialects. */
#include "server/store/sql.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "server/store/store_rows.h"
#include "tests/server/ground.h"

TEST(a_statement_on_rows_is_spelt_for_one_row_or_for_lists) {
    char out[SRV_SQL_TEXT];
    const char *text = "UPDATE t SET b = {2}, at = {now} {from tw} WHERE a = {1}";
    srv_sql_spell(&srv_sql_sqlite, text, out);
    CHECK_TEXT(out, "UPDATE t SET b = $2, at = now_us()  WHERE a = $1");
    srv_sql_spell(&srv_sql_postgres, "DELETE FROM t {using t} WHERE a = {1}", out);
    CHECK_TEXT(out, "DELETE FROM t USING unnest($1::text[]) AS v(c1) WHERE a = v.c1");
    srv_sql_spell(&srv_sql_postgres, "SELECT 1 FROM {beside wb} t WHERE a = {2} AND b = {1}", out);
    CHECK_TEXT(out, "SELECT 1 FROM unnest($1::bigint[], $2::bytea[]) AS v(c1, c2), t WHERE a = "
                    "v.c2 AND b = v.c1");
    CHECK(!strncmp(srv_sql_columns(text), "tw}", 3));
    CHECK(!srv_sql_columns("SELECT {now}"));
}

/* the number at a position of an array */
static unsigned list_number(const char *at) {
    const unsigned char *byte = (const unsigned char *)at;
    return (unsigned)byte[0] << 24 | (unsigned)byte[1] << 16 | (unsigned)byte[2] << 8 | byte[3];
}

TEST(a_list_is_an_array_of_each_column) {
    OWN(srv_sql_list, free) list = {0};
    const char *data[SRV_SQL_PARAMETERS];
    int bytes[SRV_SQL_PARAMETERS];
    for (int i = 0; i < 3; i++) {
        struct srv_value row[] = {srv_value_text(i == 1 ? NULL : "abc"), srv_value_whole(-1)};
        CHECK(srv_sql_list_add(&list, "INSERT INTO t SELECT {1}, {2} {from tw}", row, 2));
    }
    srv_sql_list_arrays(&list, data, bytes);
    CHECK_INT(bytes[0], 20 + 3 * 4 + 2 * 3);
    CHECK_INT(bytes[1], 20 + 3 * 12);
    /* dimensions, NULLs, type, elements, first subscript; then the elements, NULL without bytes */
    unsigned want[] = {1, 1, 25, 3, 1, 3};
    for (int i = 0; i < 6; i++) CHECK_INT(list_number(data[0] + 4 * i), want[i]);
    CHECK(!memcmp(data[0] + 24, "abc\xff\xff\xff\xff", 7));
    CHECK(list_number(data[1] + 4) == 0 && list_number(data[1] + 8) == 20 &&
          list_number(data[1] + 20) == 8);
    CHECK(!memcmp(data[1] + 24, "\xff\xff\xff\xff\xff\xff\xff\xff", 8));
    /* an empty list starts again */
    srv_sql_list_empty(&list);
    CHECK(srv_sql_list_add(&list, "DELETE FROM t {using t} WHERE a = {1}",
                           &(struct srv_value){.kind = SRV_SQL_NULL}, 1));
    srv_sql_list_arrays(&list, data, bytes);
    CHECK(list.columns == 1 && bytes[0] == 24 && list_number(data[0] + 12) == 1);
}

enum { ID_INSERT = 90, ID_UPDATE, ID_SELECT, ROWS = 300 };

static enum srv_stored list_one(struct srv_sql *sql, int id, const char *text,
                                const struct srv_value value[], int count) {
    if (sql->driver->post) return sql->driver->post(sql, id, text, value, count);
    return sql->driver->run(sql, id, text, value, count, NULL, NULL);
}

static enum srv_stored list_plain(struct srv_sql *sql, const char *text) {
    return sql->driver->run(sql, -1, text, NULL, 0, NULL, NULL);
}

static long long list_sum(struct srv_sql *sql) {
    struct srv_row_wholes row = {.count = 1};
    CHECK_INT(sql->driver->run(
                  sql, -1,
                  "SELECT CAST(COALESCE(SUM(b + LENGTH(c)), 0) AS BIGINT) + 1000000 * COUNT(*) + "
                  "1000000000 * COUNT(a) FROM list_test",
                  NULL, 0, srv_row_wholes, &row),
              SRV_STORED);
    return row.whole[0];
}

static enum srv_stored list_fill(struct srv_sql *sql, int from) {
    enum srv_stored stored = SRV_STORED;
    static char large[9000];
    for (int i = from; i < from + ROWS && stored == SRV_STORED; i++) {
        char name[16];
        snprintf(name, sizeof name, "n%d", i);
        struct srv_value row[] = {srv_value_text(i % 3 ? name : NULL), srv_value_whole(i),
                                  srv_value_bytes(large, i % 7 ? (size_t)i % 7 : sizeof large)};
        stored =
            list_one(sql, ID_INSERT,
                     "INSERT INTO list_test (a, b, c) SELECT {1}, {2}, {3} {from twb}", row, 3);
        memset(name, 'x', sizeof name); /* the value was copied */
    }
    return stored;
}

/* many rows, some NULL, some together longer than one message; and rows that are rolled back */
STORE_TEST(rows_of_values_take_effect_before_the_next_statement) {
    struct pend_error error;
    struct srv_sql *sql;
    (void)store;
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
    CHECK_INT(list_plain(sql, "CREATE TABLE list_test (a TEXT, b BIGINT, c {bytes})"), SRV_STORED);
    CHECK_INT(list_plain(sql, "{begin}"), SRV_STORED);
    CHECK_INT(list_fill(sql, 0), SRV_STORED);
    long long want = 0;
    for (int i = 0; i < ROWS; i++)
        want += i + (i % 7 ? i % 7 : 9000) + 1000000 + (i % 3 ? 1000000000 : 0);
    CHECK_INT(list_sum(sql), want);
    CHECK_INT(list_plain(sql, "COMMIT"), SRV_STORED);
    /* collected rows are discarded with their transaction */
    CHECK_INT(list_plain(sql, "{begin}"), SRV_STORED);
    CHECK_INT(list_fill(sql, ROWS), SRV_STORED);
    CHECK_INT(list_plain(sql, "ROLLBACK"), SRV_STORED);
    CHECK_INT(list_plain(sql, "{begin}"), SRV_STORED);
    CHECK_INT(list_sum(sql), want);
    /* each row of values changes a row of its own, in the order in which statements were first
     * posted */
    for (int i = 0; i < ROWS; i++) {
        struct srv_value row[] = {srv_value_whole(i), srv_value_whole(i % 2 ? -i : 0)};
        CHECK_INT(list_one(sql, ID_UPDATE,
                           "UPDATE list_test SET b = b + {2} {from ww} WHERE b = {1}", row, 2),
                  SRV_STORED);
        if (i % 2) want -= i;
    }
    CHECK_INT(list_plain(sql, "COMMIT"), SRV_STORED);
    CHECK_INT(list_sum(sql), want);
    driver->close(sql);
}
