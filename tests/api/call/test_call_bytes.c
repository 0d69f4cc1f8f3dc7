/* The memory that a call reports, against the C library's count of allocated bytes: before each
 * turn, for every operation, representation and method. */
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "core/base/isa.h"
#include "tests/harness/test.h"

enum { TEXT = 1 << 20, TURNS = 400 };

/* above so many bytes, a report of so many times the true value is wasteful */
static const double small = 4e6, loose = 3.3;

static double bytes_allocated(void) {
    struct mallinfo2 info = mallinfo2();
    return (double)info.uordblks + (double)info.hblkhd;
}

/* a chain, a star, or a tree with two branches per arm; arms are all equal or all different */
static const char *bytes_pendulum(char *to, int n, int kind) {
    char *at = to + sprintf(to, "\"pendulum\":{\"length\":[");
    for (int i = 0; i < n; i++)
        at += sprintf(at, "%s%g", i ? "," : "", kind == 2 ? 1 + 0.001 * i : 1);
    at += sprintf(at, "],\"mass\":[");
    for (int i = 0; i < n; i++) at += sprintf(at, "%s1", i ? "," : "");
    at += sprintf(at, "],\"parent\":[");
    for (int i = 0; i < n; i++)
        at += sprintf(at, "%s%d", i ? "," : "", !kind ? i : kind == 1 ? i > 0 : (i + 1) / 2);
    strcpy(at, "]}");
    return to;
}

/* the most bytes allocated after a turn, and the report before the last; 0 if a turn took more than
 * reported */
static int bytes_hold(enum api_op_id op, const char *accept, const char *body, double *taken,
                      double *told) {
    struct api_request request = {.op = op,
                                  .content_type = "application/json",
                                  .accept = accept,
                                  .body = body,
                                  .body_bytes = strlen(body)};
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    OWN(api_call, free) *call;
    int held = 1;
    api_limits_init(&limits);
    api_buffer_init(&out, (size_t)limits.answer_bytes);
    double before = bytes_allocated();
    *taken = *told = 0;
    if (api_call_new(&call, &limits) != PEND_OK) return 0;
    enum api_progress progress = api_call_open(call, &request, &out);
    if (progress == API_DONE)
        CHECK_SAYING(0, "%.300s: %.*s", body, out.bytes < 300 ? (int)out.bytes : 300, out.data);
    for (int turn = 0; progress == API_MORE && turn < TURNS; turn++) {
        double foreseen = api_call_bytes(call);
        *told = foreseen;
        progress = api_call_run(call, &out);
        out.bytes = api_call_streams(call) && turn ? 0 : out.bytes;
        if (api_call_streams(call)) api_call_promise(call);
        double now = bytes_allocated() - before - (double)out.cap;
        held &= now <= foreseen;
        /* an operation that takes one turn keeps only its answer afterwards */
        now += api_call_streams(call) || turn ? 0 : (double)out.cap;
        if (now > *taken) *taken = now;
    }
    return held;
}

static void bytes_check(enum api_op_id op, const char *accept, const char *pendulum,
                        const char *rest) {
    static char body[TEXT];
    double taken, told;
    CHECK(snprintf(body, sizeof body, "{%s%s}", pendulum, rest) < (int)sizeof body);
    int held = bytes_hold(op, accept, body, &taken, &told);
    CHECK_SAYING(held, "operation %d, %s, %.40s...%.100s: %.0f bytes were told, %.0f taken", op,
                 accept, pendulum, rest, told, taken);
    /* reports are for the widest lanes, of which these may need a quarter or half */
    static const double narrow[] = {
        [PEND_ISA_BASE] = 2, [PEND_ISA_AVX2] = 1.5, [PEND_ISA_AVX512] = 1};
    double slack = narrow[pend_isa_best()] * loose;
    CHECK_SAYING(told < small || told < slack * taken,
                 "operation %d, %s, %.40s...%.100s: %.0f told, %.0f taken", op, accept, pendulum,
                 rest, told, taken);
}

static const int bytes_arms[] = {1, 3, 9, 70, 600};
static const char octets[] = "application/octet-stream", json[] = "application/json",
                  npz[] = "application/x-npz", mat[] = "application/x-matlab-data";

/* whether the C library reports allocated bytes; not if a sanitizer replaces it */
static int bytes_known(void) {
    void *volatile some = malloc(1 << 16);
    int known = bytes_allocated() > 0;
    free(some);
    if (!known) test_skip("malloc does not say what is allocated");
    return known;
}

