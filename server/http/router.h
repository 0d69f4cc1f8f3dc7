/* The one table of routes: which method and path leads where.
 * Leaves to others: computing (compute), the message's form (request_head).
 * Invariant: a path of the table is answered for every method: the route, HEAD as GET, OPTIONS,
 * or 405 with Allow. */
#ifndef SRV_ROUTER_H
#define SRV_ROUTER_H

#include "api/op/op.h"
#include "server/work/exchange.h"

/** A route's own answer, given at once on the socket's thread: must not wait or compute. */
typedef void srv_handle_fn(struct srv_exchange *exchange);

/** A route's own answer that takes time; the exchange comes back through its finish. */
typedef void srv_begin_fn(struct srv_exchange *exchange);

/* What is special about a route. */
enum {
    SRV_ROUTE_CLOSED = 1, /* web pages of other origins may not ask for it unless they are listed */
    SRV_ROUTE_ANY_HOST = 2, /* any Host is good: it says nothing but how the process is */
    SRV_ROUTE_ANY_ADDRESS =
        4 /* any Host that is an address: by it those ask who look after the process */
};

struct srv_route {
    const char
        *method; /* GET also serves HEAD; POST also QUERY, where an operation of api answers */
    const char *pattern; /* "/v1/presets/{name}": one variable part at most, or two at the end that
                            take all of it */
    srv_handle_fn *handle; /* answers at once; NULL: see begin */
    srv_begin_fn *begin;   /* takes its time; NULL: a worker runs the operation */
    enum api_op_id op;
    const char *label; /* for the metrics: method and pattern */
    unsigned special;  /* SRV_ROUTE_... */
};

/** Row i of the table, or NULL beyond its end. */
const struct srv_route *srv_router_row(int i);

/** The number of a row, -1 of none. */
int srv_router_number(const struct srv_route *route);

/** The label of row i, or NULL beyond the table's end. */
const char *srv_router_label(int i);

/**
 * Finds the route of an exchange whose head was checked.
 *
 * Returns 1 when there is one: exchange->route and exchange->argument are set, and
 * exchange->identity says who asks. Else the exchange is answered: 404, 405, OPTIONS, 421 where the
 * server does not answer to its host, 403 for web pages of other origins, 401 where what should be
 * a token is none, or, where the route needs a worker, 503 while the server is draining and 429
 * beyond the client's quota.
 */
int srv_router_find(struct srv_exchange *exchange);

/**
 * Goes on with an exchange whose body is complete.
 *
 * Returns 1 when it is answered: by the route itself or from the cache. Else srv_router_hand is to
 * be called.
 */
int srv_router_begin(struct srv_exchange *exchange);

/** Hands an exchange over to whom it concerns; it comes back through its finish, answered, maybe
 * before this returns.
 */
void srv_router_hand(struct srv_exchange *exchange);

#endif
