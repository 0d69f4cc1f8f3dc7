/* What people write wrongly who come from another program, and what they are told: one fault, whose
 * sentence names what was meant. */
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define PAPER "\"pendulum\":{\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[1,1]]}"
#define TIMES "\"times\":{\"stop\":1,\"step\":0.5}"
#define ARM(fields) "{\"pendulum\":{\"arms\":[{" fields "}]}," TIMES "}"
#define LISTS(fields) "{\"pendulum\":{" fields "}," TIMES "}"
#define ALL(fields) "{" PAPER "," TIMES "," fields "}"
#define AT(times) "{" PAPER "," times "}"

static const struct {
    const char *body, *pointer, *code, *meant;
} mistakes[] = {
    /* the pendulum */
    {ARM("\"lenght\":1,\"mass\":1"), "/pendulum/arms/0/lenght", "unknown_field", "\"length\""},
    {ARM("\"length\":1,\"m\":1"), "/pendulum/arms/0/m", "unknown_field", "\"mass\""},
    {ARM("\"length\":1,\"weight\":1"), "/pendulum/arms/0/weight", "unknown_field", "\"mass\""},
    {ARM("\"length\":1,\"mass\":1,\"id\":\"a\""), "/pendulum/arms/0/id", "unknown_field",
     "\"name\""},
    {ARM("\"length\":\"9.81\",\"mass\":1"), "/pendulum/arms/0/length", "wrong_type",
     "must be a number"},
    {ARM("\"length\":true,\"mass\":1"), "/pendulum/arms/0/length", "wrong_type",
     "must be a number"},
    {ARM("\"name\":\"a\",\"length\":1,\"mass\":1},{\"length\":1,\"mass\":1,\"parent\":1"),
     "/pendulum/arms/1/parent", "unknown_name", "did you mean \"a\""},
    {LISTS("\"arms\":{\"length\":1,\"mass\":1}"), "/pendulum/arms", "wrong_type",
     "must be an array"},
    {LISTS("\"links\":[{\"length\":1,\"mass\":1}]"), "/pendulum/links", "unknown_field",
     "\"arms\""},
    {LISTS("\"L\":[1],\"m\":[1],\"S\":[[1]],\"g\":9.8"), "/pendulum/g", "unknown_field",
     "\"gravity\""},
    {LISTS("\"length\":[1,1],\"mass\":[1,1],\"parents\":[0,1]"), "/pendulum/parents",
     "unknown_field", "\"parent\""},
    {LISTS("\"length\":[1,1],\"mass\":[1,1],\"parent\":[-1,0]"), "/pendulum/parent/0", "not_a_tree",
     "0 (the pivot) or the number of an arm, 1 to 2"},
    {LISTS("\"L\":[1,1],\"m\":[1,1],\"S\":[1,0,1,1]"), "/pendulum/S", "wrong_count",
     "[[1, 0], [1, 1]]"},
    {LISTS("\"L\":[1,1],\"m\":[1,1],\"S\":\"[1 0;1 1]\""), "/pendulum/S", "wrong_count",
     "[[1, 0], [1, 1]]"},
    {LISTS("\"L\":1,\"m\":[1,1],\"S\":[[1,0],[1,1]]"), "/pendulum/L", "wrong_type",
     "an array of 2 numbers"},
    {"{\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":9.81," TIMES "}", "/L", "unknown_field",
     "put these into \"pendulum\": L, m, S, gravity"},
    {ALL("\"gravity\":9.81"), "/gravity", "unknown_field", "put it into \"pendulum\""},
    {"{\"tree\":{\"L\":[1],\"m\":[1],\"S\":[[1]]}," TIMES "}", "/tree", "unknown_field",
     "\"pendulum\""},
    /* the start */
    {ALL("\"theta\":[1,1]"), "/theta", "unknown_field", "put it into \"initial\""},
    {ALL("\"phi0\":[1,1],\"phid0\":[0,0]"), "/phi0", "unknown_field",
     "put these into \"initial\": phi0, phid0"},
    {ALL("\"y0\":[1,1,0,0]"), "/y0", "unknown_field", "\"initial\""},
    {ALL("\"initial\":[1,1,0,0]"), "/initial", "wrong_type", "\"theta\" and \"thetad\""},
    {ALL("\"initial\":{\"angle\":[1,1]}"), "/initial/angle", "unknown_field", "\"theta\""},
    {ALL("\"initial\":{\"theta\":[1,1],\"omega\":[0,0]}"), "/initial/omega", "unknown_field",
     "\"thetad\""},
    {ALL("\"initial\":{\"theta\":[90,0],\"unit\":\"degrees\"}"), "/initial/unit", "unknown_name",
     "\"deg\""},
    /* the instants */
    {AT("\"t\":[0,1,2]"), "/t", "unknown_field", "\"times\""},
    {AT("\"tspan\":[0,5]"), "/tspan", "unknown_field", "\"times\""},
    {AT("\"times\":[0,5,0.01]"), "/times/2", "wrong_order",
     "{\"start\": 0, \"stop\": 5, \"step\": 0.01}"},
    {AT("\"times\":\"0:0.01:5\""), "/times", "wrong_type",
     "{\"start\": 0, \"stop\": 5, \"step\": 0.01}"},
    {AT("\"times\":5"), "/times", "wrong_type", "{\"start\": 0, \"stop\": 5, \"step\": 0.01}"},
    {AT("\"times\":{\"stop\":1,\"dt\":0.1}"), "/times/dt", "unknown_field", "\"step\""},
    {AT("\"times\":{\"stop\":1,\"steps\":9}"), "/times/steps", "unknown_field", "\"count\""},
    {AT("\"times\":{\"end\":1,\"step\":0.1}"), "/times/end", "unknown_field", "\"stop\""},
    {AT("\"stop\":1,\"dt\":0.1"), "/stop", "unknown_field", "put these into \"times\": stop, dt"},
    /* the method and the outputs */
    {ALL("\"method\":\"RK45\""), "/method", "unknown_name", "\"rkf45\""},
    {ALL("\"method\":\"ode45\""), "/method", "unknown_name", "\"rkf45\""},
    {ALL("\"method\":\"lsoda\""), "/method", "unknown_name", "\"msadams\""},
    {ALL("\"method\":\"Taylor\""), "/method", "unknown_name", "\"taylor\""},
    {ALL("\"solver\":\"taylor\""), "/solver", "unknown_field", "\"method\""},
    {ALL("\"RelTol\":1e-6"), "/RelTol", "unknown_field", "\"rtol\""},
    {ALL("\"output\":[\"positions\"]"), "/output/0", "unknown_name", "\"z\""},
    {ALL("\"output\":[\"velocity\"]"), "/output/0", "unknown_name", "\"zd\""},
    {ALL("\"output\":[\"angles\"]"), "/output/0", "unknown_name", "\"theta\""},
    {ALL("\"output\":\"phi\""), "/output", "wrong_count", "[\"phi\"]"},
    {ALL("\"outputs\":[\"phi\"]"), "/outputs", "unknown_field", "\"output\""},
};

