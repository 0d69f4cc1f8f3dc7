/* The table of routes, and the stages that every request passes in order.
 * Leaves to others: computing (compute), the form of a head (request_head), who asks (admission).
 * Invariant: a path of the table is answered for every method: the route, HEAD as GET, OPTIONS,
 * or 405 with Allow. */
#ifndef SRV_ROUTER_H
#define SRV_ROUTER_H

#include "api/op/op.h"
#include "server/work/exchange.h"

/** Answers a route at once, on the sockets' thread: must not wait or compute. */
typedef void srv_handle_fn(struct srv_exchange *exchange);

/** Begins to answer a route whose answer takes time; the exchange's finish is called when it is
 * answered. */
typedef void srv_begin_fn(struct srv_exchange *exchange);

/* What is special about a route. */
enum {
    SRV_ROUTE_CLOSED = 1, /* web pages of other origins may not ask for it unless they are listed */
    SRV_ROUTE_ANY_HOST = 2,    /* any Host is accepted: the answer says only how the process is */
    SRV_ROUTE_ANY_ADDRESS = 4, /* any Host that is an address is accepted, as monitors use them */
    SRV_ROUTE_COUNTED = 8,  /* each request counts against its client's quota, as one does that an
                               operation answers */
    SRV_ROUTE_PROBE = 32,   /* answered by the listener of probes and metrics as well */
    SRV_ROUTE_OPERATOR = 16 /* where the server has keys it is for operators alone */
};

struct srv_route {
    const char
        *method; /* GET also serves HEAD; POST also QUERY, where an operation of api answers */
    const char *pattern; /* "/v1/presets/{name}": one variable part at most, or two at the end that
                            take all of it */
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
 * Takes a request whose header fields were taken in through the stages that need its head: who
 * asks, the target and the body's length, the route, the host, web pages of other origins, the role
 * of the process, the client's quota.
 *
 * Returns 1 when it passes: exchange->identity, route and argument are set, and exchange->account
 * where the route needs one. Else the exchange is answered; exchange->identity is set then too.
 */
int srv_router_head(struct srv_exchange *exchange);

/**
 * Takes an exchange whose body is complete through the stages that need it: a route that answers at
 * once, the cache.
 *
 * Returns 1 when it passes: srv_router_hand is to be called, once the exchange can be answered from
 * another thread. Else the exchange is answered.
 */
int srv_router_body(struct srv_exchange *exchange);

/** Hands an exchange that has passed all stages to the route's `begin`, to jobs or to compute. */
void srv_router_hand(struct srv_exchange *exchange);

#endif
