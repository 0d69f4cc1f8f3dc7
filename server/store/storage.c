#include "server/store/storage.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/condition.h"

enum {
    MOST_TOGETHER = 128,
    SWEEP_MS = 1000,
    SWEEP_WORKERS = 8,
    SWEEP_SHARE = 20, /* after a sweep without a find: a pause of 20 times its time, */
    SWEEP_REST = 10,  /* but at most this many seconds */
    RING_MS = 10, /* ms: least time between two notifications by a process; for those of work, this
                   * times the number of workers */
    RING_WAKES = 300,
    LISTEN_MS = 500,
    READERS = 1,
    WRITERS = 1,
    DESKS = READERS + WRITERS + 1,
    THREADS = DESKS + 4 /* for files */
};

struct storage_line {
    struct srv_turns turns;
    pthread_cond_t some;
};

struct storage_desk {
    struct srv_storage *storage;
    struct srv_store *store;
    enum srv_ask_kind kind;
    pthread_t thread;
    int runs;
    int away; /* the store was unreachable at the last attempt */
};

struct srv_storage {
    struct srv_log *log;
    void (*news)(void *context, int rings);
    void *context;
    pthread_mutex_t lock; /* guards the lines, the end and the figures */
    struct storage_line line[SRV_ASK_KINDS];
    struct srv_asker own; /* for queries of the process itself */
    int over;
    struct srv_store_figures figures;
    int count;       /* number of threads; 1 in a worker process, which has one connection */
    int wake;        /* an eventfd that ends the wait of the only thread */
    atomic_int away; /* connections that cannot reach the store */
    struct storage_desk desk[THREADS]; /* writers, readers, the listener, those for files */
};

/* Records whether the store answered a thread. Logs when the first thread loses the store, and when
 * all have it back. */
static void storage_note(struct storage_desk *desk, enum srv_stored stored) {
    struct srv_storage *storage = desk->storage;
    int away = stored == SRV_STORED_AWAY || stored == SRV_STORED_BROKEN;
    if (desk->away == away) return;
    desk->away = away;
    if (away && atomic_fetch_add(&storage->away, 1) == 0)
        srv_log_message(storage->log, "the store is not reachable: %s",
                        srv_store_complaint(desk->store));
    if (away || atomic_fetch_sub(&storage->away, 1) != 1) return;
    srv_log_message(storage->log, "the store is reachable again");
    storage->news(storage->context, SRV_RING_ALL);
}

static struct srv_turns_road *storage_road(struct srv_asker *asker, enum srv_ask_kind kind) {
    return &(asker->origin ? asker->origin : asker)->at[kind].road;
}

/* removes the next query in turn from its line; NULL if none waits. The caller holds the lock */
static struct srv_ask *storage_next(struct srv_storage *storage, enum srv_ask_kind kind) {
    struct srv_list *link = srv_turns_next(&storage->line[kind].turns);
    if (!link) return NULL;
    struct srv_ask *ask = SRV_CONTAINER_OF(link, struct srv_ask, link);
    srv_turns_remove(storage_road(ask->asker, kind), &ask->asker->at[kind].lane, link);
    return ask;
}

/* waits for a query or a notification on the only thread's connection, without the lock */
static void storage_hear(struct storage_desk *desk, int64_t until) {
    struct srv_storage *storage = desk->storage;
    assert(storage->count == 1 && desk->kind == SRV_ASK_WRITE);
    int64_t left_ms = (until - srv_clock_now() + 999999) / 1000000;
    uint64_t rung;
    pthread_mutex_unlock(&storage->lock);
    int heard = srv_store_listen(desk->store, left_ms > 0 ? (int)left_ms : 0, storage->wake);
    if (heard > 0) storage->news(storage->context, heard);
    if (left_ms > 0) (void)!read(storage->wake, &rung, sizeof rung);
    pthread_mutex_lock(&storage->lock);
}

/* takes up to `most` queries of a thread's line; if there are none, waits until the given time.
 * Returns their number */
static int storage_take(struct storage_desk *desk, int most, int64_t until,
                        struct srv_store_call *call[]) {
    struct srv_storage *storage = desk->storage;
    struct storage_line *line = &storage->line[desk->kind];
    struct srv_ask *ask;
    int count = 0, early = 1;
    pthread_mutex_lock(&storage->lock);
    if (storage->count == 1)
        storage_hear(desk, srv_list_empty(&line->turns.roads) && !storage->over ? until : 0);
    while (srv_list_empty(&line->turns.roads) && !storage->over && early && storage->count > 1)
        early = srv_condition_wait(&line->some, &storage->lock, until);
    while (count < most && (ask = storage_next(storage, desk->kind))) call[count++] = &ask->call;
    pthread_mutex_unlock(&storage->lock);
    return count;
}

