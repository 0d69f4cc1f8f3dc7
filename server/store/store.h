/* The store of jobs and scenes: the calls of every store, whatever its database.
 * Leaves to others: the databases (store_sqlite, store_postgres), running the jobs.
 * Invariant: data for which a call returned SRV_STORED are on disk and survive the death of any
 * process; a part's result is accepted once, from the attempt that holds its lease. */
#ifndef SRV_STORE_H
#define SRV_STORE_H

#include <stddef.h>
#include <stdint.h>

#include "server/store/sql.h"

enum {
    SRV_ID_BYTES = 27,            /* of a job or scene, with its NUL: 26 letters of base 32 */
    SRV_DIGEST_BYTES = 32,        /* of a request */
    SRV_REQUEST_HEAD_BYTES = 256, /* what a job says of its end */
    SRV_NAME_BYTES = 96,          /* clients, workers, operations, idempotency keys */
    SRV_TITLE_BYTES = 128,        /* what a client calls its job */
    SRV_VERSION_BYTES = 48,       /* of the program that took a job in */
    SRV_CHUNK_BYTES = 256 * 1024, /* a piece of a part's result; only the last is shorter */
    SRV_CLAIMS = 64,     /* parts that one claim takes at most: so many only if each computes for */
    SRV_SMALL_US = 5000, /* no longer than this, and all of them for */
    SRV_CLAIM_US = 20000, /* no longer than this, as it is estimated */
    SRV_ROW_BYTES =
        1024, /* what a job or a scene is counted for, beside its request, results or body */
    SRV_PART_BYTES = 256,   /* and each part of a job after the first */
    SRV_LIST_LOOKED = 1000, /* jobs that one call of a list looks at */
    SRV_RANK_TIMES = 64, /* a job of so much computation, us, is behind newer ones for so many times
                            as long at most, */
    SRV_RANK_KNEE_US =
        57142857,           /* if that is shorter than this; else for as long as it computes and */
    SRV_RANK_MOST_S = 3600, /* this, s */
    SRV_MOST_KILLS = 3      /* workers that may vanish while they compute one part and nothing else,
                               and no part of the job be done between, before it is given up */
};

/* The status words of OGC API - Processes; the numbers are what the databases hold. */
enum srv_job_state {
    SRV_JOB_ACCEPTED,
    SRV_JOB_RUNNING,
    SRV_JOB_SUCCESSFUL,
    SRV_JOB_FAILED,
    SRV_JOB_DISMISSED,
    SRV_JOB_STATES
};

/* Quotas and times of a store; the same in all processes that share it. */
struct srv_store_rules {
    int role;                          /* of the process, SRV_SQL_ bits; 0 = not known */
    long client_jobs;                  /* open jobs of one client */
    long long client_bytes, all_bytes; /* kept for jobs, of one client and in all */
    int64_t keep_us;                   /* from a job's end to its removal */
    long client_scenes;                /* scenes of one client */
    long long client_scene_bytes, all_scene_bytes; /* of scenes, of one client and in all */
    /* What comes from one address or account, whoever says to be its client, has these bounds; 0
     * = none. */
    long source_clients; /* clients of one source that have jobs */
    long source_jobs, source_scenes;
    long long source_bytes;
    long classes, class_pupils; /* rooms in all, pupils of one */
    long long class_bytes;      /* that the items of one are counted for */
};

/* A job to be kept; texts are shorter than SRV_NAME_BYTES and not NULL unless said. */
struct srv_job_order {
    const char *id, *client, *operation;
    const char *source;  /* the address or account that the client comes from; NULL = the client is
                            one itself */
    const char *key;     /* the client's own idempotency key, or NULL */
    const char *title;   /* what the client calls it; NULL = nothing */
    const char *version; /* of the program that takes it in; NULL = none is told */
    const void *request;
    size_t request_bytes;
    const unsigned char *digest; /* SRV_DIGEST_BYTES, of operation and request */
    long parts;                  /* >= 1 */
    int chained;     /* non-zero: a part starts from what the one before it carried over */
    int64_t cost_us; /* computation of all parts, as it is estimated */
    /* what this client may have beside what the store's rules allow to any; 0 = as much */
    long client_jobs;
    long long client_bytes;
    int turns; /* that a claim of one of the client's jobs counts for; 0 = 1 */
};

