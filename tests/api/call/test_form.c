/* Tests of requests that are sent as a form of files: the result is that of the same request as
 * JSON; malformed forms are refused at their byte.
 * Leaves to others: tables (api/op/test_op_fits), bytes that nobody would send (fuzz_fields), how a
 * client sends a form (wire).
 * Invariant: forms are written here line by line, without code of the reader. */
#include "api/call/form.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/part.h"
#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TYPE "multipart/form-data; boundary=AaB03x"
#define PART(name) "--AaB03x\r\nContent-Disposition: form-data; name=\"" name "\"\r\n\r\n"
#define FILE_PART(file)                                                                            \
    "--AaB03x\r\ncontent-disposition:form-data; filename=\"" file "\"; name=csv\r\n"               \
    "Content-Type: text/csv\r\n\r\n"
#define END "--AaB03x--\r\n"
#define REQUEST(data)                                                                              \
    "{\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1},{\"vary\":"     \
    "\"thetad\",\"arm\":1}],"                                                                      \
    "\"data\":" data ",\"pendulum\":{\"length\":[0.9],\"mass\":[1],\"parent\":[0]}}"
#define TABLE "t,theta_1 (deg)\r\n0,20\r\n0.2,16.6\r\n0.4,7.7\r\n0.6,-3.3\r\n"
#define TABLE_JSON "t,theta_1 (deg)\\n0,20\\n0.2,16.6\\n0.4,7.7\\n0.6,-3.3\\n"

static struct test_reply post_form(const char *type, const char *body, size_t bytes) {
    struct api_request request = {
        .op = API_OP_FITS, .content_type = type, .body = body, .body_bytes = bytes};
    return test_send(&request, NULL);
}

/* the JSON of a form; the caller clears the buffer */
static enum pend_status form_json(const char *body, size_t bytes, struct api_buffer *out,
                                  struct api_problem *problem) {
    struct api_limits limits;
    api_limits_init(&limits);
    api_problem_init(problem);
    api_buffer_init(out, 1 << 20);
    return api_form_json(TYPE, body, bytes, &limits, out, problem);
}

static void check_json(const char *body, const char *json) {
    OWN(api_buffer, clear) out;
    OWN(api_problem, clear) problem;
    CHECK(form_json(body, strlen(body), &out, &problem) == PEND_OK);
    CHECK_SAYING(out.bytes == strlen(json) && !memcmp(out.data, json, out.bytes), "%.*s",
                 (int)out.bytes, out.bytes ? out.data : "");
}

TEST(forms_are_the_request_with_its_tables) {
    check_json(PART("request") "{\"data\":{\"sigma\":2}}\r\n" FILE_PART("a.csv") "t,x\r\n\"1\",2"
                                                                                 "\r\n" END,
               "{\"data\":{\"sigma\":2,\"csv\":\"t,x\\r\\n\\\"1\\\",2\"}}");
    // in any order, without `data`, with a byte order mark, an empty line at the end and a comment
    check_json(
        FILE_PART("C:\\\\a \\\"b\\\".csv") "\xef\xbb\xbft\n# \xc2\xb0\n\r\n--AaB03x \t\r\nContent-"
                                           "Disposition: form-data; name=request\r\n\r\n{}"
                                           "\r\n" END "\r\n",
        "{\"data\":{\"csv\":\"t\\n# \xc2\xb0\\n\"}}");
    // bytes that are not UTF-8 are Latin 1
    check_json(PART("csv") "t,theta_1 (\xb0)\r\n" PART("request") "{}\r\n" END,
               "{\"data\":{\"csv\":\"t,theta_1 (\xc2\xb0)\"}}");
    // no table, an empty one, and text that only looks like a boundary
    check_json(PART("request") "[1]\r\n" END, "[1]");
    check_json(PART("request") "{}\r\n" PART("csv") END, "{\"data\":{\"csv\":\"\"}}");
    check_json(PART("request") "{}\r\n" PART("csv") "x--AaB03x\r\n-AaB03x\n--AaB03x\r\n" END,
               "{\"data\":{\"csv\":\"x--AaB03x\\r\\n-AaB03x\\n--AaB03x\"}}");
    // a table for each run
    check_json(PART("request") "{\"data\":{\"runs\":[{\"start\":1},{}],\"modes\":[1]},\"a\":null}"
                               "\r\n" PART("csv") "b\r\n" PART("csv") "c\r\n" END,
               "{\"a\":null,\"data\":{\"runs\":[{\"start\":1,\"csv\":\"b\"},{\"csv\":\"c\"}],"
               "\"modes\":[1]}}");
}

