#include "server/jobs/part_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/base/clock.h"

enum { PART_RUN_KEEP = 1 << 20 };

void srv_part_run_init(struct srv_part_run *run, struct srv_service *service) {
    size_t most = (size_t)srv_service_config(service)->limits.answer_bytes;
    *run = (struct srv_part_run){.service = service,
                                 .hold = {.service = service, .kind = SRV_MEMORY_JOBS}};
    api_buffer_init(&run->out, most);
    api_buffer_init(&run->carry, most);
    api_buffer_init(&run->file, most);
}

void srv_part_run_clear(struct srv_part_run *run) {
    api_part_free(&run->part);
    srv_part_run_forget(run);
    api_buffer_clear(&run->out);
    api_buffer_clear(&run->carry);
    api_buffer_clear(&run->file);
    srv_hold_set(&run->hold, 0);
}

/* The bytes that the run holds now or after the next piece, whichever is more. */
static size_t part_run_bytes(const struct srv_part_run *run) {
    size_t kept =
        run->out.cap + run->carry.cap + run->file.cap + (run->request ? run->request_bytes : 0);
    return kept + (run->part ? srv_hold_count(api_part_bytes(run->part)) : 0);
}

PEND_VALIDATOR part_run_valid(const struct srv_part_run *run) {
    return run->service && run->hold.service == run->service && !run->hold.payer &&
           (!run->job[0] || run->request) && run->out.bytes <= run->out.cap &&
           run->carry.bytes <= run->carry.cap && memchr(run->message, 0, sizeof run->message);
}

void srv_part_run_forget(struct srv_part_run *run) {
    free(run->request);
    run->request = NULL;
    run->job[0] = 0;
    srv_hold_set(&run->hold, part_run_bytes(run));
}

void srv_part_run_drop(struct srv_part_run *run) {
    api_part_free(&run->part);
    run->out.bytes = 0;
    if (run->out.cap > PART_RUN_KEEP) api_buffer_clear(&run->out);
    api_buffer_clear(&run->carry);
    api_buffer_clear(&run->file);
    run->spent = 0;
    assert(part_run_valid(run));
    srv_hold_set(&run->hold, part_run_bytes(run));
}

void srv_part_run_say(struct srv_part_run *run, const char *message) {
    assert(message[0]);
    snprintf(run->message, sizeof run->message, "%s", message);
}

/* Context of the checks between two pieces of a turn. */
struct part_run_turn {
    struct srv_part_run *run;
    int level;
};

/* Returns 1 if another task waits, or if the part should stop. */
static int part_run_hurry(void *company) {
    const struct part_run_turn *turn = company;
    struct srv_service *service = turn->run->service;
    srv_fairness_look(&service->fairness);
    return atomic_load(&turn->run->stop) || srv_queue_shorter(service->queue, turn->level);
}

static enum pend_status part_run_begin(struct srv_part_run *run, const struct srv_lease *lease,
                                       struct pend_error *error) {
    struct srv_service *service = run->service;
    struct api_request request = {.op = api_op_find(lease->operation),
                                  .content_type = "application/json",
                                  .body = run->request,
                                  .body_bytes = run->request_bytes};
    if (request.op == API_OP_COUNT)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "this version does not know the operation '%.60s'", lease->operation);
    const struct api_limits *limits = srv_service_job_limits(service);
    PEND_TRY(api_part_new(&run->part, &request, limits, lease->part, lease->parts, error));
    api_part_clock(run->part, srv_clock_seconds, NULL);
    if (!lease->start) return PEND_OK;
    return api_part_resume(run->part, lease->start, lease->start_bytes, error);
}

/* Reserves the memory of a part. Returns 1 if it may begin, 0 if it should wait until others hold
 * less. */
static int part_run_room(struct srv_part_run *run, enum pend_status *status,
                         struct pend_error *error) {
    size_t bytes = part_run_bytes(run);
    enum srv_room room = srv_hold_try(&run->hold, bytes);
    run->roomy = room == SRV_ROOM;
    if (room == SRV_ROOM_NEVER)
        *status =
            pend_fail(error, PEND_LIMIT, -1, 0,
                      "a part takes about %zu bytes of memory, more than max-held-bytes", bytes);
    else if (room != SRV_ROOM)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    return run->roomy;
}

static enum pend_status part_run_piece(struct srv_part_run *run, int *done,
                                       struct pend_error *error) {
    double limit = srv_service_job_limits(run->service)->compute_seconds;
    enum pend_status status = api_part_run(run->part, &run->out, done, error);
    if (status == PEND_OK && *done) status = api_part_carry(run->part, &run->carry);
    if (status == PEND_LIMIT && run->out.bytes + run->out.limit / 2 > run->out.limit)
        return pend_fail(error, status, -1, 0,
                         "a part's results are larger than max-answer-bytes: %zu bytes",
                         run->out.limit);
    if (status == PEND_OK && (double)run->spent > 1e9 * limit)
        return pend_fail(error, PEND_DEADLINE, -1, 0,
                         "a part took longer than max-job-seconds, %.15g s", limit);
    return status;
}

/* Moves the rows of a complete part into a file, unless there are few. */
static enum pend_status part_run_file(struct srv_part_run *run, const struct srv_lease *lease) {
    int few = lease->parts == 1 && run->out.bytes <= SRV_CHUNK_BYTES;
    if (!run->service->files || few) return PEND_OK;
    return api_part_file(run->part, &run->out, &run->file);
}

enum srv_part_run_end srv_part_run_turn(struct srv_part_run *run, const struct srv_lease *lease,
                                        int level) {
    struct part_run_turn turn = {run, level};
    struct pend_error error = {.text = ""};
    enum pend_status status = PEND_OK;
    int done = 0;
    assert(part_run_valid(run));
    do {
        int64_t begin = srv_clock_now();
        if (atomic_load(&run->stop)) return SRV_PART_RUN_STOPPED;
        if (!run->part) {
            run->roomy = 0;
            status = part_run_begin(run, lease, &error);
        }
        if (status == PEND_OK && !run->roomy && !part_run_room(run, &status, &error) &&
            status == PEND_OK)
            return SRV_PART_RUN_YIELDS;
        if (status == PEND_OK) {
            api_part_hurry(run->part, part_run_hurry, &turn);
            status = part_run_piece(run, &done, &error);
            srv_hold_set(&run->hold, part_run_bytes(run));
        }
        run->spent += srv_clock_now() - begin;
    } while (status == PEND_OK && !done &&
             !srv_queue_shorter(run->service->queue, SRV_QUEUE_LEVELS));
    if (status != PEND_OK) {
        srv_part_run_say(run, error.text);
        return SRV_PART_RUN_FAILED;
    }
    if (!done) return SRV_PART_RUN_YIELDS;
    if (part_run_file(run, lease) != PEND_OK) {
        srv_part_run_say(run, "no memory for the file of a part's results");
        return SRV_PART_RUN_FAILED;
    }
    api_part_free(&run->part);
    srv_hold_set(&run->hold, part_run_bytes(run));
    return SRV_PART_RUN_DONE;
}
