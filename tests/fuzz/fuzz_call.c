/* Fuzzes whole requests: random bodies, and mutations of valid requests that follow the grammar.
 * Leaves to others: the grammar of JSON (fuzz_json).
 * Invariant: every call ends with an answer or a problem of a known status, and what it writes is
 * valid JSON, or CSV whose lines have equally many cells. */
#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "api/json/json_in.h"
#include "api/link/oembed.h"
#include "api/link/scene.h"
#include "tests/fuzz/fuzz.h"
#ifndef FUZZER
#include "tests/harness/test.h"
#endif

enum { ROOM = 1 << 14, RUN_CAP = 100000, FORMATS = 8, OPS = 15, SCENE = 8, OEMBED = 12 };
static_assert(2 * FORMATS * OPS <= 256, "every request in every form has a first byte");

/* small limits, so that every request is soon done or refused; some ensembles, of at most 30 steps
 * per member, are computed to their end */
static struct api_limits fuzz_limits(void) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.arms = 40;
    limits.samples = 200;
    limits.members = 200;
    limits.answer_bytes = 1 << 17;
    limits.steps = 3000;
    limits.matrix_arms = 20;
    limits.mode_arms = 20;
    return limits;
}

/* every line has as many commas as the header */
/* returns true if every line has as many commas as the header, except warnings, which can only be
 * the last lines */
static int csv_is_even(const char *text, size_t bytes) {
    long first = -1, commas = 0;
    const char *words = memmem(text, bytes, "\n# ", 3);
    size_t end = words ? (size_t)(words - text) + 1 : bytes;
    for (size_t i = end; i < bytes; i++)
        if (text[i] == '\n' && i + 1 < bytes && text[i + 1] != '#') return 0;
    for (size_t i = 0; i < end; i++) {
        commas += text[i] == ',';
        if (text[i] != '\n') continue;
        if (first < 0) first = commas;
        if (commas != first) return 0;
        commas = 0;
    }
    return bytes > 0 && text[bytes - 1] == '\n';
}

static int json_is_sound(const char *text, size_t bytes) {
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    enum pend_status status = api_json_new(&document, text, bytes, 64, &problem);
    return status == PEND_OK;
}

/* a selection of modes may be empty: then there are no lines */
static int ndjson_is_sound(const char *text, size_t bytes) {
    size_t at = 0;
    while (at < bytes) {
        const char *end = memchr(text + at, '\n', bytes - at);
        if (!end || !json_is_sound(text + at, (size_t)(end - text) - at)) return 0;
        at = (size_t)(end - text) + 1;
    }
    return 1;
}

/* the number format of an answer */
struct form {
    size_t each; /* bytes per number */
    int members; /* the rows are members, which may have failed */
};

static int says(const struct api_value *root, const char *member, const char *word) {
    struct api_value value = api_value_member(root, member);
    const char *text = api_value_text(&value);
    return text && !strcmp(text, word);
}

static struct form form_of(const struct api_request *request) {
    struct form form = {sizeof(double), request->op == API_OP_ENSEMBLES};
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    if (api_json_new(&document, request->body, request->body_bytes, 64, &problem) == PEND_OK) {
        struct api_value root = api_json_root(document);
        if (says(&root, "number", "float32")) form.each = sizeof(float);
    }
    return form;
}

/* reads the name and the count of numbers of a column from a list such as
 * "t,phi[4],events_phi[2,4]"; returns the start of the next column */
static const char *column_read(const char *at, char name[32], long *numbers) {
    size_t letters = strcspn(at, "[,");
    snprintf(name, 32, "%.*s", (int)letters, at);
    at += letters;
    *numbers = 1;
    if (*at == '[') {
        do {
            char *end;
            *numbers *= strtol(at + 1, &end, 10);
            at = end;
        } while (*at == ',');
        at++;
    }
    return at + (*at == ',');
}

static double number_at(const char *text, size_t each) {
    double x;
    float y;
    if (each == sizeof y) {
        memcpy(&y, text, sizeof y);
        return (double)y;
    }
    memcpy(&x, text, sizeof x);
    return x;
}

/* Reads a row. NaN is valid for times of events that never happen, and for unknown values of a
 * failed member, whose status is in the row. Returns the end of the row, or NULL. */
