#include "server/base/metrics.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "api/base/engine.h"

/* upper ends of the buckets, as Prometheus writes them, and in ns */
static const struct {
    const char *label;
    int64_t ns;
} metrics_bucket[SRV_METRIC_BUCKETS - 1] = {
    {"1e-05", 10000},    {"2.5e-05", 25000},  {"5e-05", 50000},    {"0.0001", 100000},
    {"0.00025", 250000}, {"0.0005", 500000},  {"0.001", 1000000},  {"0.0025", 2500000},
    {"0.005", 5000000},  {"0.01", 10000000},  {"0.025", 25000000}, {"0.05", 50000000},
    {"0.1", 100000000},  {"0.25", 250000000}, {"1", 1000000000},   {"5", 5000000000},
    {"20", 20000000000}, {"60", 60000000000},
};

struct metrics_row {
    const char *name, *labels, *help;
    size_t offset;
};

static const struct metrics_row metrics_counter[] = {
#define X(field, name, labels, help) {name, labels, help, offsetof(struct srv_metrics, field)},
    SRV_COUNTERS(X)
#undef X
};

static const struct metrics_row metrics_gauge[] = {
#define X(field, name, labels, help) {name, labels, help, offsetof(struct srv_gauges, field)},
    SRV_GAUGES(X)
#undef X
};

static const struct {
    const char *stage;
    size_t offset;
} metrics_stage[] = {
#define X(field, stage) {stage, offsetof(struct srv_metrics, field)},
    SRV_STAGES(X) SRV_JOB_STAGES(X)
#undef X
};

#define COUNT(table) (sizeof(table) / sizeof *(table))

void srv_metrics_request(struct srv_metrics *metrics, int route, int status) {
    int none = route < 0 || route >= SRV_METRIC_ROUTES - 1,
        odd = status < 0 || status >= SRV_METRIC_STATUS;
    srv_metrics_count(&metrics->requests[none ? SRV_METRIC_ROUTES - 1 : route][odd ? 0 : status],
                      1);
}

void srv_metrics_time(struct srv_histogram *histogram, int64_t ns) {
    int i = 0;
    if (ns <= 0) return;
    while (i < SRV_METRIC_BUCKETS - 1 && ns > metrics_bucket[i].ns) i++;
    srv_metrics_count(&histogram->bucket[i], 1);
    srv_metrics_count(&histogram->sum_ns, (unsigned long long)ns);
}

