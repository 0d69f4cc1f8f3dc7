#include "api/call/part.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/forecast.h"
#include "api/call/results.h"
#include "api/encode/encode_raw.h"

/* maximum bytes of a part's results, which stay in memory until stored; a worker may hold two
 * parts */
enum { PLAN_PART_BYTES = 1 << 24 };

/* estimated bytes of all results; 0 = unknown */
static double plan_rows(const struct api_op *op, const void *state) {
    const struct api_table *table = api_op_table(op, state);
    if (table->rows_later) return 0;
    return (double)table->rows * api_table_numbers(table, 0) * (double)sizeof(double);
}

int api_plan_read(struct api_plan *plan, const struct api_request *request,
                  const struct api_limits *limits, double seconds, struct api_buffer *body,
                  struct api_buffer *out) {
    const struct api_op *op = api_op_at(request->op);
    struct api_problem problem;
    void *state = NULL;
    *plan = (struct api_plan){.parts = 1};
    api_problem_init(&problem);
    if (!op->table)
        api_problem_set(&problem, 422,
                        "this route answers at once: leave out Prefer: respond-async");
    api_request_check(request, limits, &problem);
    enum pend_status status = problem.status
                                  ? PEND_INVALID
                                  : api_request_read(request, &api_format_raw, limits, &problem,
                                                     &state, plan->digest, body);
    if (status == PEND_OK) {
        if (op->cost) plan->cost = op->cost(state);
        if (!api_forecast_begins(op, state, limits, plan->cost, &problem)) status = PEND_INVALID;
        double most = op->parts ? (double)op->parts(state) : 1;
        double wanted =
            fmax(ceil(plan->cost / seconds), ceil(plan_rows(op, state) / PLAN_PART_BYTES));
        plan->parts = (long)fmax(1, fmin(wanted, most));
        plan->chained = op->carry && plan->parts > 1;
        // all parts are similar
        plan->kept = plan_rows(op, state) / (double)plan->parts;
        if (op->part) op->part(state, 0, plan->parts);
        plan->bytes = op->bytes ? op->bytes(state) : API_OP_SMALL_BYTES;
        api_op_free(op, &state);
    }
    return api_problem_end(&problem, status, out);
}

struct api_part {
    struct api_request request;
    const struct api_limits *limits;
    const struct api_op *op;
    char digest[API_DIGEST_BYTES];
    long number;
    /* identifies the checkpoints' seals: the request and its number of parts */
    char place[API_DIGEST_BYTES + 24];
    const struct api_format *format; /* the raw format; JSON if JSON contains more */
    struct api_table table;          /* of its rows */
    void *state; /* NULL once the part is complete, unless it has a checkpoint to write */
    int carries; /* whether the next part needs a checkpoint of this one */
    int resumes; /* whether this part still needs the previous part's checkpoint */
    int wrote;   /* whether bytes were appended */
    double (*now)(void *context);
    void *context;
    int (*hurry)(void *company);
    void *company;
    double seconds;
};

static enum pend_status part_read(struct api_part *part, struct pend_error *error) {
    struct api_problem problem;
    api_problem_init(&problem);
    part->format = &api_format_raw;
    enum pend_status status = api_request_read(&part->request, part->format, part->limits, &problem,
                                               &part->state, part->digest, NULL);
    if (status != PEND_OK)
        pend_fail(error, status, -1, 0, "%s%s%.150s",
                  problem.count ? problem.faults[0].pointer : "", problem.count ? " " : "",
                  problem.count    ? problem.faults[0].detail
                  : problem.status ? problem.detail
                                   : pend_status_text(status));
    api_problem_clear(&problem);
    return status;
}

PEND_VALIDATOR part_valid(const struct api_part *part) {
    return part->op && part->number >= 0 && (!part->carries || part->op->carry) &&
           (!part->resumes || (part->op->carry && part->number > 0 && !part->wrote)) &&
           (part->format == &api_format_raw ||
            (part->op->json && part->format == &api_format_json));
}

