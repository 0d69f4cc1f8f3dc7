/* The server's only hash table: nodes inside the objects of a table, found by keys of any bytes.
 * Leaves to others: the objects and the memory of their keys, locks, the number of objects.
 * Invariant: a client that does not know the salt cannot choose keys that share a row (a bucket);
 * two nodes of a table never have the same key. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "server/base/container_of.h"

enum { SRV_HASH_ROWS = 4096 };

/* An object's node in a table. The owner sets `key` and `bytes`, and does not change them while the
 * node is in a table; the other members belong to the table. */
struct srv_hash_node {
    const void *key;
    size_t bytes; /* length of the key */
    uint64_t hash;
    struct srv_hash_node *next; /* next node in the same row */
};

struct srv_hash_table {
    uint64_t salt;
    size_t count; /* number of nodes */
    struct srv_hash_node *row[SRV_HASH_ROWS];
};

/** Initializes an empty table; `salt` is a number that clients do not know. */
void srv_hash_table_init(struct srv_hash_table *table, uint64_t salt);
int srv_hash_table_valid(const struct srv_hash_table *table);

/** Returns a hash of some bytes: multiplies eight bytes at a time by the salt, and folds the
 * 128-bit product. O(bytes), about a nanosecond per eight bytes. */
uint64_t srv_hash_bytes(uint64_t salt, const void *key, size_t bytes);

/** Returns the hash of a key in a table, which is srv_hash_bytes with the table's salt. Needs no
 * lock. */
uint64_t srv_hash_table_hash(const struct srv_hash_table *table, const void *key, size_t bytes);

/** Returns the node of a key with a known hash; NULL if absent. O(bytes). */
struct srv_hash_node *srv_hash_table_find(const struct srv_hash_table *table, uint64_t hash,
                                          const void *key, size_t bytes);

/** Adds a node under its key, which no node of the table has yet. O(1). */
void srv_hash_table_add(struct srv_hash_table *table, struct srv_hash_node *node, uint64_t hash);

/** Removes a node that is in the table. O(1). */
void srv_hash_table_remove(struct srv_hash_table *table, struct srv_hash_node *node);
