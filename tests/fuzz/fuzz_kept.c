/* Fuzzes rows, checkpoints and results of the store, as if altered by somebody with write access.
 * Leaves to others: files (fuzz_files), the statements of the store (tests/server/store).
 * Invariant: every input ends with a possible value or a refusal. Seals are computed for the
 * altered bytes, because whoever can change these can change the seal too. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/part.h"
#include "server/store/store_rows.h"
#include "tests/fuzz/fuzz.h"

/* --- rows of jobs --- */

/* takes a field from the bytes: a byte for its kind, then 8 bytes of a number, or a length in one
 * byte and a text of that length, copied so that a NUL follows */
static size_t take_field(struct srv_value *field, const char *data, size_t bytes, char **room) {
    size_t length = 0;
    *field = (struct srv_value){.kind = SRV_SQL_NULL};
    if (!bytes) return 0;
    int kind = (unsigned char)data[0] % 4;
    if (kind == 0) return 1;
    if (kind == 1) {
        length = bytes - 1 < 8 ? bytes - 1 : 8;
        field->kind = SRV_SQL_WHOLE;
        memcpy(&field->whole, data + 1, length);
        return 1 + length;
    }
    if (bytes > 1) length = (unsigned char)data[1];
    if (bytes < 2 || length > bytes - 2) length = bytes < 2 ? 0 : bytes - 2;
    field->kind = kind == 2 ? SRV_SQL_STRING : SRV_SQL_BYTES;
    field->data = memcpy(*room, data + (bytes < 2 ? bytes : 2), length);
    field->bytes = length;
    (*room)[length] = 0;
    *room += length + 1;
    return length + (bytes < 2 ? 1 : 2);
}

/* the seal of such a row */
static void seal_row(struct srv_value field[], unsigned char seal[SRV_SEAL_JOB_BYTES]) {
    struct srv_job job = {
        .parts = (long)field[4].whole, .chained = (int)field[15].whole, .created = field[6].whole};
    srv_row_text(&field[0], job.id, sizeof job.id);
    srv_row_text(&field[1], job.client, sizeof job.client);
    srv_row_text(&field[2], job.operation, sizeof job.operation);
    srv_row_text(&field[17], job.title, sizeof job.title);
    srv_row_text(&field[18], job.version, sizeof job.version);
    /* a row without parts or without a start has no seal */
    if (job.parts < 1 || job.created <= 0) return;
    srv_seal_job(seal, &job, "{}", 2);
    field[19] = srv_value_bytes(seal, SRV_SEAL_JOB_BYTES);
}

static int job_can_be(const struct srv_job *job) {
    if (!memchr(job->id, 0, sizeof job->id) || !memchr(job->client, 0, sizeof job->client) ||
        !memchr(job->message, 0, sizeof job->message) ||
        !memchr(job->title, 0, sizeof job->title) || !memchr(job->version, 0, sizeof job->version))
        return 0;
    if (job->flaw) return job->state == SRV_JOB_FAILED && job->message[0];
    return (int)job->state >= 0 && job->state < SRV_JOB_STATES && job->parts >= 1 &&
           job->done >= 0 && job->done <= job->parts && job->begun <= job->parts &&
           job->waiting <= job->begun && job->bytes >= 0 && job->created >= 0;
}

static int read_row(char *text, size_t bytes) {
    enum { FIELDS = SRV_ROW_JOB + 2 };
    static char room[FUZZ_ROOM + FIELDS];
    struct srv_value field[FIELDS];
    struct srv_job job[1];
    unsigned char seal[SRV_SEAL_JOB_BYTES];
    char *at = room;
    if (!bytes) return 1;
    unsigned how = (unsigned char)text[0];
    struct srv_row_jobs rows = {
        .cap = 1, .job = job, .with_digest = how & 1, .with_part = (how & 2) == 2};
    size_t used = 1;
    for (int i = 0; i < FIELDS; i++) used += take_field(&field[i], text + used, bytes - used, &at);
    if (how & 4) seal_row(field, seal);
    if (srv_row_job(&rows, field) != SRV_STORED || rows.count > 1) return 0;
    return !rows.count || job_can_be(job);
}

/* --- what the store keeps of jobs that run --- */

enum { PARTS = 3, OLD_CASES = 5, CASES = 8, CASE_ROOM = 1 << 15 };

#define TWO "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"

