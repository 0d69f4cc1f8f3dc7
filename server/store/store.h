/* The store of jobs and scenes: the calls of every store, whatever its database.
 * Leaves to others: the databases (store_sqlite, store_postgres), running the jobs.
 * Invariant: data for which a call returned SRV_STORED are on disk and survive the death of any
 * process; a part's result is accepted once, from the attempt that holds its lease. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "api/encode/encode_raw.h"
#include "server/store/sql.h"

enum {
    SRV_ID_BYTES = 27,            /* id of a job or scene with its NUL: 26 letters of base 32 */
    SRV_DIGEST_BYTES = 32,        /* digest of a request */
    SRV_REQUEST_HEAD_BYTES = 256, /* message of a failed job */
    SRV_NAME_BYTES = 96,          /* clients, workers, operations, idempotency keys */
    SRV_TITLE_BYTES = 128,        /* title of a job */
    SRV_VERSION_BYTES = 48,       /* version of the program that accepted a job */
    SRV_CHUNK_BYTES = 256 * 1024, /* a piece of a part's result; only the last is shorter */
    SRV_CLAIMS = 64, /* maximum number of parts per claim; several only if all of them are small */
    SRV_SMALL_US = 5000,    /* maximum us of a small part, by its estimate */
    SRV_CLAIM_US = 20000,   /* maximum us of all small parts of a claim */
    SRV_ROW_BYTES = 1024,   /* bytes counted for a job or scene besides its request and results */
    SRV_PART_BYTES = 256,   /* bytes counted for each part of a job after the first */
    SRV_LIST_LOOKED = 1000, /* jobs that one call of a list examines */
    SRV_RANK_TIMES = 64,    /* newer jobs may overtake a short job for this multiple of its
                             * computation time */
    SRV_RANK_KNEE_US = 57142857, /* us of computation from which a job counts as long */
    SRV_RANK_MOST_S = 3600,      /* and a long job for its computation time plus this many
                                  * seconds */
    SRV_MOST_KILLS = 3 /* a job fails after this many workers vanished while computing one part
                        * alone, without other progress of the job */
};

/* The states of OGC API - Processes; the databases store these numbers. */
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
    int role;                          /* roles of the process, SRV_SQL_ bits; 0 = unknown */
    long client_jobs;                  /* maximum number of open jobs of one client */
    long long client_bytes, all_bytes; /* maximum bytes for jobs, of one client and of all */
    int64_t keep_us;                   /* retention after a job's end, us */
    long client_scenes;                /* maximum number of scenes of one client */
    long long client_scene_bytes,
        all_scene_bytes; /* maximum bytes of scenes, of one client and of all */
    /* Limits of an address or account, over all clients that come from it; 0 = none. */
    long source_clients; /* maximum number of clients of one source that have jobs */
    long source_jobs, source_scenes;
    long long source_bytes;
    long classes, class_pupils; /* maximum number of rooms in all, most pupils of a room */
    long long class_bytes;      /* maximum bytes of the items of a room */
    struct srv_files *files;    /* where large results are stored; NULL = in the database */
};

/* A new job; texts are shorter than SRV_NAME_BYTES and not NULL unless noted. */
struct srv_job_order {
    const char *id, *client, *operation;
    const char *source;  /* address or account of the client; NULL = the client is one itself */
    const char *key;     /* the client's idempotency key, or NULL */
    const char *title;   /* NULL = none */
    const char *version; /* version of the program that accepts it; NULL = unknown */
    const void *request;
    size_t request_bytes;
    const unsigned char *digest; /* SRV_DIGEST_BYTES: digest of operation and request */
    long parts;                  /* >= 1 */
    int chained;     /* non-zero: a part starts from the checkpoint of the previous one */
    int64_t cost_us; /* estimated computation time of all parts */
    /* tighter limits of this client; 0 = the store's rules apply */
    long client_jobs;
    long long client_bytes;
    int turns; /* turns that a claim of this client's jobs counts for; 0 = 1 */
};

/* A stored job. Times are microseconds since 1970 by the store's clock, 0 = has not happened. */
struct srv_job {
    char id[SRV_ID_BYTES], client[SRV_NAME_BYTES], operation[SRV_NAME_BYTES];
    enum srv_job_state state;
    long parts, done;
    long begun;   /* parts that have been claimed at least once */
    long waiting; /* begun parts that are neither done nor held by a worker */
    int chained;
    int64_t created, started, finished, expires;
    int64_t now;     /* when the row was read, by the same clock */
    long long bytes; /* bytes of results */
    long long held;  /* bytes counted for its row and its request */
    char message[SRV_REQUEST_HEAD_BYTES];
    char title[SRV_TITLE_BYTES], version[SRV_VERSION_BYTES]; /* "" = none */
    const char *flaw; /* NULL, or the column of its row with an impossible value: the job has
                         failed */
};

