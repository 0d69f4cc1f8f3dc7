/* The one kind of list: links that lie inside the objects of a list and close in a ring.
 * Leaves to others: what the objects are, locks.
 * Invariant: an object is in at most one list by each of its links; a link that is in no list is
 * {NULL, NULL}, and so is an empty list that was never used. */
#ifndef SRV_LIST_H
#define SRV_LIST_H

#include <assert.h>

#include "server/base/container_of.h"

/* A link, or the list itself: the link at which the ring closes. Begins as {0}, and must not be
 * copied or moved while it has members. */
struct srv_list {
    struct srv_list *next, *previous;
};

/* Runs through the links of a list in their order; the list must not change meanwhile. */
#define SRV_LIST_EACH(link, list)                                                                  \
    for (struct srv_list *link = (list)->next; link && link != (list); link = link->next)

/** True for a list without members. */
static inline int srv_list_empty(const struct srv_list *list) {
    return !list->next || list->next == list;
}

/** True where the neighbours of a link, or of a list, lead back to it. O(1). */
static inline int srv_list_valid(const struct srv_list *link) {
    return link->next ? link->next->previous == link && link->previous->next == link
                      : !link->previous;
}

/** Puts a link that is in no list behind another one that is in a list; behind the list itself it
 * is the first. */
static inline void srv_list_insert(struct srv_list *after, struct srv_list *link) {
    if (!after->next) after->next = after->previous = after;
    assert(srv_list_valid(after) && !link->next && !link->previous);
    *link = (struct srv_list){.next = after->next, .previous = after};
    link->next->previous = after->next = link;
}

/** Makes a link that is in no list the last of a list. */
static inline void srv_list_append(struct srv_list *list, struct srv_list *link) {
    srv_list_insert(list->next ? list->previous : list, link);
}

/** Takes a link out of its list. */
static inline void srv_list_remove(struct srv_list *link) {
    assert(link->next && srv_list_valid(link));
    link->previous->next = link->next;
    link->next->previous = link->previous;
    *link = (struct srv_list){0};
}

/** Takes the first link out of a list; NULL where the list is empty. */
static inline struct srv_list *srv_list_take(struct srv_list *list) {
    struct srv_list *first = srv_list_empty(list) ? NULL : list->next;
    if (first) srv_list_remove(first);
    return first;
}

/** Appends all links of one list to another, in their order; the first list is empty then. */
static inline void srv_list_move(struct srv_list *from, struct srv_list *to) {
    for (struct srv_list *link; (link = srv_list_take(from));) srv_list_append(to, link);
}

#endif