static const char *row_end(const char *text, const char *end, const char *columns,
                           struct form form) {
    int failed = form.members, lacks = 0;
    while (*columns) {
        char name[32];
        long numbers;
        columns = column_read(columns, name, &numbers);
        int is_status = !strcmp(name, "status"),
            is_time = strstr(name, "time") || !strcmp(name, "sign_change") ||
                      !strcmp(name, "settled") || !strcmp(name, "events_stopped") ||
                      strstr(name, "amplitude") || !strcmp(name, "transmissibility"),
            is_known = is_status || !strcmp(name, "member") || !strcmp(name, "t");
        for (; numbers > 0; numbers--, text += form.each) {
            if ((size_t)(end - text) < form.each) return NULL;
            double x = number_at(text, form.each);
            if (isinf(x) || (isnan(x) && is_known)) return NULL;
            if (is_status) failed = x != 0;
            lacks |= isnan(x) && !is_time;
        }
    }
    return lacks && !failed ? NULL : text;
}

static int octets_are_sound(const char *text, size_t bytes, const char *columns, struct form form) {
    const char *end = text + bytes;
    if (!columns || !*columns) return 0;
    while (text && text < end) text = row_end(text, end, columns, form);
    return text == end;
}

static size_t whole_at(const char *text, int bytes) {
    size_t x = 0;
    while (bytes--) x = x << 8 | (unsigned char)text[bytes];
    return x;
}

/* the position and size of the directory in the end record lead to the end of the archive */
static int npz_is_sound(const char *text, size_t bytes) {
    if (bytes < 22 || memcmp(text, "PK\3\4", 4) || memcmp(text + bytes - 22, "PK\5\6", 4)) return 0;
    return whole_at(text + bytes - 6, 4) + whole_at(text + bytes - 10, 4) + 22 == bytes;
}

/* the elements follow each other up to the end of the file */
static int mat_is_sound(const char *text, size_t bytes) {
    size_t at = 128;
    while (at + 8 <= bytes && whole_at(text + at, 4) == 14) at += 8 + whole_at(text + at + 4, 4);
    return at == bytes && !memcmp(text, "MATLAB 5.0", 10);
}

/* the file ends at the size in its superblock, and the root group lies inside it */
static int hdf5_is_sound(const char *text, size_t bytes) {
    if (bytes < 64 || memcmp(text, "\x89HDF\r\n\x1a\n\2\x8\x8", 11) != 0) return 0;
    size_t end = whole_at(text + 28, 8), root = whole_at(text + 36, 8);
    return end == bytes && root < bytes - 4 && !memcmp(text + root, "OHDR", 4);
}

/* the footer ends the file, and its first field is the version */
static int parquet_is_sound(const char *text, size_t bytes) {
    if (bytes < 12 || memcmp(text, "PAR1", 4) || memcmp(text + bytes - 4, "PAR1", 4)) return 0;
    size_t footer = whole_at(text + bytes - 8, 4);
    return footer > 0 && footer + 12 <= bytes && text[bytes - 8 - footer] == (1 << 4 | 5);
}

static int status_is_known(int status) {
    static const int known[] = {200, 400, 404, 413, 422, 503};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (status == known[i]) return 1;
    return 0;
}

/* returns what is wrong with an answer, or NULL */
static const char *answer_complaint(const struct api_request *request, struct api_answer answer,
                                    const struct api_buffer *out) {
    const char *type = answer.media_type;
    if (!status_is_known(answer.status)) return "a status that nobody knows";
    if (answer.status == 503) return "it ran out of something";
    if ((answer.status == 200) != !strstr(answer.media_type, "problem"))
        return "status and media type disagree";
    if (answer.length >= 0 && (size_t)answer.length != out->bytes)
        return "another length than was foreseen";
    if (strstr(type, "csv"))
        return csv_is_even(out->data, out->bytes) ? NULL : "uneven lines of CSV";
    if (strstr(type, "ndjson"))
        return ndjson_is_sound(out->data, out->bytes) ? NULL : "a line that is no JSON";
    if (strstr(type, "octet"))
        return octets_are_sound(out->data, out->bytes, answer.columns, form_of(request))
                   ? NULL
                   : "octets that are no numbers";
    if (strstr(type, "npz"))
        return npz_is_sound(out->data, out->bytes) ? NULL : "an archive that is none";
    if (strstr(type, "parquet"))
        return parquet_is_sound(out->data, out->bytes) ? NULL : "a Parquet file that is none";
    if (strstr(type, "hdf5"))
        return hdf5_is_sound(out->data, out->bytes) ? NULL : "an HDF5 file that is none";
    if (strstr(type, "matlab"))
        return mat_is_sound(out->data, out->bytes) ? NULL : "a MAT-file that is none";
    return json_is_sound(out->data, out->bytes) ? NULL : "an answer that is no JSON";
}

