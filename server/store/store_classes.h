/* Classrooms in the store: pupils and items, each item with the number of the change that wrote
 * it. Leaves to others: the contents of an item (api/class/class_json), authentication (classes),
 * events (classes/class_events). Invariant: the changes of a room are numbered without gaps in
 * commit order, so a client that has read all items up to a number misses nothing by requesting
 * later ones. */
#pragma once

#include "server/store/store_class_pupils.h"

enum {
    SRV_CLASS_NAME = 96,                /* bytes of an item's name with its NUL */
    SRV_CLASS_ITEM_BYTES = 128,         /* bytes counted for an item in addition to its body */
    SRV_CLASS_PUPIL_BYTES = 128 * 1024, /* maximum bytes of a pupil's items */
    SRV_CLASS_PAGE_BYTES = 64 * 1024,   /* bytes of items after which a page ends */
    SRV_CLASS_ALL = 0,                  /* a reader: everyone in the room */
    SRV_CLASS_TEACHER = -1 /* a reader: only the teacher; k > 0: the teacher and pupil k */
};

/* A room as a client sees it. Times are microseconds since 1970 by the store's clock. */
struct srv_class {
    char code[SRV_CLASS_CODE];
    int64_t created, ends;
    int64_t version, shared; /* the last change; the last one that everyone may read */
    int64_t pupils;          /* number of pupils in the room */
    int64_t numbered;        /* highest number ever given to a pupil */
    int64_t bytes;           /* bytes counted for its items */
    int64_t empty_ends; /* expiry while no pupil has joined; 0 = it expires only at `ends`, because
                           a pupil has joined */
    int64_t share;      /* maximum number of pupils of one address; 0 = the default */
    char source[SRV_CLASS_SOURCE]; /* digest bits of the address that created the room */
    char near[SRV_CLASS_SOURCE];   /* digest bits of the address of the teacher's last write */
    int shut;                      /* closed for new pupils */
    int teacher;                   /* the client is the teacher */
    int64_t pupil;                 /* the client's number as a pupil; 0 = none */
    int64_t pupil_bytes;           /* bytes counted for this pupil's items */
};

/* The reason why nothing was written. */
enum srv_class_why {
    SRV_CLASS_FINE,
    SRV_CLASS_STRANGER,   /* the client is not in the room */
    SRV_CLASS_NO_TEACHER, /* allowed for the teacher only */
    SRV_CLASS_NO_PUPIL,   /* allowed for pupils only */
    SRV_CLASS_SHUT,       /* the teacher closed the room for new pupils */
    SRV_CLASS_CROWDED,    /* the room has max-class-pupils */
    SRV_CLASS_SHARED,     /* the address has reached its limit of pupils */
    SRV_CLASS_ROOM_FULL,  /* the room's items would exceed max-class-bytes */
    SRV_CLASS_PUPIL_FULL, /* the pupil's items would exceed SRV_CLASS_PUPIL_BYTES */
    SRV_CLASS_NO_BASE,    /* the question does not exist */
    SRV_CLASS_CLOSED,     /* the question no longer accepts answers */
    SRV_CLASS_MISFIT      /* the answer has the wrong type for the question */
};

/* A write to a room. */
struct srv_class_put {
    const char *code, *who; /* the room, and the key of the token */
    const char *name;       /* name of the item; "/NUMBER" is appended for a pupil's item */
    const char *base;       /* the item that this one answers; NULL = none */
    int own;                /* non-zero: only a pupil may write it; else only the teacher */
    int64_t reader;         /* for a teacher's item: SRV_CLASS_ALL or SRV_CLASS_TEACHER */
    int64_t flag;           /* stored with the item; if odd, it accepts no answers */
    int (*fits)(int64_t base, int64_t flag); /* checks an answer's flag against its question's; NULL
                                                = anything fits */
    int shut;           /* 1 closes the room for new pupils, 0 opens it, -1 = unchanged */
    int share;          /* new limit of pupils per address; 0 = unchanged */
    const char *source; /* digest bits of the client's address */
    const char *fold;   /* the folded nickname of a joining pupil */
    const char *pupils; /* NULL, or the numbers of pupils to remove: "3,7-12" */
    int operates;       /* the client is an operator, who may delete every room */
    const void *body;   /* NULL = delete the item */
    size_t bytes;
    enum srv_class_why why; /* out */
};

