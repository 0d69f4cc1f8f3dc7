/* Classrooms: the rooms of a teacher, their last changes, pupils by address, numbering of similar
 * nicknames, and expiry.
 * Leaves to others: folding a name (classes/nickname), writing (store_classes).
 * Invariant: two pupils in a room at the same time never have the same displayed name. */
#pragma once

#include "server/store/store_call.h"

enum {
    SRV_CLASS_CODE = 7,     /* bytes of a room's code with its NUL */
    SRV_CLASS_SOURCE = 6,   /* bytes of the digest bits of an address, with NUL */
    SRV_CLASS_FOLD = 320,   /* bytes of a folded nickname with its NUL */
    SRV_CLASS_NAMED = 1200, /* bytes of a pupil's body with its number */
    SRV_CLASS_SHARE = 40    /* pupils of one address that a room always admits */
};

/* Codes of rooms. */
struct srv_class_codes {
    int count;
    char code[SQL_CLASSES_MOST][SRV_CLASS_CODE];
};

/** Reads a row into a struct srv_class_codes. */
enum srv_stored srv_row_class_code(void *context, const struct srv_value field[]);

/** Lists the codes after `after` of a teacher's rooms ("" = all rooms) in order, at most
 * SQL_CLASSES_MOST; expired rooms may be among them. A call of its own. */
enum srv_stored srv_store_class_codes(struct srv_store *store, const char *teacher,
                                      const char *after, struct srv_class_codes *codes);

/** Reads the numbers of the last change, and of the last one that everyone may read.
 * SRV_STORED_NONE: the room has ended. */
enum srv_stored srv_store_class_mark(struct srv_store *store, const char *code, int64_t *version,
                                     int64_t *shared);

/** Counts the pupils of a room that joined from an address, given its digest bits; within a call.
 */
enum srv_stored srv_store_class_from(struct srv_store *store, const char *code, const char *source,
                                     int64_t *count);

/** As srv_store_class_from, as a call of its own. */
enum srv_stored srv_store_class_comes(struct srv_store *store, const char *code, const char *source,
                                      int64_t *count);

/**
 * Makes a joining pupil's nickname unique: if its fold is in use, adds the least free number to the
 * body and to the stored fold. O(pupils of the room).
 *
 * body        in and out: SRV_CLASS_NAMED bytes, of which *bytes are used.
 * fold, kept  the name's fold; out: the fold to store, SRV_CLASS_FOLD bytes.
 */
enum srv_stored srv_store_class_named(struct srv_store *store, const char *code, const char *fold,
                                      char body[], size_t *bytes, char kept[]);

/** Reads the next range of numbers in "3,7-12"; returns 0 at the end, or if malformed. */
int srv_store_class_range(const char **at, int64_t *from, int64_t *to);

/** Deletes a room with all its items, within the current transaction, and notifies other processes.
 * O(items). */
enum srv_stored srv_store_class_erase(struct srv_store *store, const char *code);

/** Deletes one expired room; sets *more to 1 if there was one. */
enum srv_stored srv_store_class_sweep(struct srv_store *store, int64_t now, int *more);
