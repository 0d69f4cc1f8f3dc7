/* The peer: a simple service, as one would write it in an afternoon with packaged libraries:
 * libmicrohttpd, cJSON, and GSL's rk8pd at 1e-9 on the paper's matrix equation (aaa). It answers
 * POST with t, phi and phid.
 * Leaves to others: everything else; tests/load compares it with the daemon.
 * Invariant: neither tricks nor carelessness: optimized, its own Cholesky factorization instead of
 * library calls for 4 x 4, no log. */
#include <cjson/cJSON.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ARMS = 64, BODY = 65536 };

/* A pendulum tree as the paper writes it. */
struct problem {
    int n;
    double length[ARMS], weight[ARMS],
        coupling[ARMS][ARMS]; /* l, S^T m, diag(l) S^T diag(m) S diag(l) */
    double start, step;
    int rows;
};

/* the body of a request, as far as received */
struct body {
    size_t bytes;
    char data[BODY];
};

/* solves a x = b, a symmetric and positive definite, by a = L L^T in place; b becomes x */
static int solve(int n, double a[ARMS][ARMS], double b[]) {
    for (int j = 0; j < n; j++) {
        for (int k = 0; k <= j; k++) {
            double sum = a[j][k];
            for (int i = 0; i < k; i++) sum -= a[j][i] * a[k][i];
            if (j == k && !(sum > 0)) return 0;
            a[j][k] = j == k ? sqrt(sum) : sum / a[k][k];
        }
        for (int i = 0; i < j; i++) b[j] -= a[j][i] * b[i];
        b[j] /= a[j][j];
    }
    for (int j = n - 1; j >= 0; j--) {
        for (int i = j + 1; i < n; i++) b[j] -= a[i][j] * b[i];
        b[j] /= a[j][j];
    }
    return 1;
}

/* (aaa): Re M phi'' = Im M phi'^2 - g cos(phi) l (S^T m), with M = diag(e^{-i phi} l) S^T diag(m) S
 * diag(l e^{i phi})
 */
static int equation(double t, const double y[], double dydt[], void *context) {
    const struct problem *problem = context;
    int n = problem->n;
    double c[ARMS], s[ARMS], a[ARMS][ARMS], x[ARMS];
    (void)t;
    for (int k = 0; k < n; k++) c[k] = cos(y[k]), s[k] = sin(y[k]);
    for (int j = 0; j < n; j++) {
        x[j] = -9.81 * c[j] * problem->length[j] * problem->weight[j];
        for (int k = 0; k < n; k++) {
            double factor = problem->coupling[j][k];
            a[j][k] = factor * (c[j] * c[k] + s[j] * s[k]);
            x[j] += factor * (c[j] * s[k] - s[j] * c[k]) * y[n + k] * y[n + k];
        }
    }
    if (!solve(n, a, x)) return GSL_EBADFUNC;
    for (int k = 0; k < n; k++) {
        dydt[k] = y[n + k];
        dydt[n + k] = x[k];
    }
    return GSL_SUCCESS;
}