static const struct {
    enum api_op_id op;
    const char *body;
} cases[CASES] = {
    {API_OP_TRAJECTORIES, TWO "\"times\":{\"stop\":3,\"count\":9},\"output\":[\"phi\"]}"},
    {API_OP_TRAJECTORIES, TWO "\"times\":{\"stop\":1,\"count\":6},\"method\":\"symplectic\"}"},
    {API_OP_TRAJECTORIES, TWO "\"times\":{\"stop\":1,\"count\":6},\"method\":\"rkf45\"}"},
    {API_OP_ENSEMBLES, TWO "\"states\":[{},{\"phi\":[1,2]},{}],\"duration\":1}"},
    {API_OP_ORBITS, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"mode\":1,"
                    "\"amplitude\":0.5,\"branch\":true,\"points\":6}"},
    {API_OP_TRAJECTORIES, TWO "\"times\":{\"stop\":1,\"count\":6},\"derivatives\":[{\"vary\":"
                              "\"length\",\"arm\":1},{\"vary\":\"phi\",\"arm\":2}]}"},
    {API_OP_TRAJECTORIES, TWO "\"times\":{\"stop\":1,\"count\":6},\"trust\":true}"},
    {API_OP_TRAJECTORIES,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1],\"damping\":[0.1,0.2],"
     "\"pivot\":{\"cart\":{\"mass\":2}}},\"times\":{\"stop\":1,\"count\":6}}"},
};

/* the checkpoint of a case's first part, and the rows of all parts; computed once */
static struct { struct api_buffer carried, rows; } kept[CASES];

/* the case that a byte selects; newer cases use the last bytes, so that old corpus inputs keep
 * their meaning */
static int case_of(char byte) {
    int number = (unsigned char)byte;
    return number < 200 ? number % OLD_CASES : number % CASES;
}

static struct api_limits kept_limits(void) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.steps = 2000;
    limits.answer_bytes = 1 << 20;
    return limits;
}

static struct api_part *part_of(int i, long number, char body[500],
                                const struct api_limits *limits) {
    struct api_part *part = NULL;
    struct pend_error error;
    struct api_request request = {.op = cases[i].op,
                                  .content_type = "application/json",
                                  .body = body,
                                  .body_bytes = strlen(cases[i].body)};
    strcpy(body, cases[i].body);
    if (api_part_new(&part, &request, limits, number, PARTS, &error) != PEND_OK) abort();
    return part;
}

/* runs a part to its end, for at most `turns` turns */
static enum pend_status part_end(struct api_part *part, int turns, struct api_buffer *out) {
    struct pend_error error;
    int done = 0;
    enum pend_status status = PEND_OK;
    while (status == PEND_OK && !done && turns--) status = api_part_run(part, out, &done, &error);
    return status == PEND_OK && !done ? PEND_DEADLINE : status;
}

static void keep(int i) {
    struct api_limits limits = kept_limits();
    struct pend_error error;
    OWN(api_buffer, clear) carried;
    char body[500];
    api_buffer_init(&kept[i].carried, CASE_ROOM);
    api_buffer_init(&kept[i].rows, CASE_ROOM);
    api_buffer_init(&carried, CASE_ROOM);
    for (long p = 0; p < PARTS; p++) {
        OWN(api_part, free) *part = part_of(i, p, body, &limits);
        if (p && carried.bytes &&
            api_part_resume(part, carried.data, carried.bytes, &error) != PEND_OK)
            abort();
        carried.bytes = 0;
        if (part_end(part, 100000, &kept[i].rows) != PEND_OK ||
            api_part_carry(part, &carried) != PEND_OK)
            abort();
        if (!p && carried.bytes &&
            api_buffer_add(&kept[i].carried, carried.data, carried.bytes) != PEND_OK)
            abort();
    }
}

/* Returns a copy with changes: each change is two bytes of position and the number added to the
 * byte there. The caller frees the copy. */
static char *altered(const struct api_buffer *good, const char *data, size_t bytes) {
    char *copy = malloc(good->bytes + 1);
    if (!copy) abort();
    memcpy(copy, good->data, good->bytes);
    for (size_t i = 0; i + 3 <= bytes; i += 3) {
        size_t at = (unsigned char)data[i] * 256u + (unsigned char)data[i + 1];
        if (good->bytes) copy[at % good->bytes] = (char)(copy[at % good->bytes] + data[i + 2]);
    }
    return copy;
}

