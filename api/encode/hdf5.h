/* Records of HDF5 files (HDF5 File Format Specification, version 3.0): the superblock, object
 * headers with their messages, and the B-tree nodes that index the chunks of an array. HDF5 1.8
 * (2008) and later read them.
 * Leaves to others: the layout of a file (encode_hdf5).
 * Invariant: a record depends only on the arguments; integers are little-endian. */
#pragma once

#include <stddef.h>
#include <stdint.h>

enum {
    API_HDF5_SUPERBLOCK = 48,
    API_HDF5_HEADER = 192, /* bytes of the header of an array */
    API_HDF5_AXES = 3,
    API_HDF5_FAN = 64 /* maximum number of children of a B-tree node */
};

#define API_HDF5_NOWHERE UINT64_MAX /* the undefined address */

/* The type of an array's numbers. */
enum api_hdf5_type {
    API_HDF5_DOUBLE,
    API_HDF5_FLOAT,
    API_HDF5_WHOLE /* int64 */
};

/* An array: its shape, and the address of its numbers. */
struct api_hdf5_array {
    enum api_hdf5_type type;
    int axes; /* 0 = a single number */
    uint64_t length[API_HDF5_AXES];
    uint64_t place; /* address of the numbers, or of the B-tree's root if the array is chunked */
    uint64_t piece; /* rows per chunk; 0 = contiguous */
};

/** Writes the first API_HDF5_SUPERBLOCK bytes of a file. root: address of the root group's header;
 * end: size of the file in bytes. */
void api_hdf5_superblock(char *at, uint64_t root, uint64_t end);

/** Starts an object header. Returns the position of its first message. */
char *api_hdf5_begin(char *head);

/**
 * Ends an object header: pads it with a NIL message, and writes its length and checksum.
 *
 * head   the header, `bytes` bytes.
 * at     end of its messages, at most 65535 bytes and at least 8 before the end of the header.
 */
void api_hdf5_end(char *head, char *at, size_t bytes);

/** Writes the header of an array, API_HDF5_HEADER bytes. */
void api_hdf5_array(char *head, const struct api_hdf5_array *array);

/** Writes a group's messages that precede its links, 28 bytes. Returns the end. */
char *api_hdf5_group(char *at);

/** Writes a link to an object header, 15 bytes and the name (fewer than 256 bytes). Returns the
 * end. */
char *api_hdf5_link(char *at, const char *name, uint64_t header);

/** Writes a numeric attribute, less than 64 bytes and the name. value: 8 bytes, little-endian.
 * Returns the end. */
char *api_hdf5_number(char *at, const char *name, enum api_hdf5_type type, const char value[8]);

/**
 * Writes a text attribute: less than 64 bytes, the name and the texts.
 *
 * texts  number of texts; -1 = one scalar text.
 * each   bytes of a text with its final 0.
 *
 * Returns the end.
 */
char *api_hdf5_text(char *at, const char *name, int texts, size_t each, const char *value);

/** Returns the bytes of a B-tree node of an array. O(1). */
size_t api_hdf5_node_bytes(int axes);

/** Returns the number of B-tree nodes for this many chunks. O(log pieces). */
uint64_t api_hdf5_nodes(uint64_t pieces);

/**
 * Writes node i of the B-tree of a chunked array.
 *
 * array   its `place` is ignored.
 * tree    address of node 0. The nodes are contiguous: the leaves first, then each level above, the
 *         root last.
 * first   address of the first chunk; chunks are `apart` bytes apart.
 *
 * O(API_HDF5_FAN)
 */
void api_hdf5_node(char *at, const struct api_hdf5_array *array, uint64_t i, uint64_t tree,
                   uint64_t first, uint64_t apart);