TEST(each_plausible_mistake_is_one_fault_that_names_what_was_meant) {
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; i++) {
        struct test_reply reply = test_post(API_OP_TRAJECTORIES, mistakes[i].body);
        const char *code = test_reply_text(&reply, "/errors/0/code");
        CHECK_SAYING(reply.status == 422 && test_reply_faults(&reply) == 1 &&
                         test_reply_has_fault(&reply, mistakes[i].pointer, mistakes[i].meant),
                     "%s: %s", mistakes[i].body, reply.out.data);
        CHECK_SAYING(code && !strcmp(code, mistakes[i].code), "%s: %s", mistakes[i].body,
                     code ? code : "no code");
        test_reply_free(&reply);
    }
}

#define TWO "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]"
#define REST(fields) TWO "}," fields "}"
#define DRAWN(draw) REST("\"duration\":1,\"random\":{\"count\":2,\"draw\":" draw "}")
#define DRAW(fields) DRAWN("[{\"vary\":\"theta\",\"arm\":1," fields "}]")
#define AXIS(fields) REST("\"duration\":1,\"grid\":[{" fields "}]")
#define LISTED(fields) REST("\"duration\":1,\"states\":[{\"theta\":[1,2]}]," fields)

/* tried by a newcomer on a server, whose answers named something else or only what is allowed */
static const struct {
    enum api_op_id op;
    const char *body, *pointer, *meant;
} newcomers[] = {
    {API_OP_TRAJECTORIES, TWO ",\"theta\":[1,2]}," TIMES "}", "/pendulum/theta",
     "beside \"pendulum\", in \"initial\""},
    {API_OP_TRAJECTORIES, TWO ",\"initial\":{}}," TIMES "}", "/pendulum/initial",
     "beside \"pendulum\""},
    {API_OP_TRAJECTORIES, ARM("\"length\":1,\"mass\":1,\"theta\":1"), "/pendulum/arms/0/theta",
     "beside \"pendulum\", in \"initial\""},
    {API_OP_TRAJECTORIES, TWO ",\"grav\":9.8}," TIMES "}", "/pendulum/grav", "\"gravity\""},
    {API_OP_TRAJECTORIES, TWO ",\"spring\":[1,1]}," TIMES "}", "/pendulum/spring", "\"stiffness\""},
    {API_OP_TRAJECTORIES, LISTS("\"preset\":\"double\""), "/pendulum/preset",
     "GET /v1/presets/{name}"},
    {API_OP_TRAJECTORIES, LISTS("\"L\":[1],\"M\":[1],\"S\":[[1]]"), "/pendulum/M", "\"m\""},
    {API_OP_TRAJECTORIES, AT("\"duration\":5"), "/duration", "into \"times\""},
    {API_OP_TRAJECTORIES, AT("\"t_end\":5"), "/t_end", "into \"times\""},
    {API_OP_TRAJECTORIES, AT("\"times\":{\"stop\":5,\"by\":1}"), "/times/by", "\"step\""},
    {API_OP_TRAJECTORIES, AT("\"times\":{\"stop\":5,\"interval\":1}"), "/times/interval",
     "\"step\""},
    {API_OP_TRAJECTORIES, ALL("\"ic\":{\"theta\":[1,2]}"), "/ic", "\"initial\""},
    {API_OP_TRAJECTORIES, ALL("\"output\":[\"E\"]"), "/output/0", "\"energy\""},
    {API_OP_TRAJECTORIES, ALL("\"dtype\":\"float32\""), "/dtype", "\"number\""},
    {API_OP_TRAJECTORIES, ALL("\"format\":\"csv\""), "/format", "Accept: text/csv"},
    {API_OP_TRAJECTORIES, ALL("\"async\":true"), "/async", "Prefer: respond-async"},
    {API_OP_TRAJECTORIES, ALL("\"title\":\"mine\""), "/title", "Job-Title: "},
    {API_OP_TRAJECTORIES, ALL("\"webhook\":\"https://a/\""), "/webhook", "Job-Notify: "},
    {API_OP_ENSEMBLES, LISTED("\"seed\":7"), "/seed", "into \"random\""},
    {API_OP_ENSEMBLES, REST("\"time\":5,\"states\":[{}]"), "/time", "\"duration\""},
    {API_OP_ENSEMBLES, LISTED("\"observables\":\"first_flip\""), "/observables", "[\"start\"]"},
    {API_OP_ENSEMBLES, LISTED("\"observables\":[\"max_lambda\"]"), "/observables/0",
     "\"lambda_max\""},
    {API_OP_ENSEMBLES, DRAWN("{\"vary\":\"theta\"}"), "/random/draw", "put [ ] around it"},
    {API_OP_ENSEMBLES, DRAW("\"distribution\":\"uniform\",\"min\":0,\"high\":1"),
     "/random/draw/0/min", "\"low\""},
    {API_OP_ENSEMBLES, DRAW("\"distribution\":\"uniform\",\"low\":0,\"max\":1"),
     "/random/draw/0/max", "\"high\""},
    {API_OP_ENSEMBLES, DRAW("\"distribution\":\"normal\",\"mean\":0,\"sigma\":1"),
     "/random/draw/0/sigma", "\"deviation\""},
    {API_OP_ENSEMBLES, DRAW("\"distribution\":\"gaussian\",\"mean\":0,\"deviation\":1"),
     "/random/draw/0/distribution", "\"normal\""},
    {API_OP_ENSEMBLES, AXIS("\"parameter\":\"gravity\",\"start\":1,\"stop\":3,\"count\":2"),
     "/grid/0/parameter", "\"vary\""},
    {API_OP_ENSEMBLES, AXIS("\"vary\":\"gravity\",\"start\":1,\"stop\":3,\"step\":1"),
     "/grid/0/step", "\"count\""},
    {API_OP_MODES, REST("\"select\":3"), "/select", "{\"slowest\": 3}"},
    {API_OP_MODES, REST("\"include\":\"A\""), "/include", "[\"A\"]"},
    {API_OP_MODES, REST("\"include\":[\"mass_matrix\"]"), "/include/0", "\"M\""},
    {API_OP_FORCES, REST("\"initial\":{\"theta\":[1,2]}"), "/initial", "\"state\""},
    {API_OP_LYAPUNOV, REST("\"time\":100"), "/time", "\"duration\""},
    {API_OP_EQUATIONS, REST("\"language\":\"python\""), "/language", "\"form\""},
};