/* A part of a job that a worker holds until the lease expires. */
struct srv_lease {
    char job[SRV_ID_BYTES], operation[SRV_NAME_BYTES];
    long part, parts;
    long attempt;      /* fencing token: increases with every claim of this part */
    int64_t waited_us; /* waiting time of the job, for its first part; else 0 */
    int alone;         /* a worker that held it has vanished: it is now computed alone */
    int64_t part_us;   /* estimated computation time */
    size_t elsewhere;  /* bytes of its result that are in a file, and count as stored */
    void *request;     /* the job's request; NULL if it is long; freed by srv_lease_clear */
    size_t request_bytes;
    void *start; /* checkpoint of the previous part; NULL if none; freed by srv_lease_clear */
    size_t start_bytes;
};

/* A connection to a store; one thread at a time uses it. */
struct srv_store;

/**
 * Opens a store, and creates its tables if they do not exist.
 *
 * store  out; NULL on failure.
 * url    "sqlite:PATH" or "postgresql://...".
 * error  the sentence for the operator.
 *
 * An unreachable database is no failure: calls return SRV_STORED_AWAY until it can be reached.
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

/** Returns true once the tables are known to have this version's schema. */
int srv_store_settled(const struct srv_store *store);

/** Returns the database's message about the last failure, or the limit that refused a scene; "" =
 * none. */
const char *srv_store_complaint(const struct srv_store *store);

/** Returns the largest useful number of calls for one srv_store_together. */
int srv_store_batch(const struct srv_store *store);

/* One call of a batch. `run` works on the store and returns its result, which is final once
 * `stored` is set. */
struct srv_store_call {
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call);
    enum srv_stored stored;         /* out */
    const struct srv_lease *finish; /* the part that `run` will finish, so that a batch can read the
                                     * rows of all its parts at once; NULL = unknown */
};

/**
 * Runs calls in one transaction with one sync to disk. A failed call has no effect, also not on the
 * others. If the transaction fails, each call is run again alone; so is a call that finds the disk
 * full.
 *
 * calls  `stored` of each is set to the result of its run, or to the failure of the commit.
 */
void srv_store_together(struct srv_store *store, struct srv_store_call *const calls[], int count);

/**
 * Stores a new job.
 *
 * job  out: the new job, or the earlier one with the same key and digest (its id differs from the
 *      order's). The key of a failed, dismissed or expired job can be used again.
 *
 * SRV_STORED_CLASH  the client used the key for another request.
 * SRV_STORED_QUOTA  too many open jobs or too many stored bytes, of the client or of its source;
 *                   job->message says which.
 *
 * The request counts towards the quota, and is stored until the job fails, is dismissed or expires.
 * Quotas are read without a lock: processes that accept jobs at the same instant may exceed them by
 * one transaction each.
 */
enum srv_stored srv_store_submit(struct srv_store *store, const struct srv_job_order *order,
                                 struct srv_job *job);

/** Reads a job. A job with a damaged row is marked as failed, with a message. SRV_STORED_NONE */
enum srv_stored srv_store_job(struct srv_store *store, const char *id, struct srv_job *job);

/**
 * Reads a job's request; empty if the job has failed or was dismissed.
 *
 * request  out, malloc'ed; the caller frees it.
 *
 * SRV_STORED_NONE
 * SRV_STORED_DAMAGED  its checksum is wrong: the job is marked as failed, with a message.
 */
enum srv_stored srv_store_job_request(struct srv_store *store, const char *id, void **request,
                                      size_t *bytes);

/* The filter of a list of jobs; initialized with {.state = SRV_JOB_STATES}. */
struct srv_job_wish {
    enum srv_job_state state; /* SRV_JOB_STATES = any */
    const char *operation;    /* NULL = any */
    const char *title;        /* substring of the title, ASCII case ignored; NULL = any */
    int64_t since;            /* us since 1970: created at or after this instant; 0 = any time */
    const char *before;       /* the page begins after this id; NULL = the first page */
    int most;                 /* jobs per page, >= 1 */
};

/**
 * Lists a page of a client's jobs, newest first. A call examines at most SRV_LIST_LOOKED jobs, so a
 * page with few matches may be short or empty without being the last.
 *
 * job    out, space for wish->most.
 * count  out.
 * last   out: the id that the next page begins after; "" = this is the last page.
 */