/* The state of the sweeps that a writing thread runs between queries: rounds of steps, one round
 * per second. While there is more to sweep, a round lasts its whole second. */
struct storage_round {
    int64_t next, begun;    /* ns: time of the next step; start of the round */
    int64_t before, looked; /* us by the store's clock: start of the previous and of this round */
    int pieces;             /* steps of this round so far; 0 = not begun */
};

/* runs one step of a sweep; returns 1 if more remains */
static int storage_piece(struct srv_storage *storage, struct srv_store *store,
                         struct storage_round *round, enum srv_stored *stored) {
    struct srv_store_sweep sweep;
    int64_t looked = round->pieces ? round->before : round->looked;
    if (!round->pieces) round->before = looked;
    *stored = srv_store_sweep(store, &looked, &sweep);
    if (*stored != SRV_STORED) return 0;
    if (!round->pieces++) round->looked = looked;
    if (sweep.released || sweep.given_up) {
        srv_log_message(storage->log,
                        "%d parts of jobs were taken from workers that stopped responding, %d jobs "
                        "failed for good",
                        sweep.released, sweep.given_up);
        storage->news(storage->context, SRV_RING_ALL);
    }
    return sweep.more;
}

static void storage_sweep(struct storage_desk *desk, struct storage_round *round) {
    struct srv_storage *storage = desk->storage;
    struct srv_store *store = desk->store;
    struct srv_store_figures figures;
    enum srv_stored stored;
    int64_t now = srv_clock_now(), begin = now, second = srv_clock_span(SWEEP_MS / 1000.0);
    if (!round->pieces) round->begun = now;
    int more = storage_piece(storage, store, round, &stored);
    round->next = now = srv_clock_now();
    if (more && now < round->begun + second) return;
    round->pieces = 0;
    if (stored == SRV_STORED) stored = srv_store_figures(store, &figures);
    storage_note(desk, stored);
    /* an api process sweeps every second; worker processes share the task */
    int64_t seconds =
        storage->count == 1 && stored == SRV_STORED ? 1 + figures.workers / SWEEP_WORKERS : 1;
    int64_t rest = SWEEP_SHARE * (srv_clock_now() - begin);
    if (rest > SWEEP_REST * second) rest = SWEEP_REST * second;
    if (!more) round->next = now + (rest > seconds * second ? rest : seconds * second);
    if (stored != SRV_STORED) return;
    pthread_mutex_lock(&storage->lock);
    storage->figures = figures;
    pthread_mutex_unlock(&storage->lock);
}

/* true if no query of a kind waits, not even one that came during a sweep, and none will come */
static int storage_done(struct srv_storage *storage, enum srv_ask_kind kind) {
    pthread_mutex_lock(&storage->lock);
    int done = storage->over && srv_list_empty(&storage->line[kind].turns.roads);
    pthread_mutex_unlock(&storage->lock);
    return done;
}

/* Rate-limits the notifications of a thread, by kind. Notifications of work become rarer with the
 * number of workers, because each worker also polls at a random time. PostgreSQL wakes every
 * listening connection, whatever its channel; all notifications of ended jobs together therefore
 * wake at most RING_WAKES connections per second. */
struct storage_rings {
    int64_t work, others; /* ns: earliest next notification */
};

static int64_t storage_ring(struct storage_desk *desk, struct storage_rings *rings) {
    int wanted = srv_store_rings(desk->store), due = 0;
    assert((wanted & ~SRV_RING_ALL) == 0);
    if (!wanted) return INT64_MAX;
    pthread_mutex_lock(&desk->storage->lock);
    int64_t workers = desk->storage->figures.workers;
    pthread_mutex_unlock(&desk->storage->lock);
    int64_t now = srv_clock_now(), gap = srv_clock_span(RING_MS / 1000.0);
    int64_t most = workers * gap;
    if (now >= rings->work) due |= wanted & SRV_RING_WORK;
    if (now >= rings->others) due |= wanted & ~SRV_RING_WORK;
    if (due & SRV_RING_WORK) rings->work = now + (most > gap ? most : gap);
    int64_t ends = desk->storage->count == 1 ? workers * workers * (1000000000 / RING_WAKES) : 0;
    if (due & ~SRV_RING_WORK) rings->others = now + (ends > gap ? ends : gap);
    if (due) srv_store_ring(desk->store, due);
    wanted &= ~due;
    return !wanted ? INT64_MAX : wanted & ~SRV_RING_WORK ? rings->others : rings->work;
}

