/* Fuzzes what api reads besides the requests of fuzz_call: fields that choose a representation,
 * tables of measurements, items of classrooms, and job requests.
 * Leaves to others: the grammar of JSON (fuzz_json), requests that are computed (fuzz_call).
 * Invariant: every input ends with a valid value or a problem of a known status; a stored request
 * reads the same again. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "api/call/form.h"
#include "api/call/part.h"
#include "api/class/class_table.h"
#include "api/encode/negotiate.h"
#include "tests/fuzz/fuzz.h"

static int read_accept(char *text, size_t bytes) {
    (void)bytes;
    api_negotiate_json(text);
    for (int samples = 0; samples < 3; samples++) {
        const struct api_format *format = api_negotiate_format(text, samples);
        if (format && !format->media_type[0]) return 0;
    }
    return 1;
}

/* a table of measurements, in a request that is read but not run */
static int read_table(char *text, size_t bytes) {
    static const char before[] = "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                                 "\"unknowns\":[{\"vary\":\"gravity\"}],\"data\":{\"csv\":\"";
    OWN(api_buffer, clear) body, out;
    struct api_limits limits;
    OWN(api_call, free) *call = NULL;
    int good = 0;
    api_limits_init(&limits);
    api_buffer_init(&body, 1 << 20);
    api_buffer_init(&out, 1 << 20);
    enum pend_status status = api_buffer_text(&body, before);
    for (size_t i = 0; status == PEND_OK && i < bytes; i++)
        status = (unsigned char)text[i] < ' ' || (unsigned char)text[i] > '~' || text[i] == '"' ||
                         text[i] == '\\'
                     ? api_buffer_format(&body, "\\u%04x", (unsigned char)text[i])
                     : api_buffer_add(&body, &text[i], 1);
    if (status == PEND_OK) status = api_buffer_text(&body, "\"}}");
    if (status == PEND_OK) status = api_call_new(&call, &limits);
    if (status == PEND_OK) {
        const struct api_request request = {.op = API_OP_FITS,
                                            .content_type = "application/json",
                                            .body = body.data,
                                            .body_bytes = body.bytes};
        enum api_progress progress = api_call_open(call, &request, &out);
        int http = api_call_answer(call).status;
        /* a NUL is never accepted in a text, however it is written */
        int nul = http == 400 && memchr(text, 0, bytes);
        good = progress == API_MORE || http == 422 || http == 503 || nul;
    }
    return good;
}

/* --- rooms of a class --- */

/* checks a stored item: as JSON, and as a row of the table and of the histogram */
static int item_is_sound(const char *name, const struct api_buffer *value) {
    const struct api_class_item item = {name, 3, 1700000000000000, value->data, value->bytes};
    struct api_class_names names = {0};
    struct api_class_tally tally = {0};
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1 << 20);
    enum pend_status told = api_class_item_write(&item, &out),
                     table = api_class_table_add(&item, &names, &out),
                     counted = api_class_tally_add(&item, &tally);
    int good = told == PEND_OK && (table == PEND_OK || table == PEND_INVALID) &&
               (counted == PEND_OK || counted == PEND_INVALID);
    good &= api_class_tally_write(&tally, &out) == PEND_OK;
    api_class_names_clear(&names);
    api_class_tally_clear(&tally);
    return good;
}

/* the first byte selects the kind of the item in the rest; the stored form must be valid and read
 * the same again */
static int read_class(char *text, size_t bytes) {
    static const char *const names[API_CLASS_KINDS] = {"",
                                                       "pupils/3",
                                                       "stage",
                                                       "stages/3",
                                                       "questions/tide",
                                                       "solutions/tide",
                                                       "worksheets/a",
                                                       "answers/tide/3",
                                                       "handins/a/3"};
    struct api_limits limits;
    struct api_class_facts facts, again;
    OWN(api_buffer, clear) value = {0}, twice = {0}, out = {0};
    if (!bytes) return 1;
    enum api_class_kind kind = (enum api_class_kind)((unsigned char)text[0] % API_CLASS_KINDS);
    struct api_request request = {
        .content_type = "application/json", .body = text + 1, .body_bytes = bytes - 1};
    api_limits_init(&limits);
    api_buffer_init(&value, 1 << 20);
    api_buffer_init(&twice, 1 << 20);
    api_buffer_init(&out, 1 << 20);
    int status = api_class_read(&request, &limits, kind, &facts, &value, &out), good;
    if (status) {
        good = (status == 400 || status == 413 || status == 422) && out.bytes > 0;
    } else {
        request.body = value.data ? value.data : "";
        request.body_bytes = value.bytes;
        good = kind == API_CLASS_ROOM || item_is_sound(names[kind], &value);
        if (value.bytes && kind != API_CLASS_ROOM)
            good &= api_class_read(&request, &limits, kind, &again, &twice, &out) == 0 &&
                    twice.bytes == value.bytes && !memcmp(twice.data, value.data, value.bytes);
    }
    return good;
}

/* --- jobs --- */

/* the first byte selects the operation of the request in the rest; its stored form must have the
 * same plan */