static double number(const cJSON *object, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

/* reads {"pendulum": {"L", "m", "S"}, "times": {"start", "stop", "step"}}; 0 if it has another form
 */
static int problem_read(struct problem *problem, const cJSON *request) {
    const cJSON *pendulum = cJSON_GetObjectItem(request, "pendulum"),
                *times = cJSON_GetObjectItem(request, "times");
    const cJSON *length = cJSON_GetObjectItem(pendulum, "L"),
                *mass = cJSON_GetObjectItem(pendulum, "m"),
                *paths = cJSON_GetObjectItem(pendulum, "S");
    int n = problem->n = cJSON_GetArraySize(length);
    double m[ARMS], path[ARMS][ARMS];
    if (n < 1 || n > ARMS || cJSON_GetArraySize(mass) != n || cJSON_GetArraySize(paths) != n)
        return 0;
    for (int k = 0; k < n; k++) {
        const cJSON *row = cJSON_GetArrayItem(paths, k);
        problem->length[k] = cJSON_GetArrayItem(length, k)->valuedouble;
        m[k] = cJSON_GetArrayItem(mass, k)->valuedouble;
        if (cJSON_GetArraySize(row) != n) return 0;
        for (int j = 0; j < n; j++) path[k][j] = cJSON_GetArrayItem(row, j)->valuedouble;
    }
    for (int j = 0; j < n; j++) {
        problem->weight[j] = 0;
        for (int i = 0; i < n; i++) problem->weight[j] += path[i][j] * m[i];
        for (int k = 0; k < n; k++) {
            problem->coupling[j][k] = 0;
            for (int i = 0; i < n; i++) problem->coupling[j][k] += path[i][j] * m[i] * path[i][k];
            problem->coupling[j][k] *= problem->length[j] * problem->length[k];
        }
    }
    problem->start = number(times, "start");
    problem->step = number(times, "step");
    problem->rows = (int)lround((number(times, "stop") - problem->start) / problem->step) + 1;
    return problem->rows > 0 && problem->rows <= 1000000;
}

/* integrates from rest at phi = 0 to every instant, and writes what it finds */
static char *problem_solve(struct problem *problem) {
    size_t n = (size_t)problem->n;
    double y[2 * ARMS] = {0}, t = problem->start;
    gsl_odeiv2_system system = {equation, NULL, 2 * n, problem};
    gsl_odeiv2_driver *driver =
        gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 1e-3, 1e-9, 1e-9);
    cJSON *answer = cJSON_CreateObject(), *instants = cJSON_AddArrayToObject(answer, "t"),
          *phi = cJSON_AddArrayToObject(answer, "phi"),
          *rate = cJSON_AddArrayToObject(answer, "phid");
    for (int i = 0; i < problem->rows; i++) {
        double instant = problem->start + i * problem->step;
        if (i && gsl_odeiv2_driver_apply(driver, &t, instant, y)) break;
        cJSON_AddItemToArray(instants, cJSON_CreateNumber(instant));
        cJSON_AddItemToArray(phi, cJSON_CreateDoubleArray(y, problem->n));
        cJSON_AddItemToArray(rate, cJSON_CreateDoubleArray(y + n, problem->n));
    }
    char *text = cJSON_PrintUnformatted(answer);
    cJSON_Delete(answer);
    gsl_odeiv2_driver_free(driver);
    return text;
}

static enum MHD_Result say(struct MHD_Connection *connection, unsigned status, char *text) {
    struct MHD_Response *response =
        MHD_create_response_from_buffer(strlen(text), text, MHD_RESPMEM_MUST_FREE);
    MHD_add_response_header(response, "Content-Type", "application/json");
    enum MHD_Result queued = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return queued;
}

static enum MHD_Result handle(void *context, struct MHD_Connection *connection, const char *url,
                              const char *method, const char *version, const char *data,
                              size_t *bytes, void **state) {
    struct body *body = *state;
    (void)context, (void)url, (void)method, (void)version;
    if (!body) return (*state = calloc(1, sizeof *body)) ? MHD_YES : MHD_NO;
    if (*bytes) {
        if (*bytes > sizeof body->data - body->bytes) return MHD_NO;
        memcpy(body->data + body->bytes, data, *bytes);
        body->bytes += *bytes;
        *bytes = 0;
        return MHD_YES;
    }
    struct problem problem;
    cJSON *request = cJSON_ParseWithLength(body->data, body->bytes);
    int good = problem_read(&problem, request);
    cJSON_Delete(request);
    if (!good) return say(connection, 400, strdup("{\"error\":\"bad request\"}"));
    return say(connection, 200, problem_solve(&problem));
}

static void completed(void *context, struct MHD_Connection *connection, void **state,
                      enum MHD_RequestTerminationCode code) {
    (void)context, (void)connection, (void)code;
    free(*state);
    *state = NULL;
}

/* usage: service     (says its port on standard output) */
int main(void) {
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGTERM);
    sigaddset(&ends, SIGINT);
    sigprocmask(SIG_BLOCK, &ends, NULL);
    gsl_set_error_handler_off();
    struct sockaddr_in loopback = {.sin_family = AF_INET,
                                   .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    struct MHD_Daemon *daemon =
        MHD_start_daemon(MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_TURBO, 0, NULL, NULL, handle, NULL,
                         MHD_OPTION_SOCK_ADDR, &loopback, MHD_OPTION_NOTIFY_COMPLETED, completed,
                         NULL, MHD_OPTION_END);
    if (!daemon) return 1;
    printf("%d\n", MHD_get_daemon_info(daemon, MHD_DAEMON_INFO_BIND_PORT)->port);
    fflush(stdout);
    sigwaitinfo(&ends, NULL);
    MHD_stop_daemon(daemon);
    return 0;
}