static void *storage_serve(void *context) {
    struct storage_desk *desk = context;
    struct srv_storage *storage = desk->storage;
    int most = desk->kind == SRV_ASK_WRITE ? srv_store_batch(desk->store) : 1;
    int64_t second = srv_clock_span(SWEEP_MS / 1000.0), rings_at = INT64_MAX;
    struct storage_rings rings = {0};
    struct storage_round round = {.next = srv_clock_now()};
    struct srv_store_call *call[MOST_TOGETHER];
    if (most > MOST_TOGETHER) most = MOST_TOGETHER;
    assert(most >= 1);
    do {
        int64_t until = desk->kind == SRV_ASK_WRITE ? round.next : srv_clock_now() + second;
        int count = storage_take(desk, most, rings_at < until ? rings_at : until, call);
        if (count) srv_store_together(desk->store, call, count);
        for (int i = 0; i < count; i++) {
            storage_note(desk, call[i]->stored);
            struct srv_ask *ask = SRV_CONTAINER_OF(call[i], struct srv_ask, call);
            ask->done(ask);
        }
        rings_at = storage_ring(desk, &rings);
        /* an idle thread checks whether the store is reachable again */
        struct srv_store_figures figures;
        if (desk->kind == SRV_ASK_READ && !count && desk->away)
            storage_note(desk, srv_store_figures(desk->store, &figures));
        /* queries go first: they may extend leases that a sweep would find expired */
        if (desk->kind == SRV_ASK_WRITE && srv_clock_now() >= round.next)
            storage_sweep(desk, &round);
    } while (!storage_done(storage, desk->kind));
    return NULL;
}

/* serves queries for files, without a store */
static void *storage_carry(void *context) {
    struct srv_storage *storage = ((struct storage_desk *)context)->storage;
    struct srv_ask *ask;
    do {
        pthread_mutex_lock(&storage->lock);
        while (!(ask = storage_next(storage, SRV_ASK_FILE)) && !storage->over)
            pthread_cond_wait(&storage->line[SRV_ASK_FILE].some, &storage->lock);
        pthread_mutex_unlock(&storage->lock);
        if (ask) ask->call.stored = ask->call.run(NULL, &ask->call);
        if (ask) ask->done(ask);
    } while (ask);
    return NULL;
}

static void *storage_listen(void *context) {
    struct storage_desk *desk = context;
    struct srv_storage *storage = desk->storage;
    int heard = 0;
    while (heard >= 0 && !storage_done(storage, desk->kind))
        if ((heard = srv_store_listen(desk->store, LISTEN_MS, -1)) > 0)
            storage->news(storage->context, SRV_RING_ALL);
    return NULL;
}

/* starts the threads for files */
static enum pend_status storage_files(struct srv_storage *storage, struct pend_error *error) {
    for (struct storage_desk *desk = &storage->desk[DESKS]; desk < &storage->desk[THREADS];
         desk++) {
        desk->storage = storage;
        desk->runs = !pthread_create(&desk->thread, NULL, storage_carry, desk);
        if (!desk->runs)
            return pend_fail(error, PEND_NO_MEMORY, -1, 0, "cannot start a thread for files");
    }
    return PEND_OK;
}

/* logs how many processes the database supports */
static void storage_carries(struct storage_desk *desk) {
    int64_t connections, workers;
    if (srv_store_carries(desk->store, &connections, &workers) != SRV_STORED || !connections)
        return;
    srv_log_message(
        desk->storage->log,
        "the database's max_connections, %lld, allows %lld processes of the role worker (1 "
        "connection each; they leave the last 8 free) besides one of another role (3 connections)",
        (long long)connections, (long long)(workers > 0 ? workers : 0));
}

static enum pend_status storage_start(struct srv_storage *storage, const char *url,
                                      const struct srv_store_rules *rules,
                                      struct pend_error *error) {
    struct srv_store_rules own = *rules;
    storage->count = DESKS;
    if (rules->files) PEND_TRY(storage_files(storage, error));
    for (int i = 0; i < storage->count; i++) {
        struct storage_desk *desk = &storage->desk[i];
        int listens = i == DESKS - 1;
        desk->storage = storage;
        desk->kind = i < WRITERS ? SRV_ASK_WRITE : SRV_ASK_READ;
        own.role = rules->role | (i ? SRV_SQL_BESIDE : 0);
        PEND_TRY(srv_store_open(&desk->store, url, &own, error));
        if (!i && !srv_store_settled(desk->store)) storage_note(desk, SRV_STORED_AWAY);
        if (!i && srv_store_settled(desk->store)) storage_carries(desk);
        if (rules->role == SRV_SQL_WORKS && srv_store_distant(desk->store)) storage->count = 1;
        if (listens && srv_store_listen(desk->store, 0, -1) < 0) continue;
        desk->runs =
            !pthread_create(&desk->thread, NULL, listens ? storage_listen : storage_serve, desk);
        if (!desk->runs)
            return pend_fail(error, PEND_NO_MEMORY, -1, 0, "cannot start a thread for the store");
    }
    return PEND_OK;
}

