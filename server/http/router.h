/* The table of routes, and the stages that every request passes in order.
 * Leaves to others: computing (compute), the syntax of heads (request_head), authentication
 * (admission).
 * Invariant: every method of a path in the table has an answer: that of the route, of GET for HEAD,
 * of OPTIONS, or 405 with Allow. */
#pragma once

#include "api/op/op.h"
#include "server/work/exchange.h"

/** Answers a route at once, on the sockets' thread: must not wait or compute. */
typedef void srv_handle_fn(struct srv_exchange *exchange);

/** Starts to answer a route whose answer takes time; the exchange's `finish` is called when it is
 * answered. */
typedef void srv_begin_fn(struct srv_exchange *exchange);

/* Properties of a route. */
enum {
    SRV_ROUTE_CLOSED = 1,   /* web pages of other origins may not use it unless they are listed */
    SRV_ROUTE_ANY_HOST = 2, /* any Host is accepted: the answer contains only the state of the
                             * process */
    SRV_ROUTE_ANY_ADDRESS = 4, /* any numeric address is accepted as Host, for monitors */
    SRV_ROUTE_COUNTED = 8,     /* each request counts against its client's quota, like those of
                                * operations */
    SRV_ROUTE_PROBE = 32,      /* answered by the listener of probes and metrics as well */
    SRV_ROUTE_OPERATOR = 16    /* for operators only, if the server has keys */
};

struct srv_route {
    const char *method;  /* GET also serves HEAD; POST of an operation also serves QUERY */
    const char *pattern; /* "/v1/presets/{name}": at most one variable part, or two adjacent ones at
                          * the end */
    srv_handle_fn *handle; /* answers at once; NULL: see `begin` */
    srv_begin_fn *begin;   /* answers later; NULL: a worker runs the operation */
    enum api_op_id op;
    const char *label; /* for the metrics: method and pattern */
    unsigned special;  /* SRV_ROUTE_... */
};

/** Returns the number of a row of the table, -1 for NULL. */
int srv_router_number(const struct srv_route *route);

/** Returns the label of row i, "GET /v1/jobs/{id}"; NULL beyond the table's end. */
const char *srv_router_label(int i);

/**
 * Runs the stages that need only a request's head: authentication, the target and the body's
 * length, the route, the host, web pages of other origins, the role of the process, the client's
 * quota.
 *
 * Returns 1 if it passes: exchange->identity, route and argument are set, and exchange->account if
 * the route needs one. Otherwise answers the exchange; exchange->identity is set then too.
 */
int srv_router_head(struct srv_exchange *exchange);

/**
 * Runs the stages that need the complete body: routes that answer at once, the cache.
 *
 * Returns 1 if it passes: then call srv_router_hand, once the exchange can be answered from another
 * thread. Otherwise answers the exchange.
 */
int srv_router_body(struct srv_exchange *exchange);

/** Passes an exchange after all stages to the route's `begin`, to jobs or to compute. */
void srv_router_hand(struct srv_exchange *exchange);
