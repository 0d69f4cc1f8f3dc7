#include "server/store/store_jobs.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

/* Up to this many clients of an address take one turn each. With more clients, each claim counts as
 * several turns, so that together they still take about as many. */
enum { SOURCE_TURNS = 8 };

enum srv_stored srv_store_count_bytes(struct srv_store *store, const char *name, int64_t bytes) {
    struct srv_tally_client *client;
    SRV_STORED_TRY(srv_tally_client(&store->tally, name, &client));
    client->bytes += bytes;
    store->tally.changes[SRV_TALLY_BYTES] += bytes;
    return SRV_STORED;
}

enum srv_stored srv_store_recount(struct srv_store *store, const char *name) {
    SRV_STORED_TRY(srv_tally_count_anew(&store->tally, name));
    return srv_tally_count_all(&store->tally);
}

long srv_job_claimable(const struct srv_job *job) {
    assert(job->parts >= 1 && job->waiting >= 0);
    if (job->state > SRV_JOB_RUNNING) return 0;
    if (!job->chained) return job->waiting + job->parts - job->begun;
    return job->waiting > 0 || (job->begun < job->parts && job->begun == job->done);
}

enum srv_stored srv_store_count_job(struct srv_store *store, const struct srv_job *was,
                                    const struct srv_job *is) {
    assert(!strcmp(was->id, is->id) && !strcmp(was->client, is->client));
    int64_t *changes = store->tally.changes;
    struct srv_tally_client *client;
    long before = srv_job_claimable(was), after = srv_job_claimable(is);
    SRV_STORED_TRY(srv_tally_client(&store->tally, is->client, &client));
    changes[was->state]--;
    changes[is->state]++;
    changes[SRV_TALLY_PARTS] += after - before;
    client->ready += (after > 0) - (before > 0);
    client->jobs += (is->state <= SRV_JOB_RUNNING) - (was->state <= SRV_JOB_RUNNING);
    return srv_store_count_bytes(store, is->client, is->bytes + is->held - was->bytes - was->held);
}

static enum srv_stored quotas_disk(struct srv_store *store, size_t bytes) {
    const struct srv_sql_driver *driver = store->sql->driver;
    return driver->room && !driver->room(store->sql, bytes) ? SRV_STORED_FULL : SRV_STORED;
}

enum srv_stored srv_store_room(struct srv_store *store, const char *name, size_t bytes,
                               char message[SRV_REQUEST_HEAD_BYTES]) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_tally_client *client;
    int64_t all;
    SRV_STORED_TRY(quotas_disk(store, bytes));
    SRV_STORED_TRY(srv_tally_look(&store->tally, name, &client));
    SRV_STORED_TRY(srv_tally_total(&store->tally, SRV_TALLY_BYTES, &all));
    if (client->bytes_were + client->bytes + (int64_t)bytes > rules->client_bytes)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "the client's stored jobs would exceed max-client-bytes, %lld bytes; DELETE jobs "
                 "that are no longer needed",
                 rules->client_bytes);
    else if (all + (int64_t)bytes > rules->all_bytes)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "all stored jobs would exceed max-store-bytes, %lld bytes", rules->all_bytes);
    else
        return SRV_STORED;
    return SRV_STORED_QUOTA;
}

enum srv_stored srv_store_source(struct srv_store *store, const char *name, const char *source,
                                 char message[SRV_REQUEST_HEAD_BYTES]) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_tally_client *client;
    int64_t clients, jobs, bytes;
    SRV_STORED_TRY(srv_tally_look(&store->tally, name, &client));
    snprintf(client->source, sizeof client->source, "%s", source ? source : name);
    if (!source || !strcmp(name, source)) return SRV_STORED;
    SRV_STORED_TRY(srv_tally_source(&store->tally, source, &clients, &jobs, &bytes));
    client->weight = 1 + store->tally.source_open / SOURCE_TURNS;
    int counted = client->jobs_were > 0 || client->bytes_were > 0 || client->bytes > 0;
    if (rules->source_clients && !counted && clients >= rules->source_clients)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "%ld clients of your address have jobs, the limit max-address-clients",
                 rules->source_clients);
    else if (rules->source_jobs && jobs >= rules->source_jobs)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "the clients of your address have %ld open jobs together: max-address-clients "
                 "times max-client-jobs",
                 rules->source_jobs);
    else if (rules->source_bytes && bytes > rules->source_bytes)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "the clients of your address store %lld bytes of jobs together, the limit that "
                 "max-address-clients sets; DELETE jobs that are no longer needed",
                 rules->source_bytes);
    else
        return SRV_STORED;
    return SRV_STORED_QUOTA;
}

enum srv_stored srv_store_room_scene(struct srv_store *store, const char *name, size_t bytes,
                                     int anew) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_tally_client *client;
    int64_t all;
    if (anew) SRV_STORED_TRY(quotas_disk(store, bytes));
    SRV_STORED_TRY(srv_tally_look(&store->tally, name, &client));
    SRV_STORED_TRY(srv_tally_total(&store->tally, SRV_TALLY_SCENE_BYTES, &all));
    char text[SRV_SQL_COMPLAINT];
    int64_t own = client->scene_bytes_were + client->scene_bytes + (int64_t)bytes;
    if (client->scenes_were + client->scenes >= rules->client_scenes)
        snprintf(text, sizeof text,
                 "the client has as many scenes as max-client-scenes allows, %ld; DELETE scenes "
                 "that are no longer needed",
                 rules->client_scenes);
    else if (own > rules->client_scene_bytes)
        snprintf(text, sizeof text,
                 "the client's scenes would exceed max-client-scene-bytes, %lld bytes; DELETE "
                 "scenes that are no longer needed",
                 rules->client_scene_bytes);
    else if (anew && all + (int64_t)bytes > rules->all_scene_bytes)
        snprintf(text, sizeof text, "all scenes would exceed max-store-scene-bytes, %lld bytes",
                 rules->all_scene_bytes);
    else
        return SRV_STORED;
    srv_sql_complain(store->sql, text);
    return SRV_STORED_QUOTA;
}