enum srv_stored srv_store_list(struct srv_store *store, const char *client,
                               const struct srv_job_wish *wish, struct srv_job job[], int *count,
                               char last[SRV_ID_BYTES]);

/** Dismisses a job: its parts stop, and its request and results are deleted. SRV_STORED_NONE */
enum srv_stored srv_store_dismiss(struct srv_store *store, const char *id, struct srv_job *job);

/* Whether a claim may take parts that were set aside because their worker vanished. */
enum srv_claim_aside {
    SRV_CLAIM_BESIDE, /* no: the worker holds other parts */
    SRV_CLAIM_IDLE,   /* one, if nothing else waits: the worker is idle */
    SRV_CLAIM_ASIDE   /* one, before all other parts: the worker is idle */
};

/* A claim of parts. */
struct srv_claim {
    const char *worker; /* unique name of the process */
    int64_t lease_us;   /* length of the lease, us */
    int most;           /* 1 .. SRV_CLAIMS */
    enum srv_claim_aside aside;
    int count;   /* out: >= 1 if SRV_STORED is returned. In: 0, or the count of the same claim
                    if it is repeated because its outcome is unknown */
    int skipped; /* out: non-zero if parts that were set aside are waiting */
};

/**
 * Claims waiting parts, never-claimed ones first: one part, or several small ones of different
 * jobs, with clients in turn. Among the jobs of a client the one with the lowest srv_store_rank is
 * next: short jobs overtake long ones, but none waits for ever. The cost does not depend on the
 * length of the queue. If a job's row is damaged, the job fails and the call returns
 * SRV_STORED_AGAIN: claim again.
 *
 * A part whose worker vanished is set aside: it is then claimed alone, by an idle worker, so that
 * the death of a process counts against that part only.
 *
 * lease  out, space for claim->most; in a repeated claim, as the first call left it.
 *
 * SRV_STORED_NONE  no part is waiting.
 * SRV_STORED_LOST  other processes are claiming the waiting parts.
 */
enum srv_stored srv_store_claim(struct srv_store *store, struct srv_claim *claim,
                                struct srv_lease lease[]);
void srv_lease_clear(struct srv_lease *lease);

/**
 * The rank of a job among the jobs of its client; the lowest is next.
 *
 * created  us since 1970.
 * left_us  estimated computation time of the parts not yet begun, us, >= 0.
 *
 * Returns the earlier of created + 64 left_us and created + left_us + 1 h: the job with the least
 * work left goes first, but newer jobs overtake it only until that instant. Ranks change with the
 * jobs' parts, not with the clock, so an index keeps their order.
 */
int64_t srv_store_rank(int64_t created, int64_t left_us);

/** Returns the notifications that the committed transactions require: SRV_RING_ bits. */
int srv_store_rings(const struct srv_store *store);

/** Sends notifications, SRV_RING_ bits. PostgreSQL serializes the commits of transactions that
 * notify, so notifications are not sent in the transactions that write. */
void srv_store_ring(struct srv_store *store, int rings);

/** Extends a lease. SRV_STORED_LOST */
enum srv_stored srv_store_extend(struct srv_store *store, const struct srv_lease *lease,
                                 int64_t lease_us);

/**
 * Stores a part's result; the last one ends the job.
 *
 * carry  for a chained job: the checkpoint for the next part; not for the last part.
 *
 * SRV_STORED_LOST   another attempt has the part, or the job has ended.
 * SRV_STORED_QUOTA  the client's quota of bytes would be exceeded: the job has failed with that
 *                   message.
 * Repeating a call whose outcome is unknown is safe.
 */
enum srv_stored srv_store_finish(struct srv_store *store, const struct srv_lease *lease,
                                 const void *data, size_t bytes, const void *carry,
                                 size_t carry_bytes);

/** Ends a job as failed; the message is for its client. SRV_STORED_LOST */
enum srv_stored srv_store_fail(struct srv_store *store, const struct srv_lease *lease,
                               const char *message);

/** Returns all parts of a worker to the queue, without counting an attempt. */
enum srv_stored srv_store_release(struct srv_store *store, const char *worker);

/**
 * Reads a chunk of a part's result.
 *
 * data   out, space for SRV_CHUNK_BYTES.
 *
 * SRV_STORED_NONE     the chunk does not exist.
 * SRV_STORED_DAMAGED  its checksum is wrong: bits have changed, or it belongs to another part.
 */
enum srv_stored srv_store_chunk(struct srv_store *store, const char *id, long part, long chunk,
                                void *data, size_t *bytes);

enum { SRV_PART_FILES = 1000 };

