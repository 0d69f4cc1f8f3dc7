#include "tests/server/live.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/config/config_load.h"
#include "server/service_setup.h"
#include "tests/harness/test.h"

struct srv_config live_config(const char *const options[]) {
    static const char *const fixed[] = {"pendulumd",
                                        "--listen",
                                        "127.0.0.1:0",
                                        "--access-log",
                                        "off",
                                        "--store",
                                        "none",
                                        "--sandbox",
                                        "off",
                                        "--max-wait-seconds",
                                        "3600",
                                        "--header-seconds",
                                        "3600",
                                        "--body-seconds",
                                        "3600",
                                        "--send-seconds",
                                        "3600",
                                        "--idle-seconds",
                                        "3600",
                                        "--max-compute-seconds",
                                        "86400",
                                        "--max-steps",
                                        "1000000000000",
                                        "--drain-idle-seconds",
                                        "0",
                                        "--hosts",
                                        "*"};
    enum { FIXED = sizeof fixed / sizeof *fixed };
    char *argv[FIXED + 32];
    struct srv_config config;
    struct pend_error error = {.text = ""};
    int argc = 0;
    for (; argc < FIXED; argc++) argv[argc] = (char *)fixed[argc];
    for (int i = 0; options && options[i]; i++) argv[argc++] = (char *)options[i];
    enum pend_status status = srv_config_load(&config, argc, argv, NULL, &error);
    CHECK_SAYING(status == PEND_OK, "%s", error.text);
    return config;
}

struct srv_daemon *live_start(const char *const options[]) {
    struct srv_config config = live_config(options);
    struct pend_error error = {.text = ""};
    struct srv_daemon *daemon;
    enum pend_status status = srv_daemon_new(&daemon, &config, &error);
    CHECK_SAYING(status == PEND_OK, "%s", error.text);
    return daemon;
}

int live_port(const struct srv_daemon *daemon) {
    return atoi(strrchr(srv_daemon_url(daemon), ':') + 1);
}

int live_say(const struct srv_daemon *daemon, struct test_client *client, const char *text) {
    return test_client_open(client, live_port(daemon)) && CHECK(test_client_say(client, text));
}

int live_post(const struct srv_daemon *daemon, struct test_client *client, const char *path,
              const char *body) {
    char text[4096];
    snprintf(text, sizeof text,
             "POST %s HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nContent-Length: "
             "%zu\r\n\r\n%s",
             path, strlen(body), body);
    return live_say(daemon, client, text);
}

int live_status(const struct srv_daemon *daemon, const char *text) {
    OWN(test_client, close) client;
    OWN(test_reply, clear) reply = {0};
    if (!live_say(daemon, &client, text)) return 0;
    return test_client_receive(&client, &reply, 0, TEST_PATIENCE);
}

double live_metric(const struct srv_daemon *daemon, const char *sample) {
    OWN(test_client, close) client;
    OWN(test_reply, clear) reply = {0};
    double value = NAN;
    if (!live_say(daemon, &client, "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n")) return value;
    if (CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200)) {
        char line[128];
        snprintf(line, sizeof line, "\n%s", sample);
        const char *at = strstr(reply.body, line);
        if (CHECK_SAYING(at != NULL, "no sample %s", sample))
            value = strtod(at + strlen(line), NULL);
    }
    return value;
}

int live_await(const struct srv_daemon *daemon, const char *sample, double value) {
    double until = test_clock() + TEST_PATIENCE, now;
    while ((now = live_metric(daemon, sample)) != value && test_clock() < until) test_sleep(0.005);
    return CHECK_SAYING(now == value, "%s is %g, not %g", sample, now, value);
}

int live_await_least(const struct srv_daemon *daemon, const char *sample, double least) {
    double until = test_clock() + TEST_PATIENCE, now;
    while (!((now = live_metric(daemon, sample)) >= least) && test_clock() < until)
        test_sleep(0.005);
    return CHECK_SAYING(now >= least, "%s is %g, below %g", sample, now, least);
}

void live_service(struct srv_service *service, int cap) {
    struct pend_error error = {.text = ""};
    *service = (struct srv_service){.config = live_config(NULL)};
    service->config.queue = cap;
    enum pend_status status = srv_service_setup_init(service, &error);
    CHECK_SAYING(status == PEND_OK, "%s", error.text);
    CHECK(srv_log_new(&service->log, -1, 2) == PEND_OK);
}

void live_service_clear(struct srv_service *service) {
    srv_log_free(&service->log);
    srv_service_setup_clear(service);
}