/* runs a call to its end; if the answer can be streamed and `pieces` is set, takes it in pieces as
 * the server does */
static enum api_progress run(struct api_call *call, int pieces, struct api_buffer *out) {
    OWN(api_buffer, clear) piece = {0};
    enum api_progress progress = API_MORE;
    if (!pieces || !api_call_streams(call)) {
        for (int runs = 0; progress == API_MORE && runs < RUN_CAP; runs++)
            progress = api_call_run(call, out);
        return progress;
    }
    api_buffer_init(&piece, out->limit);
    api_call_promise(call);
    for (int runs = 0; progress == API_MORE && runs < RUN_CAP; runs++) {
        progress = api_call_run(call, &piece);
        if (api_buffer_add(out, piece.data, piece.bytes) != PEND_OK) progress = API_BROKEN;
        piece.bytes = 0;
    }
    return progress;
}

/* reads a scene; its stored form must be JSON */
static const char *scene_complaint(const struct api_request *request,
                                   const struct api_limits *limits, int *status) {
    OWN(api_buffer, clear) scene, problem;
    char id[API_SCENE_ID];
    api_buffer_init(&scene, ROOM * 8);
    api_buffer_init(&problem, ROOM * 8);
    int http =
        api_scene_read(request, limits, ROOM, "2026-01-31T09:30:00.125Z", id, &scene, &problem);
    const struct api_buffer *said = http ? &problem : &scene;
    const char *fault = json_is_sound(said->data, said->bytes) ? NULL : "a scene that is no JSON";
    if (http && !status_is_known(http)) fault = "a status that nobody knows";
    if (!http && strlen(id) != API_SCENE_ID - 1) fault = "an id that is none";
    if (status) *status = http ? http : 200;
    return fault;
}

/* reads the query of an embedded link; its text must be harmless in HTML */
static const char *oembed_complaint(const char *body, size_t bytes, int *status) {
    OWN_MEMORY char *query = strndup(body, bytes);
    struct api_oembed wanted;
    OWN(api_problem, clear) problem;
    OWN(api_buffer, clear) out;
    const char *fault = NULL;
    api_problem_init(&problem);
    api_buffer_init(&out, ROOM);
    if (!query) return "it ran out of memory";
    if (api_oembed_read(query, "h:1", &wanted, &problem) != PEND_OK) {
        if (problem.status != 501 && !status_is_known(problem.status))
            fault = "a status that nobody knows";
    } else if (strpbrk(wanted.link, "\"'<> \n") || (!strstr(wanted.link, "://h:1/?embed=1") &&
                                                    !strstr(wanted.link, "://H:1/?embed=1"))) {
        fault = "a link that is not of the embed view";
    } else if (api_oembed_write(&wanted, &out) != PEND_OK || !json_is_sound(out.data, out.bytes)) {
        fault = "an answer that is no JSON";
    }
    if (status) *status = problem.status ? problem.status : 200;
    return fault;
}

/* Runs one request: the first byte selects operation and form, the rest is the body. *status
 * receives the status unless it is NULL. Returns what is wrong, or NULL. */