TEST(forms_are_answered_as_the_same_request_is) {
    static const char form[] =
        PART("request") REQUEST("{\"sigma\":0.5}") "\r\n" FILE_PART("a") TABLE "\r\n" END;
    struct test_reply told = test_post(API_OP_FITS,
                                       REQUEST("{\"sigma\":0.5,\"csv\":\"" TABLE_JSON "\"}")),
                      asked = post_form(TYPE, form, strlen(form));
    CHECK_INT(asked.status, 200);
    CHECK_TEXT(test_reply_text(&asked, "/status"), "converged");
    CHECK(asked.out.bytes == told.out.bytes);
    CHECK(test_reply_number(&asked, "/unknowns/0/value") ==
          test_reply_number(&told, "/unknowns/0/value"));
    test_reply_free(&asked);
    test_reply_free(&told);
    // an operation that accepts none
    struct api_request request = {
        .op = API_OP_MODES, .content_type = TYPE, .body = form, .body_bytes = strlen(form)};
    told = test_send(&request, NULL);
    CHECK_INT(told.status, 415);
    test_reply_free(&told);
    told = post_form("multipart/mixed; boundary=AaB03x", form, strlen(form));
    CHECK_INT(told.status, 415);
    CHECK(strstr(test_reply_text(&told, "/detail"), "or multipart/form-data"));
    test_reply_free(&told);
    told = post_form("Multipart/Form-Data; charset=x; Boundary=\"AaB03x\"", form, strlen(form));
    CHECK_INT(told.status, 200);
    test_reply_free(&told);
}

/* a job stores the request as JSON, which the next process reads */
TEST(forms_become_json_as_jobs) {
    static const char form[] =
        PART("request") REQUEST("{\"sigma\":0.5}") "\r\n" PART("csv") TABLE "\r\n" END;
    struct api_request request = {
        .op = API_OP_FITS, .content_type = TYPE, .body = form, .body_bytes = strlen(form)};
    struct api_limits limits;
    struct api_plan plan;
    OWN(api_buffer, clear) body, out;
    api_limits_init(&limits);
    api_buffer_init(&body, 2 * strlen(form));
    api_buffer_init(&out, 1 << 16);
    CHECK_INT(api_plan_read(&plan, &request, &limits, 1, &body, &out), 0);
    CHECK(!api_buffer_text(&body, "") && body.bytes && body.data[0] == '{');
    CHECK(memmem(body.data, body.bytes, "\"csv\":\"t,theta_1 (deg)\\r\\n0,20\\r\\n", 33));
}

/* its size as JSON is limited by that of bodies; the refusal differs from those of other limits */
TEST(forms_that_grow_beyond_the_limit_are_refused) {
    static const char form[] = PART("request")
        REQUEST("{\"sigma\":0.5,\"more\":[1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,"
                "1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,"
                "1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,"
                "1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,"
                "1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20,1e20]}") "\r\n" PART("csv")
            TABLE "\r\n" END;
    struct api_request request = {
        .op = API_OP_FITS, .content_type = TYPE, .body = form, .body_bytes = strlen(form)};
    struct api_limits limits;
    struct api_plan plan;
    OWN(api_buffer, clear) body, out;
    api_limits_init(&limits);
    limits.body_bytes = (double)strlen(form);
    api_buffer_init(&body, 1 << 16);
    api_buffer_init(&out, 1 << 16);
    CHECK_INT(api_plan_read(&plan, &request, &limits, 1, &body, &out), 422);
    CHECK(memmem(out.data, out.bytes, "bytes of JSON", 13));
}

