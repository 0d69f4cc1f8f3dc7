#include "server/jobs/part_poll.h"

#include <stdlib.h>
#include <string.h>

static enum srv_stored poll_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_poll *poll = SRV_CONTAINER_OF(call, struct srv_part_poll, ask.call);
    enum srv_stored stored = SRV_STORED;
    for (int i = 0; i < poll->count && stored < SRV_STORED_FULL; i++) {
        struct srv_job job;
        stored = srv_store_job(store, poll->job[i].id, &job);
        poll->job[i].ended =
            stored == SRV_STORED_NONE || (stored == SRV_STORED && job.state > SRV_JOB_RUNNING);
    }
    return stored < SRV_STORED_FULL ? SRV_STORED : stored;
}

struct srv_part_poll *srv_part_poll_new(int most, void (*done)(struct srv_ask *ask),
                                        void *context) {
    struct srv_part_poll *poll = calloc(1, sizeof *poll + (size_t)most * sizeof poll->job[0]);
    if (!poll) return NULL;
    poll->ask = (struct srv_ask){.call = {.run = poll_run}, .done = done};
    poll->context = context;
    return poll;
}

static int poll_find(const struct srv_part_poll *poll, const char *id) {
    int i = 0;
    while (i < poll->count && strcmp(poll->job[i].id, id) != 0) i++;
    return i;
}

void srv_part_poll_list(struct srv_part_poll *poll, const char *id) {
    int i = poll_find(poll, id);
    if (i < poll->count) return;
    memcpy(poll->job[i].id, id, SRV_ID_BYTES);
    poll->job[i].ended = 0;
    poll->count++;
}

int srv_part_poll_ended(const struct srv_part_poll *poll, const char *id) {
    int i = poll_find(poll, id);
    return i < poll->count && poll->job[i].ended;
}
