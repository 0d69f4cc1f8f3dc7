/* The server's only list type: links inside the objects, closed to form a ring.
 * Leaves to others: the objects, locks.
 * Invariant: an object is in at most one list by each of its links; a link that is in no list is
 * {NULL, NULL}, and so is an empty list that was never used. */
#pragma once

#include <assert.h>

#include "server/base/container_of.h"

/* A link, or the list itself: the link at which the ring closes. Begins as {0}, and must not be
 * copied or moved while it has members. */
struct srv_list {
    struct srv_list *next, *previous;
};

/* Visits the links of a list in order; the list must not change during the loop. */
#define SRV_LIST_EACH(link, list)                                                                  \
    for (struct srv_list *link = (list)->next; link && link != (list); link = link->next)

/** Returns true if the list has no members. */
static inline int srv_list_empty(const struct srv_list *list) {
    return !list->next || list->next == list;
}

/** Returns true if the neighbours of a link, or of a list, lead back to it. O(1). */
static inline int srv_list_valid(const struct srv_list *link) {
    return link->next ? link->next->previous == link && link->previous->next == link
                      : !link->previous;
}

/** Inserts a link that is in no list after another one; after the list itself it becomes the
 * first. */
static inline void srv_list_insert(struct srv_list *after, struct srv_list *link) {
    if (!after->next) after->next = after->previous = after;
    assert(srv_list_valid(after) && !link->next && !link->previous);
    *link = (struct srv_list){.next = after->next, .previous = after};
    link->next->previous = after->next = link;
}

/** Appends a link that is in no list to a list. */
static inline void srv_list_append(struct srv_list *list, struct srv_list *link) {
    srv_list_insert(list->next ? list->previous : list, link);
}

/** Removes a link from its list. */
static inline void srv_list_remove(struct srv_list *link) {
    assert(link->next && srv_list_valid(link));
    link->previous->next = link->next;
    link->next->previous = link->previous;
    *link = (struct srv_list){0};
}

/** Removes and returns the first link of a list; NULL if the list is empty. */
static inline struct srv_list *srv_list_take(struct srv_list *list) {
    struct srv_list *first = srv_list_empty(list) ? NULL : list->next;
    if (first) srv_list_remove(first);
    return first;
}

/** Appends all links of one list to another, in order; `from` is then empty. */
static inline void srv_list_move(struct srv_list *from, struct srv_list *to) {
    for (struct srv_list *link; (link = srv_list_take(from));) srv_list_append(to, link);
}
