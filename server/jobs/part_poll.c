#include "server/jobs/part_poll.h"

#include <stdlib.h>
#include <string.h>

static enum srv_stored survey_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_survey *survey = (struct srv_survey *)call;
    enum srv_stored stored = SRV_STORED;
    for (int i = 0; i < survey->count && stored < SRV_STORED_FULL; i++) {
        struct srv_job job;
        stored = srv_store_job(store, survey->job[i].id, &job);
        survey->job[i].ended = stored == SRV_STORED_NONE || (stored == SRV_STORED && job.state > SRV_JOB_RUNNING);
    }
    return stored < SRV_STORED_FULL ? SRV_STORED : stored;
}

struct srv_survey *srv_survey_new(int most, void (*done)(struct srv_ask *ask), void *context) {
    struct srv_survey *survey = calloc(1, sizeof *survey + (size_t)most * sizeof survey->job[0]);
    if (!survey) return NULL;
    survey->ask = (struct srv_ask){.call = {.run = survey_run}, .done = done};
    survey->context = context;
    return survey;
}

static int survey_find(const struct srv_survey *survey, const char *id) {
    int i = 0;
    while (i < survey->count && strcmp(survey->job[i].id, id) != 0) i++;
    return i;
}

void srv_survey_list(struct srv_survey *survey, const char *id) {
    int i = survey_find(survey, id);
    if (i < survey->count) return;
    memcpy(survey->job[i].id, id, SRV_ID_BYTES);
    survey->job[i].ended = 0;
    survey->count++;
}

int srv_survey_ended(const struct srv_survey *survey, const char *id) {
    int i = survey_find(survey, id);
    return i < survey->count && survey->job[i].ended;
}
