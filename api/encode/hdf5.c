#include "api/encode/hdf5.h"

#include <assert.h>
#include <string.h>

#include "api/base/octets.h"

/* Types of messages; bytes of a message's header, of an object header's prefix and of its
 * checksum. */
enum { NOTHING, SPACE, LINKS, TYPE, FILL = 5, LINK, LAYOUT = 8, GROUP = 10, ATTRIBUTE = 12 };
enum { MESSAGE_BYTES = 4, BEGIN_BYTES = 10, SUM_BYTES = 4 };

/* the checksum: Bob Jenkins' lookup3 over little-endian words */

static uint32_t turn(uint32_t x, int by) { return x << by | x >> (32 - by); }

static uint32_t word(const unsigned char *at) {
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void mix(uint32_t *a, uint32_t *b, uint32_t *c, int by) {
    *a -= *c;
    *a ^= turn(*c, by);
    *c += *b;
}

static uint32_t fold(uint32_t x, uint32_t y, int by) { return (x ^ y) - turn(y, by); }

static uint32_t checksum(const void *data, size_t bytes) {
    const unsigned char *at = data;
    unsigned char last[12] = {0};
    uint32_t a = 0xdeadbeef + (uint32_t)bytes, b = a, c = a;
    for (; bytes > 12; bytes -= 12, at += 12) {
        a += word(at);
        b += word(at + 4);
        c += word(at + 8);
        mix(&a, &b, &c, 4);
        mix(&b, &c, &a, 6);
        mix(&c, &a, &b, 8);
        mix(&a, &b, &c, 16);
        mix(&b, &c, &a, 19);
        mix(&c, &a, &b, 4);
    }
    memcpy(last, at, bytes);
    a += word(last);
    b += word(last + 4);
    c += word(last + 8);
    c = fold(c, b, 14);
    a = fold(a, c, 11);
    b = fold(b, a, 25);
    c = fold(c, b, 16);
    a = fold(a, c, 4);
    b = fold(b, a, 14);
    return fold(c, b, 24);
}

void api_hdf5_superblock(char *at, uint64_t root, uint64_t end) {
    char *begin = at;
    memcpy(at, "\x89HDF\r\n\x1a\n\2\x8\x8", 12); // version 2; addresses and lengths of 8 bytes
    at = api_octets_whole(at + 12, 0, 8);
    at = api_octets_whole(at, API_HDF5_NOWHERE, 8);
    at = api_octets_whole(api_octets_whole(at, end, 8), root, 8);
    at = api_octets_whole(at, checksum(begin, API_HDF5_SUPERBLOCK - SUM_BYTES), 4);
    assert(at == begin + API_HDF5_SUPERBLOCK);
}

char *api_hdf5_begin(char *head) {
    memcpy(head, "OHDR\2\2", 6); // version 2, without times, with a length of 4 bytes
    return head + BEGIN_BYTES;
}

/* writes a message's header; the body follows. Returns the end */
static char *message(char *at, int kind, size_t bytes) {
    assert(bytes <= 0xffff);
    at = api_octets_whole(api_octets_whole(at, (uint64_t)kind, 1), bytes, 2);
    return api_octets_whole(at, 0, 1);
}

void api_hdf5_end(char *head, char *at, size_t bytes) {
    char *end = head + bytes - SUM_BYTES;
    assert(at + MESSAGE_BYTES <= end);
    size_t rest = (size_t)(end - at) - MESSAGE_BYTES;
    memset(message(at, NOTHING, rest), 0, rest);
    api_octets_whole(head + 6, bytes - BEGIN_BYTES - SUM_BYTES, 4);
    api_octets_whole(end, checksum(head, bytes - SUM_BYTES), 4);
}

/* ---- datatype and dataspace messages */

static size_t number_bytes(enum api_hdf5_type type) {
    static const size_t bytes[] = {8, 4, 8};
    return bytes[type];
}

static char *type_write(char *at, enum api_hdf5_type type) {
    static const char whole[] = "\x10\x8\0\0\x8\0\0\0\0\0\x40\0",
                      wide[] = "\x11\x20\x3f\0\x8\0\0\0\0\0\x40\0\x34\xb\0\x34\xff\3\0\0",
                      narrow[] = "\x11\x20\x1f\0\x4\0\0\0\0\0\x20\0\x17\x8\0\x17\x7f\0\0\0";
    if (type == API_HDF5_WHOLE) return (char *)memcpy(at, whole, sizeof whole - 1) + 12;
    if (type == API_HDF5_DOUBLE) return (char *)memcpy(at, wide, sizeof wide - 1) + 20;
    return (char *)memcpy(at, narrow, sizeof narrow - 1) + 20;
}

static char *space_write(char *at, int axes, const uint64_t length[]) {
    at = api_octets_whole(api_octets_whole(at, 2, 1), (uint64_t)axes, 1);
    at = api_octets_whole(api_octets_whole(at, 0, 1), axes > 0, 1);
    for (int i = 0; i < axes; i++) at = api_octets_whole(at, length[i], 8);
    return at;
}

/* ---- data layout messages */
static char *layout_write(char *at, const struct api_hdf5_array *array) {
    uint64_t bytes = number_bytes(array->type);
    at = api_octets_whole(api_octets_whole(at, 3, 1), array->piece ? 2 : 1, 1);
    if (array->piece) at = api_octets_whole(at, (uint64_t)array->axes + 1, 1);
    at = api_octets_whole(at, array->place, 8);
    if (array->piece) {
        at = api_octets_whole(at, array->piece, 4);
        for (int i = 1; i < array->axes; i++) at = api_octets_whole(at, array->length[i], 4);
        return api_octets_whole(at, bytes, 4);
    }
    for (int i = 0; i < array->axes; i++) bytes *= array->length[i];
    return api_octets_whole(at, bytes, 8);
}

/* writes the header of a message whose body is already written */
static char *message_close(char *head, int kind, char *end) {
    message(head, kind, (size_t)(end - head) - MESSAGE_BYTES);
    return end;
}

void api_hdf5_array(char *head, const struct api_hdf5_array *array) {
    assert(array->axes >= 0 && array->axes <= API_HDF5_AXES && (!array->piece || array->axes));
    char *at = api_hdf5_begin(head);
    at = message_close(at, SPACE, space_write(at + MESSAGE_BYTES, array->axes, array->length));
    at = message_close(at, TYPE, type_write(at + MESSAGE_BYTES, array->type));
    // no fill values: numbers that are not written count as 0
    at = api_octets_whole(message(at, FILL, 2), array->piece ? 0xb03 : 0xa03, 2);
    at = message_close(at, LAYOUT, layout_write(at + MESSAGE_BYTES, array));
    api_hdf5_end(head, at, API_HDF5_HEADER);
}

char *api_hdf5_group(char *at) {
    at = api_octets_whole(message(at, LINKS, 18), 0, 2);
    at = api_octets_whole(api_octets_whole(at, API_HDF5_NOWHERE, 8), API_HDF5_NOWHERE, 8);
    return api_octets_whole(message(at, GROUP, 2), 0, 2);
}

char *api_hdf5_link(char *at, const char *name, uint64_t header) {
    size_t length = strlen(name);
    assert(length < 256);
    at = api_octets_whole(message(at, LINK, 3 + length + 8), 1, 2); // version 1
    at = memcpy(api_octets_whole(at, length, 1), name, length);
    return api_octets_whole(at + length, header, 8);
}

/* ---- attribute messages */
static char *attribute(char *at, const char *name, const char *type, size_t type_bytes, int texts) {
    char space[16], *end = space_write(space, texts >= 0, &(uint64_t){(uint64_t)texts});
    size_t length = strlen(name) + 1, space_bytes = (size_t)(end - space);
    at = api_octets_whole(api_octets_whole(at, 3, 2), length, 2);
    at = api_octets_whole(api_octets_whole(at, type_bytes, 2), space_bytes, 2);
    at = memcpy(api_octets_whole(at, 0, 1), name, length);
    at = memcpy(at + length, type, type_bytes);
    at = memcpy(at + type_bytes, space, space_bytes);
    return at + space_bytes;
}

char *api_hdf5_number(char *at, const char *name, enum api_hdf5_type type, const char value[8]) {
    char kind[24];
    assert(number_bytes(type) == 8);
    size_t bytes = (size_t)(type_write(kind, type) - kind);
    char *end = attribute(at + MESSAGE_BYTES, name, kind, bytes, -1);
    memcpy(end, value, 8);
    return message_close(at, ATTRIBUTE, end + 8);
}

char *api_hdf5_text(char *at, const char *name, int texts, size_t each, const char *value) {
    char kind[8], *end;
    size_t bytes = each * (texts < 0 ? 1 : (size_t)texts);
    api_octets_whole(api_octets_whole(kind, 0x13, 4), each, 4); // ASCII, terminated by a 0
    end = attribute(at + MESSAGE_BYTES, name, kind, sizeof kind, texts);
    memcpy(end, value, bytes);
    return message_close(at, ATTRIBUTE, end + bytes);
}

/* ---- B-trees of chunks */

enum { NODE_BYTES = 24 }; /* bytes before a node's keys and addresses */

static size_t key_bytes(int axes) { return 8 + 8 * ((size_t)axes + 1); }

size_t api_hdf5_node_bytes(int axes) {
    return NODE_BYTES + (API_HDF5_FAN + 1) * key_bytes(axes) + API_HDF5_FAN * 8;
}

/* the number of parents of this many nodes */
static uint64_t above(uint64_t children) { return (children + API_HDF5_FAN - 1) / API_HDF5_FAN; }

uint64_t api_hdf5_nodes(uint64_t pieces) {
    uint64_t nodes = 0;
    for (uint64_t level = pieces; level && (level > 1 || !nodes); nodes += level)
        level = above(level);
    return nodes;
}

void api_hdf5_node(char *at, const struct api_hdf5_array *array, uint64_t i, uint64_t tree,
                   uint64_t first, uint64_t apart) {
    size_t bytes = api_hdf5_node_bytes(array->axes), size = number_bytes(array->type);
    uint64_t pieces = (array->length[0] + array->piece - 1) / array->piece;
    // the level of the node, its index there, and the number of chunks below each of its children
    uint64_t children = pieces, begin = 0, below = 0, span = 1;
    int level = 0;
    for (; i - begin >= above(children); level++, span *= API_HDF5_FAN) {
        below = begin;
        begin += above(children);
        children = above(children);
    }
    uint64_t own = i - begin, child = own * API_HDF5_FAN, last = child + API_HDF5_FAN;
    if (last > children) last = children;
    for (int k = 0; k < array->axes; k++) size *= k ? array->length[k] : array->piece;
    memset(at, 0, bytes);
    at = api_octets_whole((char *)memcpy(at, "TREE\1", 5) + 5, (uint64_t)level, 1);
    at = api_octets_whole(at, last - child, 2);
    at = api_octets_whole(at, own ? tree + (i - 1) * bytes : API_HDF5_NOWHERE, 8);
    at = api_octets_whole(at, last < children ? tree + (i + 1) * bytes : API_HDF5_NOWHERE, 8);
    for (; child <= last; child++) {
        uint64_t piece = child * span < pieces ? child * span : pieces;
        api_octets_whole(at, child < last ? size : 0, 4);
        api_octets_whole(at + 8, piece * array->piece, 8);
        at += key_bytes(array->axes);
        if (child == last) break;
        uint64_t place = level ? tree + (below + child) * bytes : first + piece * apart;
        at = api_octets_whole(at, place, 8);
    }
}