static const char *complaint(const uint8_t *data, size_t bytes, int *status) {
    static const enum api_op_id ops[OPS] = {
        API_OP_TRAJECTORIES, API_OP_FORCES,    API_OP_MODES,    API_OP_TREES,
        API_OP_ENSEMBLES,    API_OP_EQUATIONS, API_OP_LYAPUNOV, API_OP_SECTIONS,
        API_OP_TRAJECTORIES, API_OP_RESPONSE,  API_OP_FITS,     API_OP_ORBITS,
        API_OP_TREES,        API_OP_TABLES,    API_OP_TRIALS};
    static const char *const accepts[FORMATS] = {NULL,
                                                 "text/csv, */*;q=0.1",
                                                 "application/x-ndjson, */*;q=0.1",
                                                 "application/octet-stream, */*;q=0.1",
                                                 "application/x-npz, */*;q=0.1",
                                                 "application/x-hdf5, */*;q=0.1",
                                                 "application/x-matlab-data, */*;q=0.1",
                                                 "application/vnd.apache.parquet, */*;q=0.1"};
    unsigned first = bytes ? (uint8_t)(data[0] - '0') : 0;
    struct api_limits limits = fuzz_limits();
    OWN(api_call, free) *call = NULL;
    OWN(api_buffer, clear) out = {0};
    const char *fault = NULL;
    struct api_request request = {.op = ops[first % OPS],
                                  .content_type = "application/json",
                                  .accept = accepts[first / OPS % FORMATS],
                                  .body = bytes ? (const char *)data + 1 : "",
                                  .body_bytes = bytes ? bytes - 1 : 0};
    /* two file formats share a first byte */
    if (first / OPS % FORMATS == FORMATS - 1 && bytes % 2)
        request.accept = "application/x-hdf5, */*;q=0.1";
    if (first % OPS == OEMBED) return oembed_complaint(request.body, request.body_bytes, status);
    if (first % OPS == SCENE) return scene_complaint(&request, &limits, status);
    api_buffer_init(&out, (size_t)limits.answer_bytes);
    if (api_call_new(&call, &limits) != PEND_OK) return "no memory for a call";
    enum api_progress progress = api_call_open(call, &request, &out);
    if (progress == API_MORE) progress = run(call, first / (OPS * FORMATS) % 2, &out);
    if (progress == API_MORE)
        fault = "it does not end";
    else if (progress == API_DONE)
        fault = answer_complaint(&request, api_call_answer(call), &out);
    if (status) *status = progress == API_BROKEN ? 422 : api_call_answer(call).status;
    return fault;
}

static int read_call(char *text, size_t bytes) {
    const char *fault = complaint((const uint8_t *)text, bytes, NULL);
    if (fault) fprintf(stderr, "%s: %.*s\n", fault, (int)bytes, text);
    return !fault;
}

#define ARMS                                                                                       \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":2.0,\"mass\":1.0},{\"name\":\"b\","        \
    "\"parent\":\"a\","                                                                            \
    "\"length\":"                                                                                  \
    "1.5,\"mass\":1e-1}],\"gravity\":9.81}"
#define LISTS                                                                                      \
    "\"pendulum\":{\"length\":[2,1.5,0.75,1.25],\"mass\":[1,1,1,0.1],\"parent\":[0,1,2,2]}"
#define PAPER "\"pendulum\":{\"L\":[2,1.5,0.75],\"m\":[1,1,1],\"S\":[[1,0,0],[1,1,0],[1,1,1]]}"
#define REAL                                                                                       \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":2,\"rod\":1,\"damping\":0.1,\"friction\":" \
    "{"                                                                                            \
    "\"torque\":0.1,\"speed\":0.5}},{\"parent\":\"a\",\"at\":[1,0.1],\"length\":1,\"mass\":0,"     \
    "\"body\":{\"mass\":2,\"center\":[0.5,0],\"inertia\":0.1},\"stiffness\":1,\"rest\":0.2,"       \
    "\"drag\":{\"linear\":0.1,\"quadratic\":0.1,\"speed\":0.1}}],\"drag_per_mass\":0.1}"
#define DRIVEN                                                                                     \
    "\"pendulum\":{\"length\":[2,1],\"mass\":[1,null],\"parent\":[0,1],\"rod\":[null,1],"          \
    "\"torque\":[{\"constant\":1,\"harmonics\":[{\"amplitude\":1,\"omega\":2,\"phase\":3}]},0.5]," \
    "\"pivot\":{\"x\":{\"harmonics\":[{\"amplitude\":0.1,\"omega\":9}]},\"y\":{\"harmonics\":[]}," \
    "\"acceleration\":[1,0]}}"

#define CART                                                                                       \
    "\"pendulum\":{\"length\":[2,1],\"mass\":[1,2],\"parent\":[0,0],\"damping\":[0.1,0],"          \
    "\"pivot\":{"                                                                                  \
    "\"cart\":{\"mass\":1,\"angle\":0.1,\"damping\":0.2,\"stiffness\":3,\"force\":{\"constant\":"  \
    "1,"                                                                                           \
    "\"harmonics\":[{\"amplitude\":1,\"omega\":2}]}}}}"