/* What is known of a job. Times are microseconds since 1970 by the store's clock, 0 = has not
 * happened. */
struct srv_job {
    char id[SRV_ID_BYTES], client[SRV_NAME_BYTES], operation[SRV_NAME_BYTES];
    enum srv_job_state state;
    long parts, done;
    long begun;   /* parts that a worker has held, ever */
    long waiting; /* of these, those that nobody holds and that are not done */
    int chained;
    int64_t created, started, finished, expires;
    int64_t now;     /* of the same clock, when this was read */
    long long bytes; /* of results */
    long long held;  /* bytes that its row and its request are counted for */
    char message[SRV_REQUEST_HEAD_BYTES];
    char title[SRV_TITLE_BYTES], version[SRV_VERSION_BYTES]; /* "" = none was told */
    const char *flaw; /* NULL, or the column of its row that holds what nobody can have written: it
                         has failed */
};

/* A piece of a job that a worker holds for a while. */
struct srv_lease {
    char job[SRV_ID_BYTES], operation[SRV_NAME_BYTES];
    long part, parts;
    long attempt;      /* the fencing token: grows with every claim of this part */
    int64_t waited_us; /* the job, before this part, its first; 0 for others */
    int alone;         /* a worker that held it has vanished: it is computed beside nothing else */
    int64_t part_us;   /* of computation, as it is estimated */
    void *request;     /* of the job; NULL where it is long; freed by srv_lease_clear */
    size_t request_bytes;
    void *start; /* what the part before it carried over; NULL where there is none; freed by
                    srv_lease_clear */
    size_t start_bytes;
};

/* A connection to a store; one thread at a time uses it. */
struct srv_store;

/**
 * Opens a store, makes its tables where there are none.
 *
 * store  out; NULL on failure.
 * url    "sqlite:PATH" or "postgresql://...".
 * error  the sentence for the operator.
 *
 * A database that cannot be reached just now is no failure: calls return SRV_STORED_AWAY until it
 * can be.
 *
 * PEND_INVALID    the url names no known store, the file cannot be opened, or the tables are of
 *                 another version.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_store_open(struct srv_store **store, const char *url,
                                                const struct srv_store_rules *rules,
                                                struct pend_error *error);

/** Closes a store and sets the pointer to NULL; NULL is accepted. */
void srv_store_close(struct srv_store **store);

/** Returns true once the tables are known to be those of this version, for which the database
 * must have been reached. */
int srv_store_settled(const struct srv_store *store);

/** Returns what the database said about the last failure; "" if nothing. */
const char *srv_store_complaint(const struct srv_store *store);

/** Returns the largest useful number of calls for one srv_store_together. */
int srv_store_batch(const struct srv_store *store);

/* One call of a batch: does its work on the store and returns the result, which is final once
 * `stored` is set. */
struct srv_store_call {
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call);
    enum srv_stored stored; /* out */
    const struct srv_lease
        *finish; /* what `run` is to end by srv_store_finish, so that the rows of all parts that a
                  * batch ends can be read at once; NULL: nobody knows */
};

/**
 * Runs calls in one transaction with one write to disk. A call that fails leaves no trace and does
 * not affect the others. If the transaction as a whole fails, each call is run again by itself; so
 * is a call that finds the disk full.
 *
 * calls  count of them; `stored` of each is set to what its run returned, or to the commit's
 * failure.
 */
void srv_store_together(struct srv_store *store, struct srv_store_call *const calls[], int count);

