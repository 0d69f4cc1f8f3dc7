#include "server/config/config.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

/* clang-format off */
#define FIELD(name) offsetof(struct srv_config, name)
static const struct srv_option config_table[] = {
    {"listen", "HOST:PORT", "127.0.0.1:8080",
     "address to listen on: port 0 = any free port, [::1]:8080 = IPv6, *:8080 = all addresses, "
     "unix:PATH = a socket for this user and its group",
     SRV_OPTION_LISTEN, FIELD(listen), 0, 0},
    {"probe-listen", "HOST:PORT", "none",
     "a separate address for only /healthz, /readyz, /version and /metrics, without keys and "
     "connection limits; none = answered at --listen",
     SRV_OPTION_TEXT, FIELD(probe_listen), 0, 0},
    {"config", "FILE", "",
     "a file with lines 'name = value', with the names of this list; # begins a comment",
     SRV_OPTION_FILE, FIELD(file), 0, 0},
    {"workers", "N", "0", "threads that compute; 0 = one for each processor",
     SRV_OPTION_WHOLE, FIELD(workers), 0, 1024},
    {"role", "ROLE", "all",
     "all; api = answers requests but computes no jobs; worker = only computes jobs",
     SRV_OPTION_ROLE, FIELD(role), 0, 0},
    {"until-idle-seconds", "S", "0",
     "a process that computes jobs exits after this time without work, for batch schedulers, and "
     "with status 75 if a signal ends it while there is work; 0 = never",
     SRV_OPTION_SECONDS, FIELD(until_idle_seconds), 0, 86400},
    {"store", "URL", "sqlite",
     "database of the jobs: sqlite:PATH, sqlite = a file in the user's state directory, "
     "postgresql://..., or none",
     SRV_OPTION_STORE, FIELD(store), 0, 0},
    {"store-file", "FILE", "none",
     "a file of mode 0600 with the value of --store, for urls with a password; overrides --store",
     SRV_OPTION_TEXT, FIELD(store_file), 0, 0},
    {"results", "URL", "none",
     "where workers store the results of jobs with many parts, as a Parquet file for each part: "
     "file:///PATH = a folder that all processes share; none = in the database",
     SRV_OPTION_TEXT, FIELD(results), 0, 0},
    {"cache-bytes", "BYTES", "64M", "memory for cached answers; 0 = no cache",
     SRV_OPTION_BYTES, FIELD(cache_bytes), 0, 1e15},
    {"compress-above", "BYTES", "4K",
     "larger text answers are compressed for clients that accept it; 0 = never",
     SRV_OPTION_BYTES, FIELD(compress_above), 0, 1e15},
    {"hosts", "LIST", "auto",
     "allowed host names; requests to others are refused with 421: * = any, names like "
     "example.org, *.example.org or [::1]:8080, or auto = this machine's own names if it listens "
     "on loopback without a trusted proxy, else any",
     SRV_OPTION_HOSTS, FIELD(hosts), 0, 0},
    {"cors-origins", "LIST", "*",
     "web pages of other origins that may read answers: * = all may compute, none, or origins like "
     "https://example.org, which may also use jobs and scenes",
     SRV_OPTION_TEXT, FIELD(cors_origins), 0, 0},
    {"frame-ancestors", "LIST", "*",
     "pages that may show the embed view (/?embed=1) in a frame: * = any, none, or origins like "
     "https://example.org; no other view can be framed",
     SRV_OPTION_FRAMES, FIELD(frame_ancestors), 0, 0},
    {"deprecated", "INSTANT", "none",
     "date (2027-01-31T00:00:00Z) from which this interface is deprecated; sent in the field "
     "Deprecation of every answer below /v1",
     SRV_OPTION_INSTANT, FIELD(deprecated), 0, 0},
    {"sunset", "INSTANT", "none",
     "date on which this interface ends; sent in the field Sunset of every answer below /v1",
     SRV_OPTION_INSTANT, FIELD(sunset), 0, 0},
    {"trusted-proxy", "LIST", "none",
     "networks like 10.0.0.0/8 of proxies that report the client, and unix for proxies that "
     "connect to a Unix socket",
     SRV_OPTION_TEXT, FIELD(trusted_proxy), 0, 0},
    {"client-header", "NAME", "X-Forwarded-For",
     "the header field in which a trusted proxy reports the client: X-Forwarded-For, Forwarded, or "
     "a field with an account name",
     SRV_OPTION_TEXT, FIELD(client_header), 0, 0},
    {"role-header", "NAME", "none",
     "the header field in which a trusted proxy reports the roles of an account, separated by "
     "commas; an account without a role is a pupil; used only with --keys",
     SRV_OPTION_TEXT, FIELD(role_header), 0, 0},
    {"keys", "FILE", "none",
     "a file of API keys and roles, made by `pendulumd keys`; clients without a key are anonymous; "
     "mode 0600, reloaded when it changes; none = roles are not used",
     SRV_OPTION_TEXT, FIELD(keys), 0, 0},
    {"sandbox", "on/off/auto", "auto",
     "a server that listens drops its capabilities, opens only files that options name or "
     "libraries need (Landlock), and makes only the system calls that it needs (seccomp); auto = "
     "as far as the kernel supports it; on = refuses to start otherwise",
     SRV_OPTION_SWITCH, FIELD(sandbox), 0, 0},
    {"allow-root", "on/off", "off", "on = may run as root; off = refuses to start as root",
     SRV_OPTION_SWITCH, FIELD(allow_root), 0, 0},
    {"max-connections", "N", "4096",
     "open connections; beyond that an idle connection is closed, or the new one is refused with "
     "503",
     SRV_OPTION_WHOLE, FIELD(connections), 1, 100000},
    {"max-client-connections", "N", "0",
     "open connections of one client, except trusted proxies; more are refused with 429; 0 = a "
     "quarter of max-connections",
     SRV_OPTION_WHOLE, FIELD(client_connections), 0, 100000},
    {"max-queue", "N", "256", "requests that wait for a worker; more are refused with 503",
     SRV_OPTION_WHOLE, FIELD(queue), 1, 1000000},
    {"max-client-queue", "N", "128",
     "requests of one client that wait for a worker; more are refused with 429",
     SRV_OPTION_WHOLE, FIELD(client_queue), 1, 1000000},
    {"max-wait-seconds", "S", "30",
     "longest wait of a request for a worker; then it is refused with 503",
     SRV_OPTION_SECONDS, FIELD(wait_seconds), 0.1, 86400},
    {"max-requests-a-minute", "N", "0",
     "requests per minute of one client that compute, list, store or delete; more are refused "
     "with 429; 0 = no limit",
     SRV_OPTION_WHOLE, FIELD(requests_a_minute), 0, 1000000},
    {"max-address-clients", "N", "64",
     "all clients with their own tokens behind one address or account share this multiple of a "
     "client's limits of requests, jobs, bytes and scenes; at most 16 times this number of clients "
     "may have jobs",
     SRV_OPTION_WHOLE, FIELD(address_clients), 1, 1000000},
    {"max-held-bytes", "BYTES", "1G",
     "memory of connections, bodies, computations, answers, jobs and the cache; requests beyond "
     "it are refused with 503",
     SRV_OPTION_BYTES, FIELD(held_bytes), 1048576, 1e15},
    {"max-client-held-bytes", "BYTES", "0",
     "share of max-held-bytes for one client; requests beyond it are refused with 429; 0 = a "
     "quarter or, if larger, max-answer-bytes + 32 MiB, but at most half",
     SRV_OPTION_BYTES, FIELD(client_held_bytes), 0, 1e15},
    {"header-seconds", "S", "10", "time to receive the request line and headers",
     SRV_OPTION_SECONDS, FIELD(header_seconds), 0.1, 3600},
    {"body-seconds", "S", "30",
     "time to receive a request's body, plus one second for every least-rate bytes received",
     SRV_OPTION_SECONDS, FIELD(body_seconds), 0.1, 3600},
    {"send-seconds", "S", "30",
     "time for the client to receive an answer, plus one second for every least-rate bytes of it",
     SRV_OPTION_SECONDS, FIELD(send_seconds), 0.1, 3600},
    {"idle-seconds", "S", "60", "time after which an idle connection is closed, in whole seconds",
     SRV_OPTION_WHOLE, FIELD(idle_seconds), 1, 86400},
    {"least-rate", "BYTES", "16K", "average rate, in bytes per second, that a client must sustain",
     SRV_OPTION_BYTES, FIELD(least_rate), 1, 1e12},
    {"drain-seconds", "S", "65",
     "time for running requests after SIGTERM; if it is shorter than max-compute-seconds, "
     "computations may be cut short",
     SRV_OPTION_SECONDS, FIELD(drain_seconds), 0, 86400},
    {"drain-idle-seconds", "S", "5",
     "time that idle connections of proxies stay open after SIGTERM, for requests on their way",
     SRV_OPTION_SECONDS, FIELD(drain_idle_seconds), 0, 3600},
    {"access-log", "on/off/auto", "auto",
     "one JSON line per request; auto = unless they would go to a terminal",
     SRV_OPTION_SWITCH, FIELD(access_log), 0, 0},
    {"log", "FILE", "-",
     "file of the access log; - = standard output; reopened at SIGHUP and SIGUSR1",
     SRV_OPTION_TEXT, FIELD(log), 0, 0},
    {"audit-log", "FILE", "none",
     "file of the audit log: one JSON line, without bodies, for everything that is created, ended "
     "or deleted, for operator requests, and for refusals with 401 or 403; - = standard output; "
     "reopened at SIGHUP and SIGUSR1",
     SRV_OPTION_TEXT, FIELD(audit_log), 0, 0},
    {"log-client", "HOW", "full",
     "addresses in both logs: full, network = 24 bits of IPv4 and 48 of IPv6, or none; names of "
     "keys and digests of accounts and tokens remain",
     SRV_OPTION_CLIENT, FIELD(log_client), 0, 0},
    {"job-part-seconds", "S", "1",
     "computation time of a part of a job; a crash repeats at most one part",
     SRV_OPTION_SECONDS, FIELD(job_part_seconds), 0.001, 3600},
    {"job-lease-seconds", "S", "15",
     "time after which a silent worker loses its part of a job to another one",
     SRV_OPTION_SECONDS, FIELD(job_lease_seconds), 0.5, 3600},
    {"max-event-streams", "N", "1024",
     "open event streams of jobs and classrooms, at most a quarter of them for one client; more "
     "are refused with 503 or 429",
     SRV_OPTION_WHOLE, FIELD(event_streams), 1, 100000},
    {"max-client-jobs", "N", "10000", "open jobs of one client; more are refused with 429",
     SRV_OPTION_WHOLE, FIELD(client_jobs), 1, 1e9},
    {"max-client-bytes", "BYTES", "4G",
     "stored bytes for jobs of one client: rows, requests, results; beyond that, jobs fail and new "
     "ones are refused with 429",
     SRV_OPTION_BYTES, FIELD(client_bytes), 65536, 1e15},
    {"max-store-bytes", "BYTES", "16G",
     "stored bytes for jobs of all clients; beyond that, jobs fail and new ones are refused with "
     "429",
     SRV_OPTION_BYTES, FIELD(store_bytes), 65536, 1e15},
    {"keep-seconds", "S", "604800", "time that a job and its results are stored after its end",
     SRV_OPTION_SECONDS, FIELD(keep_seconds), 1, 1e9},
    {"max-client-scenes", "N", "10000",
     "scenes of one client, which never expire; more are refused with 429",
     SRV_OPTION_WHOLE, FIELD(client_scenes), 1, 1e9},
    {"max-client-scene-bytes", "BYTES", "64M",
     "bytes of all scenes of one client; more are refused with 429",
     SRV_OPTION_BYTES, FIELD(client_scene_bytes), 65536, 1e15},
    {"max-store-scene-bytes", "BYTES", "1G",
     "bytes of all scenes of all clients; more are refused with 429",
     SRV_OPTION_BYTES, FIELD(store_scene_bytes), 65536, 1e15},
    {"max-scene-bytes", "BYTES", "256K",
     "bytes of a scene without blanks; a larger one is refused with 413",
     SRV_OPTION_BYTES, FIELD(scene_bytes), 1024, 1e9},
    {"max-classes", "N", "200",
     "classrooms; more are refused with 429; 0 = classrooms are off",
     SRV_OPTION_WHOLE, FIELD(classes), 0, 1e6},
    {"max-class-pupils", "N", "400", "pupils in a classroom; more are refused with 429",
     SRV_OPTION_WHOLE, FIELD(class_pupils), 1, 100000},
    {"max-class-bytes", "BYTES", "8M",
     "bytes of a classroom: stages, questions, answers, worksheets; more are refused with 429",
     SRV_OPTION_BYTES, FIELD(class_bytes), 65536, 1e12},
    {"max-job-members", "N", "100000000", "members of an ensemble that runs as a job",
     SRV_OPTION_WHOLE, FIELD(job_members), 1, 1e9},
    {"max-job-samples", "N", "20000000",
     "instants of a trajectory, or states of a request, that runs as a job",
     SRV_OPTION_WHOLE, FIELD(job_samples), 1, 1e9},
    {"max-job-steps", "N", "10000000000",
     "integration steps of a trajectory that runs as a job, or of one part of any other job",
     SRV_OPTION_WHOLE, FIELD(job_steps), 100, 1e12},
    {"max-job-seconds", "S", "86400", "estimated computation time of a job, and of any part of it",
     SRV_OPTION_SECONDS, FIELD(job_seconds), 1, 1e7},
    {"help", NULL, "", "prints this list and exits; --help=markdown prints it as a table",
     SRV_OPTION_FLAG, 0, 0, 0},
    {"version", NULL, "", "prints the version and exits",
     SRV_OPTION_FLAG, 0, 0, 0},
};
/* clang-format on */

enum { CONFIG_OWN = sizeof config_table / sizeof *config_table };

/* makes the row of a limit from its line in api/base/limits.h; `offset` is the limit's number
 * there */
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