/* valid requests; the first character selects operation and form */
static const char *const seeds[] = {
    "<url=http%3A%2F%2Fh:1%2F%3Flength%3D1,1%26lang%3Dde%23d%3Da&format=json&maxwidth=300",
    "<url=https://h:1/?sheet=period&maxheight=5&x=[1,2]",
    "0{" ARMS ",\"initial\":{\"theta\":[0.1,-0.2],\"thetad\":[1,0],\"unit\":\"deg\"},\"times\":[0,"
    "0.5,1],\"method\":\"rkf45\",\"rtol\":1e-6,\"atol\":1e-9}",
    "0{" LISTS ",\"times\":{\"start\":0,\"stop\":1,\"step\":0.1},\"output\":[\"phi\",\"phid\","
    "\"phidd\",\"theta\",\"z\","
    "\"zd\",\"lambda\",\"energy\"],\"digits\":6,\"precision\":\"double\"}",
    "0{" PAPER ",\"initial\":{\"mode\":2,\"amplitude\":0.1},\"times\":{\"start\":1,\"stop\":-1,"
    "\"count\":9},\"method\":\"linear\"}",
    "0{" ARMS ",\"times\":{\"stop\":2,\"count\":50},\"method\":\"ode23\"}",
    "0{" PAPER ",\"times\":{\"stop\":0.5,\"count\":5},\"method\":\"msadams\"}",
    "1{" LISTS ",\"state\":{\"phi\":[1,2,3,4],\"phid\":[0.1,0.2,0.3,0.4]}}",
    "1{" PAPER ",\"states\":[{},{\"phi\":[1,2,3]},{\"mode\":1,\"amplitude\":3,\"unit\":\"deg\"}],"
    "\"digits\":3}",
    "2{" LISTS ",\"select\":{\"slowest\":2},\"vectors\":true,\"normalize\":\"mass\",\"include\":["
    "\"A\",\"M\",\"S\",\"B\"],\"initial\":{\"phi\":[0,0,0,0]}}",
    "2{" ARMS ",\"select\":{\"from\":0,\"to\":9},\"vectors\":false}",
    "3{" ARMS "}",
    "={" ARMS
    ",\"data\":{\"csv\":\"t;theta_1 (deg);err;x_2\\n0;20;1;0,1\\n0,1;19;1;-\\n0,2;1;1;2\\n\","
    "\"columns\":[null,\"theta_1\"]},\"include\":[\"data\"]}",
    ">{\"trials\":[{\"length\":0.25,\"amplitude\":10,\"period\":1},{\"length\":1,\"mass\":2,"
    "\"period\":"
    "null},{\"length\":1,\"period\":2}],\"law\":\"power\",\"unit\":\"deg\",\"sigma\":0.01}",
    "3{" PAPER "}",
    "3{" REAL "}",
    "3{" DRIVEN "}",
    "0{" DRIVEN
    ",\"times\":[0,1],\"rows\":\"events\",\"events\":[{\"of\":\"theta\",\"arm\":1,\"unit\":\"deg\","
    "\"value\":10,\"direction\":\"up\",\"count\":3},{\"of\":\"distance\",\"arm\":1,\"to\":2,"
    "\"bound\":1,\"stop\":2,\"count\":9}]}",
    ":{" DRIVEN
    ",\"data\":{\"csv\":\"a,,b\\nt;x;y;theta_1\\n0;1;2;\\n0,5;1;0;1e9\\n\",\"arms\":[1]},"
    "\"camera\":{\"unknown\":[\"scale\",\"origin\"]},\"unknowns\":[{\"vary\":\"theta\",\"arm\":1,"
    "\"low\":-1,\"high\":4}],\"iterations\":3}",
    ";{" PAPER ",\"mode\":2,\"amplitude\":30,\"unit\":\"deg\",\"branch\":true,\"points\":3}",
    ";{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"damping\":[0.3],\"torque\":[{"
    "\"harmonics\":[{\"amplitude\":0.1,\"omega\":4}]}]},\"settle\":1,\"branch\":{\"vary\":"
    "\"omega\",\"to\":5},\"points\":2,\"step\":0.5}",
    "9{" DRIVEN ",\"omega\":[0,1,9],\"initial\":{\"theta\":[1,2]}}",
    "9{" REAL ",\"drive\":{\"pivot\":{\"direction\":30,\"unit\":\"deg\"}},\"omega\":{\"start\":1,"
    "\"stop\":9,\"count\":9,\"scale\":\"logarithmic\"},\"output\":[\"z\",\"transmissibility\"]}",
    "5{" CART ",\"initial\":{\"cart\":{\"x\":1}}}",
    "9{" CART ",\"drive\":{\"cart\":{\"amplitude\":2}},\"omega\":[1],\"output\":[\"cart\"]}",
    "7{" CART ",\"section\":{\"period\":\"drive\"},\"initial\":{\"cart\":{\"x\":1,\"v\":2}},"
    "\"duration\":4}",
    "6{" CART ",\"duration\":0.5,\"samples\":2,\"count\":\"all\"}",
    "6{" LISTS ",\"initial\":{\"phi\":[1,2,3,4]},\"duration\":1,\"transient\":0.1,\"samples\":3,"
    "\"count\":2,\"digits\":5}",
    "7{" LISTS ",\"section\":{\"arm\":2,\"theta\":10,\"unit\":\"deg\",\"direction\":\"both\"},"
    "\"duration\":3,\"count\":2}",
    "7{" ARMS ",\"section\":{\"arm\":\"b\",\"phi\":-1},\"duration\":1,\"rtol\":1e-6,\"digits\":5}",
    "6{" ARMS ",\"duration\":0.5,\"samples\":2,\"count\":\"all\"}",
    "5{" LISTS ",\"form\":\"compact\",\"initial\":{\"theta\":[1,2,3,4],\"unit\":\"deg\"}}",
    "5{" PAPER ",\"initial\":{\"mode\":1,\"amplitude\":0.5},\"form\":\"explicit\"}",
    "8{\"title\":\"\\u00e9\",\"request\":{" LISTS
    ",\"times\":[0,1e0]},\"view\":{\"trails\":[1,2],\"on\":true,\"none\":null}}",
    "4{" ARMS ",\"states\":[{},{\"phi\":[1,2]}],\"duration\":1,\"observables\":[\"final\","
    "\"flips\",\"first_flip\",\"lambda_max\",\"sign_change\",\"lyapunov\",\"parameters\"],"
    "\"digits\":4,\"columns\":[\"status\",\"final_phi\",\"first_flip\"],\"number\":\"float64\","
    "\"none\":\"nan\"}",
    "4{" LISTS ",\"states\":[{},{\"theta\":[3,1,2,3]}],\"duration\":1,\"observables\":["
    "\"first_flip\",\"flip_time\"],\"columns\":[\"member\",\"first_flip_time\"],\"number\":"
    "\"float32\",\"none\":\"nan\"}",
    "0{" LISTS ",\"times\":[0,1],\"output\":[\"z\",\"energy\"],\"number\":\"float32\"}",
    "4{" DRIVEN ",\"states\":[{},{}],\"duration\":1,\"events\":[{\"of\":\"energy\",\"value\":1},{"
    "\"of\":\"x\",\"arm\":2,\"bound\":0.5,\"stop\":2}]}",
    "4{" DRIVEN ",\"states\":[{},{}],\"duration\":1,\"rows\":\"events\",\"events\":[{\"of\":"
    "\"lambda\",\"arm\":1,\"value\":0,\"count\":3}]}",
    "4{" LISTS ",\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":0,\"stop\":3,\"count\":4,"
    "\"unit\":\"rad\"},{\"vary\":\"mass\",\"arm\":2,\"start\":1,\"stop\":2,\"count\":3,"
    "\"scale\":\"log\"}],\"initial\":{},\"duration\":1,\"observables\":[\"flip_time\"],"
    "\"picture\":{\"of\":\"flip_time\",\"arm\":2,\"scale\":\"log\"}}",
    "4{" DRIVEN ",\"members\":[{},{\"length\":[1,2],\"energy\":9},{\"initial\":{\"phi\":[1,2]},"
    "\"set\":[{\"vary\":\"mass\",\"arm\":1,\"value\":3}]}],\"initial\":{\"theta\":[1,1],"
    "\"thetad\":[1,0]},\"times\":[0,1],\"observables\":[\"trajectory\"],\"output\":[\"phidd\","
    "\"z\",\"energy\"]}",
    "4{" LISTS ",\"energy\":5,\"grid\":[{\"vary\":\"phi\",\"arm\":1,\"start\":0,\"stop\":3,"
    "\"count\":4,\"with\":[{\"vary\":\"phid\",\"arm\":2,\"start\":1,\"stop\":2}]}],\"duration\":1}",
    "4{" LISTS
    ",\"random\":{\"count\":5,\"first\":9,\"seed\":3,\"draw\":[{\"vary\":\"length\",\"arm\":1,"
    "\"distribution\":\"normal\",\"mean\":1,\"deviation\":1},{\"vary\":\"gravity\","
    "\"distribution\":\"uniform\",\"low\":1,\"high\":9}]},\"times\":[0,1],\"observables\":["
    "\"trajectory\"],\"output\":[\"theta\",\"lambda\"]}",
};