/**
 * Keeps a job.
 *
 * job  out: the new job, or the one that the same key and digest made before (its id differs from
 *      the order's). The key of a job that failed, was dismissed or is past its time is free again.
 *
 * SRV_STORED_CLASH  the client used the key for another request.
 * SRV_STORED_QUOTA  too many open jobs, or too many bytes are kept, of the client or of all clients
 *                   of its source; job->message says which.
 *
 * The request is counted, and kept until the job fails, is dismissed or expires. Quotas are looked
 * up, not locked:
 * several processes that accept jobs at one instant may pass them by what one transaction of each
 * has accepted.
 */
enum srv_stored srv_store_submit(struct srv_store *store, const struct srv_job_order *order,
                                 struct srv_job *job);

/** Reads a job; one whose row is damaged has failed from now on, and its message says why.
 * SRV_STORED_NONE */
enum srv_stored srv_store_job(struct srv_store *store, const char *id, struct srv_job *job);

/**
 * Reads a job's request; empty where the job has failed or was dismissed.
 *
 * request  out, malloc'ed, the caller's.
 *
 * SRV_STORED_NONE
 * SRV_STORED_DAMAGED  it is not what was written: the job has failed from now on, and its message
 *                     says why.
 */
enum srv_stored srv_store_job_request(struct srv_store *store, const char *id, void **request,
                                      size_t *bytes);

/* Which of a client's jobs a list is to hold; begins as {.state = SRV_JOB_STATES}. */
struct srv_job_wish {
    enum srv_job_state state; /* SRV_JOB_STATES = any */
    const char *operation;    /* NULL = any */
    const char *title;  /* that the job's holds, letters of ASCII in either case; NULL = any */
    int64_t since;      /* us since 1970: created then or later; 0 = at any time */
    const char *before; /* the id that the page begins after, or NULL */
    int most;           /* jobs of a page, >= 1 */
};

/**
 * A page of a client's jobs, newest first. A call looks at SRV_LIST_LOOKED jobs at most, so that
 * a page of a wish that few jobs suit may be short, or empty, and not be the last.
 *
 * job    out, room for wish->most.
 * count  out.
 * last   out: the id that the next page begins after; "" = there is none, as far as is known.
 */
enum srv_stored srv_store_list(struct srv_store *store, const char *client,
                               const struct srv_job_wish *wish, struct srv_job job[], int *count,
                               char last[SRV_ID_BYTES]);

/** Dismisses a job for its client: its parts stop, and its request and results are removed.
 * SRV_STORED_NONE */
enum srv_stored srv_store_dismiss(struct srv_store *store, const char *id, struct srv_job *job);

/* Which parts a worker takes beside those that nobody has held. */
enum srv_claim_aside {
    SRV_CLAIM_BESIDE, /* the worker holds parts: none that was set aside */
    SRV_CLAIM_IDLE,   /* the worker holds none: one that was set aside if nothing else waits */
    SRV_CLAIM_ASIDE   /* the same, one that was set aside before all others */
};

/* A claim of parts. */
struct srv_claim {
    const char *worker; /* a name that no other process has */
    int64_t lease_us;   /* how long the parts are held, us */
    int most;           /* 1 .. SRV_CLAIMS */
    enum srv_claim_aside aside;
    int count;   /* out: >= 1 where SRV_STORED is returned. In: of the same claim, when it is
                    repeated because its outcome is unknown; else 0 */
    int skipped; /* out: parts that were set aside wait */
};

/**
 * Takes parts that wait, those that nobody has held before first: one part, or one of each of as
 * many jobs while they are small, of the clients in turn. Of one client's jobs the next is the one
 * of the lowest srv_store_rank: a short job goes before a long one, and none waits for ever. The
 * cost of a claim
 * does not depend on how much waits. A job whose row is damaged fails; the call then returns
 * SRV_STORED_AGAIN, and the caller should claim again.
 *
 * Parts whose worker vanished are set aside: each of them is the only part of its claim, for a
 * worker that holds nothing else, so that the end of a process is counted against no other part.
 *
 * lease  out, room for claim->most; of a claim that is repeated as it was left.
 *
 * SRV_STORED_NONE  nothing waits.
 * SRV_STORED_LOST  other processes are claiming what waits.
 */
