#include "server/hooks/hook_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>

/* The special-purpose registries of IANA (RFC 6890 and later): blocks that are not globally
 * reachable, and those that lead to other addresses. */
static const struct address_block {
    uint32_t network;
    int bits;
} address_four[] = {
    {0x00000000, 8},  /* this network */
    {0x0a000000, 8},  /* private */
    {0x64400000, 10}, /* between a carrier and its customers */
    {0x7f000000, 8},  /* loopback */
    {0xa9fe0000, 16}, /* link local, and the metadata of clouds */
    {0xac100000, 12}, /* private */
    {0xc0000000, 24}, /* protocol assignments */
    {0xc0000200, 24}, /* documentation */
    {0xc0586300, 24}, /* relays of 6to4, which were given up */
    {0xc0a80000, 16}, /* private */
    {0xc6120000, 15}, /* benchmarks */
    {0xc6336400, 24}, /* documentation */
    {0xcb007100, 24}, /* documentation */
    {0xe0000000, 3},  /* multicast, reserved, broadcast */
};

static int address_four_may(uint32_t address) {
    for (size_t i = 0; i < sizeof address_four / sizeof *address_four; i++)
        if (!((address ^ address_four[i].network) >> (32 - address_four[i].bits))) return 0;
    return 1;
}

static uint32_t address_word(const unsigned char *at) {
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

static int address_six_may(const unsigned char address[16]) {
    static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};
    if (!memcmp(address, mapped, sizeof mapped))
        return address_four_may(address_word(address + 12));
    uint32_t first = address_word(address), second = address_word(address + 4);
    /* a translator's prefix, 64:ff9b::/96, and 6to4, 2002::/16: what they lead to counts */
    if (first == 0x0064ff9b && !second && !address_word(address + 8))
        return address_four_may(address_word(address + 12));
    if (first >> 16 == 0x2002) return address_four_may(first << 16 | second >> 16);
    /* 2000::/3 is what there is of the public internet; of it not the protocols' own 2001::/23,
     * with Teredo, documentation in 2001:db8::/32 and 3fff::/20 */
    if (first >> 29 != 1) return 0;
    return first >> 9 != 0x20010000 >> 9 && first != 0x20010db8 && first >> 12 != 0x3fff0;
}

/* the address as 16 bytes and as text; 0 of another family */
static int address_read(const struct sockaddr *address, unsigned char bytes[16],
                        char text[SRV_PEER_BYTES]) {
    static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};
    if (address->sa_family == AF_INET) {
        memcpy(bytes, mapped, sizeof mapped);
        memcpy(bytes + 12, &((const struct sockaddr_in *)(const void *)address)->sin_addr, 4);
    } else if (address->sa_family == AF_INET6)
        memcpy(bytes, &((const struct sockaddr_in6 *)(const void *)address)->sin6_addr, 16);
    else
        return 0;
    return inet_ntop(AF_INET6, bytes, text, SRV_PEER_BYTES) != NULL;
}

enum pend_status srv_hook_networks(struct srv_peers *networks, const char *text,
                                   struct pend_error *error) {
    struct pend_error why = {.text = ""};
    if (srv_peers_read(networks, text, &why) == PEND_OK && !networks->local) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "webhook-networks must be a list of at most %d networks like 10.0.0.0/8, or "
                     "none",
                     SRV_PEER_NETWORKS);
}

int srv_hook_address_may(const struct sockaddr *address, const struct srv_peers *networks) {
    unsigned char bytes[16];
    char text[SRV_PEER_BYTES];
    if (!address_read(address, bytes, text)) return 0;
    return srv_peer_trusted(networks, text) || address_six_may(bytes);
}

int srv_hook_host_may(const char *host, const struct srv_peers *networks) {
    struct sockaddr_in four = {.sin_family = AF_INET};
    struct sockaddr_in6 six = {.sin6_family = AF_INET6};
    if (inet_pton(AF_INET, host, &four.sin_addr) == 1)
        return srv_hook_address_may((const struct sockaddr *)(const void *)&four, networks);
    if (inet_pton(AF_INET6, host, &six.sin6_addr) == 1)
        return srv_hook_address_may((const struct sockaddr *)(const void *)&six, networks);
    return 1;
}
