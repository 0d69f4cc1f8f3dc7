#include "server/protocol/peer.h"

#include <arpa/inet.h>
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* parses an address to 16 bytes; returns 0 if it is invalid */
static int peer_address(const char *text, unsigned char address[16]) {
    static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};
    memcpy(address, mapped, sizeof mapped);
    return inet_pton(AF_INET, text, address + 12) == 1 || inet_pton(AF_INET6, text, address) == 1;
}

/* parses one entry, "10.0.0.0/8" */
static int peer_network(struct srv_peers *peers, char *text) {
    char *slash = strchr(text, '/'), *end = NULL;
    int family_bits = strchr(text, ':') ? 128 : 32, at = peers->count;
    if (at == SRV_PEER_NETWORKS) return 0;
    if (slash) *slash = 0;
    long bits = slash ? strtol(slash + 1, &end, 10) : family_bits;
    if (slash && (end == slash + 1 || *end || bits < 0 || bits > family_bits)) return 0;
    peers->network[at].bits = (int)bits + 128 - family_bits;
    peers->count++;
    return peer_address(text, peers->network[at].address);
}

/* removes the next element from a list; returns it without blanks, NULL at the end */
static char *peer_next(char **list) {
    char *element = *list;
    if (!element) return NULL;
    char *comma = strchr(element, ',');
    *list = comma ? comma + 1 : NULL;
    if (comma) *comma = 0;
    element += strspn(element, " \t");
    for (size_t bytes = strlen(element); bytes && strchr(" \t", element[bytes - 1]);)
        element[--bytes] = 0;
    return element;
}

enum pend_status srv_peers_read(struct srv_peers *peers, const char *text,
                                struct pend_error *error) {
    char copy[1024];
    *peers = (struct srv_peers){0};
    if (!strcmp(text, "none")) return PEND_OK;
    snprintf(copy, sizeof copy, "%s", text);
    char *list = copy;
    for (char *element; (element = peer_next(&list));) {
        char shown[64];
        snprintf(shown, sizeof shown, "%s", element);
        if (!strcmp(element, "unix")) {
            peers->local = 1;
            continue;
        }
        if (!peer_network(peers, element))
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "trusted-proxy must be a list of at most %d networks like 10.0.0.0/8, "
                             "or unix, got '%s'",
                             SRV_PEER_NETWORKS, shown);
    }
    return PEND_OK;
}

static int peer_within(const unsigned char address[16], const unsigned char network[16], int bits) {
    int whole = bits / 8, rest = bits % 8;
    if (memcmp(address, network, (size_t)whole)) return 0;
    return !rest || !((address[whole] ^ network[whole]) >> (8 - rest));
}

int srv_peers_any(const struct srv_peers *peers) { return peers->count > 0 || peers->local; }

int srv_peer_trusted(const struct srv_peers *peers, const char *text) {
    assert(peers->count >= 0 && peers->count <= SRV_PEER_NETWORKS);
    unsigned char address[16];
    if (peers->local && !strcmp(text, "unix")) return 1;
    if (!peers->count || !peer_address(text, address)) return 0;
    for (int i = 0; i < peers->count; i++)
        if (peer_within(address, peers->network[i].address, peers->network[i].bits)) return 1;
    return 0;
}

int srv_peer_names_addresses(const char *header) {
    return !strcasecmp(header, "Forwarded") || !strcasecmp(header, "X-Forwarded-For");
}

void srv_peer_network(const char *text, char network[SRV_PEER_BYTES]) {
    static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};
    unsigned char address[16];
    snprintf(network, SRV_PEER_BYTES, "%.*s", SRV_PEER_BYTES - 1, text);
    if (!peer_address(text, address)) return;
    if (!memcmp(address, mapped, sizeof mapped)) {
        inet_ntop(AF_INET, address + 12, network, SRV_PEER_BYTES);
        return;
    }
    memset(address + 8, 0, 8);
    inet_ntop(AF_INET6, address, network, SRV_PEER_BYTES);
}

void srv_peer_shorten(const char *text, char shown[SRV_PEER_BYTES]) {
    static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};
    unsigned char address[16];
    shown[0] = 0;
    if (!peer_address(text, address)) return;
    int old = !memcmp(address, mapped, sizeof mapped);
    memset(address + (old ? 15 : 6), 0, old ? 1 : 10);
    inet_ntop(old ? AF_INET : AF_INET6, address + (old ? 12 : 0), shown, SRV_PEER_BYTES);
}

/* the value of for= in an element of Forwarded; "" if absent */
static char *peer_for(char *element) {
    for (char *part = element; part; part = strchr(part, ';')) {
        part += strspn(part, "; \t");
        if (!strncasecmp(part, "for=", 4)) {
            part[4 + strcspn(part + 4, ";")] = 0;
            return part + 4;
        }
    }
    return element + strlen(element);
}

static char *peer_bare(char *text) {
    if (*text == '"') {
        text++;
        text[strcspn(text, "\"")] = 0;
    }
    if (*text == '[') {
        text++;
        text[strcspn(text, "]")] = 0;
    } else if (strchr(text, ':') == strrchr(text, ':')) {
        text[strcspn(text, ":")] = 0;
    }
    return text;
}

void srv_peer_client(const struct srv_peers *peers, const char *peer, const char *header,
                     const char *value, char client[SRV_PEER_BYTES]) {
    char copy[1024], *element[64];
    unsigned char address[16];
    int count = 0, forwarded = !strcasecmp(header, "Forwarded");
    snprintf(client, SRV_PEER_BYTES, "%s", peer);
    if (!value || !*value || !srv_peer_names_addresses(header) || !srv_peer_trusted(peers, peer))
        return;
    /* only the end of a long list is used */
    size_t bytes = strlen(value), cut = bytes < sizeof copy ? 0 : bytes - sizeof copy + 1;
    snprintf(copy, sizeof copy, "%s", value + cut);
    char *list = copy;
    for (char *next; (next = peer_next(&list));) {
        if (count == 64) memmove(element, element + 1, (size_t)--count * sizeof *element);
        element[count++] = next;
    }
    for (int trusted = 1; trusted && count--;) {
        char *named = peer_bare(forwarded ? peer_for(element[count]) : element[count]);
        if (!peer_address(named, address)) return;
        snprintf(client, SRV_PEER_BYTES, "%s", named);
        trusted = srv_peer_trusted(peers, named);
    }
}