TEST(a_trajectory_tells_its_memory_before_it_takes_it) {
    static const char *const how[] = {"\"method\":\"taylor\"",
                                      "\"method\":\"taylor\",\"rtol\":1e-16,\"atol\":1e-300",
                                      "\"method\":\"ode23\"",
                                      "\"method\":\"rkf45\"",
                                      "\"method\":\"rk8pd\"",
                                      "\"method\":\"msadams\"",
                                      "\"method\":\"symplectic\",\"step\":0.01",
                                      "\"method\":\"radau\"",
                                      "\"method\":\"linear\"",
                                      "\"precision\":\"extended\"",
                                      "\"trust\":true",
                                      "\"method\":\"rk8pd\",\"trust\":true"};
    static char pendulum[TEXT / 2], rest[TEXT / 2];
    if (!bytes_known()) return;
    for (size_t a = 0; a < sizeof bytes_arms / sizeof *bytes_arms; a++)
        for (size_t i = 0; i < sizeof how / sizeof *how; i++)
            for (int kind = 0; kind < 3; kind++) {
                snprintf(rest, sizeof rest, ",\"times\":{\"stop\":0.01,\"count\":5},%s", how[i]);
                bytes_check(API_OP_TRAJECTORIES, octets,
                            bytes_pendulum(pendulum, bytes_arms[a], kind), rest);
            }
    bytes_pendulum(pendulum, 3, 0);
    const char many[] =
        ",\"times\":{\"stop\":1,\"count\":200000},\"output\":[\"phi\",\"z\",\"energy\"]";
    bytes_check(API_OP_TRAJECTORIES, npz, pendulum, many);
    bytes_check(API_OP_TRAJECTORIES, mat, pendulum, many);
    bytes_check(API_OP_TRAJECTORIES, json, pendulum, many);
    bytes_check(API_OP_TRAJECTORIES, octets, pendulum, many);
    char *at = stpcpy(rest, ",\"times\":[0");
    for (int i = 1; i < 60000; i++) at += sprintf(at, ",%d", i);
    strcpy(at, "],\"method\":\"linear\"");
    bytes_check(API_OP_TRAJECTORIES, json, pendulum, rest);
    bytes_pendulum(pendulum, 600, 2);
    bytes_check(
        API_OP_TRAJECTORIES, octets, pendulum,
        ",\"times\":{\"stop\":0.01,\"count\":5},\"initial\":{\"mode\":1,\"amplitude\":0.1}");
}

TEST(modes_tell_their_memory_before_they_take_it) {
    static char pendulum[TEXT / 2];
    static const char *const what[] = {"", ",\"vectors\":false", ",\"select\":{\"slowest\":1}",
                                       ",\"initial\":{\"mode\":1,\"amplitude\":0.1}"};
    if (!bytes_known()) return;
    for (size_t a = 0; a < sizeof bytes_arms / sizeof *bytes_arms; a++)
        for (size_t i = 0; i < sizeof what / sizeof *what; i++)
            for (int kind = 0; kind < 3; kind++) {
                bytes_pendulum(pendulum, bytes_arms[a], kind);
                bytes_check(API_OP_MODES, json, pendulum, what[i]);
                bytes_check(API_OP_MODES, npz, pendulum, what[i]);
            }
}

TEST(what_looks_for_passages_exponents_forces_and_ensembles_tells_its_memory) {
    static char pendulum[TEXT / 2], rest[TEXT / 2], angles[TEXT / 8], states[TEXT / 4];
    if (!bytes_known()) return;
    for (size_t a = 0; a < sizeof bytes_arms / sizeof *bytes_arms; a++)
        for (int kind = 0; kind < 3; kind++) {
            int n = bytes_arms[a];
            char *at = angles;
            bytes_pendulum(pendulum, n, kind);
            for (int i = 0; i < n; i++) at += sprintf(at, "%s2", i ? "," : "");
            snprintf(rest, sizeof rest,
                     ",\"initial\":{\"theta\":[%s]},\"duration\":0.05,\"samples\":3,\"count\":%d",
                     angles, n < 70 ? 2 * n : 3);
            bytes_check(API_OP_LYAPUNOV, json, pendulum, rest);
            snprintf(rest, sizeof rest,
                     ",\"initial\":{\"theta\":[%s]},\"duration\":0.05,\"count\":9,\"section\":{"
                     "\"arm\":1,\"theta\":0}",
                     angles);
            bytes_check(API_OP_SECTIONS, json, pendulum, rest);
            snprintf(rest, sizeof rest,
                     ",\"initial\":{\"theta\":[%s]},\"times\":[0,3],\"rows\":\"events\",\"events\":"
                     "[{\"of\":\"phi\",\"arm\":1,\"value\":-1.5},{\"of\":\"energy\",\"value\":1}]",
                     angles);
            if (n < 70) bytes_check(API_OP_TRAJECTORIES, a ? npz : json, pendulum, rest);
            snprintf(rest, sizeof rest,
                     ",\"drive\":{\"pivot\":{\"x\":1}},\"output\":[\"phi\",\"z\"],\"omega\":{"
                     "\"start\":0,\"stop\":9,\"count\":%d}",
                     9 + 2000 / n);
            bytes_check(API_OP_RESPONSE, a ? json : npz, pendulum, rest);
            if (n <= 100) {
                snprintf(rest, sizeof rest,
                         ",\"mode\":%d,\"amplitude\":0.03,\"points\":2,\"branch\":true,\"rows\":"
                         "\"orbits\"",
                         n);
                bytes_check(API_OP_ORBITS, a ? json : npz, pendulum, rest);
            }
            at = states;
            for (int i = 0; i < 2 + 2000 / n; i++)
                at += sprintf(at, "%s{\"theta\":[%s]}", i ? "," : "", angles);
            snprintf(rest, sizeof rest, ",\"states\":[%s]", states);
            bytes_check(API_OP_FORCES, json, pendulum, rest);
            bytes_check(API_OP_TREES, json, pendulum, "");
            if (n <= 20) bytes_check(API_OP_EQUATIONS, json, pendulum, ",\"form\":\"explicit\"");
            bytes_check(API_OP_EQUATIONS, json, pendulum, ",\"form\":\"compact\"");
            for (int differ = 0; differ < 2; differ++) {
                snprintf(
                    rest, sizeof rest,
                    ",\"duration\":0.01,\"initial\":{\"theta\":[%s]},\"grid\":[{\"vary\":\"theta\","
                    "\"arm\":1,\"start\":0,\"stop\":1,\"count\":%d}]%s",
                    angles, n < 70 ? 3000 : 9,
                    differ
                        ? ",\"derivatives\":[{\"vary\":\"gravity\"},{\"vary\":\"mass\",\"arm\":1}]"
                        : "");
                if (!differ || n < 700) bytes_check(API_OP_ENSEMBLES, json, pendulum, rest);
            }
        }
    bytes_pendulum(pendulum, 1, 0);
    bytes_check(API_OP_SECTIONS, npz, pendulum,
                ",\"initial\":{\"theta\":[0],\"thetad\":[50]},\"duration\":4000,\"count\":50000,"
                "\"section\":{\"arm\":1,\"theta\":0}");
}