enum srv_stored srv_store_claim(struct srv_store *store, struct srv_claim *claim,
                                struct srv_lease lease[]);

/**
 * When a job's turn comes among those of its client, which go in the order of these instants.
 *
 * created  us since 1970.
 * left_us  of computation that nobody has begun, as it is estimated, >= 0.
 *
 * Returns created + 64 left_us, or created + left_us + 1 h where that is earlier: what has least
 * left goes first, but a job waits for jobs that are made later only until that instant. Instants
 * move with the jobs' parts, not with the clock, so that an index holds them in order.
 */
int64_t srv_store_rank(int64_t created, int64_t left_us);

/** Returns whom to wake because of what was committed: bits of SRV_RING_. */
int srv_store_rings(const struct srv_store *store);

/** Wakes those of `rings`. PostgreSQL lets one transaction at a time commit that notifies, so that
 * this is not done in those that change something. */
void srv_store_ring(struct srv_store *store, int rings);

/** Frees what a lease holds in memory. */
void srv_lease_clear(struct srv_lease *lease);

/** Holds a part for longer. SRV_STORED_LOST */
enum srv_stored srv_store_extend(struct srv_store *store, const struct srv_lease *lease,
                                 int64_t lease_us);

/**
 * Keeps a part's result; the last one ends the job.
 *
 * carry  for a chained job: what the next part starts from; not for the last part.
 *
 * SRV_STORED_LOST   another attempt has the part, or the job is over.
 * SRV_STORED_QUOTA  the client's quota of bytes would be passed: the job has failed with that
 *                   message.
 * Repeating a call whose outcome is unknown is safe.
 */
enum srv_stored srv_store_finish(struct srv_store *store, const struct srv_lease *lease,
                                 const void *data, size_t bytes, const void *carry,
                                 size_t carry_bytes);

/** Ends a job as failed; the message is for its client. SRV_STORED_LOST */
enum srv_stored srv_store_fail(struct srv_store *store, const struct srv_lease *lease,
                               const char *message);

/** Returns every part that a worker holds to the waiting parts, without counting an attempt
 * against it. */
enum srv_stored srv_store_release(struct srv_store *store, const char *worker);

/**
 * Reads a chunk of a part's result.
 *
 * data   out, room for SRV_CHUNK_BYTES.
 *
 * SRV_STORED_NONE     there is no such chunk.
 * SRV_STORED_DAMAGED  it is not what was written: bits have changed, or it is another job's or
 *                     part's.
 */
enum srv_stored srv_store_chunk(struct srv_store *store, const char *id, long part, long chunk,
                                void *data, size_t *bytes);

/* What a sweep found. */
struct srv_store_sweep {
    int more;     /* work is left: sweep again soon */
    int released; /* parts whose lease had run out wait again */
    int given_up; /* jobs that failed because their workers vanished */
    int expired;  /* jobs that were removed because they were past their time */
};

/**
 * Returns parts whose lease ran out to the waiting parts, gives up jobs whose workers vanish, and
 * removes jobs that were dismissed or have expired. One call does a piece of this: at most 64
 * parts, 64 chunks of results of a job that has ended, and 128 jobs that expired. Any process may
 * sweep at any time. After the store's clock has jumped ahead no job expires for ten minutes, so
 * that a clock which was set by mistake, and is set back, costs nobody a result.
 *
 * looked  us by the store's clock, 0 at first, set to now. Only leases count that had run out when
 * this process swept the last time, so that a process that was suspended can extend its own leases
 * before it judges any. NULL: all leases that have run out.
 */
