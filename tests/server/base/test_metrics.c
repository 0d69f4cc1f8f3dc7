/* Tests of server/base/metrics: the counts, and that the text conforms to Prometheus' format. */
#include "server/base/metrics.h"

#include <ctype.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

static const char *metrics_label(int route) {
    return route == 0 ? "POST /v1/trees" : route == 1 ? "GET /x" : NULL;
}

/* the value of a sample, by the start of its line; NaN if there is none */
static double metrics_value(const char *text, const char *sample) {
    size_t bytes = strlen(sample);
    for (const char *line = text; line && *line; line = strchr(line, '\n'), line += line != NULL)
        if (!strncmp(line, sample, bytes) && line[bytes] == ' ') return strtod(line + bytes, NULL);
    return NAN;
}

/* one line: a comment HELP or TYPE, or name{label="value",...} number */
static int metrics_line_good(const char *line, size_t bytes) {
    const char *end = line + bytes, *at = line;
    if (!strncmp(line, "# HELP ", 7) || !strncmp(line, "# TYPE ", 7)) return 1;
    while (at < end && (isalnum((unsigned char)*at) || *at == '_' || *at == ':')) at++;
    if (at == line) return 0;
    if (*at == '{') {
        for (at++; at < end && *at != '}'; at += *at == ',') {
            while (at < end && (isalnum((unsigned char)*at) || *at == '_')) at++;
            if (at + 1 >= end || at[0] != '=' || at[1] != '"') return 0;
            for (at += 2; at < end && *at != '"'; at++)
                if (*at == '\\') at++;
            at++;
        }
        at++;
    }
    if (at >= end || *at != ' ') return 0;
    char *stop;
    strtod(at + 1, &stop);
    return stop == end;
}

/* checks the form: every line, and one HELP and TYPE before the samples of a name, which are
 * adjacent */
static void metrics_check_form(const char *text) {
    char seen[64][64], name[64] = "";
    int count = 0, comments = 0;
    for (const char *line = text; *line;) {
        size_t bytes = strcspn(line, "\n");
        CHECK_SAYING(line[bytes] == '\n' && metrics_line_good(line, bytes), "bad line %.*s",
                     (int)bytes, line);
        if (!strncmp(line, "# TYPE ", 7)) {
            comments++;
            snprintf(name, sizeof name, "%.*s", (int)strcspn(line + 7, " "), line + 7);
            for (int i = 0; i < count; i++)
                CHECK_SAYING(strcmp(seen[i], name), "%s has two types", name);
            if (count < 64) snprintf(seen[count++], 64, "%s", name);
        } else if (*line != '#') {
            CHECK_SAYING(!strncmp(line, name, strlen(name)), "%.*s stands under %s", (int)bytes,
                         line, name);
        }
        line += bytes + (line[bytes] == '\n');
    }
    CHECK(comments > 15);
}

TEST(metrics_are_counted_and_written_in_prometheus_form) {
    static struct srv_metrics metrics;
    struct srv_gauges gauges = {.queued = 3, .resident = srv_metrics_resident(), .started = 1e9};
    OWN(api_buffer, clear) out;
    memset(&metrics, 0, sizeof metrics);
    api_buffer_init(&out, 1 << 20);
    srv_metrics_request(&metrics, 0, 200);
    srv_metrics_request(&metrics, 0, 200);
    srv_metrics_request(&metrics, 1, 404);
    srv_metrics_request(&metrics, -1, 0);
    srv_metrics_request(&metrics, 1000, 100000);
    srv_metrics_count(&metrics.busy_ns, 1500000000);
    srv_metrics_time(&metrics.queue, 0);
    srv_metrics_time(&metrics.compute, 1);
    srv_metrics_time(&metrics.compute, 10000);
    srv_metrics_time(&metrics.compute, 10001);
    srv_metrics_time(&metrics.compute, 7200 * (int64_t)1000000000);
    CHECK(srv_metrics_write(&metrics, &gauges, metrics_label, &out) == PEND_OK);
    REQUIRE(api_buffer_add(&out, "", 1) == PEND_OK);
    metrics_check_form(out.data);
    CHECK(metrics_value(out.data,
                        "pendulumd_requests_total{route=\"POST /v1/trees\",status=\"200\"}") == 2);
    CHECK(metrics_value(out.data, "pendulumd_requests_total{route=\"GET /x\",status=\"404\"}") ==
          1);
    CHECK(metrics_value(out.data, "pendulumd_requests_total{route=\"none\",status=\"0\"}") == 2);
    CHECK(metrics_value(out.data, "pendulumd_worker_busy_seconds_total") == 1.5);
    CHECK(metrics_value(out.data, "pendulumd_queue_depth") == 3);
    CHECK(metrics_value(out.data, "process_resident_memory_bytes") > 100000);
    static const char stage[] = "pendulumd_request_duration_seconds_bucket{stage=\"compute\",le=";
    char sample[128];
    static const struct {
        const char *le;
        double count;
    } bucket[] = {{"1e-05", 2}, {"2.5e-05", 3}, {"60", 3}, {"+Inf", 4}};
    for (size_t i = 0; i < sizeof bucket / sizeof *bucket; i++) {
        snprintf(sample, sizeof sample, "%s\"%s\"}", stage, bucket[i].le);
        CHECK(metrics_value(out.data, sample) == bucket[i].count);
    }
    CHECK(metrics_value(out.data, "pendulumd_request_duration_seconds_count{stage=\"compute\"}") ==
          4);
    CHECK(
        fabs(metrics_value(out.data, "pendulumd_request_duration_seconds_sum{stage=\"compute\"}") -
             7200.000020002) < 1e-6);
    CHECK(metrics_value(out.data, "pendulumd_request_duration_seconds_count{stage=\"queue\"}") ==
          0);
    api_buffer_clear(&out);
    /* not enough space: reported, not truncated silently */
    api_buffer_init(&out, 1000);
    CHECK(srv_metrics_write(&metrics, &gauges, metrics_label, &out) == PEND_LIMIT);
}

static void *metrics_crowd(void *argument) {
    for (int i = 0; i < 20000; i++) srv_metrics_request(argument, i % 3, 200);
    return NULL;
}

TEST(no_count_is_lost_between_threads) {
    static struct srv_metrics metrics;
    pthread_t thread[4];
    memset(&metrics, 0, sizeof metrics);
    for (int i = 0; i < 4; i++) CHECK(!pthread_create(&thread[i], NULL, metrics_crowd, &metrics));
    for (int i = 0; i < 4; i++) pthread_join(thread[i], NULL);
    CHECK_INT(
        (long)(metrics.requests[0][200] + metrics.requests[1][200] + metrics.requests[2][200]),
        80000);
}
