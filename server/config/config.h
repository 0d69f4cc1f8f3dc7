/* Every option of the server in one table: name, default, meaning, and allowed values.
 * Leaves to others: reading values (config_load), acting on them.
 * Invariant: an option is one field of struct srv_config or one row of api/base/limits.h, and
 * one row here; help and documents are generated from the table. */
#pragma once

#include "api/base/buffer.h"
#include "api/base/limits.h"

enum { SRV_CONFIG_TEXT = 256, SRV_CONFIG_AUTO = 2 };

/* The task that the command line requests. */
enum srv_config_task { SRV_CONFIG_SERVE, SRV_CONFIG_HELP, SRV_CONFIG_TABLE, SRV_CONFIG_VERSION };

struct srv_config {
    enum srv_config_task task;
    char warning[SRV_CONFIG_TEXT]; /* an odd setting that is not an error, for the log; "" = none */
    char listen[SRV_CONFIG_TEXT], file[SRV_CONFIG_TEXT];
    char role[SRV_CONFIG_TEXT], store[SRV_CONFIG_TEXT];
    double workers; /* 0 = one per processor */
    double connections, client_connections, queue, client_queue;
    double held_bytes, client_held_bytes; /* client_held_bytes: 0 = a share (work/hold) */
    double wait_seconds, requests_a_minute, address_clients;
    double cache_bytes, compress_above;
    char log[SRV_CONFIG_TEXT], audit_log[SRV_CONFIG_TEXT], log_client[SRV_CONFIG_TEXT];
    char cors_origins[SRV_CONFIG_TEXT], frame_ancestors[SRV_CONFIG_TEXT];
    char trusted_proxy[SRV_CONFIG_TEXT], client_header[SRV_CONFIG_TEXT],
        role_header[SRV_CONFIG_TEXT];
    char store_file[SRV_CONFIG_TEXT], probe_listen[SRV_CONFIG_TEXT]; /* "none" = unset */
    char keys[SRV_CONFIG_TEXT], results[SRV_CONFIG_TEXT];
    char hosts[SRV_CONFIG_TEXT];
    char deprecated[SRV_CONFIG_TEXT], sunset[SRV_CONFIG_TEXT]; /* "none" or an RFC 3339 instant */
    double header_seconds, body_seconds, idle_seconds, send_seconds, drain_seconds,
        drain_idle_seconds;
    double least_rate; /* bytes that prolong a client's deadlines by a second */
    double sandbox;    /* 0, 1 or SRV_CONFIG_AUTO: as far as the kernel supports it */
    double allow_root; /* 1 = may run as root */
    double access_log; /* 0, 1 or SRV_CONFIG_AUTO: 1 unless its lines go to a terminal */
    double job_part_seconds, job_lease_seconds, until_idle_seconds;
    double client_jobs, client_bytes, store_bytes, keep_seconds;
    double client_scenes, scene_bytes, client_scene_bytes, store_scene_bytes;
    double event_streams;
    double classes, class_pupils, class_bytes;
    double job_members, job_samples, job_steps, job_seconds;
    struct api_limits limits;
};

/** Returns true if the process, by its role, answers requests that compute. */
int srv_config_answers(const struct srv_config *config);

/** Returns true if the process, by its role, computes jobs. */
int srv_config_works(const struct srv_config *config);

/** Returns the limits of a job's request, which are at least those of other requests. */
struct api_limits srv_config_job_limits(const struct srv_config *config);

/* The type of a value. */
enum srv_option_kind {
    SRV_OPTION_FLAG,    /* no value: selects a task */
    SRV_OPTION_LISTEN,  /* HOST:PORT or unix:PATH */
    SRV_OPTION_FILE,    /* a file of options, which cannot itself name another */
    SRV_OPTION_TEXT,    /* any text */
    SRV_OPTION_WHOLE,   /* a whole number */
    SRV_OPTION_BYTES,   /* an integer, with an optional suffix K, M or G */
    SRV_OPTION_SECONDS, /* a number */
    SRV_OPTION_SWITCH,  /* on, off, or auto if the row offers it */
    SRV_OPTION_HOSTS,   /* *, auto or a list of hosts */
    SRV_OPTION_INSTANT, /* none, or a text that api_job_instant reads */
    SRV_OPTION_FRAMES,  /* origins that may frame a page: valid in a header */
    SRV_OPTION_ROLE,    /* all, api or worker */
    SRV_OPTION_CLIENT,  /* full, network or none */
    SRV_OPTION_STORE    /* none, sqlite, sqlite:PATH or postgresql://... */
};

/* A row of the table. */
struct srv_option {
    const char *name;    /* "max-queue": --max-queue, PENDULUMD_MAX_QUEUE, max-queue = 256 */
    const char *sample;  /* placeholder of the value in the help; NULL if the option has no value */
    char start[32];      /* the default as one would write it */
    const char *meaning; /* one or two sentences, without a capital or a full stop */
    enum srv_option_kind kind;
    size_t offset;      /* of the value in struct srv_config, or the number of a limit */
    double least, most; /* bounds of a number */
};

/** Copies row i of the table, the server's own options first, then api/base/limits.h; returns false
 * beyond the end. */
int srv_config_row(int i, struct srv_option *row);

/** Finds the row of a name, `bytes` long, and its index in the table. Returns 0 if it is unknown.
 */
int srv_config_find(const char *name, size_t bytes, int *i, struct srv_option *row);

/**
 * Returns a pointer to the value of option i in a config: a double for numbers and switches, else a
 * text.
 *
 * bytes  out: size of the value; 0 if the option has none, then NULL is returned.
 */
void *srv_config_value(struct srv_config *config, int i, size_t *bytes);

/** Writes the help; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_config_help(struct api_buffer *out);

/** Writes the table as Markdown, for README.md; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_config_table(struct api_buffer *out);