TEST(what_newcomers_try_is_one_fault_that_names_what_was_meant) {
    for (size_t i = 0; i < sizeof newcomers / sizeof *newcomers; i++) {
        struct test_reply reply = test_post(newcomers[i].op, newcomers[i].body);
        CHECK_SAYING(reply.status == 422 && test_reply_faults(&reply) == 1 &&
                         test_reply_has_fault(&reply, newcomers[i].pointer, newcomers[i].meant),
                     "%s: %s", newcomers[i].body, reply.out.data);
        test_reply_free(&reply);
    }
}

TEST(what_modes_and_sections_do_not_have_is_no_nameless_fault) {
    static const char arm[] = "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]";
    static const struct {
        enum api_op_id op;
        const char *rest, *pointer, *code;
    } row[] = {
        {API_OP_MODES, ",\"damping\":[1]},\"normalize\":\"mass\"", "/normalize", "not_applicable"},
        {API_OP_MODES, ",\"damping\":[1]},\"about\":[\"up\"]", "/about", "not_applicable"},
        {API_OP_SECTIONS, "},\"duration\":1,\"section\":{\"period\":\"drive\"}", "/section/period",
         "not_applicable"},
        {API_OP_SECTIONS,
         ",\"torque\":[{\"harmonics\":[{\"amplitude\":1,\"omega\":3},{\"amplitude\":1,"
         "\"omega\":4}]}]},\"duration\":1,\"section\":{\"period\":\"drive\"}",
         "/section/period", "conflict"},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char body[600];
        snprintf(body, sizeof body, "{%s%s}", arm, row[i].rest);
        struct test_reply reply = test_post(row[i].op, body);
        const char *code = test_reply_text(&reply, "/errors/0/code"),
                   *pointer = test_reply_text(&reply, "/errors/0/pointer");
        CHECK_SAYING(reply.status == 422 && pointer && !strcmp(pointer, row[i].pointer) && code &&
                         !strcmp(code, row[i].code),
                     "%s: %s", body, reply.out.data);
        test_reply_free(&reply);
    }
}

