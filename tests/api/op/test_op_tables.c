/* Tests of the interpretation of tables: the roles of columns, suggestions, and names in a request
 * that override them.
 * Leaves to others: shapes of tables (csv/test_csv_roles), fits (fit/test_fits_data).
 * Invariant: numbers are made up here. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

TEST(a_table_is_looked_at_without_a_pendulum) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TABLES, "{\"data\":{\"csv\":\"t;x_m2;y_m2;x_m1;r\\n0,5;1;2;;4\\n1,5;2;3;4;5\\n"
                       "1,5;2;3;4;5\\nend\\n\"}}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/rows"), 2);
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/repeated"), 1);
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/passed_over"), 1);
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/separator"), ";");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/decimal"), ",");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/1/is"), "x 2");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/3/is"), "x 1");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/4/is"), "");
    CHECK(test_reply_number(&reply, "/tables/0/first/0/0") == 0.5);
    CHECK(isnan(test_reply_number(&reply, "/tables/0/first/0/3")));
    CHECK_INT(test_reply_count(&reply, "/tables/0/first"), 3);
}

TEST(tables_of_several_runs_are_looked_at_and_a_fit_s_request_may_be_sent) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TABLES,
        "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"unknowns\":[{\"vary\":"
        "\"length\",\"arm\":1}],\"data\":{\"runs\":[{\"csv\":\"t,theta\\n0,1\\n\"},{\"csv\":"
        "\"t,theta\\n0,1\\n\",\"unit\":\"deg\"}]}}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK(test_reply_number(&reply, "/tables/0/columns/1/unit") == 1);
    CHECK(fabs(test_reply_number(&reply, "/tables/1/columns/1/unit") - 0.0174532925) < 1e-9);
}

TEST(what_is_missing_is_suggested_and_may_be_named) {
#define TABLE "\"csv\":\"a,b\\n3,1\\n2,2\\n1,1\\n\""
    struct test_reply reply = test_post(API_OP_TABLES, "{\"data\":{" TABLE "}}");
    const char *said = test_reply_text(&reply, "/tables/0/suggestions/0");
    CHECK(said && strstr(said, "no column of times"));
    said = test_reply_text(&reply, "/tables/0/suggestions/1");
    CHECK(said && strstr(said, "no column of angles or positions"));
    test_reply_free(&reply);
    reply = test_post(API_OP_TABLES,
                      "{\"data\":{" TABLE ",\"columns\":[\"t (ms)\",\"thetad_1 (deg/s)\"]}}");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/0/is"), "t");
    CHECK(test_reply_number(&reply, "/tables/0/columns/0/unit") == 1e-3);
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/1/is"), "thetad 1");
    said = test_reply_text(&reply, "/tables/0/suggestions/0");
    CHECK(said && strstr(said, "not in order"));
    CHECK_INT(test_reply_count(&reply, "/tables/0/suggestions"), 1);
    test_reply_free(&reply);
    static const struct {
        const char *columns, *pointer, *says;
    } refused[] = {
        {"[\"t\",\"colour\"]", "/data/columns/1", "does not name a quantity"},
        {"[\"t\",\"theta 1\",\"x 1\"]", "/data/columns/2", "after the table's last"},
        {"[\"theta 1\",\"theta 1\"]", "/data/columns/1", "the same quantity of this arm"},
        {"[\"t\",4]", "/data/columns/1", "does not name a quantity"},
        {"\"t\"", "/data/columns", "an array"},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        char body[200];
        snprintf(body, sizeof body, "{\"data\":{" TABLE ",\"columns\":%s}}", refused[i].columns);
        CHECK_REFUSED(API_OP_TABLES, body, refused[i].pointer, refused[i].says);
    }
    CHECK_REFUSED(API_OP_TABLES, "{\"data\":{}}", "/data/csv", "a table as text");
    CHECK_REFUSED(API_OP_TABLES, "{}", "/data", "is missing");
    CHECK_REFUSED(API_OP_TABLES, "{\"data\":{\"runs\":[]}}", "/data/runs", "1 to 32 runs");
}

/* 12 swings, measured from the horizontal in degrees, and by a camera with y downwards */
TEST(a_zero_elsewhere_and_y_downwards_are_suggested_before_a_fit) {
    for (int kind = 0; kind < 4; kind++) {
        char body[8000], *at = body;
        at += sprintf(at, "{\"data\":{\"csv\":\"%s", kind < 2 ? "t,theta (deg)" : "t,x,y");
        for (int i = 0; i < 120; i++) {
            double angle = 0.3 * cos(0.6 * i), x = 300 + 500 * sin(angle), y = 500 * cos(angle);
            if (kind < 2)
                at += sprintf(at, "\\n%g,%.4f", 0.1 * i, (kind ? 90 : 0) + 57.3 * angle);
            else
                at += sprintf(at, "\\n%g,%.3f,%.3f", 0.1 * i, x, kind == 3 ? y : -y);
        }
        sprintf(at, "\\n\"}}");
        OWN(test_reply, free) reply = test_post(API_OP_TABLES, body);
        const char *said = test_reply_text(&reply, "/tables/0/suggestions/0");
        CHECK_INT(test_reply_count(&reply, "/tables/0/suggestions"), kind & 1);
        if (kind == 1) CHECK(said && strstr(said, "swing about 9") && strstr(said, "\"zero\""));
        if (kind == 3) CHECK(said && strstr(said, "\"down\": true"));
    }
}

