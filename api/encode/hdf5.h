/* Records of HDF5 files (HDF5 File Format Specification, version 3.0): the superblock, object
 * headers with their messages, and the nodes of the trees that say where the pieces of an array
 * are. What is used of the format is what libraries from 1.8 (2008) on read.
 * Leaves to others: what stands where in a file (encode_hdf5).
 * Invariant: no record depends on anything but what it is given; whole numbers are little-endian.
 */
#ifndef API_ENCODE_HDF5_H
#define API_ENCODE_HDF5_H

#include <stddef.h>
#include <stdint.h>

enum {
    API_HDF5_SUPERBLOCK = 48,
    API_HDF5_HEADER = 192, /* bytes of the header of an array */
    API_HDF5_AXES = 3,
    API_HDF5_FAN = 64 /* children of a node of a tree */
};

#define API_HDF5_NOWHERE UINT64_MAX /* the place of what is not there */

/* What a number of an array is. */
enum api_hdf5_type {
    API_HDF5_DOUBLE,
    API_HDF5_FLOAT,
    API_HDF5_WHOLE /* of 64 bits with a sign */
};

/* An array: its axes, and where its numbers are. */
struct api_hdf5_array {
    enum api_hdf5_type type;
    int axes; /* 0 = one number */
    uint64_t length[API_HDF5_AXES];
    uint64_t place; /* of the numbers, or, if they are in pieces, of the root of their tree */
    uint64_t piece; /* rows of a piece; 0 = all numbers are in one place, one after the other */
};

/** Writes the first API_HDF5_SUPERBLOCK bytes of a file. root: place of the root group's header;
 * end: bytes of the file. */
void api_hdf5_superblock(char *at, uint64_t root, uint64_t end);

/** Begins the header of an object: returns where its messages begin. */
char *api_hdf5_begin(char *head);

/**
 * Ends the header of an object: fills it with nothing, and writes its length and checksum.
 *
 * head   the begin of the header, `bytes` bytes.
 * at     the end of its messages, at most 65535 bytes and at least 8 before the header's end.
 */
void api_hdf5_end(char *head, char *at, size_t bytes);

/** Writes the header of an array, API_HDF5_HEADER bytes. */
void api_hdf5_array(char *head, const struct api_hdf5_array *array);

/** Writes the messages of a group before its links. Returns the end, 28 bytes on. */
char *api_hdf5_group(char *at);

/** Writes a link of a group to the header of an object. name: fewer than 256 letters. Returns the
 * end, 15 bytes and the name on. */
char *api_hdf5_link(char *at, const char *name, uint64_t header);

/** Writes an attribute that is a number of 8 bytes, little-endian in `value`. Returns the end,
 * fewer than 64 bytes and the name on. */
char *api_hdf5_number(char *at, const char *name, enum api_hdf5_type type, const char value[8]);

/**
 * Writes an attribute that is text.
 *
 * texts  how many there are: -1 = one, which has no axis.
 * each   bytes of a text, the last of which is 0.
 *
 * Returns the end, fewer than 64 bytes, the name and the texts on.
 */
char *api_hdf5_text(char *at, const char *name, int texts, size_t each, const char *value);

/** Returns the bytes of a node of the tree of an array. O(1). */
size_t api_hdf5_node_bytes(int axes);

/** Returns how many nodes the tree of so many pieces has. O(log pieces). */
uint64_t api_hdf5_nodes(uint64_t pieces);

/**
 * Writes node i of the tree of an array in pieces.
 *
 * array   its `place` is ignored.
 * tree    place of node 0; the nodes stand one after the other, those above others behind them, the
 *         root last.
 * first   place of the first piece; `apart` bytes after the begin of each is the next one.
 *
 * O(API_HDF5_FAN)
 */
void api_hdf5_node(char *at, const struct api_hdf5_array *array, uint64_t i, uint64_t tree,
                   uint64_t first, uint64_t apart);

#endif