/* an altered checkpoint with a matching seal */
static int read_carried(char *text, size_t bytes) {
    struct api_limits limits = kept_limits();
    struct pend_error error = {.text = ""};
    struct api_plan plan;
    OWN(api_buffer, clear) out = {0};
    char body[500], place[API_DIGEST_BYTES + 24];
    if (!bytes) return 1;
    int i = case_of(text[0]);
    if (!kept[i].rows.data) keep(i);
    if (!kept[i].carried.bytes) return 1;
    OWN_MEMORY char *copy = altered(&kept[i].carried, text + 1, bytes - 1);
    struct api_request request = {.op = cases[i].op,
                                  .content_type = "application/json",
                                  .body = cases[i].body,
                                  .body_bytes = strlen(cases[i].body)};
    api_buffer_init(&out, 1 << 20);
    if (api_plan_read(&plan, &request, &limits, 1, NULL, &out)) abort();
    snprintf(place, sizeof place, "%s/%d", plan.digest, PARTS);
    size_t held = kept[i].carried.bytes - API_SEAL_BYTES;
    api_seal((unsigned char *)copy + held, place, 1, copy, held);
    OWN(api_part, free) *part = part_of(i, 1, body, &limits);
    enum pend_status status = api_part_resume(part, copy, held + API_SEAL_BYTES, &error);
    int good = status == PEND_OK || error.text[0];
    if (status == PEND_OK && part_end(part, 50, &out) == PEND_OK)
        good = api_part_carry(part, &out) == PEND_OK;
    return good;
}

struct rest {
    const char *data;
    size_t bytes, at;
};

static enum pend_status rest_fetch(void *context, void *data, size_t cap, size_t *bytes,
                                   struct pend_error *error) {
    struct rest *rest = context;
    (void)error;
    *bytes = rest->bytes - rest->at < cap ? rest->bytes - rest->at : cap;
    if (*bytes) memcpy(data, rest->data + rest->at, *bytes);
    rest->at += *bytes;
    return PEND_OK;
}

static void rest_again(void *context) { ((struct rest *)context)->at = 0; }

/* altered rows of results; the second byte selects the representation, and whether all rows are
 * there */
static int read_rows(char *text, size_t bytes) {
    static const char *const accepts[] = {"application/json",     "text/csv",
                                          "application/x-ndjson", "application/octet-stream",
                                          "application/x-npz",    "application/vnd.apache.parquet",
                                          "application/x-hdf5",   "application/x-matlab-data"};
    struct api_limits limits = kept_limits();
    OWN(api_call, free) *call = NULL;
    OWN(api_buffer, clear) out = {0};
    if (bytes < 2) return 1;
    int i = case_of(text[0]), form = (unsigned char)text[1] % 8;
    if (!kept[i].rows.data) keep(i);
    struct rest rest = {altered(&kept[i].rows, text + 2, bytes - 2), kept[i].rows.bytes, 0};
    struct api_source source = {.fetch = rest_fetch,
                                .again = rest_again,
                                .context = &rest,
                                .partial = (unsigned char)text[1] / 128};
    struct api_request request = {.op = cases[i].op,
                                  .content_type = "application/json",
                                  .accept = accepts[form],
                                  .body = cases[i].body,
                                  .body_bytes = strlen(cases[i].body)};
    api_buffer_init(&out, 1 << 20);
    if (api_call_new(&call, &limits) != PEND_OK) abort();
    enum api_progress progress = api_call_results(call, &request, &source, &out);
    for (int turns = 0; progress == API_MORE && turns < 1000; turns++)
        progress = api_call_run(call, &out);
    int status = api_call_answer(call).status,
        good = progress == API_DONE &&
               (status == 200 || status == 202 || status == 422 || status == 500 || status == 503);
    free((char *)rest.data);
    return good;
}

static const struct fuzz_reader kept_readers[] = {
    {"row",
     read_row,
     {"\4\2\5abcde\2\3key\2\5trees\1\1\1\2\1\1\1\1\1\2\1\3\1\1\1\1\1\1\2\1m\1\1\1\1\1\1"},
     1},
    {"carried",
     read_carried,
     {"\5\1\2\3", "\1\1\1\177", "\2\1\7\200", "\4\1\1\1", "\325\1\1\1", "\326\2\3\1", "\327\1\7\1"},
     1},
    {"rows",
     read_rows,
     {"\5\1\1\2\3", "\1\2\1\1\177", "\2\3\1\7\200", "\3\4\1\1\1", "\325\1\1\2\3"},
     1},
};
FUZZ_READERS(kept_readers)