/* An item of a room, valid during a call. */
struct srv_class_item {
    char name[SRV_CLASS_NAME];
    int64_t version, reader, flag, changed;
    const void *body; /* if `bytes` is 0, the item is deleted */
    size_t bytes;
};

/** Receives an item, in the order of changes. Any result other than SRV_STORED ends the reading
 * with that result. */
typedef enum srv_stored srv_class_item_fn(void *context, const struct srv_class_item *item);

struct srv_class_new {
    const char *code;     /* a code that is not in use */
    const char *who;      /* the teacher's key */
    const char *key;      /* the client's idempotency key, or NULL */
    const char *source;   /* digest bits of the teacher's address */
    int64_t span_us;      /* lifetime, us */
    int64_t empty_us;     /* lifetime while no pupil has joined, us; 0 = span_us */
    long most, most_from; /* maximum number of rooms of the teacher, and of the address */
};

/**
 * Creates a room.
 *
 * room  out; if the same key created a room before, that room, whose code differs.
 * full  out: the limit that was reached: its subject in a sentence, such as "you have".
 *
 * SRV_STORED_CLASH  the code is in use.
 * SRV_STORED_QUOTA  there are max-classes rooms, or the teacher or the address has reached its
 * limit.
 */
enum srv_stored srv_store_class_new(struct srv_store *store, const struct srv_class_new *made,
                                    struct srv_class *room, const char **full);

/** Reads a room, and the client's role in it. SRV_STORED_NONE: it does not exist or has expired. */
enum srv_stored srv_store_class(struct srv_store *store, const char *code, const char *who,
                                struct srv_class *room);

/**
 * Adds a pupil, and writes the item "pupils/NUMBER", which the pupil and the teacher may read. A
 * client that is in the room already keeps its number and item. If the nickname's fold is in use, "
 * (2)" is inserted before the last two bytes of the body, its quote and brace.
 *
 * put   code, who, body, bytes, source and fold are read; why is set.
 *
 * SRV_STORED_NONE   the room does not exist.
 * SRV_STORED_CLASH  see put->why.
 * SRV_STORED_AGAIN  another process is writing to the room.
 */
enum srv_stored srv_store_class_join(struct srv_store *store, struct srv_class_put *put,
                                     struct srv_class *room);

/**
 * Writes or deletes an item; an equal item is not written again, so that requests can be repeated.
 * The pupils in put->pupils are removed with all their items.
 *
 * room  out: its state afterwards.
 *
 * Fails as srv_store_class_join. O(1); O(items of the pupil) to remove a pupil.
 */
enum srv_stored srv_store_class_put(struct srv_store *store, struct srv_class_put *put,
                                    struct srv_class *room);

/**
 * Reads the items after a change that the client may read: at most 64, and none after the one that
 * exceeds SRV_CLASS_PAGE_BYTES.
 *
 * since  in: the change; out: the change up to which all items were read.
 * more   out: non-zero if there may be further items.
 *
 * SRV_STORED_NONE   the room does not exist.
 * SRV_STORED_CLASH  the client is not in it.
 * O(1); for a pupil O(items that it may read).
 */
enum srv_stored srv_store_class_items(struct srv_store *store, const char *code, const char *who,
                                      int64_t *since, int *more, struct srv_class *room,
                                      srv_class_item_fn *take, void *context);

/** Deletes a room, for its teacher or an operator. Fails as srv_store_class_join. O(items). */
enum srv_stored srv_store_class_end(struct srv_store *store, struct srv_class_put *put,
                                    struct srv_class *room);

/** Deletes a room of a client, or removes the client from one. count: out, 1; 0 if none is left.
 * SRV_STORED_AGAIN: another process is writing to the room. O(items). */
enum srv_stored srv_store_erase_classes(struct srv_store *store, const char *client, int *count);