enum pend_status srv_storage_new(struct srv_storage **storage, const char *url,
                                 const struct srv_store_rules *rules, struct srv_log *log,
                                 void (*news)(void *context, int rings), void *context,
                                 struct pend_error *error) {
    struct srv_storage *made = *storage = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->log = log;
    made->news = news;
    made->context = context;
    made->wake = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    pthread_mutex_init(&made->lock, NULL);
    for (int kind = 0; kind < SRV_ASK_KINDS; kind++) srv_condition_init(&made->line[kind].some);
    enum pend_status status = storage_start(made, url, rules, error);
    if (status != PEND_OK) srv_storage_free(storage);
    return status;
}

static void storage_wake(struct srv_storage *storage) {
    static const uint64_t one = 1;
    if (storage->count == 1) (void)!write(storage->wake, &one, sizeof one);
}

void srv_storage_free(struct srv_storage **storage) {
    struct srv_storage *gone = *storage;
    if (!gone) return;
    pthread_mutex_lock(&gone->lock);
    gone->over = 1;
    for (int kind = 0; kind < SRV_ASK_KINDS; kind++) pthread_cond_broadcast(&gone->line[kind].some);
    storage_wake(gone);
    pthread_mutex_unlock(&gone->lock);
    for (int i = 0; i < THREADS; i++) {
        if (gone->desk[i].runs) pthread_join(gone->desk[i].thread, NULL);
        srv_store_close(&gone->desk[i].store);
    }
    // clear the pointer only now, because the threads read it in their callbacks
    *storage = NULL;
    for (int kind = 0; kind < SRV_ASK_KINDS; kind++) {
        assert(srv_list_empty(&gone->line[kind].turns.roads));
        pthread_cond_destroy(&gone->line[kind].some);
    }
    pthread_mutex_destroy(&gone->lock);
    if (gone->wake >= 0) close(gone->wake);
    free(gone);
}

void srv_storage_ask(struct srv_storage *storage, enum srv_ask_kind kind, struct srv_ask *ask) {
    if (storage->count == 1 && kind != SRV_ASK_FILE) kind = SRV_ASK_WRITE;
    struct storage_line *line = &storage->line[kind];
    pthread_mutex_lock(&storage->lock);
    assert(!storage->over && ask->done && ask->call.run);
    if (!ask->asker) ask->asker = &storage->own;
    srv_turns_add(&line->turns, storage_road(ask->asker, kind), &ask->asker->at[kind].lane,
                  &ask->link);
    storage_wake(storage);
    pthread_cond_signal(&line->some);
    pthread_mutex_unlock(&storage->lock);
}

/* A query on behalf of a thread that waits for its result. */
struct storage_waiter {
    struct srv_ask ask;
    struct srv_ask *own;
    sem_t answered;
};

static enum srv_stored storage_wait_run(struct srv_store *store, struct srv_store_call *call) {
    struct storage_waiter *waiter = SRV_CONTAINER_OF(call, struct storage_waiter, ask.call);
    return waiter->own->call.run(store, &waiter->own->call);
}

static void storage_wait_done(struct srv_ask *ask) {
    struct storage_waiter *waiter = SRV_CONTAINER_OF(ask, struct storage_waiter, ask);
    sem_post(&waiter->answered);
}

enum srv_stored srv_storage_wait(struct srv_storage *storage, enum srv_ask_kind kind,
                                 struct srv_ask *ask) {
    struct storage_waiter waiter = {
        .ask = {.call = {.run = storage_wait_run}, .done = storage_wait_done, .asker = ask->asker},
        .own = ask};
    sem_init(&waiter.answered, 0, 0);
    srv_storage_ask(storage, kind, &waiter.ask);
    while (sem_wait(&waiter.answered)) continue;
    sem_destroy(&waiter.answered);
    return ask->call.stored = waiter.ask.call.stored;
}

int srv_storage_here(const struct srv_storage *storage) { return !atomic_load(&storage->away); }

int srv_storage_hears(const struct srv_storage *storage) {
    return storage->desk[storage->count - 1].runs;
}

struct srv_store_figures srv_storage_figures(struct srv_storage *storage) {
    pthread_mutex_lock(&storage->lock);
    struct srv_store_figures figures = storage->figures;
    pthread_mutex_unlock(&storage->lock);
    return figures;
}
