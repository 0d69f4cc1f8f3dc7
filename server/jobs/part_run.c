#include "server/jobs/part_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/base/clock.h"

enum { STINT_KEEP = 1 << 20 };

void srv_stint_init(struct srv_stint *stint, struct srv_service *service) {
    size_t most = (size_t)srv_service_config(service)->limits.answer_bytes;
    *stint = (struct srv_stint){.service = service, .hold = {.service = service, .kind = SRV_MEMORY_JOBS}};
    api_buffer_init(&stint->out, most);
    api_buffer_init(&stint->carry, most);
}

void srv_stint_clear(struct srv_stint *stint) {
    api_part_free(&stint->part);
    srv_stint_forget(stint);
    api_buffer_clear(&stint->out);
    api_buffer_clear(&stint->carry);
    srv_hold_set(&stint->hold, 0);
}

/* bytes that it holds, and will after the next piece */
static size_t stint_bytes(const struct srv_stint *stint) {
    size_t kept = stint->out.cap + stint->carry.cap + (stint->request ? stint->request_bytes : 0);
    return kept + (stint->part ? (size_t)api_part_bytes(stint->part) : 0);
}

void srv_stint_forget(struct srv_stint *stint) {
    free(stint->request);
    stint->request = NULL;
    stint->job[0] = 0;
    srv_hold_set(&stint->hold, stint_bytes(stint));
}

void srv_stint_drop(struct srv_stint *stint) {
    api_part_free(&stint->part);
    stint->out.bytes = 0;
    if (stint->out.cap > STINT_KEEP) api_buffer_clear(&stint->out);
    api_buffer_clear(&stint->carry);
    stint->spent = 0;
    srv_hold_set(&stint->hold, stint_bytes(stint));
}

void srv_stint_say(struct srv_stint *stint, const char *message) {
    snprintf(stint->message, sizeof stint->message, "%s", message);
}

/* A turn's company: what is asked between two pieces of it. */
struct stint_turn {
    struct srv_stint *stint;
    int level;
};

static enum api_op_id stint_op(const char *name) {
    int op = 0;
    while (op < API_OP_COUNT && strcmp(api_op_at((enum api_op_id)op)->name, name)) op++;
    return (enum api_op_id)op;
}

/* does anybody wait for an answer, or is it not to go on? */
static int stint_hurry(void *company) {
    const struct stint_turn *turn = company;
    struct srv_service *service = turn->stint->service;
    srv_intake_look(&service->intake);
    return atomic_load(&turn->stint->stop) || srv_queue_shorter(service->queue, turn->level);
}

/* makes the part ready */
static enum pend_status stint_begin(struct srv_stint *stint, const struct srv_lease *lease, struct pend_error *error) {
    struct srv_service *service = stint->service;
    struct api_request request = {.op = stint_op(lease->operation),
                                  .content_type = "application/json",
                                  .body = stint->request,
                                  .body_bytes = stint->request_bytes};
    if (request.op == API_OP_COUNT)
        return pend_fail(error, PEND_INVALID, -1, 0, "this version does not know the operation '%.60s'",
                         lease->operation);
    PEND_TRY(api_part_new(&stint->part, &request, srv_service_job_limits(service), lease->shard, lease->shards, error));
    api_part_clock(stint->part, srv_clock_seconds, NULL);
    if (!lease->start) return PEND_OK;
    return api_part_resume(stint->part, lease->start, lease->start_bytes, error);
}

/* Reserves the memory of a part. Returns 1 when it may begin, 0 when it is to wait until others hold less. */
static int stint_room(struct srv_stint *stint, enum pend_status *status, struct pend_error *error) {
    size_t bytes = stint_bytes(stint);
    enum srv_room room = srv_hold_try(&stint->hold, bytes);
    stint->roomy = room == SRV_ROOM;
    if (room == SRV_ROOM_NEVER)
        *status = pend_fail(error, PEND_LIMIT, -1, 0,
                            "a part takes about %zu bytes of memory, more than max-held-bytes", bytes);
    else if (room != SRV_ROOM)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    return stint->roomy;
}

/* one piece of a part */
static enum pend_status stint_piece(struct srv_stint *stint, int *done, struct pend_error *error) {
    double limit = srv_service_job_limits(stint->service)->compute_seconds;
    enum pend_status status = api_part_run(stint->part, &stint->out, done, error);
    if (status == PEND_OK && *done) status = api_part_carry(stint->part, &stint->carry);
    if (status == PEND_LIMIT && stint->out.bytes + stint->out.limit / 2 > stint->out.limit)
        return pend_fail(error, status, -1, 0, "a part's results are larger than max-answer-bytes: %zu bytes",
                         stint->out.limit);
    if (status == PEND_OK && (double)stint->spent > 1e9 * limit)
        return pend_fail(error, PEND_DEADLINE, -1, 0, "a part computed longer than max-job-seconds allows: %.15g s",
                         limit);
    return status;
}

enum srv_stint_end srv_stint_turn(struct srv_stint *stint, const struct srv_lease *lease, int level) {
    struct stint_turn turn = {stint, level};
    struct pend_error error = {.text = ""};
    enum pend_status status = PEND_OK;
    int done = 0;
    do {
        int64_t begin = srv_clock_now();
        if (atomic_load(&stint->stop)) return SRV_STINT_STOPPED;
        if (!stint->part) {
            stint->roomy = 0;
            status = stint_begin(stint, lease, &error);
        }
        if (status == PEND_OK && !stint->roomy && !stint_room(stint, &status, &error) && status == PEND_OK)
            return SRV_STINT_YIELDS;
        if (status == PEND_OK) {
            api_part_hurry(stint->part, stint_hurry, &turn);
            status = stint_piece(stint, &done, &error);
            srv_hold_set(&stint->hold, stint_bytes(stint));
        }
        stint->spent += srv_clock_now() - begin;
    } while (status == PEND_OK && !done && !srv_queue_count(stint->service->queue));
    if (status != PEND_OK) {
        srv_stint_say(stint, error.text);
        return SRV_STINT_FAILED;
    }
    if (!done) return SRV_STINT_YIELDS;
    api_part_free(&stint->part);
    return SRV_STINT_DONE;
}
