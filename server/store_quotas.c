#include "server/store_quotas.h"

#include <stdio.h>
#include <string.h>

#include "server/store_rows.h"

enum srv_stored srv_store_client(struct srv_store *store, const char *client, long jobs, long long bytes, int turn,
                                 int64_t *total) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLIENT_CHANGE, srv_row_wholes, &row, srv_value_text(client),
                           srv_value_whole(jobs), srv_value_whole(bytes), srv_value_whole(turn)));
    if (total) *total = row.whole[0];
    return SRV_STORED;
}

enum srv_stored srv_store_room(struct srv_store *store, size_t bytes, int64_t client_bytes,
                               char message[SRV_MESSAGE_BYTES]) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_row_wholes all = {.count = 1};
    if (store->sql->driver->room && !store->sql->driver->room(store->sql, bytes)) return SRV_STORED_FULL;
    SRV_STORED_TRY(srv_store_run(store, SQL_ALL_BYTES, NULL, 0, srv_row_wholes, &all));
    if (client_bytes > rules->client_bytes)
        snprintf(message, SRV_MESSAGE_BYTES,
                 "the client's kept results would pass max-client-bytes, %lld bytes; "
                 "DELETE jobs that are not needed any more",
                 rules->client_bytes);
    else if (all.whole[0] > rules->all_bytes)
        snprintf(message, SRV_MESSAGE_BYTES, "all kept results would pass max-store-bytes, %lld bytes",
                 rules->all_bytes);
    else
        return SRV_STORED;
    return SRV_STORED_QUOTA;
}

enum srv_stored srv_store_source(struct srv_store *store, const char *client, const char *source,
                                 char message[SRV_MESSAGE_BYTES]) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_row_wholes all = {.count = 3};
    if (!source || !strcmp(client, source)) return SRV_STORED;
    SRV_STORED_TRY(SRV_RUN(store, SQL_SOURCE, srv_row_wholes, &all, srv_value_text(source)));
    if (rules->source_clients && all.whole[0] > rules->source_clients)
        snprintf(message, SRV_MESSAGE_BYTES,
                 "%ld clients of your address have jobs: max-address-clients allows no more", rules->source_clients);
    else if (rules->source_jobs && all.whole[1] > rules->source_jobs)
        snprintf(message, SRV_MESSAGE_BYTES,
                 "the clients of your address have %ld open jobs together: max-address-clients times max-client-jobs",
                 rules->source_jobs);
    else if (rules->source_bytes && all.whole[2] > rules->source_bytes)
        snprintf(message, SRV_MESSAGE_BYTES,
                 "the clients of your address keep %lld bytes of results together: max-address-clients allows no more; "
                 "DELETE jobs that are not needed any more",
                 rules->source_bytes);
    else
        return SRV_STORED;
    return SRV_STORED_QUOTA;
}
