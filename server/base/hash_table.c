#include "server/base/hash_table.h"

#include <assert.h>
#include <string.h>

void srv_hash_table_init(struct srv_hash_table *table, uint64_t salt) {
    memset(table, 0, sizeof *table);
    table->salt = salt | 1;
}

uint64_t srv_hash_bytes(uint64_t salt, const void *key, size_t bytes) {
    uint64_t hash = salt ^ bytes, word;
    for (const char *at = key; bytes; at += sizeof word) {
        size_t part = bytes < sizeof word ? bytes : sizeof word;
        word = 0;
        memcpy(&word, at, part);
        bytes -= part;
        __extension__ unsigned __int128 product =
            (unsigned __int128)(hash ^ word) * (salt ^ 0x9e3779b97f4a7c15u);
        hash = (uint64_t)product ^ (uint64_t)(product >> 64);
    }
    return hash;
}

uint64_t srv_hash_table_hash(const struct srv_hash_table *table, const void *key, size_t bytes) {
    return srv_hash_bytes(table->salt, key, bytes);
}

struct srv_hash_node *srv_hash_table_find(const struct srv_hash_table *table, uint64_t hash,
                                          const void *key, size_t bytes) {
    assert(hash == srv_hash_table_hash(table, key, bytes));
    struct srv_hash_node *node = table->row[hash % SRV_HASH_ROWS];
    while (node && !(node->hash == hash && node->bytes == bytes && !memcmp(node->key, key, bytes)))
        node = node->next;
    return node;
}

void srv_hash_table_add(struct srv_hash_table *table, struct srv_hash_node *node, uint64_t hash) {
    assert(!srv_hash_table_find(table, hash, node->key, node->bytes));
    struct srv_hash_node **row = &table->row[hash % SRV_HASH_ROWS];
    node->hash = hash;
    node->next = *row;
    *row = node;
    table->count++;
}

void srv_hash_table_remove(struct srv_hash_table *table, struct srv_hash_node *node) {
    struct srv_hash_node **at = &table->row[node->hash % SRV_HASH_ROWS];
    while (*at && *at != node) at = &(*at)->next;
    assert(*at == node && table->count > 0);
    *at = node->next;
    table->count--;
}

int srv_hash_table_valid(const struct srv_hash_table *table) {
    size_t count = 0;
    for (size_t row = 0; row < SRV_HASH_ROWS; row++)
        for (const struct srv_hash_node *node = table->row[row]; node; node = node->next) {
            uint64_t hash = srv_hash_table_hash(table, node->key, node->bytes);
            if (node->hash != hash || hash % SRV_HASH_ROWS != row || ++count > table->count)
                return 0;
        }
    return count == table->count;
}
