#include "server/jobs/download.h"

#include <stdlib.h>
#include <string.h>

#include "server/store/store_files.h"
#include "server/work/inflight.h"

enum { DOWNLOAD_AHEAD = 2 }; /* pieces in memory: one is encoded while the next is read */

struct download {
    struct srv_source source; /* first, because a source is converted to its download */
    struct srv_ask ask;
    struct srv_storage *storage;
    struct srv_hold hold; /* the reservation for the pieces */
    char id[SRV_ID_BYTES];
    long parts;
    void *body; /* the request */

    /* Owned by the storage thread during a query: the piece to read and its destination. If the
     * piece names a file instead of rows, `whole` becomes the part with the file's rows. */
    struct {
        long part, chunk;
        char *to;
        size_t bytes;
        struct api_raw_file file; /* width 0 = none */
        struct api_buffer whole;
    } read;

    pthread_mutex_t lock; /* guards the following members; taken before the lock of srv_inflight */
    struct srv_work *waiting; /* the computation that is parked until a piece arrives */
    int asked;                /* the storage thread is reading a piece */
    int stale;                /* the piece being read is no longer needed */
    int gone; /* the computation has ended; the thread that receives the piece frees the download */
    long part, chunk;       /* the next part and chunk to read */
    enum srv_stored stored; /* the error that ends reading; SRV_STORED = none */
    size_t given;           /* bytes of read.whole that have become pieces */
    int first, count;       /* the ring of pieces that have arrived */
    size_t bytes[DOWNLOAD_AHEAD];
    char data[]; /* the memory of DOWNLOAD_AHEAD pieces */
};

/* The ring's indices are in range, and the next piece belongs to the job. The caller holds the
 * lock. */
PEND_VALIDATOR download_valid(const struct download *download) {
    return download->first >= 0 && download->first < DOWNLOAD_AHEAD && download->count >= 0 &&
           download->count + download->asked <= DOWNLOAD_AHEAD && download->part >= 0 &&
           download->part <= download->parts && download->chunk >= 0;
}

static void download_end(struct download *download) {
    struct srv_hold *hold = &download->hold;
    pthread_mutex_destroy(&download->lock);
    srv_hold_set(hold, 0);
    if (hold->payer) srv_clients_give(hold->service->clients, hold->payer);
    free(download->body);
    api_buffer_clear(&download->read.whole);
    free(download);
}

/* --- on the storage threads --- */

static enum srv_stored download_run(struct srv_store *store, struct srv_store_call *call) {
    struct download *download = SRV_CONTAINER_OF(call, struct download, ask.call);
    return srv_store_chunk(store, download->id, download->read.part, download->read.chunk,
                           download->read.to, &download->read.bytes);
}

/* Reads the file that a piece names; called on a thread for files. */
static enum srv_stored download_file(struct srv_store *store, struct srv_store_call *call) {
    struct download *download = SRV_CONTAINER_OF(call, struct download, ask.call);
    struct srv_files *files = download->hold.service->files;
    struct api_buffer *whole = &download->read.whole;
    size_t bytes = sizeof *download + (size_t)DOWNLOAD_AHEAD * SRV_CHUNK_BYTES +
                   download->source.body_bytes + 2 * download->read.file.bytes;
    (void)store;
    /* a larger reservation stays, because all parts are similar */
    if (bytes > download->hold.bytes && srv_hold_try(&download->hold, bytes) != SRV_ROOM)
        return SRV_STORED_QUOTA;
    whole->limit = 2 * download->read.file.bytes + SRV_CHUNK_BYTES;
    SRV_STORED_TRY(
        srv_files_get(files, download->id, download->read.part, &download->read.file, whole));
    enum pend_status status = api_buffer_add(whole, download->read.to + API_RAW_FILE_BYTES,
                                             download->read.bytes - API_RAW_FILE_BYTES);
    return status == PEND_OK ? SRV_STORED : SRV_STORED_BROKEN;
}