TEST(what_is_not_json_is_told_what_json_has) {
    static const struct {
        const char *body, *meant;
    } row[] = {
        {ALL("\"rtol\":NaN"), "JSON has no NaN"},
        {ALL("\"rtol\":-Infinity"), "no infinity"},
        {ALL("\"trust\":True"), "JSON writes true"},
        {ALL("\"trust\":None"), "JSON writes null"},
        {"{'pendulum':1}", "double quotes"},
        {"{" PAPER "," TIMES ",}", "no comma stands before it"},
        {"{ // arms\n" PAPER "}", "JSON has no comments"},
        {ALL("\"rtol\":.5"), "begins with a digit"},
        {ALL("\"accuracy\":0,5"), "a decimal point is a point"},
        {"[object Object]", "JSON.stringify"},
        {"\x1f\x8b\x08", "Content-Encoding: gzip"},
        {"\xef\xbb\xbf{}", "byte order mark precedes the text: leave it out"},
        {"", "the body is empty"},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct test_reply reply = test_post(API_OP_TRAJECTORIES, row[i].body);
        const char *type = test_reply_text(&reply, "/type");
        CHECK_SAYING(reply.status == 400 && type && !strcmp(type, "/docs#problem-not-json") &&
                         strstr(test_reply_text(&reply, "/detail"), row[i].meant),
                     "%s: %s", row[i].body, reply.out.data);
        test_reply_free(&reply);
    }
}