TEST(forms_are_refused_where_they_are_malformed) {
#define ONE_TABLE PART("csv") "t\r\n"
    static const struct {
        const char *body;
        int status;
        const char *says;
    } tried[] = {
        {"", 400, "byte 1 of the body: the body must start with the boundary"},
        {"--AaB03", 400, "byte 1 of the body"},
        {"--AaB03x", 400, "byte 9 of the body: a boundary line must end here"},
        {"\r\n" PART("request") "{}\r\n" END, 400, "byte 1 of the body"},
        {PART("request") "{}", 400, "no closing boundary"},
        {PART("request") "{}\n--AaB03x--", 400, "no closing boundary"},
        {PART("request") "{}\r\n--AaB03xy\r\n" END, 400, "a boundary line must end here"},
        {PART("request") "{}\r\n--AaB03x--\r\nmore", 400, "nothing may follow the last boundary"},
        {"--AaB03x\r\nContent-Disposition: form-data; name=request\r\n{}\r\n" END, 400,
         "is not a header field"},
        {"--AaB03x\r\n\r\n{}\r\n" END, 400, "Content-Disposition: form-data with a name"},
        {"--AaB03x\r\nContent-Disposition: form-data\r\n\r\n{}\r\n" END, 400, "with a name"},
        {"--AaB03x\r\nContent-Disposition: attachment; name=csv\r\n\r\n{}\r\n" END, 400,
         "is not form-data"},
        {"--AaB03x\r\nContent-Disposition: form-data; name=csv\r\nContent-Disposition: form-data; "
         "name=csv\r\n\r\n{}\r\n" END,
         400, "a second"},
        {"--AaB03x\r\nContent-Transfer-Encoding: base64\r\n\r\n" END, 400, "send parts unencoded"},
        {END, 422, "no part named request"},
        {PART("request") "{}\r\n" PART("request") "{}\r\n" END, 422, "two parts named request"},
        {PART("request") "{}\r\n" PART("cvs") "{}\r\n" END, 422, "an unknown part \"cvs\""},
        {PART("request") "{\r\n" ONE_TABLE END, 400, "not JSON"},
        {PART("request") "{}\r\n" PART("csv") "t\1\r\n" END, 422, "byte 2 of part csv number 1"},
        {PART("csv") "PK\3\4\r\n" END, 422,
         "csv number 1 is an archive: save a spreadsheet as CSV"},
        {PART("csv") "\xd0\xcf\x11\xe0\r\n" END, 422, "csv number 1 is an Excel file"},
        {PART("csv") "MATLAB 5.0 MAT-file\r\n" END, 422, "writematrix"},
        {PART("csv") "\x93NUMPY\r\n" END, 422, "numpy.savetxt"},
    };
    for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
        OWN(test_reply, free) reply = post_form(TYPE, tried[i].body, strlen(tried[i].body));
        const char *detail = test_reply_text(&reply, "/detail");
        CHECK_SAYING(reply.status == tried[i].status && strstr(detail, tried[i].says), "%zu: %d %s",
                     i, reply.status, detail);
    }
    static const struct {
        const char *body, *pointer, *says;
    } faulty[] = {
        {ONE_TABLE END, "/pendulum", "is missing"},
        {PART("request") "[]\r\n" ONE_TABLE END, "", "object"},
        {PART("request") "{\"data\":1}\r\n" ONE_TABLE END, "/data", "object"},
        {PART("request") "{\"data\":{\"csv\":\"\"}}\r\n" ONE_TABLE END, "/data/csv", "leave one"},
        {PART("request") "{}\r\n" ONE_TABLE ONE_TABLE END, "/data/runs", "2 objects"},
        {PART("request") "{\"data\":{\"runs\":[{}]}}\r\n" ONE_TABLE ONE_TABLE END, "/data/runs",
         "2 objects"},
        {PART("request") "{\"data\":{\"runs\":[{},3]}}\r\n" ONE_TABLE ONE_TABLE END, "/data/runs",
         "2 objects"},
        {PART("request") "{\"data\":{\"runs\":[{},{\"csv\":1}]}}\r\n" ONE_TABLE ONE_TABLE END,
         "/data/runs/1/csv", "leave one"},
        {PART("request") REQUEST("{}") "\r\n" PART("csv") "t,theta_1\r\n0,NaN\r\n" END, "/data/csv",
         "has no number"},
    };
    for (size_t i = 0; i < sizeof faulty / sizeof *faulty; i++) {
        OWN(test_reply, free) reply = post_form(TYPE, faulty[i].body, strlen(faulty[i].body));
        CHECK_INT(reply.status, 422);
        CHECK_SAYING(test_reply_has_fault(&reply, faulty[i].pointer, faulty[i].says), "%zu: %s", i,
                     reply.out.data);
    }
}

