#include "server/config/config.h"

#include <assert.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* clang-format off */
#define FIELD(name) offsetof(struct srv_config, name)
static const struct srv_option config_table[] = {
    {"listen", "HOST:PORT", "127.0.0.1:8080",
     "where to serve; port 0 takes a free one, [::1]:8080 is IPv6, *:8080 every address, "
     "unix:PATH a socket for this user and its group",
     SRV_OPTION_LISTEN, FIELD(listen), 0, 0},
    {"probe-listen", "HOST:PORT", "none",
     "an address of its own for /healthz, /readyz, /version and /metrics and nothing else, without "
     "keys and limits of connections; none = they are answered at --listen alone",
     SRV_OPTION_TEXT, FIELD(probe_listen), 0, 0},
    {"config", "FILE", "",
     "a file with lines 'name = value', the names as in this list; # begins a comment",
     SRV_OPTION_FILE, FIELD(file), 0, 0},
    {"workers", "N", "0", "threads that compute; 0 = one a processor",
     SRV_OPTION_WHOLE, FIELD(workers), 0, 1024},
    {"role", "ROLE", "all",
     "what this process does: all, api = it answers but computes no jobs, worker = it computes "
     "jobs and nothing else",
     SRV_OPTION_ROLE, FIELD(role), 0, 0},
    {"until-idle-seconds", "S", "0",
     "a process that computes jobs ends when it found nothing to compute for so long, as batch "
     "schedulers want it; 0 = never",
     SRV_OPTION_SECONDS, FIELD(until_idle_seconds), 0, 86400},
    {"store", "URL", "sqlite",
     "where jobs are kept: sqlite:PATH, sqlite = a file in the user's state directory, "
     "postgresql://..., or none",
     SRV_OPTION_STORE, FIELD(store), 0, 0},
    {"store-file", "FILE", "none",
     "a file of mode 0600 that says what --store is, where that holds a password; it goes before "
     "--store",
     SRV_OPTION_TEXT, FIELD(store_file), 0, 0},
    {"cache-bytes", "BYTES", "64M", "memory for answers that can be given again; 0 = none",
     SRV_OPTION_BYTES, FIELD(cache_bytes), 0, 1e15},
    {"compress-above", "BYTES", "4K",
     "answers of text that are larger are compressed for clients that accept it; 0 = none is",
     SRV_OPTION_BYTES, FIELD(compress_above), 0, 1e15},
    {"hosts", "LIST", "auto",
     "names it answers to, others get 421: * = any, hosts like example.org, *.example.org or "
     "[::1]:8080, or auto = this machine's names where it listens on loopback and trusts no "
     "proxy, else any",
     SRV_OPTION_HOSTS, FIELD(hosts), 0, 0},
    {"cors-origins", "LIST", "*",
     "web pages of other origins that may read answers: * = all may compute, none, or origins "
     "like https://example.org, which may have jobs and scenes too",
     SRV_OPTION_TEXT, FIELD(cors_origins), 0, 0},
    {"frame-ancestors", "LIST", "*",
     "pages that may have the page's embed view (/?embed=1) in a frame: * = any, none, or origins "
     "like https://example.org; the rest of the page is never in one",
     SRV_OPTION_FRAMES, FIELD(frame_ancestors), 0, 0},
    {"deprecated", "INSTANT", "none",
     "since when (2027-01-31T00:00:00Z) this server's interface is not for new programs: every "
     "answer below /v1 tells it in the field Deprecation",
     SRV_OPTION_INSTANT, FIELD(deprecated), 0, 0},
    {"sunset", "INSTANT", "none",
     "when this server's interface will be gone: every answer below /v1 tells it in the field "
     "Sunset",
     SRV_OPTION_INSTANT, FIELD(sunset), 0, 0},
    {"trusted-proxy", "LIST", "none",
     "networks like 10.0.0.0/8 of proxies that may say who the client is, and unix for those that "
     "come by a socket's path",
     SRV_OPTION_TEXT, FIELD(trusted_proxy), 0, 0},
    {"client-header", "NAME", "X-Forwarded-For",
     "the header field in which a trusted proxy says it: this, Forwarded, or one whose value is "
     "the client's key",
     SRV_OPTION_TEXT, FIELD(client_header), 0, 0},
    {"role-header", "NAME", "none",
     "the header field in which a trusted proxy that names accounts says their roles, as words "
     "with commas between; an account without one is a pupil; it is looked at with --keys alone",
     SRV_OPTION_TEXT, FIELD(role_header), 0, 0},
    {"keys", "FILE", "none",
     "keys that `pendulumd keys` has made, and what roles may: who has none is anonymous; the "
     "file has mode 0600, and is read again when it changes; none = no client has a role",
     SRV_OPTION_TEXT, FIELD(keys), 0, 0},
    {"walls", "on/off/auto", "auto",
     "once it listens it drops all capabilities, opens no file but those that options name and "
     "those of libraries (Landlock), and makes no system call but those it needs (seccomp); auto = "
     "as far as the kernel has this, on = or it does not start",
     SRV_OPTION_SWITCH, FIELD(walls), 0, 0},
    {"allow-root", "on/off", "off", "on = it runs as root too; off = it refuses to start",
     SRV_OPTION_SWITCH, FIELD(allow_root), 0, 0},
    {"max-connections", "N", "4096",
     "open connections; for one more a silent one ends, or it is answered 503",
     SRV_OPTION_WHOLE, FIELD(connections), 1, 100000},
    {"max-client-connections", "N", "0",
     "open connections of one client that is no trusted proxy; one more is answered 429; 0 = a "
     "quarter of max-connections",
     SRV_OPTION_WHOLE, FIELD(client_connections), 0, 100000},
    {"max-queue", "N", "256", "requests that wait for a worker; one more is answered 503",
     SRV_OPTION_WHOLE, FIELD(queue), 1, 1000000},
    {"max-client-queue", "N", "128",
     "requests of one client that wait for a worker; one more is answered 429",
     SRV_OPTION_WHOLE, FIELD(client_queue), 1, 1000000},
    {"max-wait-seconds", "S", "30",
     "time that a request may wait for a worker; then it is answered 503",
     SRV_OPTION_SECONDS, FIELD(wait_seconds), 0.1, 86400},
    {"max-requests-a-minute", "N", "0",
     "requests of one client that compute, list, store or delete; one more is answered 429; 0 = "
     "any number",
     SRV_OPTION_WHOLE, FIELD(requests_a_minute), 0, 1000000},
    {"max-address-clients", "N", "64",
     "clients with tokens of their own that all of one address or account together are worth: "
     "so many times a client's requests a minute, jobs, bytes and scenes, and 16 times so many "
     "of them may keep jobs",
     SRV_OPTION_WHOLE, FIELD(address_clients), 1, 1000000},
    {"max-held-bytes", "BYTES", "1G",
     "memory of all connections, bodies, computations, answers, jobs and the cache; what finds "
     "none is answered 503",
     SRV_OPTION_BYTES, FIELD(held_bytes), 1048576, 1e15},
    {"max-client-held-bytes", "BYTES", "0",
     "of that what one client may hold; more is answered 429; 0 = a quarter, or 32 MiB beyond "
     "max-answer-bytes, half at most",
     SRV_OPTION_BYTES, FIELD(client_held_bytes), 0, 1e15},
    {"header-seconds", "S", "10",
     "time for a request's line and headers, from the first byte to the last",
     SRV_OPTION_SECONDS, FIELD(header_seconds), 0.1, 3600},
    {"body-seconds", "S", "30",
     "time for a request's body, and one second more for every least-rate bytes that came",
     SRV_OPTION_SECONDS, FIELD(body_seconds), 0.1, 3600},
    {"send-seconds", "S", "30",
     "time for the client to take an answer, and one second more for every least-rate bytes of "
     "it",
     SRV_OPTION_SECONDS, FIELD(send_seconds), 0.1, 3600},
    {"idle-seconds", "S", "60", "time that an open connection may be silent, in whole seconds",
     SRV_OPTION_WHOLE, FIELD(idle_seconds), 1, 86400},
    {"least-rate", "BYTES", "16K", "bytes a second that a client must manage on average",
     SRV_OPTION_BYTES, FIELD(least_rate), 1, 1e12},
    {"drain-seconds", "S", "65",
     "time for requests to finish after SIGTERM; more than max-compute-seconds, or a drain may "
     "cut a computation short",
     SRV_OPTION_SECONDS, FIELD(drain_seconds), 0, 86400},
    {"drain-idle-seconds", "S", "5",
     "time that silent connections of proxies are kept after SIGTERM, for a request that is "
     "just being sent on one",
     SRV_OPTION_SECONDS, FIELD(drain_idle_seconds), 0, 3600},
    {"access-log", "on/off/auto", "auto",
     "one JSON line a request; auto = where they do not go to a terminal",
     SRV_OPTION_SWITCH, FIELD(access_log), 0, 0},
    {"log", "FILE", "-",
     "where the lines of requests go; - = standard output; a file is opened anew at SIGHUP and "
     "SIGUSR1",
     SRV_OPTION_TEXT, FIELD(log), 0, 0},
    {"audit-log", "FILE", "none",
     "where it is written who has made, ended or erased what, asked what is an operator's, or was "
     "refused with 401 or 403: one JSON line each, without bodies; - = standard output; a file is "
     "opened anew at SIGHUP and SIGUSR1",
     SRV_OPTION_TEXT, FIELD(audit_log), 0, 0},
    {"log-client", "HOW", "full",
     "what both logs say of addresses: full, network = of IPv4 24 bits and of IPv6 48, or none; "
     "keys' names and digests of accounts and tokens stay",
     SRV_OPTION_CLIENT, FIELD(log_client), 0, 0},
    {"job-part-seconds", "S", "1",
     "computation after which a part of a job is kept: what a crash repeats at most",
     SRV_OPTION_SECONDS, FIELD(job_part_seconds), 0.001, 3600},
    {"job-lease-seconds", "S", "15",
     "time after which a worker that is not heard of loses its part of a job to another",
     SRV_OPTION_SECONDS, FIELD(job_lease_seconds), 0.5, 3600},
    {"max-event-streams", "N", "1024",
     "open streams of events of jobs and of classes, a quarter of them of one client; one more is "
     "answered 503 or 429",
     SRV_OPTION_WHOLE, FIELD(event_streams), 1, 100000},
    {"max-client-jobs", "N", "10000",
     "jobs of one client that have not ended; one more is answered 429",
     SRV_OPTION_WHOLE, FIELD(client_jobs), 1, 1e9},
    {"max-client-bytes", "BYTES", "4G",
     "what is kept for jobs of one client: rows, requests, results; beyond it jobs fail and new "
     "ones are answered 429",
     SRV_OPTION_BYTES, FIELD(client_bytes), 65536, 1e15},
    {"max-store-bytes", "BYTES", "16G",
     "what is kept for jobs of all clients; beyond it jobs fail and new ones are answered 429",
     SRV_OPTION_BYTES, FIELD(store_bytes), 65536, 1e15},
    {"keep-seconds", "S", "604800", "time that a job and its results are kept after its end",
     SRV_OPTION_SECONDS, FIELD(keep_seconds), 1, 1e9},
    {"max-client-scenes", "N", "10000",
     "scenes of one client, which are kept for ever; one more is answered 429",
     SRV_OPTION_WHOLE, FIELD(client_scenes), 1, 1e9},
    {"max-client-scene-bytes", "BYTES", "64M",
     "scenes of one client together; one more is answered 429",
     SRV_OPTION_BYTES, FIELD(client_scene_bytes), 65536, 1e15},
    {"max-store-scene-bytes", "BYTES", "1G",
     "scenes of all clients together; one more is answered 429",
     SRV_OPTION_BYTES, FIELD(store_scene_bytes), 65536, 1e15},
    {"max-scene-bytes", "BYTES", "256K", "a scene, without blanks; a larger one is answered 413",
     SRV_OPTION_BYTES, FIELD(scene_bytes), 1024, 1e9},
    {"max-classes", "N", "200",
     "rooms in which a class works together; one more is answered 429; 0 = none is made",
     SRV_OPTION_WHOLE, FIELD(classes), 0, 1e6},
    {"max-class-pupils", "N", "400", "pupils in one room; one more is answered 429",
     SRV_OPTION_WHOLE, FIELD(class_pupils), 1, 100000},
    {"max-class-bytes", "BYTES", "8M",
     "what stands in one room: stages, questions, answers, worksheets; more is answered 429",
     SRV_OPTION_BYTES, FIELD(class_bytes), 65536, 1e12},
    {"max-job-members", "N", "100000000", "members of an ensemble that is a job",
     SRV_OPTION_WHOLE, FIELD(job_members), 1, 1e9},
    {"max-job-samples", "N", "20000000",
     "instants of a trajectory, or states of a request, that is a job",
     SRV_OPTION_WHOLE, FIELD(job_samples), 1, 1e9},
    {"max-job-steps", "N", "10000000000",
     "integration steps of a trajectory, or of one part of another job",
     SRV_OPTION_WHOLE, FIELD(job_steps), 100, 1e12},
    {"max-job-seconds", "S", "86400",
     "computation of a job as it is estimated, and of any part of it",
     SRV_OPTION_SECONDS, FIELD(job_seconds), 1, 1e7},
    {"help", NULL, "", "prints this list and ends; --help=markdown prints it as a table",
     SRV_OPTION_FLAG, 0, 0, 0},
    {"version", NULL, "", "prints the version and ends",
     SRV_OPTION_FLAG, 0, 0, 0},
};
/* clang-format on */

