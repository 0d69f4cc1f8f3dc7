#include "server/work/service.h"

const struct srv_config *srv_service_config(const struct srv_service *service) {
    const struct srv_reloaded *reloaded =
        atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? &reloaded->config : &service->config;
}

const struct srv_peers *srv_service_trusted(const struct srv_service *service) {
    const struct srv_reloaded *reloaded =
        atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? &reloaded->trusted : &service->trusted;
}

const char *srv_service_hosts(const struct srv_service *service) {
    const struct srv_reloaded *reloaded =
        atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? reloaded->hosts : service->hosts;
}

const struct api_limits *srv_service_job_limits(const struct srv_service *service) {
    const struct srv_reloaded *reloaded =
        atomic_load_explicit(&service->reloaded, memory_order_acquire);
    return reloaded ? &reloaded->job_limits : &service->job_limits;
}

const char *srv_service_jobless(const struct srv_service *service) {
    if (!service->storage) return "this server stores no jobs: --store none";
    if (!srv_storage_here(service->storage)) return "the store is not reachable";
    return srv_storage_figures(service->storage).full;
}

static double service_held(const struct srv_service *service, enum srv_memory_kind kind) {
    return (double)atomic_load(&service->memory.kind[kind]);
}

struct srv_gauges srv_service_gauges(struct srv_service *service) {
    assert(service->workers >= 0);
    srv_memory_look(&service->memory);
    struct srv_cache_size cache = srv_cache_size(service->cache);
    struct srv_store_figures store = {0};
    if (service->storage) store = srv_storage_figures(service->storage);
    return (struct srv_gauges){.queued = srv_queue_count(service->queue),
                               .computing = atomic_load(&service->computing),
                               .workers = service->workers,
                               .busy = atomic_load(&service->busy),
                               .connections = atomic_load(&service->connections),
                               .event_streams = atomic_load(&service->listening),
                               .held = (double)srv_memory_all(&service->memory),
                               .held_connections = service_held(service, SRV_MEMORY_CONNECTIONS),
                               .held_bodies = service_held(service, SRV_MEMORY_BODIES),
                               .held_computations = service_held(service, SRV_MEMORY_COMPUTATIONS),
                               .held_answers = service_held(service, SRV_MEMORY_ANSWERS),
                               .held_jobs = service_held(service, SRV_MEMORY_JOBS),
                               .allocated = (double)atomic_load(&service->memory.allocated),
                               .cache_bytes = (double)cache.bytes,
                               .cache_entries = (double)cache.entries,
                               .draining = atomic_load(&service->draining) != SRV_DRAIN_NOT,
                               .jobs_accepted = (double)store.jobs[SRV_JOB_ACCEPTED],
                               .jobs_running = (double)store.jobs[SRV_JOB_RUNNING],
                               .jobs_successful = (double)store.jobs[SRV_JOB_SUCCESSFUL],
                               .jobs_failed = (double)store.jobs[SRV_JOB_FAILED],
                               .jobs_dismissed = (double)store.jobs[SRV_JOB_DISMISSED],
                               .parts_waiting = (double)store.parts,
                               .job_oldest = 1e-6 * (double)store.oldest_us,
                               .processes = (double)store.workers,
                               .store_connections = (double)store.connections,
                               .store_bytes = (double)store.bytes,
                               .store_up = service->storage && srv_storage_here(service->storage),
                               .resident = srv_metrics_resident(),
                               .started = service->started};
}
