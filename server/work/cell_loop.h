/* The life of a process that computes for the server: it answers what it is asked on its socket.
 * Leaves to others: what a question means (api/call/relay_host), making and confining the process
 * (zygote), the other end of the socket (cells).
 * Invariant: it reads and writes that socket and nothing else, and ends with it. */
#ifndef SRV_CELL_LOOP_H
#define SRV_CELL_LOOP_H

#include "api/call/relay.h"

/* What goes before a question: its head and its texts come behind. */
struct srv_cell_question {
    unsigned long long bytes; /* of the head and the texts */
};

/* What goes before the output and the checkpoint, or body, of an answer. */
struct srv_cell_answer {
    unsigned long long out, more; /* bytes of these */
    struct api_relay_told told;
};

/** Answers questions until the socket's other end is closed, or a question makes no sense, or
 * memory is short at a place where it cannot be told. */
void srv_cell_loop(int fd);

#endif
