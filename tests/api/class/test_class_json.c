#include "api/class/class_json.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

#define SCENE                                                                                      \
    "{\"request\":{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"times\":{\"stop\":" \
    "1,\"step\":0.1}},\"view\":{\"trails\":[1]}}"

/* The result for one body. */
struct body {
    int http;
    struct api_class_facts facts;
    struct api_buffer value, problem; /* NUL-terminated */
};

static struct body body_of(enum api_class_kind kind, const char *text) {
    struct body body = {.http = 0};
    struct api_limits limits;
    struct api_request request = {
        .content_type = "application/json", .body = text, .body_bytes = strlen(text)};
    api_limits_init(&limits);
    api_buffer_init(&body.value, 1 << 20);
    api_buffer_init(&body.problem, 1 << 20);
    body.http = api_class_read(&request, &limits, kind, &body.facts, &body.value, &body.problem);
    CHECK(api_buffer_add(&body.value, "", 1) == PEND_OK &&
          api_buffer_add(&body.problem, "", 1) == PEND_OK);
    return body;
}

static void body_clear(struct body *body) {
    api_buffer_clear(&body->value);
    api_buffer_clear(&body->problem);
}

/* a body is valid, and stored as that text */
static struct api_class_facts good(enum api_class_kind kind, const char *text, const char *kept) {
    OWN(body, clear) body = body_of(kind, text);
    CHECK_SAYING(!body.http, "%s: %s", text, body.problem.data);
    if (kept) CHECK_TEXT(body.value.data, kept);
    return body.facts;
}

/* a body is refused, with an error at a pointer and some words */
static void bad(enum api_class_kind kind, int http, const char *text, const char *pointer,
                const char *words) {
    OWN(body, clear) body = body_of(kind, text);
    char wanted[80];
    CHECK_INT(body.http, http);
    snprintf(wanted, sizeof wanted, "\"pointer\":\"%s\"", pointer ? pointer : "");
    CHECK_SAYING(!pointer || strstr(body.problem.data, wanted), "%s: %s", text, body.problem.data);
    CHECK_SAYING(!strstr(body.problem.data, "\"code\":\"invalid\""), "%s: %s", text,
                 body.problem.data);
    CHECK_SAYING(strstr(body.problem.data, words) != NULL, "%s: %s", text, body.problem.data);
}

TEST(what_stands_in_a_room_is_kept_in_one_form) {
    CHECK_INT((long)good(API_CLASS_ROOM, "{}", NULL).hours, 24);
    CHECK_INT((long)good(API_CLASS_ROOM, "{\"hours\":720}", NULL).hours, 720);
    good(API_CLASS_PUPIL, "{ \"nickname\" : \"\\u003cscript\\u003e\" }",
         "{\"nickname\":\"<script>\"}");
    CHECK_INT(good(API_CLASS_STAGE, "{\"open\":false,\"frozen\":true}",
                   "{\"frozen\":true,\"open\":false}")
                  .shut,
              1);
    CHECK_INT(good(API_CLASS_STAGE, "{\"scene\":" SCENE ",\"release\":{\"number\":3}}", NULL).shut,
              0);
    good(API_CLASS_STAGE, "{\"pace\":50,\"follow\":{\"playing\":true,\"time\":2.5}}",
         "{\"follow\":{\"playing\":true,\"time\":2.5},\"pace\":50}");
    good(API_CLASS_STAGE, "{\"follow\":{\"drawer\":\"plots\"}}", NULL);
    good(API_CLASS_WORKSHEET,
         "{\"title\":\"T\",\"feedback\":\"at_end\",\"steps\":[{\"id\":\"a\"}]}", NULL);
    good(API_CLASS_HANDIN, "{\"answers\":[{\"step\":\"a\",\"value\":2,\"tries\":[3,\"x\"]}]}",
         NULL);
    good(API_CLASS_OWN_STAGE, "{\"scene\":" SCENE ",\"state\":\"stuck\",\"release\":3}", NULL);
    good(API_CLASS_OWN_STAGE, "{\"state\":\"away\"}", NULL);
    good(API_CLASS_OWN_STAGE, "{\"idle\":2592000}", NULL);
    good(API_CLASS_SOLUTION, "{\"value\":2.006,\"tolerance\":1e-2}",
         "{\"tolerance\":0.01,\"value\":2.006}");
    CHECK_INT(good(API_CLASS_SOLUTION, "{\"shown\":true}", NULL).shown, 1);
    good(API_CLASS_WORKSHEET,
         "{\"title\":\"T\",\"steps\":[{\"id\":\"a\",\"question\":{\"kind\":\"choice\",\"choices\":["
         "\"x\",\"y\"],\"value\":2},\"needs\":\"right\"},{\"id\":\"b\",\"hidden_until\":\"a\","
         "\"scene\":" SCENE "}]}",
         NULL);
    good(API_CLASS_HANDIN,
         "{\"answers\":[{\"step\":\"a\",\"value\":2},{\"step\":\"b\",\"value\":\"because\","
         "\"scene\":" SCENE "}],\"done\":true}",
         NULL);
}

