/* The side that computes what a relay asks for, in a process of its own.
 * Leaves to others: the process, and carrying the messages (server/work/zygote).
 * Invariant: it has one call or one part at a time; a question that makes no sense is not
 * answered. */
#ifndef API_RELAY_HOST_H
#define API_RELAY_HOST_H

#include "api/call/relay.h"

struct api_relay_host;

/**
 * Makes the side that computes: one call or part at a time.
 *
 * now  as api_call_clock wants it.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_relay_host_new(struct api_relay_host **host,
                                                    double (*now)(void *context));

/** Frees it with the call or part that it has. */
void api_relay_host_free(struct api_relay_host **host);

/**
 * Answers a question.
 *
 * message  the head and the texts, as api_relay_put orders them; kept by the caller until the next
 *          question that is no RUN or PART, since requests point into it.
 * told     out.
 * out      the output, lent until the next question.
 * more     the checkpoint or the body, lent likewise.
 *
 * Returns 0 if the message makes no sense: the caller ends the process.
 */
int api_relay_host_answer(struct api_relay_host *host, const void *message, size_t bytes,
                          struct api_relay_told *told, struct api_buffer **out,
                          struct api_buffer **more);

#endif