double srv_metrics_resident(void) {
    unsigned long long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (file && fscanf(file, "%llu %llu", &pages, &resident) != 2) resident = 0;
    if (file) fclose(file);
    return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

static enum pend_status metrics_head(struct api_buffer *out, const char *name, const char *help,
                                     const char *type) {
    return api_buffer_format(out, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

/* Writes a row up to its value, preceded by HELP and TYPE if it is the first row of its name. */
static enum pend_status metrics_row(struct api_buffer *out, const struct metrics_row *row,
                                    int first, const char *type) {
    if (first || strcmp(row->name, row[-1].name))
        PEND_TRY(metrics_head(out, row->name, row->help, type));
    return *row->labels ? api_buffer_format(out, "%s{%s} ", row->name, row->labels)
                        : api_buffer_format(out, "%s ", row->name);
}

static unsigned long long metrics_read(const void *counter) {
    return atomic_load_explicit((const atomic_ullong *)counter, memory_order_relaxed);
}

static enum pend_status metrics_counters(const struct srv_metrics *metrics,
                                         struct api_buffer *out) {
    for (size_t i = 0; i < COUNT(metrics_counter); i++) {
        const void *at = (const char *)metrics + metrics_counter[i].offset;
        PEND_TRY(metrics_row(out, &metrics_counter[i], !i, "counter"));
        /* this counter is in ns, its metric in seconds */
        int seconds = at == &metrics->busy_ns;
        PEND_TRY(seconds ? api_buffer_format(out, "%.9f\n", 1e-9 * (double)metrics_read(at))
                         : api_buffer_format(out, "%llu\n", metrics_read(at)));
    }
    return PEND_OK;
}

static enum pend_status metrics_requests(const struct srv_metrics *metrics,
                                         const char *(*label)(int route), struct api_buffer *out) {
    static const char name[] = "pendulumd_requests_total";
    PEND_TRY(metrics_head(out, name,
                          "Finished requests, by route and status; 0 = ended without an answer",
                          "counter"));
    for (int route = 0; route < SRV_METRIC_ROUTES; route++) {
        const char *text = label(route);
        for (int status = 0; status < SRV_METRIC_STATUS; status++) {
            unsigned long long count = metrics_read(&metrics->requests[route][status]);
            if (!count) continue;
            PEND_TRY(api_buffer_format(out, "%s{route=\"%s\",status=\"%d\"} %llu\n", name,
                                       text ? text : "none", status, count));
        }
    }
    return PEND_OK;
}

static enum pend_status metrics_histogram(const struct srv_histogram *histogram, const char *name,
                                          const char *stage, struct api_buffer *out) {
    unsigned long long count = 0;
    for (int i = 0; i < SRV_METRIC_BUCKETS; i++) {
        count += metrics_read(&histogram->bucket[i]);
        PEND_TRY(api_buffer_format(out, "%s_bucket{stage=\"%s\",le=\"%s\"} %llu\n", name, stage,
                                   i < SRV_METRIC_BUCKETS - 1 ? metrics_bucket[i].label : "+Inf",
                                   count));
    }
    assert(count >= metrics_read(&histogram->bucket[SRV_METRIC_BUCKETS - 1]));
    return api_buffer_format(out, "%s_sum{stage=\"%s\"} %.9f\n%s_count{stage=\"%s\"} %llu\n", name,
                             stage, 1e-9 * (double)metrics_read(&histogram->sum_ns), name, stage,
                             count);
}

static enum pend_status metrics_stages(const struct srv_metrics *metrics, struct api_buffer *out) {
    static const char *const name[] = {"pendulumd_request_duration_seconds",
                                       "pendulumd_job_duration_seconds"};
    static const char *const help[] = {
        "Time that requests spent in a stage: waiting for a worker, being computed, being sent, "
        "and in total",
        "Time that jobs waited for their first worker, and computation time of their parts"};
    for (size_t i = 0; i < COUNT(metrics_stage); i++) {
        size_t offset = metrics_stage[i].offset, first = offsetof(struct srv_metrics, job_wait);
        int job = offset >= first;
        if (!i || offset == first) PEND_TRY(metrics_head(out, name[job], help[job], "histogram"));
        PEND_TRY(metrics_histogram((const void *)((const char *)metrics + offset), name[job],
                                   metrics_stage[i].stage, out));
    }
    return PEND_OK;
}

enum pend_status srv_metrics_write(struct srv_metrics *metrics, const struct srv_gauges *gauges,
                                   const char *(*label)(int route), struct api_buffer *out) {
    assert(metrics && gauges && label);
    PEND_TRY(metrics_requests(metrics, label, out));
    PEND_TRY(metrics_head(out, "pendulumd_build_info",
                          "1; its labels are the version of the program and the engine", "gauge"));
    PEND_TRY(api_buffer_format(out, "pendulumd_build_info{version=\"%s\",engine=\"%s\"} 1\n",
                               api_version, api_engine_name));
    PEND_TRY(metrics_stages(metrics, out));
    PEND_TRY(metrics_counters(metrics, out));
    for (size_t i = 0; i < COUNT(metrics_gauge); i++) {
        PEND_TRY(metrics_row(out, &metrics_gauge[i], !i, "gauge"));
        PEND_TRY(api_buffer_format(
            out, "%.15g\n", *(const double *)((const char *)gauges + metrics_gauge[i].offset)));
    }
    return PEND_OK;
}