static int read_plan(char *text, size_t bytes) {
    static const enum api_op_id ops[] = {
        API_OP_TRAJECTORIES, API_OP_FORCES,   API_OP_MODES, API_OP_ENSEMBLES, API_OP_LYAPUNOV,
        API_OP_SECTIONS,     API_OP_RESPONSE, API_OP_FITS,  API_OP_ORBITS,    API_OP_CONTROLLERS};
    struct api_limits limits;
    struct api_plan plan, again;
    OWN(api_buffer, clear) kept = {0}, twice = {0}, out = {0};
    if (!bytes) return 1;
    struct api_request request = {.op = ops[(unsigned char)text[0] % (sizeof ops / sizeof *ops)],
                                  .content_type = "application/json",
                                  .body = text + 1,
                                  .body_bytes = bytes - 1};
    api_limits_init(&limits);
    limits.arms = limits.matrix_arms = limits.mode_arms = 40;
    limits.samples = limits.members = 200;
    limits.answer_bytes = 1 << 20;
    api_buffer_init(&kept, 1 << 20);
    api_buffer_init(&twice, 1 << 20);
    api_buffer_init(&out, 1 << 20);
    int status = api_plan_read(&plan, &request, &limits, 1, &kept, &out), good;
    if (status) {
        good = status >= 400 && status <= 422 && out.bytes > 0;
    } else {
        request.body = kept.data;
        request.body_bytes = kept.bytes;
        good = plan.parts >= 1 && plan.cost >= 0 && plan.bytes >= 0 && kept.bytes < bytes &&
               !api_plan_read(&again, &request, &limits, 1, &twice, &out) &&
               again.parts == plan.parts && again.chained == plan.chained &&
               !strcmp(again.digest, plan.digest) && twice.bytes == kept.bytes &&
               !memcmp(twice.data, kept.data, kept.bytes);
    }
    return good;
}

/* a form with files, whose first part must be JSON */
static int read_form(char *text, size_t bytes) {
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    OWN(api_problem, clear) problem;
    OWN(api_json, free) *document = NULL;
    api_limits_init(&limits);
    api_problem_init(&problem);
    api_buffer_init(&out, 1 << 20);
    enum pend_status status =
        api_form_json("multipart/form-data; boundary=b", text, bytes, &limits, &out, &problem);
    int good = status == PEND_INVALID && problem.status >= 400;
    if (status == PEND_OK) {
        status = api_json_new(&document, out.bytes ? out.data : "", out.bytes, (int)limits.depth,
                              &problem);
        /* a request without tables is passed on unchanged */
        good = status == PEND_OK || !out.bytes || memmem(text, bytes, out.data, out.bytes);
    }
    return good;
}

#define TWO "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"

static const struct fuzz_reader api[] = {
    {"accept",
     read_accept,
     {"application/json", "text/csv;q=0.5, application/x-npz;q=1", "*/*;q=0.1, image/png",
      "application/json; charset=utf-8", "text/*;q=0.3, application/vnd.apache.parquet"},
     0},
    {"table",
     read_table,
     {"t,x,y\n0,1,2\n0.1,1.1,2.1\n", "mass A;;;mass B;\nt;x;y;x;y\n0;1,5;2;3;4\n",
      "t\ttheta_1\ttheta_2\r\n0\t1\t-2e-1\r\n1\t\t3\r\n", "# a\ntime, phi_1\n0, 1\n1, NaN\n"},
     0},
    {"form",
     read_form,
     {"--b\r\nContent-Disposition: form-data; name=request\r\n\r\n{\"data\":{\"sigma\":1}}\r\n"
      "--b\r\nContent-Disposition: form-data; name=\"csv\"; filename=\"a.csv\"\r\nContent-Type: "
      "text/csv\r\n\r\nt,x\r\n0,1\r\n\r\n--b--\r\n",
      "--b\r\nContent-Disposition: form-data; name=csv\r\n\r\n\xb0\r\n--b\r\nContent-Disposition: "
      "form-data; name=csv\r\n\r\n--b \r\nContent-Disposition: form-data; name=request\r\n\r\n"
      "{\"data\":{\"runs\":[{},{}]},\"a\":[1,2]}\r\n--b--"},
     1},
    {"class",
     read_class,
     {"\11{}", "\1{\"nickname\":\"=<b>\"}",
      "\2{\"open\":false,\"frozen\":true,\"release\":{\"number\":3}}",
      "\3{\"state\":\"stuck\",\"scene\":{\"request\":{" TWO
      ",\"times\":{\"stop\":1,\"count\":3}}}}",
      "\4{\"text\":\"?\",\"kind\":\"choice\",\"choices\":[\"a\",\"b\"]}",
      "\5{\"value\":2.006,\"tolerance\":1e-2}",
      "\6{\"title\":\"T\",\"steps\":[{\"id\":\"a\",\"question\":{\"text\":\"?\",\"kind\":"
      "\"number\"}},{\"id\":\"b\"}]}",
      "\10{\"answers\":[{\"step\":\"a\",\"value\":2},{\"step\":\"b\",\"value\":\"@x\"}]}"},
     1},
    {"plan",
     read_plan,
     {"\11{" TWO ",\"times\":{\"stop\":3,\"count\":9}}",
      "\3{" TWO ",\"states\":[{},{}],\"duration\":1}", "\2{" TWO ",\"select\":{\"slowest\":2}}",
      "\6{" TWO ",\"drive\":{\"pivot\":{\"x\":1}},\"omega\":[1,2]}",
      "\10{" TWO ",\"mode\":1,\"amplitude\":0.5,\"branch\":true,\"points\":9}"},
     1},
};
FUZZ_READERS(api)