/* adds a list of n equal entries to a pendulum that bytes_pendulum has written */
static void bytes_term(char *pendulum, int n, const char *name, const char *entry) {
    char *at = pendulum + strlen(pendulum) - 1;
    at += sprintf(at, ",\"%s\":[", name);
    for (int i = 0; i < n; i++) at += sprintf(at, "%s%s", i ? "," : "", entry);
    strcpy(at, "]}");
}

/* a cart and all terms of tips, joints and bodies, or only the first kinds of these */
static void bytes_real(char *pendulum, int n, int shape, int kind) {
    static const struct {
        const char *name, *entry;
    } term[] = {{"damping", "0.1"},
                {"torque", "{\"harmonics\":[{\"amplitude\":1,\"omega\":2}]}"},
                {"rod", "1"},
                {"stiffness", "2"},
                {"friction", "{\"torque\":0.1,\"speed\":0.1}"},
                {"drag", "{\"linear\":0.1,\"quadratic\":0.1,\"speed\":0.1}"}};
    int count = kind < 2 ? kind + 1 : kind == 2 ? 1 : 6;
    bytes_pendulum(pendulum, n, shape);
    for (int i = 0; i < count; i++)
        bytes_term(pendulum, n, term[kind == 2 ? 2 : i].name, term[kind == 2 ? 2 : i].entry);
    if (kind == 4) strcpy(pendulum + strlen(pendulum) - 1, ",\"pivot\":{\"cart\":{\"mass\":1}}}");
}

TEST(a_real_pendulum_tells_its_memory_before_it_takes_it) {
    static const int arms[] = {1, 6, 40, 70, 600};
    enum { CARTS = 4, RODS = 2 }; /* number of kinds */
    /* kinds `first` to `last` are computed in this way */
    static const struct {
        const char *how;
        int first, last;
    } row[] = {
        {"\"method\":\"taylor\"", 0, CARTS},
        {"\"method\":\"rk8pd\"", 0, CARTS},
        {"\"method\":\"radau\"", RODS, CARTS},
        {"\"precision\":\"extended\"", 0, CARTS},
        {"\"trust\":true", 0, CARTS},
        {"\"method\":\"symplectic\",\"step\":0.01", RODS, RODS},
        {"\"derivatives\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"gravity\"}]", 0, CARTS - 1}};
    static char pendulum[TEXT / 2], rest[TEXT / 2];
    if (!bytes_known()) return;
    for (size_t a = 0; a < sizeof arms / sizeof *arms; a++)
        for (size_t i = 0; i < sizeof row / sizeof *row; i++)
            for (int kind = row[i].first; kind <= row[i].last; kind++)
                for (int shape = 0; shape < 3; shape++) {
                    bytes_real(pendulum, arms[a], shape, kind);
                    snprintf(rest, sizeof rest, ",\"times\":{\"stop\":1e-4,\"count\":5},%s",
                             row[i].how);
                    bytes_check(API_OP_TRAJECTORIES, octets, pendulum, rest);
                }
}