/** Calls `take` for the files of at most SRV_PART_FILES parts of a job, in order, from part *from
 * on; *from becomes the part after the last. SRV_STORED_CLASH: the results of a part are in the
 * database; SRV_STORED_DAMAGED; what `take` returns. */
enum srv_stored srv_store_files(struct srv_store *store, const char *job, long *from,
                                enum srv_stored (*take)(void *context, long part,
                                                        const struct api_raw_file *file),
                                void *context);

/* The result of a sweep. */
struct srv_store_sweep {
    int more;     /* non-zero: more work remains, sweep again soon */
    int released; /* parts returned to the queue because their lease expired */
    int given_up; /* jobs that failed because their workers vanished */
    int expired;  /* jobs deleted because they expired */
};

/**
 * Returns parts with expired leases to the queue, fails jobs whose workers keep vanishing, and
 * deletes dismissed and expired jobs. One call processes at most 64 parts, 64 chunks of results of
 * an ended job, and 128 expired jobs. Any process may sweep at any time. After the store's clock
 * jumps ahead no job expires for ten minutes, so that a wrong clock that is set back deletes no
 * result.
 *
 * looked  us by the store's clock, initially 0; set to now. Only leases that had already expired at
 *         this process's last sweep count, so that a process that was suspended can first extend
 * its own leases. NULL: all expired leases.
 */
enum srv_stored srv_store_sweep(struct srv_store *store, int64_t *looked,
                                struct srv_store_sweep *sweep);

enum { SRV_ERASE_MOST = 32 };

/**
 * Erases a batch of a client's jobs with their results; open jobs are dismissed first. Later sweeps
 * delete large results.
 *
 * most   maximum number of jobs of the batch, up to SRV_ERASE_MOST; a full disk has space for few.
 * count  out: jobs that were erased; 0 when none is left.
 */
enum srv_stored srv_store_erase_jobs(struct srv_store *store, const char *client, int most,
                                     int *count);

/** Removes a client from a batch of its scenes, and deletes those that no other client stored.
 *
 * most   maximum number of scenes of the batch.
 * count  out: scenes removed; 0 when none is left. */
enum srv_stored srv_store_erase_scenes(struct srv_store *store, const char *client, int most,
                                       int *count);

/* Figures of a store, for metrics and autoscaling. */
struct srv_store_figures {
    long jobs[SRV_JOB_STATES];
    long long bytes; /* bytes of jobs: rows, requests, results */
    long parts;      /* parts that can be claimed now */
    long scenes;
    long long scene_bytes;
    int64_t oldest_us; /* since when the longest-waiting of the clients' next jobs has waited */
    /* On a shared database: processes that compute, and connections of all processes; 0 = unknown
     */
    long workers, connections;
    const char *full; /* why no job can be stored, as a clause; NULL = it can, or unknown */
};

/** Reads the sums that every call keeps up to date; O(1) in the amount of stored data. */
enum srv_stored srv_store_figures(struct srv_store *store, struct srv_store_figures *figures);

/**
 * Stores a scene for this client; other clients may have stored it too.
 *
 * id      shorter than SRV_ID_BYTES; repeating the same id and body is no error.
 * source  address or account of the client; NULL = the client is one itself.
 *
 * SRV_STORED_CLASH  the id has another body; the client does not store it.
 * SRV_STORED_QUOTA  too many scenes or bytes of the client, of its source, or of all clients.
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
 * SRV_STORED_NONE   the scene does not exist.
 * SRV_STORED_CLASH  other clients stored it, this client did not.
 */
enum srv_stored srv_store_scene_drop(struct srv_store *store, const char *id, const char *client);

/** Reads a scene; body is malloc'ed, the caller frees it. SRV_STORED_NONE; SRV_STORED_DAMAGED: its
 * checksum is wrong */
enum srv_stored srv_store_scene(struct srv_store *store, const char *id, void **body,
                                size_t *bytes);

/**
 * Waits for a notification by another process. The result is only a hint.
 *
 * wake  a file descriptor; the wait also ends when it is readable; -1 = none.
 *
 * Returns SRV_RING_ bits, 0 after the timeout, and -1 if the store cannot notify other processes:
 * then callers must poll.
 */
int srv_store_listen(struct srv_store *store, int timeout_ms, int wake);

/** Returns the database's limit of connections, and the number of worker processes it supports
 * besides one api process; 0 = unlimited. */
enum srv_stored srv_store_carries(struct srv_store *store, int64_t *connections, int64_t *workers);

/** Returns true for a database server with a limited number of connections. */
int srv_store_distant(const struct srv_store *store);
