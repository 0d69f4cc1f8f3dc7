#include "server/work/clients.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum {
    CLIENTS_DEBT = 3600 /* the largest debt of a client, in seconds of computation */
};

struct srv_clients {
    pthread_mutex_t lock;
    struct srv_list idle; /* records without references; the one released last is at the end */
    int idle_count;
    struct srv_hash_table table;
};

enum pend_status srv_clients_new(struct srv_clients **clients) {
    struct srv_clients *made = *clients = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    /* The heap address serves as the salt: it differs from run to run, so clients cannot choose
     * addresses that share a row. */
    srv_hash_table_init(&made->table, (uint64_t)(uintptr_t)made * 0x9e3779b97f4a7c15u);
    return PEND_OK;
}

static void clients_unlink(struct srv_clients *clients, struct srv_client *client) {
    srv_list_remove(&client->idle);
    clients->idle_count--;
}

/* Frees the record that has been without a reference for longest. */
static void clients_forget(struct srv_clients *clients) {
    struct srv_client *client = SRV_CONTAINER_OF(clients->idle.next, struct srv_client, idle);
    clients_unlink(clients, client);
    srv_hash_table_remove(&clients->table, &client->node);
    free(client);
}

void srv_clients_free(struct srv_clients **clients) {
    struct srv_clients *gone = *clients;
    *clients = NULL;
    if (!gone) return;
    while (gone->idle_count) clients_forget(gone);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

static struct srv_client *clients_make(struct srv_clients *clients, const char *key, size_t bytes,
                                       uint64_t hash) {
    struct srv_client *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    memcpy(made->key, key, bytes);
    made->node.key = made->key;
    made->node.bytes = bytes;
    srv_hash_table_add(&clients->table, &made->node, hash);
    return made;
}

/* The caller holds the lock. */
static struct srv_client *clients_take(struct srv_clients *clients, const char *key) {
    size_t bytes = strnlen(key, SRV_CLIENT_KEY - 1);
    uint64_t hash = srv_hash_table_hash(&clients->table, key, bytes);
    struct srv_hash_node *node = srv_hash_table_find(&clients->table, hash, key, bytes);
    struct srv_client *client = node ? SRV_CONTAINER_OF(node, struct srv_client, node)
                                     : clients_make(clients, key, bytes, hash);
    if (client && client->idle.next) clients_unlink(clients, client);
    if (client) client->users++;
    return client;
}

/* The caller holds the lock. */
static void clients_give(struct srv_clients *clients, struct srv_client *client) {
    assert(client->users > 0);
    if (--client->users) return;
    assert(!client->lane.count && atomic_load(&client->held) == 0);
    assert(atomic_load(&client->connections) == 0);
    struct srv_client *source = client->source;
    client->source = NULL;
    client->lane.road = NULL;
    client->asker.origin = NULL;
    srv_list_append(&clients->idle, &client->idle);
    clients->idle_count++;
    if (source && source != client) clients_give(clients, source);
}

/* Finds or creates the record of a client's address, unless the client already refers to it.
 * Returns 0 if memory is short. The caller holds the lock. */
static int clients_trace(struct srv_clients *clients, struct srv_client *client,
                         const char *source) {
    if (client->source) return 1;
    int itself = !source || !strcmp(source, client->key);
    client->source = itself ? client : clients_take(clients, source);
    if (client->source && !itself) {
        client->lane.road = &client->source->lane.own;
        client->asker.origin = &client->source->asker;
        if (!client->source->source) client->source->source = client->source;
    }
    return client->source != NULL;
}

struct srv_client *srv_clients_take(struct srv_clients *clients, const char *key,
                                    const char *source) {
    pthread_mutex_lock(&clients->lock);
    struct srv_client *client = clients_take(clients, key);
    if (client && !clients_trace(clients, client, source)) {
        clients_give(clients, client);
        client = NULL;
    }
    pthread_mutex_unlock(&clients->lock);
    return client;
}

void srv_clients_share(struct srv_clients *clients, struct srv_client *client) {
    pthread_mutex_lock(&clients->lock);
    assert(client->users > 0);
    client->users++;
    pthread_mutex_unlock(&clients->lock);
}

void srv_clients_give(struct srv_clients *clients, struct srv_client *client) {
    pthread_mutex_lock(&clients->lock);
    clients_give(clients, client);
    while (clients->idle_count > SRV_CLIENTS_KEPT) clients_forget(clients);
    pthread_mutex_unlock(&clients->lock);
}

/* Adds the tokens earned since the last call, at `a_minute` per minute, up to `burst`. */
static void bucket_fill(struct srv_bucket *bucket, double a_minute, double burst, int64_t now) {
    double grown = burst;
    if (bucket->counted)
        grown = bucket->tokens + 1e-9 * (double)(now - bucket->counted) * a_minute / 60;
    bucket->tokens = grown < burst ? grown : burst;
    bucket->counted = now;
}

struct srv_quota srv_clients_quota(struct srv_clients *clients, struct srv_client *client,
                                   double a_minute, double shares, int64_t now) {
    struct srv_quota quota = {0};
    pthread_mutex_lock(&clients->lock);
    assert(client->users > 0 && client->source && a_minute > 0 && shares > 0);
    struct srv_bucket *own = &client->own, *all = &client->source->all;
    bucket_fill(own, a_minute, a_minute, now);
    bucket_fill(all, a_minute * shares, a_minute * shares, now);
    quota.granted = own->tokens >= 1 && all->tokens >= 1;
    if (quota.granted) {
        own->tokens -= 1;
        all->tokens -= 1;
    }
    /* Report the bucket with less left; an address has several times the rate of one client. */
    int crowded = all->tokens < own->tokens;
    double left = crowded ? all->tokens : own->tokens,
           rate = crowded ? a_minute * shares : a_minute;
    pthread_mutex_unlock(&clients->lock);
    quota.limit = a_minute;
    quota.left = left;
    quota.refresh = (a_minute - left) * 60 / rate;
    quota.retry = quota.granted ? 0 : (1 - left) * 60 / rate;
    return quota;
}

double srv_clients_debt(struct srv_clients *clients, struct srv_client *client, double a_minute,
                        int64_t now) {
    assert(a_minute >= 0);
    pthread_mutex_lock(&clients->lock);
    bucket_fill(&client->seconds, a_minute, a_minute, now);
    double left = client->seconds.tokens;
    pthread_mutex_unlock(&clients->lock);
    if (left > 0) return 0;
    /* A client whose limit is 0 is asked to retry in a minute. */
    return a_minute > 0 ? 1e-3 - left * 60 / a_minute : 60;
}

void srv_clients_charge(struct srv_clients *clients, struct srv_client *client, double seconds) {
    assert(seconds >= 0);
    pthread_mutex_lock(&clients->lock);
    struct srv_bucket *bucket = &client->seconds;
    if (bucket->counted) {
        double left = bucket->tokens - seconds;
        bucket->tokens = left > -CLIENTS_DEBT ? left : -CLIENTS_DEBT;
    }
    pthread_mutex_unlock(&clients->lock);
}

double srv_clients_pace(struct srv_clients *clients, struct srv_client *client, enum srv_pace pace,
                        double a_second, double burst, int taken, int64_t now) {
    pthread_mutex_lock(&clients->lock);
    assert(client->users > 0 && (unsigned)pace < SRV_PACES && a_second > 0 && burst >= 1);
    struct srv_bucket *bucket = &client->pace[pace];
    bucket_fill(bucket, 60 * a_second, burst, now);
    double lacks = 1 - bucket->tokens;
    if (lacks <= 0 && taken) bucket->tokens -= 1;
    pthread_mutex_unlock(&clients->lock);
    return lacks <= 0 ? 0 : lacks / a_second;
}
