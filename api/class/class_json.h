/* What may stand in a room in which a class works together: reading it from a request, and writing
 * it for whoever may read it.
 * Leaves to others: keeping it, and who may read it (server/store/store_classes, server/classes).
 * Invariant: an item is kept in its canonical form, so that the same item is the same bytes; a
 * pendulum that stands in it is one that /v1/trajectories takes. */
#ifndef API_CLASS_JSON_H
#define API_CLASS_JSON_H

#include <stdint.h>

#include "api/call/request.h"

/* What a body is of. */
enum api_class_kind {
    API_CLASS_ROOM,      /* a new room */
    API_CLASS_PUPIL,     /* somebody who comes in */
    API_CLASS_STAGE,     /* what the whole class is shown */
    API_CLASS_OWN_STAGE, /* what a pupil has on the stage */
    API_CLASS_QUESTION,
    API_CLASS_SOLUTION,
    API_CLASS_WORKSHEET,
    API_CLASS_ANSWER,
    API_CLASS_HANDIN,
    API_CLASS_KINDS
};

enum {
    API_CLASS_NICKNAME = 32, /* characters */
    API_CLASS_CHOICES = 12,
    API_CLASS_STEPS = 50,
    API_CLASS_ID = 32 /* characters of the id of a question or a worksheet */
};

/* What a body says to the server. */
struct api_class_facts {
    double hours; /* of a room: how long it is there */
    int shut;     /* of the class's stage: 1 = nobody more may join, */
    long share;   /* and how many pupils one address may have; 0 = as it is */
    int shown;    /* of a solution: 1 = to everybody */
    int64_t flag; /* of a question and an answer: see api_class_fits */
    char nickname[4 * API_CLASS_NICKNAME + 1]; /* of a pupil */
};

/**
 * Reads and checks a body.
 *
 * request  its op is ignored.
 * value    the item in its canonical form is appended here.
 * out      a problem is appended here.
 *
 * Returns 0 if the body is good, else the problem's HTTP status. O(body).
 */
int api_class_read(const struct api_request *request, const struct api_limits *limits,
                   enum api_class_kind kind, struct api_class_facts *facts,
                   struct api_buffer *value, struct api_buffer *out);

/** True where an answer with the flag `answer` answers a question with the flag `question`: a
 * number, a choice that there is, or a text. */
int api_class_fits(int64_t question, int64_t answer);

/** True for 1 to API_CLASS_ID of a-z, 0-9 and -. */
int api_class_id_good(const char *id);

/* An item as it is told. */
struct api_class_item {
    const char *name;
    int64_t version, changed; /* changed: us since 1970 */
    const void *value;        /* JSON; of no bytes: the item is gone */
    size_t bytes;
};

/** Appends an item as a JSON object; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_class_item_write(const struct api_class_item *item,
                                                      struct api_buffer *out);

/* A room as it is told. */
struct api_class_room {
    const char *code, *role; /* role: "teacher" or "pupil" */
    const char *token;       /* that the server has made, NULL = it has made none */
    long pupil;              /* number; 0 = none */
    int64_t created, ends;   /* us since 1970 */
    int64_t empty_ends;      /* the same, of a room that nobody has joined; 0 = none */
    int64_t version;         /* of the last change, or of the last one that is told */
    long pupils;
    int shut;
    const char *source; /* the mark of the address that made it, for an operator; NULL = not told */
};

/** Appends a room as a JSON object, without its closing brace; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_class_room_write(const struct api_class_room *room,
                                                      struct api_buffer *out);

#endif