/* Divides a part that is in memory into pieces. The caller holds the lock. */
static void download_cut(struct download *download) {
    struct api_buffer *whole = &download->read.whole;
    while (download->given < whole->bytes && download->count < DOWNLOAD_AHEAD) {
        int place = (download->first + download->count++) % DOWNLOAD_AHEAD;
        size_t left = whole->bytes - download->given,
               bytes = left < SRV_CHUNK_BYTES ? left : SRV_CHUNK_BYTES;
        memcpy(download->data + (size_t)place * SRV_CHUNK_BYTES, whole->data + download->given,
               bytes);
        download->bytes[place] = bytes;
        download->given += bytes;
    }
    if (download->given < whole->bytes) return;
    api_buffer_clear(whole);
    download->given = 0;
}

/* Requests the next piece if there is one and the ring has space. The caller holds the lock. */
static void download_ask(struct download *download) {
    assert(download_valid(download));
    if (download->asked) return;
    download_cut(download);
    int over = download->part == download->parts || download->stored != SRV_STORED;
    if (over || download->count == DOWNLOAD_AHEAD) return;
    int place = (download->first + download->count) % DOWNLOAD_AHEAD;
    download->read.part = download->part;
    download->read.chunk = download->chunk;
    download->read.to = download->data + (size_t)place * SRV_CHUNK_BYTES;
    download->read.bytes = 0;
    download->read.file.width = 0;
    download->ask.call.run = download_run;
    download->asked = 1;
    srv_storage_ask(download->storage, SRV_ASK_READ, &download->ask);
}

/* Takes a piece, or the error in its place. The caller holds the lock. */
static void download_take(struct download *download, enum srv_stored stored) {
    assert(download->count < DOWNLOAD_AHEAD);
    if (stored == SRV_STORED_NONE && !download->chunk && download->source.from.partial &&
        !download->read.file.width) {
        /* rows end before the first missing part */
        download->parts = download->part;
        return;
    }
    /* the last piece was full, so only now it shows that the part has no more */
    int none = stored == SRV_STORED_NONE && download->chunk > 0;
    size_t bytes = none ? 0 : download->read.bytes;
    if (stored != SRV_STORED && !none) {
        download->stored = stored;
        return;
    }
    download->chunk++;
    if (bytes < SRV_CHUNK_BYTES) {
        download->part++;
        download->chunk = 0;
    }
    assert(bytes <= SRV_CHUNK_BYTES);
    if (bytes && !download->read.file.width)
        download->bytes[(download->first + download->count++) % DOWNLOAD_AHEAD] = bytes;
}

/* Returns 1 if there is a piece, an error or the end. The caller holds the lock. */
static int download_has(const struct download *download) {
    return download->count || download->stored != SRV_STORED || download->part == download->parts;
}

static void download_done(struct srv_ask *ask) {
    struct download *download = SRV_CONTAINER_OF(ask, struct download, ask);
    pthread_mutex_lock(&download->lock);
    int gone = download->gone, idle = gone || download->stale;
    int filed = !idle && ask->call.stored == SRV_STORED && !download->read.chunk &&
                !download->read.file.width &&
                api_raw_file_get(download->read.to, download->read.bytes, &download->read.file);
    if (filed && download->hold.service->files) {
        ask->call.run = download_file;
        srv_storage_ask(download->storage, SRV_ASK_FILE, ask);
        pthread_mutex_unlock(&download->lock);
        return;
    }
    download->asked = 0;
    if (idle) api_buffer_clear(&download->read.whole);
    if (!gone) {
        if (!download->stale) download_take(download, filed ? SRV_STORED_CLASH : ask->call.stored);
        download->stale = 0;
        download_ask(download);
        if (download->waiting && download_has(download)) {
            /* the computation cannot end while the lock is held */
            srv_inflight_unpark(download->waiting);
            download->waiting = NULL;
        }
    }
    pthread_mutex_unlock(&download->lock);
    if (gone) download_end(download);
}

/* --- on a worker --- */

static int download_ready(void *context) {
    struct download *download = context;
    pthread_mutex_lock(&download->lock);
    download_ask(download);
    int has = download_has(download);
    pthread_mutex_unlock(&download->lock);
    return has;
}

