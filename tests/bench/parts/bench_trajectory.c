/* The paper's example, 501 instants of phi, phi' and lambda: by method, and as a whole request.
 * Leaves to others: sockets.
 * Invariant: the timed code has to succeed. */
#include <string.h>

#include "api/call/call.h"
#include "core/integrate/run/run.h"
#include "tests/bench/parts/bench.h"

enum { ARMS = 4, INSTANTS = 501 };

static const double length[ARMS] = {2, 1.5, 0.75, 1.25}, mass[ARMS] = {1, 1, 1, 0.1}, rest[ARMS];
static const int parent[ARMS] = {-1, 0, 1, 1};

static void integrate(struct bench *bench, const char *name, double tolerance) {
    static double t[INSTANTS], phi[INSTANTS * ARMS], rate[INSTANTS * ARMS], force[INSTANTS * ARMS];
    struct pend_tree *tree;
    if (pend_tree_new(&tree, ARMS, length, mass, parent, NULL) != PEND_OK) bench_broken("tree");
    struct pend_problem problem = {.tree = tree, .loads.gravity = 9.81, .phi = rest, .rate = rest};
    problem.times = (struct pend_times){.count = INSTANTS, .start = 0, .span = 5, .divisor = 500};
    problem.rtol = problem.atol = tolerance;
    while (bench_go(bench, 1)) {
        struct pend_samples samples = {
            .cap = INSTANTS, .t = t, .phi = phi, .rate = rate, .force = force};
        struct pend_run *run;
        int done = 0;
        if (pend_run_new(&run, pend_method_find(name), &problem, NULL) != PEND_OK)
            bench_broken(name);
        while (!done)
            if (pend_run_next(run, &samples, 1e9, &done, NULL) != PEND_OK) bench_broken(name);
        pend_run_free(&run);
    }
    pend_tree_free(&tree);
}

BENCH(example_taylor_1e_12, "run") { integrate(bench, "taylor", 1e-12); }
BENCH(example_taylor_1e_6, "run") { integrate(bench, "taylor", 1e-6); }
BENCH(example_rk8pd_1e_12, "run") { integrate(bench, "rk8pd", 1e-12); }
BENCH(example_rkf45_1e_9, "run") { integrate(bench, "rkf45", 1e-9); }
BENCH(example_msadams_1e_9, "run") { integrate(bench, "msadams", 1e-9); }
BENCH(example_ode23_defaults, "run") { integrate(bench, "ode23", 0); }

static void answer(struct bench *bench, const char *accept, const char *more) {
    char body[512];
    strcpy(body, "{\"pendulum\":{\"L\":[2,1.5,0.75,1.25],\"m\":[1,1,1,0.1],\"S\":[[1,0,0,0],[1,1,0,"
                 "0],[1,1,1,0],[1,1,0,1]]},\"times\":{\"start\":0,\"stop\":5,\"step\":0.01},"
                 "\"output\":[\"phi\",\"phid\"],\"rtol\":1e-9");
    strcat(body, more);
    struct api_request request = {
        .op = API_OP_TRAJECTORIES, .content_type = "application/json", .accept = accept};
    request.body = body;
    request.body_bytes = strlen(body);
    struct api_limits limits;
    api_limits_init(&limits);
    struct api_buffer out;
    api_buffer_init(&out, 1 << 24);
    while (bench_go(bench, 1)) {
        struct api_call *call;
        if (api_call_new(&call, &limits) != PEND_OK) bench_broken("call");
        out.bytes = 0;
        enum api_progress progress = api_call_open(call, &request, &out);
        while (progress == API_MORE) progress = api_call_run(call, &out);
        if (api_call_answer(call).status != 200) bench_broken("answer");
        api_call_free(&call);
    }
    api_buffer_clear(&out);
}

BENCH(answer_json, "request") { answer(bench, NULL, "}"); }
BENCH(answer_json_6_digits, "request") { answer(bench, NULL, ",\"digits\":6}"); }
BENCH(answer_csv, "request") { answer(bench, "text/csv", "}"); }
