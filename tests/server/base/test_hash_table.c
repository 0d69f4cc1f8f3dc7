/* Tests of server/base/hash_table. */
#include "server/base/hash_table.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

enum { THINGS = 3 * SRV_HASH_ROWS };

struct thing {
    struct srv_hash_node node;
    char key[24];
};

static struct srv_hash_table table;
static struct thing thing[THINGS];

static void thing_add(struct thing *made, const char *key) {
    snprintf(made->key, sizeof made->key, "%s", key);
    made->node.key = made->key;
    made->node.bytes = strlen(key);
    srv_hash_table_add(&table, &made->node, srv_hash_table_hash(&table, key, strlen(key)));
}

static struct srv_hash_node *thing_find(const char *key, size_t bytes) {
    return srv_hash_table_find(&table, srv_hash_table_hash(&table, key, bytes), key, bytes);
}

TEST(a_hash_table_finds_what_was_added_and_nothing_else) {
    char key[24];
    srv_hash_table_init(&table, 12345);
    for (int i = 0; i < THINGS; i++) {
        snprintf(key, sizeof key, "key %d", i);
        thing_add(&thing[i], key);
    }
    CHECK(srv_hash_table_valid(&table));
    CHECK_INT((long long)table.count, THINGS);
    int found = 0;
    for (int i = 0; i < THINGS; i++)
        found += thing_find(thing[i].key, strlen(thing[i].key)) == &thing[i].node;
    CHECK_INT(found, THINGS);
    CHECK(!thing_find("key", 3) && !thing_find("key 1\0", 6) && !thing_find("", 0));
    for (int i = 0; i < THINGS; i += 2) srv_hash_table_remove(&table, &thing[i].node);
    CHECK(srv_hash_table_valid(&table));
    found = 0;
    for (int i = 0; i < THINGS; i++)
        found += thing_find(thing[i].key, strlen(thing[i].key)) != NULL;
    CHECK_INT(found, THINGS / 2);
    CHECK_INT((long long)table.count, THINGS / 2);
}

TEST(keys_may_hold_any_bytes_and_none) {
    srv_hash_table_init(&table, 0);
    thing[0].node = (struct srv_hash_node){.key = "", .bytes = 0};
    thing[1].node = (struct srv_hash_node){.key = "\0", .bytes = 1};
    thing[2].node = (struct srv_hash_node){.key = "\0\0\0\0\0\0\0\0\0", .bytes = 9};
    for (int i = 0; i < 3; i++)
        srv_hash_table_add(&table, &thing[i].node,
                           srv_hash_table_hash(&table, thing[i].node.key, thing[i].node.bytes));
    CHECK(thing_find("", 0) == &thing[0].node && thing_find("\0", 1) == &thing[1].node);
    CHECK(thing_find("\0\0\0\0\0\0\0\0\0", 9) == &thing[2].node && !thing_find("\0\0", 2));
    CHECK(srv_hash_table_valid(&table));
}

TEST(another_salt_puts_keys_into_other_rows_evenly) {
    static struct srv_hash_table other;
    int same = 0, longest = 0;
    static int row[SRV_HASH_ROWS];
    srv_hash_table_init(&table, 1);
    srv_hash_table_init(&other, 3);
    memset(row, 0, sizeof row);
    for (uint64_t i = 0; i < SRV_HASH_ROWS; i++) {
        uint64_t one = srv_hash_table_hash(&table, &i, sizeof i) % SRV_HASH_ROWS;
        same += one == srv_hash_table_hash(&other, &i, sizeof i) % SRV_HASH_ROWS;
        if (++row[one] > longest) longest = row[one];
    }
    CHECK(same < 40);
    CHECK(longest < 16);
}

TEST(a_hash_table_with_a_changed_key_is_not_valid) {
    srv_hash_table_init(&table, 7);
    thing_add(&thing[0], "one");
    thing_add(&thing[1], "two");
    CHECK(srv_hash_table_valid(&table));
    thing[1].key[0] = 'x';
    CHECK(!srv_hash_table_valid(&table));
    thing[1].key[0] = 't';
    table.count = 3;
    CHECK(!srv_hash_table_valid(&table));
}
