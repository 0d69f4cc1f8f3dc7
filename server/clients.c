#include "server/clients.h"

#include <arpa/inet.h>
#include <assert.h>
#include <pthread.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CLIENTS_ROWS = 4096 };

struct srv_clients {
    pthread_mutex_t lock;
    struct srv_link idle; /* those that nobody has, the one that was left last is last */
    int idle_count;
    uint64_t salt;
    struct srv_client *row[CLIENTS_ROWS];
};

static struct srv_client *clients_of_idle(struct srv_link *link) {
    return (struct srv_client *)((char *)link - offsetof(struct srv_client, idle));
}

enum pend_status srv_clients_new(struct srv_clients **clients) {
    struct srv_clients *made = *clients = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    made->idle.next = made->idle.previous = &made->idle;
    /* where the heap is differs from run to run: enough that nobody can choose addresses of one row */
    made->salt = (uint64_t)(uintptr_t)made * 0x9e3779b97f4a7c15u;
    return PEND_OK;
}

static int clients_row(const struct srv_clients *clients, const char *key) {
    uint64_t hash = clients->salt;
    for (; *key; key++) hash = (hash ^ (unsigned char)*key) * 0x100000001b3u, hash ^= hash >> 29;
    return (int)(hash % CLIENTS_ROWS);
}

static void clients_forget(struct srv_clients *clients, struct srv_client *client) {
    struct srv_client **at = &clients->row[clients_row(clients, client->key)];
    while (*at != client) at = &(*at)->next_in_row;
    *at = client->next_in_row;
    free(client);
}

static void clients_unlink(struct srv_clients *clients, struct srv_client *client) {
    client->idle.previous->next = client->idle.next;
    client->idle.next->previous = client->idle.previous;
    clients->idle_count--;
}

void srv_clients_free(struct srv_clients **clients) {
    struct srv_clients *gone = *clients;
    *clients = NULL;
    if (!gone) return;
    while (gone->idle_count) {
        struct srv_client *client = clients_of_idle(gone->idle.next);
        clients_unlink(gone, client);
        clients_forget(gone, client);
    }
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

/* an IPv6 address becomes its network */
static void clients_key(const char *name, char key[SRV_CLIENT_KEY]) {
    struct in6_addr address;
    snprintf(key, SRV_CLIENT_KEY, "%s", name);
    if (!strchr(name, ':') || inet_pton(AF_INET6, name, &address) != 1) return;
    memset(address.s6_addr + 8, 0, 8);
    inet_ntop(AF_INET6, &address, key, SRV_CLIENT_KEY);
}

static struct srv_client *clients_make(struct srv_clients *clients, const char *key, int row) {
    struct srv_client *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    strcpy(made->key, key);
    made->next_in_row = clients->row[row];
    clients->row[row] = made;
    return made;
}

struct srv_client *srv_clients_take(struct srv_clients *clients, const char *name) {
    char key[SRV_CLIENT_KEY];
    clients_key(name, key);
    pthread_mutex_lock(&clients->lock);
    int row = clients_row(clients, key);
    struct srv_client *client = clients->row[row];
    while (client && strcmp(client->key, key)) client = client->next_in_row;
    if (client && !client->users) clients_unlink(clients, client);
    if (!client) client = clients_make(clients, key, row);
    if (client) client->users++;
    pthread_mutex_unlock(&clients->lock);
    return client;
}

void srv_clients_share(struct srv_clients *clients, struct srv_client *client) {
    pthread_mutex_lock(&clients->lock);
    client->users++;
    pthread_mutex_unlock(&clients->lock);
}

void srv_clients_give(struct srv_clients *clients, struct srv_client *client) {
    pthread_mutex_lock(&clients->lock);
    assert(client->users > 0);
    if (!--client->users) {
        assert(!client->lane.count);
        client->idle = (struct srv_link){.next = &clients->idle, .previous = clients->idle.previous};
        client->idle.previous->next = clients->idle.previous = &client->idle;
        clients->idle_count++;
    }
    while (clients->idle_count > SRV_CLIENTS_KEPT) {
        struct srv_client *oldest = clients_of_idle(clients->idle.next);
        clients_unlink(clients, oldest);
        clients_forget(clients, oldest);
    }
    pthread_mutex_unlock(&clients->lock);
}

struct srv_quota srv_clients_quota(struct srv_clients *clients, struct srv_client *client, double a_minute,
                                   int64_t now) {
    struct srv_quota quota = {0};
    pthread_mutex_lock(&clients->lock);
    double grown = client->counted ? client->tokens + 1e-9 * (double)(now - client->counted) * a_minute / 60 : a_minute;
    client->tokens = grown < a_minute ? grown : a_minute;
    client->counted = now;
    quota.granted = client->tokens >= 1;
    if (quota.granted) client->tokens -= 1;
    quota.left = client->tokens;
    pthread_mutex_unlock(&clients->lock);
    quota.refresh = (a_minute - quota.left) * 60 / a_minute;
    quota.retry = quota.granted ? 0 : (1 - quota.left) * 60 / a_minute;
    return quota;
}