static enum pend_status download_fetch(void *context, void *data, size_t cap, size_t *bytes,
                                       struct pend_error *error) {
    struct download *download = context;
    enum pend_status status = PEND_OK;
    *bytes = 0;
    if (cap < SRV_CHUNK_BYTES)
        return pend_fail(error, PEND_BUG, -1, 0, "a chunk of %d bytes has no room",
                         SRV_CHUNK_BYTES);
    pthread_mutex_lock(&download->lock);
    enum srv_stored stored = download->stored;
    if (download->count) {
        *bytes = download->bytes[download->first];
        memcpy(data, download->data + (size_t)download->first * SRV_CHUNK_BYTES, *bytes);
        download->first = (download->first + 1) % DOWNLOAD_AHEAD;
        download->count--;
        download_ask(download);
    } else if (stored != SRV_STORED) {
        status = pend_fail(error, PEND_CANCELLED, -1, 0,
                           stored == SRV_STORED_NONE ? "some of the job's results are lost, or no "
                                                       "longer stored"
                           : stored == SRV_STORED_CLASH
                               ? "the job's results are in files: start this server with the "
                                 "option --results of the workers"
                           : stored == SRV_STORED_QUOTA
                               ? "downloads of results hold too much memory now: try again"
                           : stored == SRV_STORED_DAMAGED ? "the job's stored results are damaged"
                                                          : "the store is not reachable");
    } else if (download->part < download->parts) {
        status = pend_fail(error, PEND_BUG, -1, 0, "nothing was read yet");
    }
    assert(*bytes <= cap && download->first < DOWNLOAD_AHEAD);
    pthread_mutex_unlock(&download->lock);
    return status;
}

static void download_again(void *context) {
    struct download *download = context;
    pthread_mutex_lock(&download->lock);
    download->stale = download->asked;
    download->part = download->chunk = download->count = 0;
    download->given = 0;
    if (!download->asked) api_buffer_clear(&download->read.whole);
    download->stored = SRV_STORED;
    pthread_mutex_unlock(&download->lock);
}

static int download_park(struct srv_source *source, struct srv_work *work) {
    assert(source && work);
    struct download *download = (struct download *)source;
    pthread_mutex_lock(&download->lock);
    int rests = !download_has(download) && srv_inflight_park(work);
    if (rests) download->waiting = work;
    pthread_mutex_unlock(&download->lock);
    return rests;
}

static void download_free(struct srv_source *source) {
    struct download *download = (struct download *)source;
    pthread_mutex_lock(&download->lock);
    assert(!download->gone);
    int asked = download->gone = download->asked;
    download->waiting = NULL;
    pthread_mutex_unlock(&download->lock);
    if (!asked) download_end(download);
}

enum srv_room srv_download_new(struct srv_source **source, struct srv_exchange *exchange,
                               const char *id, long parts, void *body, size_t body_bytes) {
    assert(parts >= 1 && strlen(id) < SRV_ID_BYTES);
    struct srv_service *service = exchange->service;
    struct download *made = malloc(sizeof *made + (size_t)DOWNLOAD_AHEAD * SRV_CHUNK_BYTES);
    *source = NULL;
    if (!made) {
        free(body);
        return SRV_ROOM_NONE;
    }
    *made = (struct download){.source = {.from = {.fetch = download_fetch,
                                                  .again = download_again,
                                                  .context = made,
                                                  .ready = download_ready},
                                         .body = body,
                                         .body_bytes = body_bytes,
                                         .park = download_park,
                                         .free = download_free},
                              .ask = {.call = {.run = download_run}, .done = download_done},
                              .storage = service->storage,
                              .hold = {.service = service,
                                       .payer = srv_exchange_payer(exchange),
                                       .kind = SRV_MEMORY_COMPUTATIONS},
                              .parts = parts,
                              .body = body,
                              .stored = SRV_STORED};
    memcpy(made->id, id, sizeof made->id);
    pthread_mutex_init(&made->lock, NULL);
    if (made->hold.payer) {
        srv_clients_share(service->clients, made->hold.payer);
        made->ask.asker = &made->hold.payer->asker;
    }
    enum srv_room room = srv_hold_try(
        &made->hold, sizeof *made + (size_t)DOWNLOAD_AHEAD * SRV_CHUNK_BYTES + body_bytes);
    if (room == SRV_ROOM)
        *source = &made->source;
    else
        download_end(made);
    return room;
}