TEST(what_may_not_stand_in_a_room_is_refused_with_its_place) {
    bad(API_CLASS_ROOM, 422, "{\"hours\":721}", "/hours", "720");
    bad(API_CLASS_ROOM, 400, "{", NULL, "JSON");
    bad(API_CLASS_PUPIL, 422, "{}", "/nickname", "text of 1 to 32 characters");
    bad(API_CLASS_PUPIL, 422, "{\"nickname\":\"\"}", "/nickname", "got 0");
    bad(API_CLASS_PUPIL, 422, "{\"nickname\":\"a\\nb\"}", "/nickname", "one line");
    bad(API_CLASS_PUPIL, 422, "{\"nickname\":\"a\\u202eb\"}", "/nickname", "direction");
    bad(API_CLASS_PUPIL, 422, "{\"nickname\":\"123456789012345678901234567890123\"}", "/nickname",
        "got 33");
    bad(API_CLASS_PUPIL, 422, "{\"nickname\":\"Ada\",\"surname\":\"L\"}", "/surname", "known");
    bad(API_CLASS_STAGE, 422, "{\"scene\":{\"request\":{}}}", "/scene/request/pendulum", "");
    bad(API_CLASS_STAGE, 422, "{\"release\":{\"spread\":2}}", "/release/spread", "1");
    bad(API_CLASS_STAGE, 422, "{\"pace\":51}", "/pace", "50");
    bad(API_CLASS_STAGE, 422, "{\"follow\":{\"time\":-1}}", "/follow/time", "0");
    bad(API_CLASS_STAGE, 422, "{\"follow\":{\"speed\":1}}", "/follow/speed", "known");
    bad(API_CLASS_WORKSHEET, 422,
        "{\"title\":\"T\",\"feedback\":\"soon\",\"steps\":[{\"id\":\"a\"}]}", "/feedback",
        "at_once");
    bad(API_CLASS_HANDIN, 422,
        "{\"answers\":[{\"step\":\"a\",\"value\":1,\"tries\":[1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,"
        "1,1,1]}]}",
        "/answers/0/tries", "at most 20");
    bad(API_CLASS_HANDIN, 422, "{\"answers\":[{\"step\":\"a\",\"value\":1,\"tries\":[null]}]}",
        "/answers/0/tries/0", "a number or a text");
    bad(API_CLASS_OWN_STAGE, 422, "{\"state\":\"asleep\"}", "/state", "working");
    bad(API_CLASS_OWN_STAGE, 422, "{\"idle\":-1}", "/idle", "0");
    bad(API_CLASS_OWN_STAGE, 422, "{\"idle\":2592001}", "/idle", "2592000");
    bad(API_CLASS_QUESTION, 422, "{\"text\":\"?\"}", "/kind", "");
    bad(API_CLASS_QUESTION, 422, "{\"text\":\"?\",\"kind\":\"choice\"}", "/choices", "2 to 12");
    bad(API_CLASS_QUESTION, 422, "{\"text\":\"?\",\"kind\":\"text\",\"choices\":[\"a\",\"b\"]}",
        "/choices", "choice");
    bad(API_CLASS_ANSWER, 422, "{\"value\":[1]}", "/value", "a number or a text");
    bad(API_CLASS_WORKSHEET, 422, "{\"title\":\"T\",\"steps\":[]}", "/steps", "1 to 50");
    bad(API_CLASS_WORKSHEET, 422, "{\"title\":\"T\",\"steps\":[{\"id\":\"a\"},{\"id\":\"a\"}]}",
        "/steps/1/id", "earlier");
    bad(API_CLASS_WORKSHEET, 422,
        "{\"title\":\"T\",\"steps\":[{\"id\":\"a\",\"needs\":\"right\"}]}", "/steps/0/needs",
        "question");
    bad(API_CLASS_WORKSHEET, 422,
        "{\"title\":\"T\",\"steps\":[{\"id\":\"a\",\"hidden_until\":\"b\"},{\"id\":\"b\"}]}",
        "/steps/0/hidden_until", "earlier");
    bad(API_CLASS_WORKSHEET, 422,
        "{\"title\":\"T\",\"steps\":[{\"id\":\"a\",\"question\":{\"kind\":\"number\",\"value\":"
        "\"two\"}}]}",
        "/steps/0/question/value", "an answer to the question");
    bad(API_CLASS_HANDIN, 422, "{\"answers\":[{\"step\":\"A\",\"value\":1}]}", "/answers/0/step",
        "a-z");
}

