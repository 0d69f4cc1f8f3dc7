#include "server/jobs/jobs.h"

#include <string.h>

#include "server/jobs/events.h"
#include "server/jobs/part_runner.h"
#include "server/jobs/store_request.h"
#include "server/store/store_classes.h"
#include "server/work/admission.h"

static const struct srv_store_request_words erasure_words = {
    "clients", "repeat the request to erase the rest"};

/* Erases a batch of the stored data of asked->client; `count` becomes 0 once nothing is left. */
static enum srv_stored erasure_piece(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    int most = asked->piece;
    enum srv_stored stored = srv_store_erase_jobs(store, asked->client, most, &asked->count);
    if (stored != SRV_STORED || asked->count) return stored;
    stored = srv_store_erase_scenes(store, asked->client, most, &asked->count);
    if (stored != SRV_STORED || asked->count) return stored;
    return srv_store_erase_classes(store, asked->client, &asked->count);
}

static void erasure_done(struct srv_store_request *asked, enum srv_stored stored) {
    /* Deleting needs disk space too: on a full disk, retry with a smaller batch. */
    int smaller = stored == SRV_STORED_FULL && asked->piece > 1;
    if (smaller) asked->piece = 1;
    if (smaller || (stored == SRV_STORED && asked->count)) {
        srv_store_request_ask(asked, SRV_ASK_WRITE, erasure_piece, erasure_done);
        return;
    }
    if (stored == SRV_STORED) {
        srv_exchange_static(asked->exchange, 204, NULL, NULL, 0);
        srv_part_runner_news(asked->service->runner, SRV_RING_ALL);
        srv_events_news(asked->service->events);
    } else {
        srv_store_request_refuse(asked, stored);
    }
    srv_store_request_end(asked);
}

/* Determines the client that the path names. Returns 0 if the exchange was answered. */
static int erasure_whom(struct srv_exchange *exchange, char key[SRV_IDENTITY_KEY]) {
    const struct srv_identity *identity = &exchange->identity;
    int self = !strcmp(exchange->argument, "me");
    if (self && identity->kind == SRV_IDENTITY_ADDRESS) {
        srv_admission_challenge(
            exchange,
            "data of an address may belong to many people: only an operator may erase them");
        return 0;
    }
    if (self) {
        memcpy(key, identity->key, SRV_IDENTITY_KEY);
        return 1;
    }
    if (identity->role == SRV_ROLE_NONE) {
        srv_exchange_problem(exchange, 403,
                             API_TYPE_ROLE
                             "only an operator may erase data of others, and this server has no "
                             "keys to identify one: see the option --keys");
        return 0;
    }
    if (identity->role != SRV_ROLE_OPERATOR) {
        srv_admission_forbid(exchange, SRV_ROLE_OPERATOR,
                             "only an operator may erase data of others");
        return 0;
    }
    if (srv_identity_named(exchange->argument, key)) return 1;
    srv_exchange_problem(exchange, 404,
                         "client must be me, key:NAME, account:NAME or address:ADDRESS, got %.100s",
                         exchange->argument);
    return 0;
}

void srv_erasure(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &erasure_words);
    if (!asked) return;
    char *key = srv_exchange_text(exchange, SRV_IDENTITY_KEY);
    assert(exchange->argument);
    if (!key)
        srv_exchange_problem(exchange, 431, "the request's head is too long");
    else if (erasure_whom(exchange, key)) {
        asked->client = key;
        asked->piece = SRV_ERASE_MOST;
        srv_store_request_ask(asked, SRV_ASK_WRITE, erasure_piece, erasure_done);
        return;
    }
    srv_store_request_end(asked);
}
