#include "server/config/hosts.h"

#include <arpa/inet.h>
#include <assert.h>
#include <string.h>
#include <strings.h>

/* names of the local machine; 127/8 stands for the whole network */
static const char hosts_loopback[] = "localhost, *.localhost, 127/8, [::1]";

struct hosts_part {
    const char *name, *port;
    size_t name_bytes, port_bytes;
};

static struct hosts_part hosts_split(const char *text, size_t bytes) {
    struct hosts_part part = {.name = text, .name_bytes = bytes, .port = text + bytes};
    const char *bracket = bytes && *text == '[' ? memchr(text, ']', bytes) : NULL;
    size_t from = bracket ? (size_t)(bracket - text) + 1 : 0;
    const char *colon = memchr(text + from, ':', bytes - from);
    if (colon) {
        part.name_bytes = (size_t)(colon - text);
        part.port = colon;
        part.port_bytes = bytes - part.name_bytes;
    }
    if (part.name_bytes && text[part.name_bytes - 1] == '.') part.name_bytes--;
    assert(part.name_bytes + part.port_bytes <= bytes);
    return part;
}

/* cuts the next entry off a list, without blanks; 0 at the end */
static int hosts_next(const char **at, const char **entry, size_t *bytes) {
    if (!*at) return 0;
    *entry = *at + strspn(*at, " \t");
    *bytes = strcspn(*entry, ",");
    *at = (*entry)[*bytes] ? *entry + *bytes + 1 : NULL;
    while (*bytes && strchr(" \t", (*entry)[*bytes - 1])) --*bytes;
    return 1;
}

static int hosts_is(const char *entry, size_t bytes, const char *text) {
    return bytes == strlen(text) && !memcmp(entry, text, bytes);
}

/* a colon and digits, or nothing */
static int hosts_port_good(const struct hosts_part *part) {
    size_t digits = 0;
    while (digits + 1 < part->port_bytes && part->port[digits + 1] >= '0' &&
           part->port[digits + 1] <= '9')
        digits++;
    return !part->port_bytes || (digits && digits < 6 && digits + 1 == part->port_bytes);
}

static int hosts_entry_good(const char *entry, size_t bytes) {
    static const char letters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._";
    struct hosts_part part = hosts_split(entry, bytes);
    size_t star = part.name_bytes > 2 && !memcmp(entry, "*.", 2) ? 2 : 0;
    const char *name = part.name + star;
    size_t left = part.name_bytes - star;
    int bracketed = left > 2 && name[0] == '[' && name[left - 1] == ']';
    if (!left || !hosts_port_good(&part)) return 0;
    for (size_t i = bracketed; i < left - (size_t)bracketed; i++)
        if (!memchr(bracketed ? "0123456789abcdefABCDEF:." : letters, name[i],
                    bracketed ? sizeof "0123456789abcdefABCDEF:." - 1 : sizeof letters - 1))
            return 0;
    return name[0] != '.';
}

int srv_hosts_good(const char *list) {
    const char *entry;
    size_t bytes;
    if (!strcmp(list, "*") || !strcmp(list, "auto")) return 1;
    for (const char *at = list; hosts_next(&at, &entry, &bytes);)
        if (!hosts_entry_good(entry, bytes)) return 0;
    return 1;
}

const char *srv_hosts_mean(const char *list, const char *listen, int proxied) {
    assert(srv_hosts_good(list));
    if (strcmp(list, "auto") != 0) return list;
    const char *colon = strrchr(listen, ':');
    size_t bytes = colon ? (size_t)(colon - listen) : strlen(listen);
    return !proxied && srv_hosts_allow(hosts_loopback, listen) && bytes ? hosts_loopback : "*";
}

/* whether a name is an address of 127.0.0.0/8 in full notation */
static int hosts_of_loopback(const struct hosts_part *host) {
    char text[16];
    struct in_addr address;
    if (host->name_bytes >= sizeof text) return 0;
    assert(host->name_bytes < sizeof text);
    memcpy(text, host->name, host->name_bytes);
    text[host->name_bytes] = 0;
    return inet_pton(AF_INET, text, &address) == 1 && ntohl(address.s_addr) >> 24 == 127;
}

static int hosts_match(const struct hosts_part *entry, const struct hosts_part *host) {
    if (entry->port_bytes && (entry->port_bytes != host->port_bytes ||
                              memcmp(entry->port, host->port, host->port_bytes)))
        return 0;
    if (entry->name_bytes > 2 && !memcmp(entry->name, "*.", 2)) {
        size_t tail = entry->name_bytes - 1;
        return host->name_bytes > tail &&
               !strncasecmp(host->name + host->name_bytes - tail, entry->name + 1, tail);
    }
    return entry->name_bytes == host->name_bytes &&
           !strncasecmp(entry->name, host->name, host->name_bytes);
}

int srv_hosts_allow(const char *list, const char *host) {
    const char *entry;
    size_t bytes;
    if (!host || !*host || !strcmp(list, "*")) return 1;
    struct hosts_part asked = hosts_split(host, strlen(host));
    if (!hosts_port_good(&asked)) return 0;
    for (const char *at = list; hosts_next(&at, &entry, &bytes);) {
        struct hosts_part listed = hosts_split(entry, bytes);
        if (hosts_is(entry, bytes, "127/8") ? hosts_of_loopback(&asked)
                                            : hosts_match(&listed, &asked))
            return 1;
    }
    return 0;
}

int srv_hosts_numeric(const char *host) {
    char text[64];
    unsigned char address[16];
    if (!host) return 0;
    struct hosts_part part = hosts_split(host, strlen(host));
    int bracketed = part.name_bytes > 2 && part.name[0] == '[';
    size_t bytes = part.name_bytes - 2 * (size_t)bracketed;
    if (!part.name_bytes || bytes >= sizeof text || !hosts_port_good(&part)) return 0;
    memcpy(text, part.name + bracketed, bytes);
    text[bytes] = 0;
    return inet_pton(bracketed ? AF_INET6 : AF_INET, text, address) == 1;
}
