/* Mistakes of people who come from another program, and the answers: one error, whose sentence
 * names what was meant. */
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define PAPER "\"pendulum\":{\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[1,1]]}"
#define TIMES "\"times\":{\"stop\":1,\"step\":0.5}"
#define ALL(fields) "{" PAPER "," TIMES "," fields "}"

TEST(each_plausible_mistake_is_one_fault_that_names_what_was_meant) {
    test_refused_rows("tests/api/call/refused.txt");
}

TEST(what_modes_and_sections_do_not_have_is_no_nameless_fault) {
    static const char arm[] = "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]";
    static const struct {
        enum api_op_id op;
        const char *rest, *pointer, *code;
    } row[] = {
        {API_OP_MODES, ",\"damping\":[1]},\"normalize\":\"mass\"", "/normalize", "not_applicable"},
        {API_OP_MODES, ",\"damping\":[1]},\"about\":[\"up\"],\"initial\":{}", "/about", "conflict"},
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
        OWN(test_reply, free) reply = test_post(row[i].op, body);
        const char *code = test_reply_text(&reply, "/errors/0/code"),
                   *pointer = test_reply_text(&reply, "/errors/0/pointer");
        CHECK_SAYING(reply.status == 422 && pointer && !strcmp(pointer, row[i].pointer) && code &&
                         !strcmp(code, row[i].code),
                     "%s: %s", body, reply.out.data);
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
        {"{" PAPER "," TIMES ",}", "a comma is missing before it"},
        {"{ // arms\n" PAPER "}", "JSON has no comments"},
        {ALL("\"rtol\":.5"), "begins with a digit"},
        {ALL("\"accuracy\":0,5"), "the decimal mark is a point"},
        {"[object Object]", "JSON.stringify"},
        {"\x1f\x8b\x08", "it looks compressed, send it uncompressed"},
        {"\xef\xbb\xbf{}", "byte order mark precedes the text: leave it out"},
        {"", "the body is empty"},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, row[i].body);
        const char *type = test_reply_text(&reply, "/type");
        CHECK_SAYING(reply.status == 400 && type &&
                         !strcmp(type, "urn:pendulumd:problem-not-json") &&
                         strstr(test_reply_text(&reply, "/detail"), row[i].meant),
                     "%s: %s", row[i].body, reply.out.data);
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
        OWN(test_reply, free) reply = test_send(&request, NULL);
        const char *detail = test_reply_text(&reply, "/detail");
        CHECK_SAYING(reply.status == row[i].status && detail && strstr(detail, row[i].meant),
                     "%zu: %s", i, reply.out.data);
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
        OWN(test_reply, free) number = test_post(API_OP_TRAJECTORIES, row[i][0]),
                              list = test_post(API_OP_TRAJECTORIES, row[i][1]);
        CHECK_SAYING(number.status == 200 && list.status == 200, "%s", number.out.data);
        double a = test_reply_number(&number, "/phi/2/0"), b = test_reply_number(&list, "/phi/2/0");
        CHECK_SAYING(a == b, "%s: %.17g and %.17g", row[i][0], a, b);
    }
}
