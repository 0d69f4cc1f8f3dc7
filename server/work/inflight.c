#include "server/work/inflight.h"

#include <stdlib.h>
#include <string.h>

enum { INFLIGHT_LARGE = 4 * SRV_INFLIGHT_BLOCK };

struct srv_inflight {
    pthread_mutex_t lock;
    struct srv_hash_table table; /* works that other exchanges may join */
};

enum pend_status srv_inflight_new(struct srv_inflight **inflight) {
    struct srv_inflight *made = *inflight = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    /* The keys are digests, so clients cannot choose keys that share a row, even without a salt. */
    srv_hash_table_init(&made->table, 0);
    return PEND_OK;
}

void srv_inflight_free(struct srv_inflight **inflight) {
    struct srv_inflight *gone = *inflight;
    *inflight = NULL;
    if (!gone) return;
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

static void inflight_lock(struct srv_work *work) {
    pthread_mutex_lock(&work->service->inflight->lock);
    assert(srv_inflight_valid(work));
}

static void inflight_unlock(struct srv_work *work) {
    assert(srv_inflight_valid(work));
    pthread_mutex_unlock(&work->service->inflight->lock);
}

/* Lets an exchange wait for a computation. The caller holds the lock. */
static void inflight_join(struct srv_work *work, struct srv_exchange *exchange) {
    srv_list_append(&work->waiters, &exchange->beside);
    exchange->work = work;
}

struct srv_work *srv_inflight_begin(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    struct srv_work *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    size_t limit = (size_t)srv_service_config(service)->limits.answer_bytes;
    made->service = service;
    made->limits =
        exchange->source ? srv_service_job_limits(service) : &srv_service_config(service)->limits;
    made->source = exchange->source;
    exchange->source = NULL;
    made->account = exchange->account;
    made->task.lane = &made->account->lane;
    made->coding = exchange->coding;
    srv_clients_share(service->clients, made->account);
    made->hold = (struct srv_hold){
        .service = service, .payer = srv_exchange_payer(exchange), .kind = SRV_MEMORY_COMPUTATIONS};
    if (made->hold.payer) srv_clients_share(service->clients, made->hold.payer);
    api_buffer_init(&made->out, limit);
    api_buffer_init(&made->coded, limit);
    api_buffer_init(&made->ready, limit);
    inflight_lock(made);
    inflight_join(made, exchange);
    inflight_unlock(made);
    return made;
}

void srv_inflight_end(struct srv_work *work) {
    struct srv_buffer_pool *pool = &work->service->pool;
    assert(srv_list_empty(&work->waiters) && !work->reader && !work->listed);
    api_call_free(&work->call);
    if (work->source) work->source->free(work->source);
    if (work->coder) srv_coding_at(work->coding)->free(work->coder);
    srv_buffer_pool_give(pool, &work->out);
    srv_buffer_pool_give(pool, &work->coded);
    srv_buffer_pool_give(pool, &work->ready);
    srv_hold_set(&work->hold, 0);
    if (work->hold.payer) srv_clients_give(work->service->clients, work->hold.payer);
    srv_clients_charge(work->service->clients, work->account, 1e-9 * (double)work->spent);
    srv_clients_give(work->service->clients, work->account);
    free(work);
}

int srv_inflight_valid(const struct srv_work *work) {
    int streams = work->reader || work->reader_waits || work->parked;
    return work->service && work->account && work->key_bytes <= SRV_INFLIGHT_KEY &&
           work->taken <= work->ready.bytes && (!work->listed || work->key_bytes) &&
           (!work->reader_waits || work->reader) && !(!srv_list_empty(&work->waiters) && streams) &&
           work->over == (work->ended != 0);
}

/* --- joining --- */

static struct srv_exchange *inflight_of_link(struct srv_list *link) {
    return SRV_CONTAINER_OF(link, struct srv_exchange, beside);
}

struct srv_exchange *srv_inflight_next(struct srv_list *taken) {
    struct srv_list *link = srv_list_take(taken);
    return link ? inflight_of_link(link) : NULL;
}

/* Removes a computation from the table, so that no exchange can join it. The lock is held. */
static void inflight_unlist(struct srv_work *work) {
    if (work->listed) srv_hash_table_remove(&work->service->inflight->table, &work->node);
    work->listed = 0;
}

int srv_inflight_opened(struct srv_work *work) {
    struct srv_hash_table *table = &work->service->inflight->table;
    uint64_t hash = srv_hash_table_hash(table, work->key, work->key_bytes);
    inflight_lock(work);
    work->opened = 1;
    int alive = work->key_bytes && !work->stop;
    struct srv_hash_node *same =
        alive ? srv_hash_table_find(table, hash, work->key, work->key_bytes) : NULL;
    if (same) {
        inflight_join(SRV_CONTAINER_OF(same, struct srv_work, node),
                      srv_inflight_next(&work->waiters));
    } else if (alive) {
        work->node = (struct srv_hash_node){.key = work->key, .bytes = work->key_bytes};
        srv_hash_table_add(table, &work->node, hash);
        work->listed = 1;
    }
    inflight_unlock(work);
    return same != NULL;
}

enum srv_stop srv_inflight_stop(struct srv_work *work) {
    inflight_lock(work);
    enum srv_stop stop = work->stop;
    inflight_unlock(work);
    return stop;
}

/* Moves the exchanges that wait for a computation to `taken`. The caller holds the lock. */
static void inflight_take(struct srv_work *work, struct srv_list *taken) {
    SRV_LIST_EACH (link, &work->waiters) inflight_of_link(link)->work = NULL;
    srv_list_move(&work->waiters, taken);
}

void srv_inflight_take(struct srv_work *work, struct srv_list *taken) {
    inflight_lock(work);
    inflight_unlist(work);
    inflight_take(work, taken);
    inflight_unlock(work);
}

int srv_inflight_waiters(struct srv_work *work) {
    int count = 0;
    inflight_lock(work);
    SRV_LIST_EACH (link, &work->waiters) count++;
    inflight_unlock(work);
    return count;
}

/* Removes a computation from the queue or from its source, if no worker has it. Returns 1 if it was
 * removed. The caller holds the lock. */
static int inflight_withdraw(struct srv_work *work) {
    int rests = work->parked || work->fetching;
    work->parked = work->fetching = 0;
    return rests || srv_queue_remove(work->service->queue, &work->task);
}

/* Removes an exchange from a computation. Returns the computation if it should end, else NULL. The
 * caller holds the lock. */
static struct srv_work *inflight_leave_work(struct srv_work *work, struct srv_exchange *exchange,
                                            enum srv_stop why, int *detached) {
    int alone = work->waiters.next == work->waiters.previous,
        withdrawn = alone && inflight_withdraw(work);
    /* A worker that is reading the request still needs the exchange. */
    *detached = work->opened || withdrawn;
    if (*detached) {
        srv_list_remove(&exchange->beside);
        exchange->work = NULL;
    }
    if (!alone) return NULL;
    inflight_unlist(work);
    work->stop = why;
    return withdrawn ? work : NULL;
}

/* Removes the reader of a stream. Returns the computation if it should end, else NULL. The caller
 * holds the lock. */
static struct srv_work *inflight_leave_stream(struct srv_work *work, struct srv_exchange *exchange,
                                              enum srv_stop why, int *detached) {
    *detached = work->reader_waits;
    exchange->stream = NULL;
    work->reader = NULL;
    work->reader_waits = 0;
    if (!work->stop) work->stop = why;
    return work->over || inflight_withdraw(work) ? work : NULL;
}

struct srv_work *srv_inflight_leave(struct srv_exchange *exchange, enum srv_stop why,
                                    int *detached) {
    struct srv_work *gone = NULL;
    struct srv_inflight *inflight = exchange->service->inflight;
    *detached = 0;
    pthread_mutex_lock(&inflight->lock);
    if (!exchange->stop) exchange->stop = why;
    if (exchange->stream)
        gone = inflight_leave_stream(exchange->stream, exchange, why, detached);
    else if (exchange->work)
        gone = inflight_leave_work(exchange->work, exchange, why, detached);
    pthread_mutex_unlock(&inflight->lock);
    return gone;
}

enum srv_stop srv_inflight_left(const struct srv_exchange *exchange) {
    struct srv_inflight *inflight = exchange->service->inflight;
    pthread_mutex_lock(&inflight->lock);
    enum srv_stop why = (enum srv_stop)exchange->stop;
    pthread_mutex_unlock(&inflight->lock);
    return why;
}

/* --- streams --- */

struct srv_exchange *srv_inflight_stream(struct srv_work *work, struct srv_list *others) {
    inflight_lock(work);
    inflight_unlist(work);
    struct srv_exchange *reader = srv_inflight_next(&work->waiters);
    inflight_take(work, others);
    work->reader = reader;
    if (reader) {
        reader->work = NULL;
        reader->stream = work;
        reader->streams = 1;
    }
    inflight_unlock(work);
    return reader;
}

/* Returns the block that was appended last, which is sent next. */
static struct api_buffer *inflight_chunk(struct srv_work *work) {
    return work->coder ? &work->coded : &work->out;
}

static int inflight_drained(const struct srv_work *work) {
    return work->taken == work->ready.bytes;
}

int srv_inflight_hungry(struct srv_work *work) {
    inflight_lock(work);
    int hungry = work->reader_waits;
    inflight_unlock(work);
    return hungry;
}

/* Makes the appended block the one to send. The caller holds the lock. */
static void inflight_swap(struct srv_work *work) {
    struct api_buffer *chunk = inflight_chunk(work), sent = work->ready;
    work->ready = *chunk;
    *chunk = sent;
    chunk->bytes = 0;
    /* Free the large buffer that was needed before the head was sent. */
    if (chunk->cap > INFLIGHT_LARGE) api_buffer_clear(chunk);
    work->ready_cap = work->ready.cap;
    work->taken = 0;
}

int srv_inflight_pass(struct srv_work *work, int ended, int *over) {
    struct api_buffer *chunk = inflight_chunk(work);
    inflight_lock(work);
    if (!work->reader) ended = -1;
    if (work->reader) {
        work->reader->computed = work->spent;
        work->reader->steps = api_call_steps(work->call);
    }
    if (inflight_drained(work) && chunk->bytes) inflight_swap(work);
    work->ended = ended;
    work->over = *over = ended != 0;
    work->parked = !ended && chunk->bytes >= SRV_INFLIGHT_BLOCK;
    int go_on = !ended && !work->parked, gone = ended && !work->reader;
    if (work->reader_waits && (ended || !inflight_drained(work))) {
        work->reader_waits = 0;
        work->reader->finish(work->reader);
    }
    inflight_unlock(work);
    if (gone) srv_inflight_end(work);
    return go_on;
}

int srv_inflight_park(struct srv_work *work) {
    inflight_lock(work);
    assert(work->source && !work->parked && !work->over);
    int rests = work->fetching = !work->stop;
    inflight_unlock(work);
    return rests;
}

void srv_inflight_unpark(struct srv_work *work) {
    inflight_lock(work);
    if (work->fetching) srv_queue_again(work->service->queue, &work->task);
    work->fetching = 0;
    inflight_unlock(work);
}

/* If the block to send is used up, replaces it by the appended one. Returns 1 if the computation
 * rested until then and should go on. The caller holds the lock. */
static int inflight_refill(struct srv_work *work) {
    int rests = work->parked || work->fetching || work->over;
    if (inflight_drained(work) && rests && inflight_chunk(work)->bytes) inflight_swap(work);
    int again = work->parked && !inflight_chunk(work)->bytes;
    if (again) work->parked = 0;
    return again;
}

long srv_inflight_read(struct srv_exchange *exchange, char *to, size_t cap,
                       void (*pause)(struct srv_exchange *)) {
    struct srv_inflight *inflight = exchange->service->inflight;
    long result = SRV_INFLIGHT_BROKEN;
    pthread_mutex_lock(&inflight->lock);
    struct srv_work *work = exchange->stream;
    if (work) {
        assert(srv_inflight_valid(work) && work->reader == exchange);
        int again = inflight_refill(work);
        size_t left = work->ready.bytes - work->taken, count = left < cap ? left : cap;
        if (count) memcpy(to, work->ready.data + work->taken, count);
        work->taken += count;
        result = (long)count;
        if (!result && work->ended)
            result = work->ended > 0 ? SRV_INFLIGHT_END : SRV_INFLIGHT_BROKEN;
        if (result == SRV_INFLIGHT_WAIT) {
            work->reader_waits = 1;
            pause(exchange);
        }
        if (again) srv_queue_again(work->service->queue, &work->task);
    }
    pthread_mutex_unlock(&inflight->lock);
    return result;
}

void srv_inflight_stat_fields(struct srv_exchange *exchange,
                              struct api_stats_headers *stat_fields) {
    struct srv_inflight *inflight = exchange->service->inflight;
    stat_fields->count = 0;
    pthread_mutex_lock(&inflight->lock);
    struct srv_work *work = exchange->stream;
    struct api_answer answer =
        work && work->ended > 0 ? api_call_answer(work->call) : (struct api_answer){0};
    if (answer.stat_fields) *stat_fields = *answer.stat_fields;
    pthread_mutex_unlock(&inflight->lock);
}
