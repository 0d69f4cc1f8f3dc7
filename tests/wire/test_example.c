#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/wire/ask.h"

enum { ARMS = 4, ROWS = 51, COLUMNS = 1 + 3 * ARMS };

/* reads the reference rows: t, phi, phi', lambda at every 0.1 s */
static int golden(double row[ROWS][COLUMNS]) {
    FILE *file = fopen("tests/golden/paper_example.txt", "r");
    char line[2048];
    int rows = 0;
    while (file && rows < ROWS && fgets(line, sizeof line, file)) {
        if (line[0] == '#') continue;
        int at = 0, used;
        for (int k = 0; k < COLUMNS && sscanf(line + at, "%lf%n", &row[rows][k], &used) == 1; k++)
            at += used;
        rows++;
    }
    if (file) fclose(file);
    return rows == ROWS;
}

/* the largest difference of one quantity over all rows, and the largest value */
static double worst(const cJSON *answer, const char *name, double row[ROWS][COLUMNS], int first,
                    double *largest) {
    const cJSON *rows = cJSON_GetObjectItemCaseSensitive(answer, name);
    double difference = 0;
    *largest = 0;
    for (int i = 0; i < ROWS; i++)
        for (int k = 0; k < ARMS; k++) {
            double got = ask_at(rows, 10 * i, k), want = row[i][first + k];
            difference = fmax(difference, isnan(got) ? INFINITY : fabs(got - want));
            *largest = fmax(*largest, fabs(want));
        }
    return difference;
}

TEST(paper_example_over_http_agrees_with_the_reference_at_all_its_instants) {
    static double row[ROWS][COLUMNS];
    static const char *const name[] = {"phi", "phid", "lambda"};
    static const double tolerance[] = {2e-10, 5e-10, 8e-10};
    OWN(test_reply, clear) reply = {0};
    REQUIRE(golden(row));
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    CHECK_INT(ask(server, &reply, "/v1/trajectories", ASK_EXAMPLE), 200);
    cJSON *answer = ask_json(&reply);
    const cJSON *t = cJSON_GetObjectItemCaseSensitive(answer, "t");
    CHECK_INT(cJSON_GetArraySize(t), 501);
    for (int i = 0; i < ROWS && answer; i++) {
        const cJSON *instant = cJSON_GetArrayItem(t, 10 * i);
        CHECK(instant && instant->valuedouble == row[i][0]);
    }
    for (int i = 0; i < 3; i++) {
        double largest, difference = worst(answer, name[i], row, 1 + i * ARMS, &largest);
        CHECK_INT(cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(answer, name[i])), 501);
        CHECK_SAYING(difference < 1e-9, "%s is off by %.3e", name[i], difference);
        CHECK_RESIDUAL(difference, tolerance[i], name[i]);
        CHECK(largest > 1);
    }
    cJSON_Delete(answer);
}

TEST(paper_example_comes_bit_for_bit_the_same_twice) {
    OWN(test_reply, clear) first = {0}, second = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    ask(server, &first, "/v1/trajectories", ASK_EXAMPLE);
    ask(server, &second, "/v1/trajectories", ASK_EXAMPLE);
    /* everything except the computing time */
    char *end_first = strstr(first.body, "\"stats\""),
         *end_second = strstr(second.body, "\"stats\"");
    CHECK(end_first && end_second && end_first - first.body == end_second - second.body);
    CHECK(end_first && end_second &&
          !memcmp(first.body, second.body, (size_t)(end_first - first.body)));
}

TEST(ode23_with_its_defaults_is_as_far_off_as_matlab_is) {
    static double row[ROWS][COLUMNS];
    OWN(test_reply, clear) reply = {0};
    REQUIRE(golden(row));
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    CHECK_INT(ask(server, &reply, "/v1/trajectories",
                  "{\"pendulum\":" ASK_FOUR_ARMS
                  ",\"times\":{\"start\":0,\"stop\":5,\"step\":0.01},"
                  "\"method\":\"ode23\",\"output\":[\"phi\"]}"),
              200);
    cJSON *answer = ask_json(&reply);
    const cJSON *phi = cJSON_GetObjectItemCaseSensitive(answer, "phi");
    double off = 0;
    for (int k = 0; k < ARMS; k++) off = fmax(off, fabs(ask_at(phi, 500, k) - row[50][1 + k]));
    CHECK_SAYING(off > 0.02 && off < 0.5, "at t = 5 phi is off by %.3f", off);
    cJSON_Delete(answer);
}
