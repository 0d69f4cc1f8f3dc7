/* The counters of the running server, and their text for Prometheus.
 * Leaves to others: counting (http, compute, cache), access to the text (router).
 * Invariant: counting takes no lock and never waits; every metric is a row of a table here. */
#pragma once

#include <stdatomic.h>
#include <stdint.h>

#include "api/base/buffer.h"

/* Counters: field, name, labels, help. Rows with the same name are adjacent. */
#define SRV_COUNTERS(X)                                                                            \
    X(bytes_in, "pendulumd_request_body_bytes_total", "", "Bytes of request bodies")               \
    X(bytes_out, "pendulumd_response_body_bytes_total", "", "Bytes of answer bodies sent")         \
    X(cache_exact, "pendulumd_cache_lookups_total", "result=\"exact\"",                            \
      "Cache lookups by result: same bytes, same meaning, being computed, or not found")           \
    X(cache_digest, "pendulumd_cache_lookups_total", "result=\"digest\"", "")                      \
    X(cache_joined, "pendulumd_cache_lookups_total", "result=\"joined\"", "")                      \
    X(cache_missed, "pendulumd_cache_lookups_total", "result=\"missed\"", "")                      \
    X(not_modified, "pendulumd_not_modified_total", "", "Answers 304 to If-None-Match")            \
    X(cancelled, "pendulumd_cancelled_total", "",                                                  \
      "Computations cancelled because their clients disconnected")                                 \
    X(overtime, "pendulumd_overtime_total", "", "Computations longer than max-compute-seconds")    \
    X(broken, "pendulumd_broken_streams_total", "",                                                \
      "Streams cut off because the computation failed")                                            \
    X(refused_queue, "pendulumd_refused_total", "limit=\"max-queue\"",                             \
      "Refused requests, by limit")                                                                \
    X(refused_client, "pendulumd_refused_total", "limit=\"max-client-queue\"", "")                 \
    X(refused_rate, "pendulumd_refused_total", "limit=\"max-requests-a-minute\"", "")              \
    X(refused_held, "pendulumd_refused_total", "limit=\"max-held-bytes\"", "")                     \
    X(refused_share, "pendulumd_refused_total", "limit=\"max-client-held-bytes\"", "")             \
    X(refused_own_connections, "pendulumd_refused_total", "limit=\"max-client-connections\"", "")  \
    X(refused_wait, "pendulumd_refused_total", "limit=\"max-wait-seconds\"", "")                   \
    X(refused_connections, "pendulumd_refused_total", "limit=\"max-connections\"", "")             \
    X(refused_keys, "pendulumd_refused_total", "limit=\"key\"", "")                                \
    X(refused_roles, "pendulumd_refused_total", "limit=\"role\"", "")                              \
    X(refused_compute, "pendulumd_refused_total", "limit=\"compute\"", "")                         \
    X(slices, "pendulumd_slices_total", "", "Time slices of computations on a worker")             \
    X(parts_kept, "pendulumd_job_parts_total", "end=\"kept\"",                                     \
      "Parts of jobs that this process computed, by result")                                       \
    X(parts_lost, "pendulumd_job_parts_total", "end=\"lost\"", "")                                 \
    X(parts_failed, "pendulumd_job_parts_total", "end=\"failed\"", "")                             \
    X(busy_ns, "pendulumd_worker_busy_seconds_total", "", "Total busy time of all workers")

/* Gauges, read when metrics are requested: field, name, labels, help. Rows with the same name are
 * adjacent. */