/* the returned data are in the form that a fit accepts: in rad and s, repeated rows once, weighted
 * rows */
TEST(a_table_s_measurements_are_answered_as_a_fit_takes_them) {
    struct test_reply reply = test_post(
        API_OP_TABLES,
        "{\"include\":[\"data\"],\"data\":{\"csv\":\"t (ms);theta_1 (deg);sigma_theta_1;x_1 "
        "(cm);r\\n0;90;;2;1\\n0;90;;2;1\\n100;45;0,5;3;2\\n\"}}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK_INT(test_reply_count(&reply, "/tables/0/data/t"), 2);
    CHECK(fabs(test_reply_number(&reply, "/tables/0/data/t/1") - 0.1) < 1e-15);
    CHECK_INT(test_reply_count(&reply, "/tables/0/data/series"), 2);
    CHECK(test_reply_number(&reply, "/tables/0/data/series/0/theta") == 1);
    CHECK(isnan(test_reply_number(&reply, "/tables/0/data/series/0/values/0")));
    CHECK(fabs(test_reply_number(&reply, "/tables/0/data/series/0/values/1") - 0.78539816) < 1e-8);
    CHECK(test_reply_number(&reply, "/tables/0/data/series/0/sigma/0") == 1);
    CHECK(fabs(test_reply_number(&reply, "/tables/0/data/series/0/sigma/1") - 0.0087266) < 1e-6);
    CHECK(test_reply_number(&reply, "/tables/0/data/series/1/x") == 1);
    CHECK(test_reply_number(&reply, "/tables/0/data/series/1/values/1") == 3);
    test_reply_free(&reply);
    static const char *const unfit[] = {"t,theta_1\\n0,1\\n1,wet\\n2,3",
                                        "t,theta_1\\n0,1\\n,2\\n2,3"};
    static const char *const says[] = {"line 3: field 2 must", "line 3: t must"};
    for (int i = 0; i < 2; i++) {
        char body[200];
        snprintf(body, sizeof body, "{\"include\":[\"data\"],\"data\":{\"csv\":\"%s\"}}", unfit[i]);
        reply = test_post(API_OP_TABLES, body);
        const char *said = test_reply_text(&reply, "/tables/0/suggestions/0");
        CHECK_SAYING(said && strstr(said, says[i]), "%s", reply.out.data);
        CHECK_INT(test_reply_count(&reply, "/tables/0/data/t"), -1);
        test_reply_free(&reply);
    }
    CHECK_REFUSED(API_OP_TABLES, "{\"include\":[\"rows\"],\"data\":{\"csv\":\"t,x\\n0,1\\n1,2\"}}",
                  "/include/0", "data");
}
