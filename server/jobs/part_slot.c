#include "server/jobs/part_slot.h"

#include <string.h>

#include "server/store/store_files.h"

PEND_VALIDATOR part_slot_valid(const struct srv_part_slot *slot) {
    return slot->service && slot->runner && slot->holder && slot->lease_us > 0 &&
           slot->state >= SRV_PART_SLOT_IDLE && slot->state <= SRV_PART_SLOT_RETRY &&
           (!srv_part_slot_holds(slot) || slot->lease.job[0]);
}

int srv_part_slot_holds(const struct srv_part_slot *slot) {
    return slot->state != SRV_PART_SLOT_IDLE && slot->state != SRV_PART_SLOT_CLAIM;
}

/* --- on the store's threads --- */

static enum srv_stored slot_request(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(call, struct srv_part_slot, ask.call);
    return srv_store_job_request(store, slot->lease.job, &slot->run.request,
                                 &slot->run.request_bytes);
}

static enum srv_stored slot_file(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(call, struct srv_part_slot, ask.call);
    const struct srv_lease *lease = &slot->lease;
    const struct api_buffer *out = &slot->run.out;
    struct api_raw_file file;
    (void)store;
    if (!api_raw_file_get(out->data, out->bytes, &file)) return SRV_STORED_BROKEN;
    return srv_files_put(slot->service->files, lease->job, lease->part, &file, slot->run.file.data);
}

static enum srv_stored slot_finish(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(call, struct srv_part_slot, ask.call);
    const struct api_buffer *out = &slot->run.out, *carry = &slot->run.carry;
    return srv_store_finish(store, &slot->lease, out->data, out->bytes,
                            carry->bytes ? carry->data : NULL, carry->bytes);
}

static enum srv_stored slot_fail(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(call, struct srv_part_slot, ask.call);
    return srv_store_fail(store, &slot->lease, slot->run.message);
}

static enum srv_stored slot_extend(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(call, struct srv_part_slot, beat.call);
    return srv_store_extend(store, &slot->beaten, slot->lease_us);
}

/* checks whether the job of the part has ended elsewhere; a job that cannot be read counts as
 * running */
static enum srv_stored slot_look(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(call, struct srv_part_slot, beat.call);
    struct srv_job job = {.state = SRV_JOB_DISMISSED};
    enum srv_stored stored = srv_store_job(store, slot->beaten.job, &job);
    return stored <= SRV_STORED_NONE && job.state > SRV_JOB_RUNNING ? SRV_STORED_LOST : stored;
}

/* --- questions --- */

void srv_part_slot_ask(struct srv_part_slot *slot, enum srv_part_slot_state state) {
    enum srv_ask_kind kind = state == SRV_PART_SLOT_REQUEST ? SRV_ASK_READ
                             : state == SRV_PART_SLOT_FILE  ? SRV_ASK_FILE
                                                            : SRV_ASK_WRITE;
    assert(state == SRV_PART_SLOT_REQUEST || state == SRV_PART_SLOT_FILE ||
           state == SRV_PART_SLOT_FINISH || state == SRV_PART_SLOT_FAIL);
    assert(slot->state != state);
    slot->state = state;
    assert(part_slot_valid(slot));
    slot->ask.call.finish = state == SRV_PART_SLOT_FINISH ? &slot->lease : NULL;
    slot->lease.elsewhere = slot->run.file.bytes;
    slot->ask.call.run = state == SRV_PART_SLOT_REQUEST  ? slot_request
                         : state == SRV_PART_SLOT_FILE   ? slot_file
                         : state == SRV_PART_SLOT_FINISH ? slot_finish
                                                         : slot_fail;
    srv_storage_ask(slot->service->storage, kind, &slot->ask);
}

void srv_part_slot_beat(struct srv_part_slot *slot, int look) {
    assert(part_slot_valid(slot) && srv_part_slot_holds(slot) && !slot->beating);
    slot->beaten = slot->lease;
    slot->beaten.start = slot->beaten.request = NULL;
    slot->beating = 1;
    slot->looking = look;
    slot->beat.call.run = look ? slot_look : slot_extend;
    srv_storage_ask(slot->service->storage, look ? SRV_ASK_READ : SRV_ASK_WRITE, &slot->beat);
}

int srv_part_slot_beats(const struct srv_part_slot *slot) {
    const struct srv_lease *now = &slot->lease, *then = &slot->beaten;
    return srv_part_slot_holds(slot) && now->part == then->part && now->attempt == then->attempt &&
           !strcmp(now->job, then->job);
}

/* --- beginning and end --- */

void srv_part_slot_drop(struct srv_part_slot *slot) {
    srv_part_run_drop(&slot->run);
    srv_lease_clear(&slot->lease);
    slot->state = SRV_PART_SLOT_IDLE;
    assert(part_slot_valid(slot));
    atomic_store(&slot->run.stop, 0);
}