TEST(what_is_wrong_beside_the_body_is_told_too) {
    static const struct {
        const char *type, *accept, *query, *meant;
        int status;
    } row[] = {
        {"application/x-www-form-urlencoded", NULL, NULL, "Content-Type: application/json", 415},
        {NULL, NULL, NULL, "Content-Type: application/json", 415},
        {"application/json", "text/json", NULL, "application/json", 406},
        {"application/json", NULL, "method=taylor", "put it into the body", 422},
        {"application/json", NULL, "format=csv", "Accept: text/csv", 422},
        {"application/json", NULL, "wait=30", "Prefer: respond-async, wait=30", 422},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const char *body = "{" PAPER "," TIMES "}";
        struct api_request request = {.op = API_OP_TRAJECTORIES,
                                      .content_type = row[i].type,
                                      .accept = row[i].accept,
                                      .query = row[i].query,
                                      .body = body,
                                      .body_bytes = strlen(body)};
        struct test_reply reply = test_send(&request, NULL);
        const char *detail = test_reply_text(&reply, "/detail");
        CHECK_SAYING(reply.status == row[i].status && detail && strstr(detail, row[i].meant),
                     "%zu: %s", i, reply.out.data);
        test_reply_free(&reply);
    }
}

/* --- one arm: encoders of arrays write a list of one as a number --- */

#define SINGLE(pendulum, initial)                                                                  \
    "{\"pendulum\":{" pendulum "},\"initial\":{" initial "}," TIMES "}"

TEST(one_arm_is_given_by_numbers_as_well_as_by_lists) {
    static const char *const row[][2] = {
        {SINGLE("\"L\":2,\"m\":3,\"S\":1", "\"phi\":0.5,\"phid\":0.25"),
         SINGLE("\"L\":[2],\"m\":[3],\"S\":[[1]]", "\"phi\":[0.5],\"phid\":[0.25]")},
        {SINGLE("\"L\":2,\"m\":3,\"S\":[1]", "\"theta\":30,\"unit\":\"deg\""),
         SINGLE("\"L\":[2],\"m\":[3],\"S\":[[1]]", "\"theta\":[30],\"unit\":\"deg\"")},
        {SINGLE("\"length\":2,\"mass\":3,\"parent\":0,\"damping\":0.1,"
                "\"body\":{\"mass\":1,\"center\":[1,0]}",
                "\"thetad\":1,\"theta\":0"),
         SINGLE("\"length\":[2],\"mass\":[3],\"parent\":[0],\"damping\":[0.1],"
                "\"body\":[{\"mass\":1,\"center\":[1,0]}]",
                "\"thetad\":[1],\"theta\":[0]")},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct test_reply number = test_post(API_OP_TRAJECTORIES, row[i][0]),
                          list = test_post(API_OP_TRAJECTORIES, row[i][1]);
        CHECK_SAYING(number.status == 200 && list.status == 200, "%s", number.out.data);
        double a = test_reply_number(&number, "/phi/2/0"), b = test_reply_number(&list, "/phi/2/0");
        CHECK_SAYING(a == b, "%s: %.17g and %.17g", row[i][0], a, b);
        test_reply_free(&number);
        test_reply_free(&list);
    }
}

TEST(a_number_in_place_of_a_list_is_blamed_itself) {
    CHECK_REFUSED(API_OP_TRAJECTORIES, LISTS("\"L\":-1,\"m\":1,\"S\":1"), "/pendulum/L",
                  "greater than 0, got -1");
    CHECK_REFUSED(API_OP_TRAJECTORIES, LISTS("\"length\":1,\"mass\":1,\"parent\":7"),
                  "/pendulum/parent", "must be 0 (the pivot)");
    CHECK_REFUSED(API_OP_TRAJECTORIES,
                  SINGLE("\"L\":1,\"m\":1,\"S\":1", "\"theta\":1e16,\"unit\":\"deg\""),
                  "/initial/theta", "1e15");
}
