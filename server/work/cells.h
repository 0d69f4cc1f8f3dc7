/* Processes that compute, as the daemon sees them: each has one computation, a plan or a part of a
 * job, and its end is the end of that alone.
 * Leaves to others: making and confining them (zygote), what they do (cell_loop), what is asked
 * and believed (api/call/relay).
 * Invariant: whoever waits for a process waits for a bounded time, and a process that did not
 * answer as it should is never asked again. */
#ifndef SRV_CELLS_H
#define SRV_CELLS_H

#include "api/call/relay.h"
#include "server/work/service.h"

enum {
    SRV_CELL_BYTES = 2 << 20, /* memory of a process besides what its computation holds */
    SRV_CELL_TRIES = 3        /* how often a part of a job is computed again whose process ended */
};

struct srv_cells;

/**
 * Starts the process that makes the others. Before the daemon has a second thread, and before it
 * gives up the right to start programs.
 *
 * service  its config is set; its log may follow.
 * lack     out: walls that are not up around those that compute; "" = all are.
 *
 * PEND_NO_MEMORY
 * PEND_INVALID    error says why it did not begin.
 */
PEND_MUST_CHECK enum pend_status srv_cells_new(struct srv_cells **cells,
                                               struct srv_service *service,
                                               char lack[SRV_CONFIG_TEXT],
                                               struct pend_error *error);

/** Ends that process, and so all others. */
void srv_cells_free(struct srv_cells **cells);

/** Returns 1 once the process that makes the others has ended, or does not take orders any more:
 * there will be no more of them, and its own have ended with it. Any thread. */
int srv_cells_lost(struct srv_cells *cells);

struct srv_cell {
    struct srv_cells *cells;
    struct api_relay relay;     /* the way to it, for one call, part or plan */
    int fd, pid;                /* fd -1: it is not to be asked again */
    unsigned long long number;  /* as struct srv_zygote_told */
    double seconds;             /* that an answer may take */
    int crashed;                /* it ended by itself, or told nonsense */
    int (*stop)(void *context); /* looked at while an answer is awaited: non-zero = it is not wanted
                                   any more; NULL = never. Set by who owns the cell. */
    void *context;
};

/**
 * Takes a process; ends with srv_cell_free.
 *
 * cell     out; NULL after a failure.
 * seconds  that its computation may take in all; an answer that takes longer ends it.
 *
 * PEND_NO_MEMORY  the system has no process, or no descriptor, to spare; error says so.
 * Any thread. Cost: about 30 us where one was made ahead, else a fork.
 */
PEND_MUST_CHECK enum pend_status srv_cell_new(struct srv_cell **cell, struct srv_cells *cells,
                                              double seconds, struct pend_error *error);

/** Ends a process; NULL is accepted. Any thread. */
void srv_cell_free(struct srv_cell **cell);

#endif