TEST(forms_need_a_boundary) {
    static const char *const types[] = {
        "multipart/form-data",
        "multipart/form-data; boundary=", "multipart/form-data; boundary=\"a \"",
        "multipart/form-data; boundary=a\"b",
        ("multipart/form-data; boundary="
         "12345678901234567890123456789012345678901234567890123456789012345678901")};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        OWN(test_reply, free) reply = post_form(types[i], END, strlen(END));
        CHECK_INT(reply.status, 400);
        CHECK_SAYING(strstr(test_reply_text(&reply, "/detail"), "boundary of 1 to 70"), "%s",
                     types[i]);
    }
}

/* 65 tables, the head of a part that does not end, and a body that is larger as JSON */
TEST(forms_are_bounded) {
    static char body[80000];
    char *at = body + sprintf(body, PART("request") "{}\r\n");
    for (int i = 0; i <= API_FORM_TABLES; i++) at += sprintf(at, ONE_TABLE);
    sprintf(at, END);
    OWN(test_reply, free) reply = post_form(TYPE, body, strlen(body));
    CHECK_INT(reply.status, 422);
    CHECK(strstr(test_reply_text(&reply, "/detail"), "more than 64 parts named csv"));
    test_reply_free(&reply);
    at = body + sprintf(body, "--AaB03x\r\n");
    memset(at, ':', 70000), at[70000] = 0;
    reply = post_form(TYPE, body, strlen(body));
    CHECK_INT(reply.status, 400);
    CHECK(strstr(test_reply_text(&reply, "/detail"), "begins with a few header lines"));
    test_reply_free(&reply);
    struct api_limits limits;
    api_limits_init(&limits);
    at = body + sprintf(body, PART("request") REQUEST("{\"sigma\":1}") "\r\n" PART("csv"));
    memset(at, '\n', 5000);
    sprintf(at + 5000, TABLE "\r\n" END);
    limits.body_bytes = (double)strlen(body);
    struct api_request request = {
        .op = API_OP_FITS, .content_type = TYPE, .body = body, .body_bytes = strlen(body)};
    reply = test_send(&request, &limits);
    // names of columns are in the first lines
    CHECK(test_reply_has_fault(&reply, "/data/csv", "no row of two or more"));
}

/* a table that a spreadsheet saves as "Unicode text": both byte orders, and a letter of each
 * length */
TEST(forms_take_tables_in_utf16) {
    static const char *const letters =
        "t\tWinkel \316\270 \342\200\211(deg)\n0\t10\n0.5\t-1\n1\t-9\n1.5\t2\n";
    for (int low = 0; low < 2; low++) {
        char body[1000];
        int at = sprintf(body, PART("request") REQUEST("{}") "\r\n" PART("csv"));
        at += sprintf(body + at, "%s", low ? "\xff\xfe" : "\xfe\xff");
        for (const unsigned char *c = (const unsigned char *)letters; *c;) {
            unsigned code = *c < 0x80   ? *c
                            : *c < 0xe0 ? (c[0] & 31U) << 6 | (c[1] & 63U)
                                        : (c[0] & 15U) << 12 | (c[1] & 63U) << 6 | (c[2] & 63U);
            c += *c < 0x80 ? 1 : *c < 0xe0 ? 2 : 3;
            body[at++] = (char)(low ? code : code >> 8),
            body[at++] = (char)(low ? code >> 8 : code);
        }
        int end = sprintf(body + at, "\r\n" END);
        OWN(test_reply, free) reply = post_form(TYPE, body, (size_t)(at + end));
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/1/is"), "theta 1");
        CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/1/name"),
                   "Winkel \316\270 \342\200\211(deg)");
    }
}

TEST(forms_survive_without_memory) {
    static const char body[] =
        PART("request") "{\"data\":{\"runs\":[{},{}]}}\r\n" ONE_TABLE PART("csv") "\xb0\r\n" END;
    for (long count = 1, over = 0; !over; count++) {
        OWN(api_buffer, clear) out;
        OWN(api_problem, clear) problem;
        test_alloc_fail(count, 1);
        enum pend_status status = form_json(body, strlen(body), &out, &problem);
        test_alloc_faults_off();
        over = status == PEND_OK;
        CHECK(over || status == PEND_NO_MEMORY || problem.status == 503);
        CHECK(count < 1000);
    }
}