enum { CONFIG_OWN = sizeof config_table / sizeof *config_table };

/* the row of a limit, made from its line in api/base/limits.h; offset is its number there */
static struct srv_option config_limit(const struct api_limit_row *limit, int i) {
    int bytes = !strcmp(limit->unit, "bytes"), seconds = !strcmp(limit->unit, "s");
    struct srv_option row = {.name = limit->name,
                             .sample = bytes     ? "BYTES"
                                       : seconds ? "S"
                                                 : "N",
                             .meaning = limit->meaning,
                             .kind = bytes     ? SRV_OPTION_BYTES
                                     : seconds ? SRV_OPTION_SECONDS
                                               : SRV_OPTION_WHOLE,
                             .offset = (size_t)i,
                             .least = limit->least,
                             .most = limit->most};
    snprintf(row.start, sizeof row.start, "%.15g", limit->start);
    return row;
}

int srv_config_row(int i, struct srv_option *row) {
    assert(i >= 0);
    if (i < CONFIG_OWN) {
        *row = config_table[i];
        return 1;
    }
    const struct api_limit_row *limit = api_limits_row(i - CONFIG_OWN);
    if (limit) *row = config_limit(limit, i - CONFIG_OWN);
    return limit != NULL;
}

int srv_config_find(const char *name, size_t bytes, int *i, struct srv_option *row) {
    for (*i = 0; srv_config_row(*i, row); ++*i)
        if (strlen(row->name) == bytes && !memcmp(row->name, name, bytes)) return 1;
    return 0;
}