/* larger than its kind allows: before it is read, or once its size without blanks is known */
TEST(what_is_too_large_for_a_room_is_refused) {
    static char text[1 << 17];
    memset(text, ' ', sizeof text - 1);
    memcpy(text, "{\"nickname\":\"Ada\"}", 18);
    bad(API_CLASS_PUPIL, 413, text, NULL, "at most 1024 bytes");
    int bytes = snprintf(text, sizeof text,
                         "{\"scene\":{\"request\":{\"pendulum\":{\"length\":[1],\"mass\":[1],"
                         "\"parent\":[0]},\"times\":[0,1]},\"view\":{\"v\":\"");
    memset(text + bytes, 'v', 9000);
    snprintf(text + bytes + 9000, 8, "\"}}}");
    bad(API_CLASS_OWN_STAGE, 413, text, NULL, "at most 8192 bytes without blanks");
}

TEST(an_answer_fits_the_kind_of_its_question) {
    static const char *const question[] = {
        "{\"text\":\"?\",\"kind\":\"number\",\"unit\":\"s\"}",
        "{\"text\":\"?\",\"kind\":\"choice\",\"choices\":[\"a\",\"b\",\"c\"]}",
        "{\"text\":\"?\",\"kind\":\"angle\",\"closed\":true}",
        "{\"text\":\"?\",\"kind\":\"text\"}"};
    static const char *const answer[] = {"{\"value\":3}", "{\"value\":4}", "{\"value\":2.5}",
                                         "{\"value\":-1}", "{\"value\":\"3\"}"};
    static const int fit[4][5] = {
        {1, 1, 1, 1, 0}, {1, 0, 0, 0, 0}, {1, 1, 1, 1, 0}, {0, 0, 0, 0, 1}};
    for (int i = 0; i < 4; i++) {
        int64_t wanted = good(API_CLASS_QUESTION, question[i], NULL).flag;
        CHECK_INT(wanted & 1, i == 2);
        for (int k = 0; k < 5; k++) {
            int64_t given = good(API_CLASS_ANSWER, answer[k], NULL).flag;
            CHECK_INT(given & 1, 0);
            CHECK_INT(api_class_fits(wanted, given), fit[i][k]);
        }
    }
}

TEST(a_room_is_told) {
    const struct api_class_room room = {.code = "ABCDE",
                                        .role = "pupil",
                                        .pupil = 3,
                                        .created = 1769851800125000,
                                        .ends = 1769855400125000,
                                        .version = 7,
                                        .pupils = 4,
                                        .shut = 1};
    const struct api_class_item item = {"answers/q/3", 7, 1769851800125000, "{\"value\":1}", 11},
                                gone = {"stages/3", 8, 1769851800125000, "", 0};
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 4096);
    CHECK_INT(api_class_room_write(&room, &out), PEND_OK);
    CHECK_INT(api_buffer_text(&out, ",\"items\":["), PEND_OK);
    CHECK_INT(api_class_item_write(&item, &out), PEND_OK);
    CHECK_INT(api_class_item_write(&gone, &out), PEND_OK);
    CHECK_INT(api_buffer_add(&out, "]}", 3), PEND_OK);
    CHECK_TEXT(out.data,
               "{\"code\":\"ABCDE\",\"role\":\"pupil\",\"pupil\":3,\"created\":"
               "\"2026-01-31T09:30:00.125Z\",\"ends\":\"2026-01-31T10:30:00.125Z\",\"version\":7,"
               "\"pupils\":4,\"open\":false,\"links\":{\"self\":\"/v1/classes/ABCDE\"},\"items\":[{"
               "\"name\":\"answers/q/3\",\"version\":7,\"changed\":\"2026-01-31T09:30:00.125Z\","
               "\"value\":{\"value\":1}},{\"name\":\"stages/3\",\"version\":8,\"changed\":"
               "\"2026-01-31T09:30:00.125Z\",\"value\":null}]}");
}