enum pend_status api_part_new(struct api_part **part, const struct api_request *request,
                              const struct api_limits *limits, long number, long parts,
                              struct pend_error *error) {
    struct api_part *made = *part = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->request = *request;
    made->limits = limits;
    made->op = api_op_at(request->op);
    made->number = number;
    enum pend_status status = part_read(made, error);
    snprintf(made->place, sizeof made->place, "%s/%ld", made->digest, parts);
    if (status == PEND_OK && made->op->part) made->op->part(made->state, number, parts);
    if (status == PEND_OK) made->table = *api_op_table(made->op, made->state);
    made->carries = made->op->carry && number + 1 < parts;
    made->resumes = made->op->carry && number > 0;
    assert(part_valid(made) && number < parts);
    if (status != PEND_OK) api_part_free(part);
    return status;
}

void api_part_free(struct api_part **part) {
    if (!*part) return;
    api_op_free((*part)->op, &(*part)->state);
    free(*part);
    *part = NULL;
}

void api_part_clock(struct api_part *part, double (*now)(void *context), void *context) {
    part->now = now;
    part->context = context;
}

void api_part_hurry(struct api_part *part, int (*hurry)(void *company), void *company) {
    part->hurry = hurry;
    part->company = company;
}

enum pend_status api_part_resume(struct api_part *part, const void *carried, size_t bytes,
                                 struct pend_error *error) {
    unsigned char seal[API_SEAL_BYTES];
    error->text[0] = 0;
    if (!part->resumes)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "this part has no checkpoint to continue from");
    size_t held = bytes < sizeof seal ? 0 : bytes - sizeof seal;
    if (held) api_seal(seal, part->place, part->number, carried, held);
    if (!held || memcmp(seal, (const char *)carried + held, sizeof seal))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the checkpoint of the previous part is damaged or belongs to another "
                         "job: submit the job again");
    struct pend_checkpoint checkpoint = {
        .way = PEND_CHECKPOINT_PUT, .at = (char *)carried, .bytes = held};
    part->resumes = 0;
    enum pend_status status = part->op->carry(part->state, &checkpoint, error);
    if (status == PEND_OK && pend_checkpoint_whole(&checkpoint)) return PEND_OK;
    if (status != PEND_OK && status != PEND_INVALID)
        return error->text[0] ? status
                              : pend_fail(error, status, -1, 0, "%s", pend_status_text(status));
    return pend_fail(
        error, PEND_INVALID, -1, 0,
        "the previous part was computed by another version of the program: submit the job again");
}

enum pend_status api_part_carry(struct api_part *part, struct api_buffer *carried) {
    struct pend_checkpoint checkpoint = {.way = PEND_CHECKPOINT_COUNT};
    assert(part_valid(part) && (part->state || !part->carries));
    if (!part->carries) return PEND_OK;
    PEND_TRY(part->op->carry(part->state, &checkpoint, NULL));
    PEND_TRY(api_buffer_room(carried, checkpoint.used + API_SEAL_BYTES));
    checkpoint = (struct pend_checkpoint){.way = PEND_CHECKPOINT_TAKE,
                                          .at = carried->data + carried->bytes,
                                          .bytes = checkpoint.used};
    PEND_TRY(part->op->carry(part->state, &checkpoint, NULL));
    /* the checkpoint gets a seal, because it is stored and read by another process */
    unsigned char *seal = (unsigned char *)checkpoint.at + checkpoint.used;
    api_seal(seal, part->place, part->number + 1, checkpoint.at, checkpoint.used);
    carried->bytes += checkpoint.used + API_SEAL_BYTES;
    return PEND_OK;
}

/* wraps the JSON appended since `before` into records, from the last one to the first, because
 * heads move the later bytes */