enum { SEEDS = sizeof seeds / sizeof *seeds };

static struct fuzz_reader call = {.name = "call", .read = read_call, .bare = 1};

__attribute__((constructor)) static void register_call(void) {
    for (int i = 0; i < SEEDS; i++) call.seed[i] = seeds[i];
    fuzz_register(&call, 1);
}

#ifndef FUZZER

/* replacements for a number, a text or a whole value */
static char values_text[] =
    "0~-0.0~1~2~3~4~5~-1~0.5~1e-300~1e300~1e-9~1e9~1e16~17~18~null~true~[]~{}~\"\"~\"a\"~\"b\"~["
    "1]~[[1]]~4e-324~1.7976931348623157e308~9007199254740993~[1,2]~[1,2,3]~{\"phi\":["
    "1]}~\"all\"~\"taylor\"~\"linear\"~\"float32\"~\"nan\"~\"energy\"~{\"slowest\":1}~-1e18~[0,0,0,"
    "0]~[3,0,1,1]~2147483648~\"\\u0001\xc3\xa9\"";
enum { VALUES = 43 };
static const char *values[VALUES];

__attribute__((constructor)) static void split_values(void) {
    char *rest = values_text;
    for (int i = 0; i < VALUES; i++) values[i] = strsep(&rest, "~");
}

