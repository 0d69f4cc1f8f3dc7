/* Rooms in which a class works together, in the store: who is in them, and the items that stand
 * there, each with the number of the change that it was written by.
 * Leaves to others: what an item says (api/class/class_json), who asks (classes), telling of
 * changes (classes/class_events).
 * Invariant: changes of a room are numbered without a gap in the order in which they are committed;
 * who has read all items up to a number misses nothing by asking for those above it. */
#ifndef SRV_STORE_CLASSES_H
#define SRV_STORE_CLASSES_H

#include "server/store/store_class_pupils.h"

enum {
    SRV_CLASS_NAME = 96,                /* bytes of an item's name, with its NUL */
    SRV_CLASS_ITEM_BYTES = 128,         /* that an item is counted for beside its body */
    SRV_CLASS_PUPIL_BYTES = 128 * 1024, /* that the items of one pupil may be counted for */
    SRV_CLASS_PAGE_BYTES = 64 * 1024,   /* after so many bytes of items a page ends */
    SRV_CLASS_ALL = 0,                  /* a reader: everybody in the room */
    SRV_CLASS_TEACHER = -1              /* a reader: the teacher alone; k > 0: and pupil k */
};

/* A room, as somebody meets it. Times are microseconds since 1970 by the store's clock. */
struct srv_class {
    char code[SRV_CLASS_CODE];
    int64_t created, ends;
    int64_t version, shared; /* the last change; the last one that everybody may read */
    int64_t pupils;          /* in the room */
    int64_t numbered;        /* that ever were: the highest number of one */
    int64_t bytes;           /* that its items are counted for */
    int64_t empty_ends;      /* when it ends if nobody has joined; 0 = somebody has, or at `ends` */
    int64_t share;           /* pupils that one address may have; 0 = the default */
    char source[SRV_CLASS_SOURCE]; /* the mark of the address that made it, */
    char near[SRV_CLASS_SOURCE];   /* and of the one from which its teacher wrote last */
    int shut;                      /* nobody more may join */
    int teacher;                   /* who asks is the teacher; */
    int64_t pupil;                 /* a pupil of this number, 0 = none; */
    int64_t pupil_bytes;           /* whose items are counted for so many */
};

/* Why nothing was written. */
enum srv_class_why {
    SRV_CLASS_FINE,
    SRV_CLASS_STRANGER,   /* the token belongs to nobody in the room */
    SRV_CLASS_NO_TEACHER, /* only the teacher may */
    SRV_CLASS_NO_PUPIL,   /* only a pupil may */
    SRV_CLASS_SHUT,       /* the teacher has shut the door */
    SRV_CLASS_CROWDED,    /* the room has max-class-pupils */
    SRV_CLASS_SHARED,     /* the address has its share of the room's pupils */
    SRV_CLASS_ROOM_FULL,  /* the items of the room would pass max-class-bytes */
    SRV_CLASS_PUPIL_FULL, /* those of the pupil would pass SRV_CLASS_PUPIL_BYTES */
    SRV_CLASS_NO_BASE,    /* what the item answers is not there */
    SRV_CLASS_CLOSED,     /* it takes no answers any more */
    SRV_CLASS_MISFIT      /* the item is no answer to it */
};

/* Something to write into a room. */
struct srv_class_put {
    const char *code, *who; /* the room, and the key of the token */
    const char *name;       /* of the item; that of a pupil's has "/NUMBER" behind it */
    const char *base;       /* the item that this one answers, NULL = none */
    int own;                /* a pupil writes it, and no other; else the teacher does */
    int64_t reader;         /* of a teacher's item: SRV_CLASS_ALL or SRV_CLASS_TEACHER */
    int64_t flag;           /* kept with the item; an odd one takes no answers */
    int (*fits)(int64_t base, int64_t flag); /* whether an item answers another by their flags;
                                                NULL = any does */
    int shut;                                /* the door from now on: 1, 0, -1 = as it is */
    int share;                               /* of an address from now on; 0 = as it is */
    const char *source;                      /* the mark of the address */
    const char *fold;                        /* of who joins: the folded nickname */
    const char *pupils;                      /* NULL, or the numbers of pupils who go: "3,7-12" */
    int operates;                            /* an operator asks, who may end every room */
    const void *body;                        /* NULL = the item goes */
    size_t bytes;
    enum srv_class_why why; /* out */
};

