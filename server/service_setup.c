#include "server/service_setup.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "server/base/clock.h"
#include "server/classes/class_events.h"
#include "server/config/hosts.h"
#include "server/config/state_dir.h"
#include "server/jobs/job_events.h"
#include "server/jobs/part_runner.h"
#include "server/store/store_files.h"
#include "server/work/inflight.h"
#include "server/work/workers.h"

/* parts of jobs held per worker: one is computed while another is stored or claimed */
enum { PARTS_SLOTS = 2 };

/* clients of one address that may have open jobs, per client that the address counts as */
enum { PARTS_KEEPERS = 16 };

enum pend_status srv_service_setup_init(struct srv_service *service, struct pend_error *error) {
    struct srv_config *config = &service->config;
    service->job_limits = srv_config_job_limits(config);
    service->started = (double)time(NULL);
    service->workers = config->workers > 0 ? (int)config->workers : srv_workers_default();
    if (getrandom(&service->seed, sizeof service->seed, GRND_NONBLOCK) < 0)
        service->seed = (uint64_t)srv_clock_now();
    srv_memory_settle(service->workers);
    srv_buffer_pool_init(&service->pool);
    srv_lengths_init(&service->lengths);
    enum pend_status status = srv_peers_read(&service->trusted, config->trusted_proxy, error);
    service->hosts =
        srv_hosts_mean(config->hosts, config->listen, srv_peers_any(&service->trusted));
    if (status == PEND_OK && strcmp(config->keys, "none"))
        status = srv_key_ring_new(&service->keys, config->keys, error);
    if (status == PEND_OK)
        status = srv_queue_new(&service->queue, (int)config->queue, (int)config->client_queue);
    srv_fairness_init(&service->fairness, service->queue, service->workers);
    if (status == PEND_OK) status = srv_clients_new(&service->clients);
    if (status == PEND_OK) status = srv_inflight_new(&service->inflight);
    if (status == PEND_OK)
        status = srv_cache_new(&service->cache, (size_t)config->cache_bytes, service->seed);
    return status == PEND_NO_MEMORY ? pend_fail(error, status, -1, 0, "out of memory") : status;
}

/* called when the store may have changed, perhaps by another process */
static void setup_news(void *context, int rings) {
    struct srv_service *service = context;
    srv_part_runner_news(service->runner, rings);
    if (rings & SRV_RING_ENDS) srv_events_news(service->events);
}

static enum pend_status setup_storage(struct srv_service *service, struct pend_error *error) {
    const struct srv_config *config = &service->config;
    /* all clients of an address together may use three quarters of the store, or the quota of one
     * client if that is larger */
    double shares = config->address_clients, most = 0.75 * config->store_bytes;
    double bytes = shares * config->client_bytes < most ? shares * config->client_bytes : most;
    struct srv_store_rules rules = {
        .role = (srv_config_works(config) ? SRV_SQL_WORKS : 0) |
                (srv_config_answers(config) ? SRV_SQL_ANSWERS : 0),
        .client_jobs = (long)config->client_jobs,
        .client_bytes = (long long)config->client_bytes,
        .all_bytes = (long long)config->store_bytes,
        .keep_us = (int64_t)(1e6 * config->keep_seconds),
        .client_scenes = (long)config->client_scenes,
        .client_scene_bytes = (long long)config->client_scene_bytes,
        .all_scene_bytes = (long long)config->store_scene_bytes,
        .source_clients = (long)(PARTS_KEEPERS * shares),
        .source_jobs = (long)(shares * config->client_jobs),
        .source_scenes = (long)(shares * config->client_scenes),
        .source_bytes = (long long)(bytes > config->client_bytes ? bytes : config->client_bytes),
        .classes = (long)config->classes,
        .class_pupils = (long)config->class_pupils,
        .class_bytes = (long long)config->class_bytes};
    char url[SRV_CONFIG_TEXT];
    struct pend_error why = {.text = ""};
    PEND_TRY(srv_state_url(config->store, url, error));
    if (strcmp(config->results, "none") != 0) {
        struct srv_files *files = calloc(1, sizeof *files);
        if (!(rules.files = service->files = files)) return PEND_NO_MEMORY;
        files->log = service->log;
        snprintf(files->url, sizeof files->url, "%s", config->results);
        PEND_TRY(srv_files_check(files, error));
    }
    enum pend_status status =
        srv_storage_new(&service->storage, url, &rules, service->log, setup_news, service, &why);
    return status == PEND_OK ? status
                             : pend_fail(error, status, -1, 0, "the store: %.220s", why.text);
}

enum pend_status srv_service_setup_jobs(struct srv_service *service, struct pend_error *error) {
    int slots = srv_config_works(&service->config) ? PARTS_SLOTS * service->workers : 0;
    if (service->config.until_idle_seconds > 0 &&
        (!slots || !strcmp(service->config.store, "none")))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--until-idle-seconds needs a process that computes jobs");
    if (!strcmp(service->config.store, "none")) {
        if (srv_config_answers(&service->config) && srv_config_works(&service->config))
            return PEND_OK;
        return pend_fail(error, PEND_INVALID, -1, 0, "--role %.10s needs a --store that it shares",
                         service->config.role);
    }
    int streams = (int)service->config.event_streams;
    enum pend_status status = srv_part_runner_new(&service->runner, service, slots);
    if (status == PEND_OK) status = srv_events_new(&service->events, service, streams);
    if (status == PEND_OK) status = srv_events_add(service->events, srv_job_events_new(streams));
    if (status == PEND_OK) status = srv_events_add(service->events, srv_class_events_new());
    if (status == PEND_OK) PEND_TRY(setup_storage(service, error));
    if (status == PEND_OK) status = srv_events_start(service->events);
    if (status == PEND_OK) status = srv_part_runner_start(service->runner);
    return status == PEND_OK ? status : pend_fail(error, status, -1, 0, "no memory for jobs");
}

void srv_service_setup_jobs_end(struct srv_service *service) {
    if (service->events) srv_events_end(service->events);
    srv_storage_free(&service->storage);
    srv_part_runner_free(&service->runner);
    if (service->files && service->files->walk) closedir(service->files->walk);
    free(service->files);
    srv_events_free(&service->events);
}

void srv_service_setup_clear(struct srv_service *service) {
    srv_cache_free(&service->cache);
    srv_inflight_free(&service->inflight);
    srv_queue_free(&service->queue);
    srv_fairness_clear(&service->fairness);
    srv_clients_free(&service->clients);
    srv_buffer_pool_clear(&service->pool);
    srv_lengths_clear(&service->lengths);
    srv_key_ring_free(&service->keys);
}
