#include "server/service.h"

int srv_service_room(const struct srv_service *service) {
    double cached = (double)srv_cache_size(service->cache).bodies;
    return (double)atomic_load(&service->held) - cached <= service->config.held_bytes;
}

const char *srv_service_unready(const struct srv_service *service) {
    return atomic_load(&service->draining) ? "the server is draining" : NULL;
}

struct srv_gauges srv_service_gauges(const struct srv_service *service) {
    struct srv_cache_size cache = srv_cache_size(service->cache);
    return (struct srv_gauges){.queued = srv_queue_count(service->queue),
                               .computing = atomic_load(&service->computing),
                               .workers = service->workers,
                               .busy = atomic_load(&service->busy),
                               .connections = atomic_load(&service->connections),
                               .held = (double)atomic_load(&service->held),
                               .cache_bytes = (double)cache.bytes,
                               .cache_entries = (double)cache.entries,
                               .draining = atomic_load(&service->draining),
                               .resident = srv_metrics_resident(),
                               .started = service->started};
}