static const char *const names[] = {
    "pendulum", "arms",    "name",         "parent",  "length",    "mass",          "L",
    "m",        "S",       "gravity",      "initial", "state",     "states",        "phi",
    "phid",     "theta",   "thetad",       "mode",    "amplitude", "unit",          "times",
    "start",    "stop",    "step",         "count",   "method",    "rtol",          "atol",
    "output",   "digits",  "precision",    "select",  "slowest",   "fastest",       "from",
    "to",       "vectors", "normalize",    "include", "events",    "typo",          "grid",
    "random",   "members", "columns",      "number",  "none",      "first",         "with",
    "energy",   "set",     "vary",         "arm",     "duration",  "observables",   "draw",
    "seed",     "picture", "form",         "title",   "request",   "view",          "transient",
    "samples",  "rod",     "body",         "at",      "damping",   "stiffness",     "rest",
    "friction", "torque",  "drag",         "center",  "inertia",   "speed",         "harmonics",
    "omega",    "phase",   "constant",     "linear",  "quadratic", "drag_per_mass", "pivot",
    "x",        "y",       "acceleration", "cart",
};

enum { NAMES = sizeof names / sizeof *names };

/* replaces `old` bytes by a piece; a text that would become too long, or ends before them, is
 * unchanged */
static size_t replace(char *text, size_t bytes, size_t at, size_t old, const char *piece) {
    size_t length = strlen(piece);
    if (at + old > bytes || bytes - old + length > ROOM) return bytes;
    memmove(text + at + length, text + at + old, bytes - at - old);
    memcpy(text + at, piece, length);
    return bytes - old + length;
}

/* the length of the value at `at`: a number, a word, a string, or brackets with their contents */
static size_t value_bytes(const char *text, size_t bytes, size_t at) {
    size_t i = at;
    int depth = 0, quoted = 0;
    do {
        if (text[i] == '"') quoted = !quoted;
        if (!quoted && strchr("[{", text[i])) depth++;
        if (!quoted && strchr("]}", text[i])) depth--;
        i++;
    } while (i < bytes && (depth > 0 || quoted || !strchr(",]}:", text[i])));
    return i - at;
}

/* a position at which a value begins, or 0 */
static size_t value_place(const char *text, size_t bytes, unsigned long long *state) {
    for (int tries = 0; tries < 50; tries++) {
        size_t at = 1 + (size_t)test_random_int(state, (int)bytes - 1);
        if (strchr(":[,", text[at - 1]) && !strchr("]}", text[at])) return at;
    }
    return 0;
}

/* removes an element or a member with one of the adjacent commas */
static size_t lose(char *text, size_t bytes, size_t at, size_t length) {
    if (text[at + length] == ':') length += 1 + value_bytes(text, bytes, at + length + 1);
    if (text[at + length] == ',')
        length++;
    else if (text[at - 1] == ',')
        at--, length++;
    return text[at - 1] == ':' ? bytes : replace(text, bytes, at, length, "");
}

