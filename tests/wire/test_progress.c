/* The progress that a job reports while it runs: the finished parts, and the remaining time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/place.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ROWS "30" /* everything takes longer */
#else
#define ROWS "150"
#endif
#define LONG_MAP                                                                                   \
    "{\"pendulum\":" ASK_DOUBLE                                                                    \
    ",\"duration\":20,\"rtol\":1e-9,\"observables\":[\"final\"],\"grid\":["                        \
    "{\"vary\":\"theta\",\"arm\":1,\"start\":0.5,\"stop\":2.5,\"count\":" ROWS "},"                \
    "{\"vary\":\"theta\",\"arm\":2,\"start\":0.5,\"stop\":2.5,\"count\":150}]}"

enum { MOST_LOOKS = 4000 };

/* a job's report at an instant; left is NAN if it was missing */
struct look {
    double at, progress, left;
    char word[WORDS];
};

static double look_number(const cJSON *json, const char *name) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static int look_take(const struct test_server *server, const char *id, struct look *look) {
    OWN(test_reply, clear) reply;
    int status = job_get(server, &reply, id, "", "");
    look->at = test_clock();
    if (status == 200) {
        cJSON *json = ask_json(&reply);
        const char *word = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "status"));
        snprintf(look->word, WORDS, "%s", word ? word : "");
        look->progress = look_number(json, "progress");
        look->left = look_number(json, "remaining_seconds");
        cJSON_Delete(json);
    }
    return status == 200 && (!strcmp(look->word, "accepted") || !strcmp(look->word, "running"));
}

static int by_size(const void *one, const void *two) {
    double a = *(const double *)one, b = *(const double *)two;
    return (a > b) - (a < b);
}

/* checks the reports: the remaining time as a multiple of the true one; the median over the middle
 * of a job, and whether it decreases. A busy machine changes its pace, so the bounds are wide, but
 * on both sides */
static int looks_good(const struct look look[], int count) {
    static double ratio[MOST_LOOKS];
    const struct look *first = NULL, *last = NULL;
    int ratios = 0;
    for (int i = 0; i < count; i++) {
        if (i) CHECK(look[i].progress >= look[i - 1].progress);
        if (!strcmp(look[i].word, "accepted")) CHECK(isnan(look[i].left) && look[i].progress == 0);
        if (isnan(look[i].left)) continue;
        CHECK(look[i].left >= 0 && look[i].progress < 100);
        last = &look[i];
        if (look[i].progress < 20 || look[i].progress > 80) continue;
        ratio[ratios++] = (look[count - 1].at - look[i].at) / look[i].left;
        first = first ? first : &look[i];
    }
    if (ratios < 5 || last->at <= first->at) return 0;
    qsort(ratio, (size_t)ratios, sizeof *ratio, by_size);
    printf("  it took %.2f times what it said, %d times; from %.2f s at %.0f %% to %.2f s at %.0f "
           "%%\n",
           ratio[ratios / 2], ratios, first->left, first->progress, last->left, last->progress);
    return ratio[ratios / 2] > 0.2 && ratio[ratios / 2] < 5 && last->left < 0.7 * first->left;
}

/* one job, read while it runs; returns whether its reports were right */
static int progress_of(const struct test_server *server) {
    static struct look look[MOST_LOOKS];
    char id[ID + 1];
    int count = 0;
    CHECK_INT(submit(server, "/v1/ensembles", ASYNC, LONG_MAP, id), 202);
    while (count < MOST_LOOKS - 1 && look_take(server, id, &look[count])) {
        count++;
        test_sleep(0.015);
    }
    CHECK_TEXT(look[count].word, "successful");
    /* nothing remains in the end, and nothing is reported */
    CHECK(look[count].progress == 100 && isnan(look[count].left));
    return looks_good(look, count + 1);
}

/* a machine whose pace changes in the middle of a job makes its reports wrong: then another one is
 * tried */
static void progress(struct place *place) {
    int good = 0;
    OWN(test_server, stop) *server = place_serve(place, "all", "0.05", "--workers", "2");
    for (int i = 0; i < 6 && server && !good; i++) good = progress_of(server);
    CHECK_SAYING(good, "jobs do not keep what they say");
}

TEST(a_job_says_how_long_it_will_take_and_means_it) { place_on_both(progress); }
