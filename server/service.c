#include "server/service.h"

const struct srv_config *srv_service_config(const struct srv_service *service) {
    const struct srv_reloaded *reloaded = atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? &reloaded->config : &service->config;
}

const struct srv_peers *srv_service_trusted(const struct srv_service *service) {
    const struct srv_reloaded *reloaded = atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? &reloaded->trusted : &service->trusted;
}

const char *srv_service_hosts(const struct srv_service *service) {
    const struct srv_reloaded *reloaded = atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? reloaded->hosts : service->hosts;
}

const struct api_limits *srv_service_job_limits(const struct srv_service *service) {
    const struct srv_reloaded *reloaded = atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? &reloaded->job_limits : &service->job_limits;
}

int srv_service_room(const struct srv_service *service) {
    double cached = (double)srv_cache_size(service->cache).bodies;
    return (double)atomic_load(&service->held) - cached <= srv_service_config(service)->held_bytes;
}

const char *srv_service_jobless(const struct srv_service *service) {
    if (!service->storage) return "this server keeps no jobs: --store none";
    if (!srv_storage_here(service->storage)) return "the store is out of reach";
    return (double)srv_storage_figures(service->storage).bytes >= service->config.store_bytes
               ? "the store is full: max-store-bytes"
               : NULL;
}

struct srv_gauges srv_service_gauges(const struct srv_service *service) {
    struct srv_cache_size cache = srv_cache_size(service->cache);
    struct srv_store_figures store = {0};
    if (service->storage) store = srv_storage_figures(service->storage);
    return (struct srv_gauges){.queued = srv_queue_count(service->queue),
                               .computing = atomic_load(&service->computing),
                               .workers = service->workers,
                               .busy = atomic_load(&service->busy),
                               .connections = atomic_load(&service->connections),
                               .event_streams = atomic_load(&service->listening),
                               .held = (double)atomic_load(&service->held),
                               .cache_bytes = (double)cache.bytes,
                               .cache_entries = (double)cache.entries,
                               .draining = atomic_load(&service->draining) != SRV_DRAIN_NOT,
                               .jobs_accepted = (double)store.jobs[SRV_JOB_ACCEPTED],
                               .jobs_running = (double)store.jobs[SRV_JOB_RUNNING],
                               .jobs_successful = (double)store.jobs[SRV_JOB_SUCCESSFUL],
                               .jobs_failed = (double)store.jobs[SRV_JOB_FAILED],
                               .jobs_dismissed = (double)store.jobs[SRV_JOB_DISMISSED],
                               .parts_waiting = (double)store.shards,
                               .store_bytes = (double)store.bytes,
                               .store_up = service->storage && srv_storage_here(service->storage),
                               .resident = srv_metrics_resident(),
                               .started = service->started};
}
