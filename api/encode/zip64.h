/* Records of zip archives with uncompressed members: the local header, the data descriptor and the
 * central directory. Sizes and offsets that exceed 32 bits use the ZIP64 fields (APPNOTE 6.3.10,
 * sections 4.3.14, 4.3.15, 4.5.3); small archives stay readable without ZIP64.
 * Leaves to others: the members' bytes and checksums (encode_npz).
 * Invariant: the same members give the same bytes; no time of day, no attributes. */
#pragma once

#include <stdint.h>

enum { API_ZIP64_NAME = 48 };

/* a member of the archive */
struct api_zip64_member {
    char name[API_ZIP64_NAME];
    uint32_t crc;
    uint64_t bytes, offset; /* offset of its local header in the archive */
    int streamed;           /* whether a data descriptor after it has its size and checksum */
};

/* Bytes of the records without names and ZIP64 fields; END_WIDE and LOCATOR are the ZIP64 end of
 * central directory record and its locator. */
enum {
    API_ZIP64_LOCAL_HEAD = 30,
    API_ZIP64_CENTRAL_HEAD = 46,
    API_ZIP64_END_HEAD = 22,
    API_ZIP64_END_WIDE = 56,
    API_ZIP64_LOCATOR = 20
};

/* Upper bounds of the records with names and ZIP64 fields; BEHIND is the data descriptor. */
enum {
    API_ZIP64_LOCAL = API_ZIP64_LOCAL_HEAD + API_ZIP64_NAME + 20,
    API_ZIP64_BEHIND = 24,
    API_ZIP64_CENTRAL = API_ZIP64_CENTRAL_HEAD + API_ZIP64_NAME + 28,
    API_ZIP64_END = API_ZIP64_END_WIDE + API_ZIP64_LOCATOR + API_ZIP64_END_HEAD
};

/* The largest value of a 32-bit field; the value above it means "see the ZIP64 field". */
#define API_ZIP64_MOST UINT64_C(0xfffffffe)
#define API_ZIP64_THERE UINT64_C(0xffffffff)

/**
 * Writes a member's local header.
 *
 * at    space for API_ZIP64_LOCAL bytes.
 * most  largest value of a 32-bit field: API_ZIP64_MOST; smaller only in tests.
 *
 * Returns the end. O(1).
 */
char *api_zip64_local(char *at, const struct api_zip64_member *member, uint64_t most);

/** Writes the data descriptor of a streamed member, API_ZIP64_BEHIND bytes. Returns the end. */
char *api_zip64_behind(char *at, const struct api_zip64_member *member);

/** Writes a member's entry of the central directory, at most API_ZIP64_CENTRAL bytes. Returns the
 * end. */
char *api_zip64_central(char *at, const struct api_zip64_member *member, uint64_t most);

/**
 * Writes the end of the archive, after the central directory.
 *
 * at       space for API_ZIP64_END bytes.
 * members  number of entries; fewer than 65535.
 * begin    offset of the directory in the archive.
 * bytes    size of the directory.
 *
 * Returns the end. O(1).
 */
char *api_zip64_end(char *at, int members, uint64_t begin, uint64_t bytes, uint64_t most);