/* An item of a room, lent for a call. */
struct srv_class_item {
    char name[SRV_CLASS_NAME];
    int64_t version, reader, flag, changed;
    const void *body; /* of no bytes: the item is gone */
    size_t bytes;
};

/** Receives an item, in the order of versions. Anything but SRV_STORED ends the reading with
 * that. */
typedef enum srv_stored srv_class_item_fn(void *context, const struct srv_class_item *item);

/* A room to be made. */
struct srv_class_new {
    const char *code;     /* a new one */
    const char *who;      /* the teacher */
    const char *key;      /* the client's own idempotency key, or NULL */
    const char *source;   /* the mark of the address */
    int64_t span_us;      /* how long it is there, */
    int64_t empty_us;     /* and while nobody has joined; 0 = as long */
    long most, most_from; /* rooms that the teacher, and all from the address, may have */
};

/**
 * Makes a room.
 *
 * room  out; where the same key made a room before, that room: its code differs then.
 * full  out: which bound was met: "max-classes", or what it is called in a problem.
 *
 * SRV_STORED_CLASH  the code is taken.
 * SRV_STORED_QUOTA  there are max-classes rooms, or the teacher or the address has its share.
 */
enum srv_stored srv_store_class_new(struct srv_store *store, const struct srv_class_new *made,
                                    struct srv_class *room, const char **full);

/** Reads a room, and who asks there. SRV_STORED_NONE: there is none, or it has ended. */
enum srv_stored srv_store_class(struct srv_store *store, const char *code, const char *who,
                                struct srv_class *room);

/**
 * Lets a pupil in, and keeps an item "pupils/NUMBER", which the pupil and the teacher may read.
 * Whoever is in already keeps number and item. A nickname whose fold is in the room already is
 * numbered: " (2)" comes before the last two bytes of the body, which are its quote and brace.
 *
 * put   code, who, body, bytes, source and fold are read; why is set.
 *
 * SRV_STORED_NONE   no such room.
 * SRV_STORED_CLASH  see put->why.
 * SRV_STORED_AGAIN  another process writes into the room just now.
 */
enum srv_stored srv_store_class_join(struct srv_store *store, struct srv_class_put *put,
                                     struct srv_class *room);

/**
 * Writes an item, or takes one away; one that is there already as it is to be is not written, so
 * that a request may be repeated. Pupils whom put->pupils numbers go with all items of theirs.
 *
 * room  out: as it is afterwards.
 *
 * Fails as srv_store_class_join. O(1) but for a pupil that goes: O(items of the pupil).
 */
enum srv_stored srv_store_class_put(struct srv_store *store, struct srv_class_put *put,
                                    struct srv_class *room);

/**
 * Reads the items that whoever asks may read and that were written after a change, 64 at most, and
 * none after the one that passes SRV_CLASS_PAGE_BYTES.
 *
 * since  in: the change; out: the one up to which nothing is left out.
 * more   out: there may be further ones.
 *
 * SRV_STORED_NONE   no such room.
 * SRV_STORED_CLASH  the token belongs to nobody in it.
 * O(1), for a pupil O(items that it may read).
 */
enum srv_stored srv_store_class_items(struct srv_store *store, const char *code, const char *who,
                                      int64_t *since, int *more, struct srv_class *room,
                                      srv_class_item_fn *take, void *context);

/** Erases a room at its teacher's word, or an operator's. As srv_store_class_join fails. O(items)
 */
enum srv_stored srv_store_class_end(struct srv_store *store, struct srv_class_put *put,
                                    struct srv_class *room);

/** Erases a room that a client has, or takes the client out of one. count: 1; 0 when it is in none.
 * SRV_STORED_AGAIN: another process writes into the room just now. O(items) */
enum srv_stored srv_store_erase_classes(struct srv_store *store, const char *client, int *count);

#endif