void *srv_config_value(struct srv_config *config, int i, size_t *bytes) {
    struct srv_option row;
    *bytes = 0;
    if (!srv_config_row(i, &row) || row.kind == SRV_OPTION_FLAG) return NULL;
    int number = row.kind == SRV_OPTION_WHOLE || row.kind == SRV_OPTION_BYTES ||
                 row.kind == SRV_OPTION_SECONDS || row.kind == SRV_OPTION_SWITCH;
    *bytes = number ? sizeof(double) : SRV_CONFIG_TEXT;
    assert(i >= CONFIG_OWN || row.offset + *bytes <= sizeof *config);
    return i < CONFIG_OWN ? (char *)config + row.offset
                          : (char *)api_limits_value(&config->limits, (int)row.offset);
}

void srv_config_take(struct srv_config *config, const struct srv_config *from, int i) {
    assert(config != from);
    size_t bytes;
    void *to = srv_config_value(config, i, &bytes);
    if (bytes) memcpy(to, srv_config_value((struct srv_config *)from, i, &bytes), bytes);
}

int srv_config_same(const struct srv_config *one, const struct srv_config *other, int i) {
    size_t bytes;
    const void *first = srv_config_value((struct srv_config *)one, i, &bytes);
    const void *second = srv_config_value((struct srv_config *)other, i, &bytes);
    if (bytes == sizeof(double)) return !memcmp(first, second, bytes);
    return !bytes || !strcmp(first, second);
}

int srv_config_answers(const struct srv_config *config) {
    return strcmp(config->role, "worker") != 0;
}

int srv_config_works(const struct srv_config *config) { return strcmp(config->role, "api") != 0; }

static double config_wider(double of_requests, double of_jobs) {
    return of_requests > of_jobs ? of_requests : of_jobs;
}

struct api_limits srv_config_job_limits(const struct srv_config *config) {
    struct api_limits limits = config->limits;
    limits.of_jobs = 1;
    limits.members = config_wider(limits.members, config->job_members);
    limits.samples = config_wider(limits.samples, config->job_samples);
    limits.steps = config_wider(limits.steps, config->job_steps);
    limits.compute_seconds = config_wider(limits.compute_seconds, config->job_seconds);
    return limits;
}
