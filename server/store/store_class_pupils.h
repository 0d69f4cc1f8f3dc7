/* Of rooms: which ones somebody has, their last changes, how many pupils come from one address, the
 * numbers of nicknames that look alike, and the rooms' end.
 * Leaves to others: what a name is folded to (classes/nickname), writing (store_classes).
 * Invariant: two pupils who are in a room at the same time never have the same shown name. */
#ifndef SRV_STORE_CLASS_PUPILS_H
#define SRV_STORE_CLASS_PUPILS_H

#include "server/store/store_call.h"

enum {
    SRV_CLASS_CODE = 7,     /* bytes of a room's code, with its NUL */
    SRV_CLASS_SOURCE = 6,   /* of the mark of an address, with its NUL */
    SRV_CLASS_FOLD = 320,   /* of a folded nickname, with its NUL */
    SRV_CLASS_NAMED = 1200, /* of a pupil's body with its number */
    SRV_CLASS_SHARE = 40    /* pupils that one address may have in a room at least */
};

/* Codes of rooms. */
struct srv_class_codes {
    int count;
    char code[SQL_CLASSES_MOST][SRV_CLASS_CODE];
};

/** Takes a row into a struct srv_class_codes. */
enum srv_stored srv_row_class_code(void *context, const struct srv_value field[]);

/** The codes after `after` of the rooms that a teacher has, "" = of all, in order, at most
 * SQL_CLASSES_MOST; rooms that have ended may be among them. A call of its own. */
enum srv_stored srv_store_class_codes(struct srv_store *store, const char *teacher,
                                      const char *after, struct srv_class_codes *codes);

/** The numbers of the last change, and of the last that everybody may read. SRV_STORED_NONE: the
 * room has ended. */
enum srv_stored srv_store_class_mark(struct srv_store *store, const char *code, int64_t *version,
                                     int64_t *shared);

/** How many pupils of a room come from an address, by its mark; within a call. */
enum srv_stored srv_store_class_from(struct srv_store *store, const char *code, const char *source,
                                     int64_t *count);

/** The same as a call of its own. */
enum srv_stored srv_store_class_comes(struct srv_store *store, const char *code, const char *source,
                                      int64_t *count);

/** How many pupils of a room may come from one address, where its teacher has not said. */
int64_t srv_store_class_share(const struct srv_store *store);

/**
 * The body of a pupil who joins a room, and the fold that is kept: both with a number where others
 * have the fold already, the least that is free. O(pupils of the room)
 *
 * body        SRV_CLASS_NAMED bytes, of which *bytes are used; in and out.
 * fold, kept  of the name; out: SRV_CLASS_FOLD bytes.
 */
enum srv_stored srv_store_class_named(struct srv_store *store, const char *code, const char *fold,
                                      char body[], size_t *bytes, char kept[]);

/** Reads the next of the ranges of numbers "3,7-12"; 0 at the end, or where it is none. */
int srv_store_class_range(const char **at, int64_t *from, int64_t *to);

/** Removes a room with all that is kept of it, in the transaction that runs; processes are woken.
 * O(items) */
enum srv_stored srv_store_class_erase(struct srv_store *store, const char *code);

/** Removes one room whose time is over; *more becomes 1 if there was one. */
enum srv_stored srv_store_class_sweep(struct srv_store *store, int64_t now, int *more);

#endif
