/* Records of zip archives whose members are stored and not deflated: what stands before a member
 * and, where its checksum is known only then, behind it, and the directory at the end. Sizes and
 * places beyond the fields of 32 bits go into those of 64 (ZIP64;
 * APPNOTE 6.3.10, 4.3.14, 4.3.15, 4.5.3), and into these only then: so that readers without them
 * read all small archives. Leaves to others: the members' bytes and checksums (encode_npz).
 * Invariant: the same members give the same bytes; no time of
 * day, no attributes. */
#ifndef API_ENCODE_ZIP64_H
#define API_ENCODE_ZIP64_H

#include <stdint.h>

enum { API_ZIP64_NAME = 48 };

/* a file of the archive */
struct api_zip64_member {
    char name[API_ZIP64_NAME];
    uint32_t crc;
    uint64_t bytes, offset; /* offset: of its first record, from the begin of the archive */
    int streamed;           /* length and checksum stand behind it; not yet known before */
};

/* bytes of the records without name and fields of 64 bits: before a member, of it in the directory,
 * at the archive's end; of a large archive's end; and of what says where that is */
enum {
    API_ZIP64_LOCAL_HEAD = 30,
    API_ZIP64_CENTRAL_HEAD = 46,
    API_ZIP64_END_HEAD = 22,
    API_ZIP64_END_WIDE = 56,
    API_ZIP64_LOCATOR = 20
};

/* bytes of the records, at most: before a member, behind it, of it in the directory, the end */
enum {
    API_ZIP64_LOCAL = API_ZIP64_LOCAL_HEAD + API_ZIP64_NAME + 20,
    API_ZIP64_BEHIND = 24,
    API_ZIP64_CENTRAL = API_ZIP64_CENTRAL_HEAD + API_ZIP64_NAME + 28,
    API_ZIP64_END = API_ZIP64_END_WIDE + API_ZIP64_LOCATOR + API_ZIP64_END_HEAD
};

/* the largest number of a field of 32 bits, whose last value means "see the field of 64" */
#define API_ZIP64_MOST UINT64_C(0xfffffffe)
#define API_ZIP64_THERE UINT64_C(0xffffffff)

/**
 * Writes what stands before a member's bytes.
 *
 * at    room for API_ZIP64_LOCAL bytes.
 * most  API_ZIP64_MOST; less in tests, which have no archives of 4 GiB.
 *
 * Returns the end. O(1).
 */
char *api_zip64_local(char *at, const struct api_zip64_member *member, uint64_t most);

/** Writes what stands behind a streamed member's bytes, API_ZIP64_BEHIND bytes. Returns the end. */
char *api_zip64_behind(char *at, const struct api_zip64_member *member);

/** Writes a member's record of the directory: at most API_ZIP64_CENTRAL bytes. Returns the end. */
char *api_zip64_central(char *at, const struct api_zip64_member *member, uint64_t most);

/**
 * Writes the end of the archive, behind the directory.
 *
 * at       room for API_ZIP64_END bytes.
 * members  in the directory; fewer than 65535.
 * begin    place of the directory's first byte in the archive.
 * bytes    of the directory.
 *
 * Returns the end. O(1).
 */
char *api_zip64_end(char *at, int members, uint64_t begin, uint64_t bytes, uint64_t most);

#endif