static size_t mutate(char *text, size_t bytes, unsigned long long *state) {
    static char copy[ROOM + 2];
    char member[80];
    size_t at = bytes > 2 ? value_place(text, bytes - 1, state) : 0;
    if (!at) return bytes;
    size_t length = value_bytes(text, bytes, at);
    int key = text[at + length] == ':', way = test_random_int(state, 24);
    const char *name = names[test_random_int(state, NAMES)],
               *value = values[test_random_int(state, VALUES)];
    if (way == 0)
        return replace(text, bytes, at, (size_t)test_random_int(state, 2),
                       value); /* random text instead of a value */
    if (way < 3) return lose(text, bytes, at, length);
    snprintf(member, sizeof member, "\"%s\":%s,", name, value);
    if (way < 5) return replace(text, bytes, 2, 0, member);
    snprintf(member, sizeof member, "\"%s\"", name);
    if (key) return replace(text, bytes, at, length, member);
    if (way < 14) return replace(text, bytes, at, length, value);
    memcpy(copy, text + at, length);
    copy[length] = 0;
    if (way < 20 || text[at - 1] == ':') { /* copies the value over another one */
        at = value_place(text, bytes - 1, state);
        length = value_bytes(text, bytes, at);
        return at && text[at + length] != ':' ? replace(text, bytes, at, length, copy) : bytes;
    }
    memcpy(copy + length, ",", 2);
    return replace(text, bytes, at, 0, copy); /* inserts one more element of the same kind */
}

static int sound(const char *text, size_t bytes, int *status) {
    const char *fault = complaint((const uint8_t *)text, bytes, status);
    return CHECK_SAYING(!fault, "%s: %.*s", fault, (int)bytes, text);
}

/* the same request in another representation, whole or in pieces */
static void in_form(char *text, unsigned form) {
    *text = (char)('0' + (*text - '0') % OPS + (int)(OPS * form));
}

TEST(fuzz_call_answers_the_seeds) {
    for (int i = 0; i < SEEDS; i++)
        for (unsigned form = 0; form < 2 * FORMATS; form++) {
            char text[1000];
            int status = 0;
            snprintf(text, sizeof text, "%s", seeds[i]);
            in_form(text, form);
            sound(text, strlen(seeds[i]), &status);
            /* matrices are returned as JSON only, and every Accept header here allows JSON */
            CHECK_SAYING(status == 200, "%s gets %d", text, status);
        }
}

/* FUZZ_RUNS (20000) mutations from FUZZ_SEED (1) */
TEST(fuzz_call_survives_mutations) {
    static char text[ROOM];
    const char *runs_text = getenv("FUZZ_RUNS"), *seed_text = getenv("FUZZ_SEED");
    long runs = runs_text ? atol(runs_text) : 20000, answered = 0, refused = 0;
    unsigned long long state = seed_text ? strtoull(seed_text, NULL, 10) : 1;
    for (long i = 0; i < runs; i++) {
        const char *seed = seeds[test_random_int(&state, SEEDS)];
        size_t bytes = strlen(seed);
        int status = 0;
        memcpy(text, seed, bytes);
        in_form(text, (unsigned)test_random_int(&state, 2 * FORMATS));
        for (int times = test_random_int(&state, 4); times >= 0; times--)
            bytes = mutate(text, bytes, &state);
        if (!sound(text, bytes, &status)) return;
        answered += status == 200;
        refused += status == 422;
    }
    CHECK_SAYING(answered > runs / 50 && refused > runs / 4,
                 "of %ld %ld were answered, %ld refused", runs, answered, refused);
}

/* inputs that failed in the past, in every form */
TEST(fuzz_call_answers_what_once_failed) {
    static const char *const once[] = {
        "2{\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":2.0,\"mass\":2},{\"name\":\"b\","
        "\"parent\":\"a\",\"length\":1e300,\"mass\":1e-1}],\"gravity\":9.81},\"vectors\":false}",
    };
    for (size_t i = 0; i < sizeof once / sizeof *once; i++)
        for (unsigned form = 0; form < 2 * FORMATS; form++) {
            char text[1000];
            snprintf(text, sizeof text, "%s", once[i]);
            in_form(text, form);
            sound(text, strlen(text), NULL);
        }
}

#endif