#define SRV_GAUGES(X)                                                                              \
    X(queued, "pendulumd_queue_depth", "", "Computations that wait for a worker")                  \
    X(computing, "pendulumd_computations", "",                                                     \
      "Computations in progress: waiting, running, or waiting for their reader")                   \
    X(workers, "pendulumd_workers", "", "Threads that compute")                                    \
    X(busy, "pendulumd_workers_busy", "", "Workers that are computing")                            \
    X(connections, "pendulumd_connections", "", "Open connections")                                \
    X(event_streams, "pendulumd_event_streams", "", "Open event streams")                          \
    X(held, "pendulumd_held_bytes", "",                                                            \
      "Memory used by or reserved for requests, answers, jobs and connections")                    \
    X(held_connections, "pendulumd_held_kind_bytes", "kind=\"connections\"",                       \
      "Memory used by or reserved for each kind of owner")                                         \
    X(held_bodies, "pendulumd_held_kind_bytes", "kind=\"bodies\"", "")                             \
    X(held_computations, "pendulumd_held_kind_bytes", "kind=\"computations\"", "")                 \
    X(held_answers, "pendulumd_held_kind_bytes", "kind=\"answers\"", "")                           \
    X(held_jobs, "pendulumd_held_kind_bytes", "kind=\"jobs\"", "")                                 \
    X(allocated, "pendulumd_allocated_bytes", "", "Memory allocated by malloc; 0 if unknown")      \
    X(cache_bytes, "pendulumd_cache_bytes", "", "Memory of the cache")                             \
    X(cache_entries, "pendulumd_cache_entries", "", "Keys in the cache")                           \
    X(draining, "pendulumd_draining", "", "1 while the server drains, else 0")                     \
    X(jobs_accepted, "pendulumd_jobs", "state=\"accepted\"", "Jobs in the store by their state")   \
    X(jobs_running, "pendulumd_jobs", "state=\"running\"", "")                                     \
    X(jobs_successful, "pendulumd_jobs", "state=\"successful\"", "")                               \
    X(jobs_failed, "pendulumd_jobs", "state=\"failed\"", "")                                       \
    X(jobs_dismissed, "pendulumd_jobs", "state=\"dismissed\"", "")                                 \
    X(parts_waiting, "pendulumd_job_parts_waiting", "",                                            \
      "Parts of jobs that are ready for a worker")                                                 \
    X(job_oldest, "pendulumd_job_oldest_waiting_seconds", "",                                      \
      "Age of the oldest waiting job among the next jobs of all clients; 0 = none waits")          \
    X(processes, "pendulumd_store_workers", "",                                                    \
      "Processes that compute jobs of a PostgreSQL store now; 0 on SQLite")                        \
    X(store_connections, "pendulumd_store_connections", "",                                        \
      "Connections of all processes to a PostgreSQL store; 0 on SQLite")                           \
    X(store_bytes, "pendulumd_store_bytes", "", "Bytes kept for jobs in the store")                \
    X(store_up, "pendulumd_store_up", "", "1 while the store answers, else 0; 0 without a store")  \
    X(resident, "process_resident_memory_bytes", "", "Resident memory of the process")             \
    X(started, "process_start_time_seconds", "", "Start of the process, in seconds since 1970")

/* Histograms of durations: field, stage; those of requests, then those of jobs. */
#define SRV_STAGES(X)                                                                              \
    X(queue, "queue") /* from the complete request to a worker */                                  \
    X(compute, "compute")                                                                          \
    X(write, "write") /* from the answer's first byte to its last */                               \
    X(total, "total")
#define SRV_JOB_STAGES(X)                                                                          \
    X(job_wait, "wait") /* from the submission to the claim of a job's first part */               \
    X(job_run, "run")   /* from the claim of a part to its result on disk */

enum {
    SRV_METRIC_BUCKETS = 19, /* the last bucket is +Inf */
    SRV_METRIC_ROUTES = 96,  /* number of routes; the last stands for unknown routes; the router
                              * asserts the number */
    SRV_METRIC_STATUS = 600
};

struct srv_histogram {
    atomic_ullong bucket[SRV_METRIC_BUCKETS], sum_ns;
};

struct srv_metrics {
#define X(field, name, labels, help) atomic_ullong field;
    SRV_COUNTERS(X)
#undef X
#define X(field, stage) struct srv_histogram field;
    SRV_STAGES(X)
    SRV_JOB_STAGES(X)
#undef X
    atomic_ullong requests[SRV_METRIC_ROUTES][SRV_METRIC_STATUS];
};

struct srv_gauges {
#define X(field, name, labels, help) double field;
    SRV_GAUGES(X)
#undef X
};

/** Adds to a counter. Any thread; one or two nanoseconds. */
static inline void srv_metrics_count(atomic_ullong *counter, unsigned long long count) {
    atomic_fetch_add_explicit(counter, count, memory_order_relaxed);
}

/** Counts a request of a route by its HTTP status; 0 = no answer. Any thread. */
void srv_metrics_request(struct srv_metrics *metrics, int route, int status);

/** Adds a duration to a histogram; a value <= 0 is ignored, because the stage was not reached. */
void srv_metrics_time(struct srv_histogram *histogram, int64_t ns);

/** Returns the resident memory of the process in bytes; 0 if unknown. */
double srv_metrics_resident(void);

/**
 * Writes all metrics in Prometheus' text format (version 0.0.4).
 *
 * label  the label of route i, as "POST /v1/trees"; NULL beyond the last.
 *
 * Fails as api_buffer_room does.
 */
PEND_MUST_CHECK enum pend_status srv_metrics_write(struct srv_metrics *metrics,
                                                   const struct srv_gauges *gauges,
                                                   const char *(*label)(int route),
                                                   struct api_buffer *out);