enum srv_stored srv_store_sweep(struct srv_store *store, int64_t *looked,
                                struct srv_store_sweep *sweep);

enum { SRV_ERASE_MOST = 32 };

/**
 * Erases a piece of what is kept of a client's jobs: open ones are dismissed, and all go with their
 * results, of which large ones are removed by the sweeps that follow.
 *
 * most   jobs of the piece, SRV_ERASE_MOST at most; a full disk has space for few.
 * count  out: jobs that were erased; 0 when none is left.
 */
enum srv_stored srv_store_erase_jobs(struct srv_store *store, const char *client, int most,
                                     int *count);

/** Has a client keep some of its scenes no more; those that nobody else keeps go.
 *
 * most   scenes of the piece.
 * count  out: scenes that were let go; 0 when none is left. */
enum srv_stored srv_store_erase_scenes(struct srv_store *store, const char *client, int most,
                                       int *count);

/* What is in a store, for metrics and for whoever decides how many workers there should be. */
struct srv_store_figures {
    long jobs[SRV_JOB_STATES];
    long long bytes; /* kept for jobs: rows, requests, results */
    long parts;      /* that could be claimed now */
    long scenes;
    long long scene_bytes;
    int64_t oldest_us; /* since when the oldest of the jobs waits that are their clients' next */
    /* On a database that processes share: those that compute, and the connections of all; 0 where
     * it does not say */
    long workers, connections;
    const char
        *full; /* why no job can be kept, as a sentence's part; NULL = it can, or nobody knows */
};

/** Reads the sums that every call keeps up to date; its cost depends on nothing that is kept. */
enum srv_stored srv_store_figures(struct srv_store *store, struct srv_store_figures *figures);

/**
 * Stores a scene for this client; other clients may have stored it too.
 *
 * id      shorter than SRV_ID_BYTES; the same id and body twice is no fault.
 * source  the address or account that the client comes from; NULL = the client is one itself.
 *
 * SRV_STORED_CLASH  the id has another body; this client does not keep it.
 * SRV_STORED_QUOTA  the client, all clients of its source, or all clients would have too many, or
 * too many bytes.
 */
enum srv_stored srv_store_scene_put(struct srv_store *store, const char *id, const char *client,
                                    const char *source, const void *body, size_t bytes);

/** As srv_store_scene_put, for a scene that is stored already, whatever its body.
 * SRV_STORED_NONE, SRV_STORED_QUOTA */
enum srv_stored srv_store_scene_keep(struct srv_store *store, const char *id, const char *client,
                                     const char *source);

/**
 * Removes this client's share of a scene; the scene is removed with the last share.
 *
 * SRV_STORED_NONE   there is no such scene.
 * SRV_STORED_CLASH  other clients keep it, this client does not.
 */
enum srv_stored srv_store_scene_drop(struct srv_store *store, const char *id, const char *client);

/** Reads a scene; body is malloc'ed and the caller's. SRV_STORED_NONE; SRV_STORED_DAMAGED: it is
 * not what was kept */
enum srv_stored srv_store_scene(struct srv_store *store, const char *id, void **body,
                                size_t *bytes);

/**
 * Waits until another process may have stored, ended or returned something. The result is only a
 * hint.
 *
 * wake  a file: the wait ends when it can be read; -1 = none.
 *
 * Returns bits of SRV_RING_ for the news that there may be, 0 after the time, and -1 if the store
 * cannot notify other processes; callers must poll then.
 */
int srv_store_listen(struct srv_store *store, int timeout_ms, int wake);

/** How many connections the database takes, and how many processes that only compute it carries
 * beside one that answers; 0 where it takes any number. */
enum srv_stored srv_store_carries(struct srv_store *store, int64_t *connections, int64_t *workers);

/** Returns true for a database that is reached over connections of which it has few. */
int srv_store_distant(const struct srv_store *store);

#endif
