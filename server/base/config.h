/* Every option of the server in one table, and the four places that set them: default, file,
 * environment, command line.
 * Leaves to others: acting on the values.
 * Invariant: what was loaded has passed every check of the table; help and documents are written
 * from the table. */
#ifndef SRV_CONFIG_H
#define SRV_CONFIG_H

#include "api/base/buffer.h"
#include "api/base/limits.h"

enum { SRV_CONFIG_TEXT = 256, SRV_CONFIG_AUTO = 2 };

/* What the command line asks for. */
enum srv_config_task {
    SRV_CONFIG_SERVE,
    SRV_CONFIG_HELP,
    SRV_CONFIG_TABLE,
    SRV_CONFIG_VERSION,
    SRV_CONFIG_REPLAY /* of the file `replay` */
};

struct srv_config {
    enum srv_config_task task;
    char warning[SRV_CONFIG_TEXT]; /* something odd that is no error, for the log; "" = nothing */
    char listen[SRV_CONFIG_TEXT], file[SRV_CONFIG_TEXT];
    char role[SRV_CONFIG_TEXT], store[SRV_CONFIG_TEXT];
    double workers; /* 0 = one a processor */
    double connections, client_connections, queue, client_queue;
    double held_bytes, client_held_bytes; /* of a client 0 = a share, see hold */
    double wait_seconds, requests_a_minute, address_clients;
    double cache_bytes, compress_above;
    char log[SRV_CONFIG_TEXT];
    char cors_origins[SRV_CONFIG_TEXT], trusted_proxy[SRV_CONFIG_TEXT],
        client_header[SRV_CONFIG_TEXT];
    char hosts[SRV_CONFIG_TEXT];
    char record[SRV_CONFIG_TEXT], replay[SRV_CONFIG_TEXT]; /* "none" */
    double header_seconds, body_seconds, idle_seconds, send_seconds, drain_seconds,
        drain_idle_seconds;
    double least_rate; /* bytes/s */
    double access_log; /* 0, 1 or SRV_CONFIG_AUTO: 1 where its lines go to no terminal */
    double job_part_seconds, job_lease_seconds, until_idle_seconds;
    double client_jobs, client_bytes, store_bytes, keep_seconds;
    double client_scenes, scene_bytes, client_scene_bytes, store_scene_bytes;
    double event_streams;
    double job_members, job_samples, job_steps, job_seconds;
    struct api_limits limits;
};

/** What a process does, after its role. */
int srv_config_answers(const struct srv_config *config); /* requests that compute */
int srv_config_works(const struct srv_config *config);   /* jobs */

/** The limits of a job's request: those of any request, or wider. */
struct api_limits srv_config_job_limits(const struct srv_config *config);

/* A row of the table. */
struct srv_option {
    const char
        *name; /* "max-queue": --max-queue, PENDULUMD_MAX_QUEUE, max-queue = ... in the file */
    const char *sample;  /* what a value looks like, for the help; NULL where there is none */
    char start[32];      /* the default as one would write it */
    const char *meaning; /* one or two sentences without a capital and a full stop */
};

/**
 * Loads the options; later places win: the defaults, the file, the environment, the command line.
 *
 * argv         of main; argv[0] is skipped.
 * environment  of main, ended by NULL; a PENDULUMD_ variable that names no option gives a warning,
 *              as supervisors set some by themselves.
 *
 * PEND_INVALID  error->text names the option, where it stands, and what would be right.
 */
PEND_MUST_CHECK enum pend_status srv_config_load(struct srv_config *config, int argc,
                                                 char *const argv[], char *const environment[],
                                                 struct pend_error *error);

/**
 * Row i of the table, the server's own options first, then api/base/limits.h; 0 beyond the end.
 */
int srv_config_row(int i, struct srv_option *row);

/** True where option i of the table has one value in both. */
int srv_config_same(const struct srv_config *one, const struct srv_config *other, int i);

/** Gives option i of the table the value that it has in another config. */
void srv_config_take(struct srv_config *config, const struct srv_config *from, int i);

/** Writes the help; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_config_help(struct api_buffer *out);

/** Writes the table as Markdown, for README.md; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_config_table(struct api_buffer *out);

#endif
