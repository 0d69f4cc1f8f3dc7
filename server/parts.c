#include "server/parts.h"

#include <sys/random.h>
#include <time.h>

#include "server/clock.h"
#include "server/flights.h"
#include "server/workers.h"

enum pend_status srv_parts_init(struct srv_service *service, struct pend_error *error) {
    struct srv_config *config = &service->config;
    service->started = (double)time(NULL);
    service->workers = config->workers > 0 ? (int)config->workers : srv_workers_default();
    if (getrandom(&service->seed, sizeof service->seed, GRND_NONBLOCK) < 0) service->seed = (uint64_t)srv_clock_now();
    srv_spares_init(&service->spares);
    enum pend_status status = srv_peers_read(&service->trusted, config->trusted_proxy, error);
    if (status == PEND_OK) status = srv_queue_new(&service->queue, (int)config->queue, (int)config->client_queue);
    if (status == PEND_OK) status = srv_clients_new(&service->clients);
    if (status == PEND_OK) status = srv_flights_new(&service->flights);
    if (status == PEND_OK) status = srv_cache_new(&service->cache, (size_t)config->cache_bytes, service->seed);
    return status == PEND_NO_MEMORY ? pend_fail(error, status, -1, 0, "out of memory") : status;
}

void srv_parts_clear(struct srv_service *service) {
    srv_cache_free(&service->cache);
    srv_flights_free(&service->flights);
    srv_queue_free(&service->queue);
    srv_clients_free(&service->clients);
    srv_spares_clear(&service->spares);
}