static enum pend_status part_wrap(struct api_buffer *out, size_t before) {
    size_t bytes = out->bytes - before, records = (bytes + API_PIECE_BYTES - 1) / API_PIECE_BYTES;
    PEND_TRY(api_buffer_room(out, records * API_RAW_HEAD));
    for (size_t i = records; i-- > 0;) {
        size_t from = i * API_PIECE_BYTES,
               piece = bytes - from < API_PIECE_BYTES ? bytes - from : API_PIECE_BYTES;
        char *to = out->data + before + from + i * API_RAW_HEAD;
        memmove(to + API_RAW_HEAD, out->data + before + from, piece);
        api_raw_head_put(to, API_RAW_JSON, piece);
    }
    out->bytes += records * API_RAW_HEAD;
    return PEND_OK;
}

/* writes an empty record, so that every part has one and a missing part is noticed */
static enum pend_status part_write_nothing(struct api_part *part, struct api_buffer *out) {
    PEND_TRY(api_buffer_room(out, API_RAW_HEAD));
    api_raw_head_put(out->data + out->bytes, API_RAW_ROWS, 0);
    out->bytes += API_RAW_HEAD;
    part->wrote = 1;
    return PEND_OK;
}

double api_part_bytes(const struct api_part *part) {
    double state =
        part->state && part->op->bytes ? part->op->bytes(part->state) : API_OP_SMALL_BYTES;
    return (double)sizeof *part + (double)part->request.body_bytes + state;
}

/* true if the part must still write JSON after its rows, as only the last part of a chain does */
static int part_says_more(const struct api_part *part) {
    return part->format == &api_format_raw && part->op->json && !part->carries;
}

enum pend_status api_part_run(struct api_part *part, struct api_buffer *out, int *done,
                              struct pend_error *error) {
    struct api_turn turn = {.out = out,
                            .now = part->now,
                            .context = part->context,
                            .hurry = part->hurry,
                            .company = part->company,
                            .earlier = part->seconds,
                            .before = out->bytes};
    int over = 0;
    *done = 0;
    error->text[0] = 0;
    assert(part_valid(part) && part->state);
    if (part->resumes)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "this part needs the checkpoint of the previous one");
    if (turn.now) turn.begun = turn.now(turn.context);
    enum pend_status status = part->op->run(part->state, &turn, &over, error);
    if (turn.now) part->seconds = api_turn_seconds(&turn);
    if (status == PEND_OK && part->format != &api_format_raw) status = part_wrap(out, turn.before);
    if (status != PEND_OK)
        return error->text[0] ? status
                              : pend_fail(error, status, -1, 0, "%s", pend_status_text(status));
    part->wrote |= out->bytes > turn.before;
    if (!over) return PEND_OK;
    *done = !part_says_more(part);
    if (*done) return part->wrote ? PEND_OK : part_write_nothing(part, out);
    part->op->json(part->state);
    part->format = &api_format_json;
    assert(part_valid(part));
    return PEND_OK;
}

enum pend_status api_part_file(const struct api_part *part, struct api_buffer *out,
                               struct api_buffer *file) {
    struct api_table table = part->table;
    struct api_raw_file said = {.width = (long)api_table_numbers(&table, 0)};
    size_t kept = 0;
    enum api_raw kind;
    assert(part->state && !file->bytes);
    table.rows_later = 1;
    table.float32 = 0;
    PEND_TRY(api_results_file(&table, out, file, &said.rows));
    for (size_t at = 0, bytes; at < out->bytes; at += bytes) {
        if (!api_raw_head(out->data + at, &kind, &bytes)) return PEND_BUG;
        bytes += API_RAW_HEAD;
        if (kind == API_RAW_ROWS) continue;
        memmove(out->data + kept, out->data + at, bytes);
        kept += bytes;
    }
    out->bytes = kept;
    PEND_TRY(api_buffer_room(out, API_RAW_FILE_BYTES));
    memmove(out->data + API_RAW_FILE_BYTES, out->data, kept);
    out->bytes += API_RAW_FILE_BYTES;
    said.bytes = file->bytes;
    api_digest_bytes(said.digest, file->data, file->bytes);
    api_raw_file_put(out->data, &said);
    return PEND_OK;
}
