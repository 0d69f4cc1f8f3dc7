#include "api/clients/cli/request.h"

#include <assert.h>
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/canonical.h"
#include "api/call/form.h"

enum { MOST_BYTES = 1 << 30, DEPTH = 64 };

int cli_scheduled;

static int status_of(int status) {
    return !cli_scheduled ? status : status == CLI_FAILED ? CLI_AGAIN : CLI_BAD;
}

void cli_end(int status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("pendulum: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(status_of(status));
}

void cli_warn(const char *text) { fprintf(stderr, "pendulum: warning: %s\n", text); }

void cli_need(int good) {
    if (!good) cli_die("out of memory");
}

/* the option that gives a field, " (--t)"; "" if there is none */
static const char *option_of(const char *pointer) {
    static const struct {
        const char *pointer, *option;
    } rows[] = {{"/times", " (--t)"},
                {"/grid/0", " (--x)"},
                {"/grid/1", " (--y)"},
                {"/initial/theta", " (--theta)"},
                {"/initial/thetad", " (--thetad)"},
                {"/initial/phi", " (--phi)"},
                {"/initial/phid", " (--phid)"},
                {"/initial/unit", " (--unit)"},
                {"/method", " (--method)"},
                {"/duration", " (--duration)"},
                {"/observables/0", " (--of)"},
                {"/data", " (--csv)"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        size_t length = strlen(rows[i].pointer);
        if (!strncmp(rows[i].pointer, pointer, length) && !isalpha((unsigned char)pointer[length]))
            return rows[i].option;
    }
    return "";
}

void cli_refuse(long status, const struct api_buffer *text) {
    struct api_problem problem;
    struct api_json *document = NULL;
    api_problem_init(&problem);
    if (api_json_new(&document, text->data ? text->data : "", text->bytes, 16, &problem) != PEND_OK)
        cli_end(CLI_REFUSED, "the server answered with status %ld", status);
    struct api_value root = api_json_root(document), detail = api_value_member(&root, "detail");
    struct api_value errors = api_value_member(&root, "errors");
    const char *said = api_value_text(&detail);
    fprintf(stderr, "pendulum: %ld %s\n", status, said ? said : "");
    for (struct api_value item = api_value_first(&errors); api_value_kind(&item) != API_MISSING;
         item = api_value_next(&item)) {
        struct api_value pointer = api_value_member(&item, "pointer");
        struct api_value words = api_value_member(&item, "detail");
        if (api_value_text(&pointer) && api_value_text(&words))
            fprintf(stderr, "  %s%s %s\n", api_value_text(&pointer),
                    option_of(api_value_text(&pointer)), api_value_text(&words));
    }
    if (status == 401 && !getenv("PENDULUM_TOKEN"))
        fputs("  Set PENDULUM_TOKEN (openssl rand -hex 16) before you submit jobs.\n", stderr);
    exit(status_of(CLI_REFUSED));
}

/* parses a document; on failure ends the program with its detail, silently if `what` is NULL */
static struct api_json *parsed(const char *text, size_t bytes, const char *what) {
    struct api_problem problem;
    struct api_json *document = NULL;
    api_problem_init(&problem);
    if (api_json_new(&document, text, bytes, DEPTH, &problem) != PEND_OK && what)
        cli_end(CLI_USAGE, "%s: %s", what, problem.status ? problem.detail : "out of memory");
    api_problem_clear(&problem);
    return document;
}

void cli_field(struct cli_fields *fields, const char *name, const char *value) {
    if (fields->count == CLI_FIELDS) cli_end(CLI_USAGE, "more than %d fields", CLI_FIELDS);
    assert(fields->count >= 0 && name && value);
    int i = fields->count++;
    const char *dot = strchr(name, '.');
    size_t object = dot ? (size_t)(dot - name) : 0;
    const char *last = dot ? dot + 1 : name;
    if (object >= sizeof fields->field[i].object || strlen(last) >= sizeof fields->field[i].name ||
        !*last)
        cli_end(CLI_USAGE, "%s is not the name of a field", name);
    memcpy(fields->field[i].object, name, object);
    strcpy(fields->field[i].name, last);
    struct api_json *document = parsed(value, strlen(value), NULL);
    struct api_buffer text;
    api_buffer_init(&text, MOST_BYTES);
    if (document) {
        cli_need(api_buffer_text(&text, value) == PEND_OK);
    } else {
        cli_need(api_out_text(&text, "", value) == PEND_OK); /* "":"value" */
        text.bytes -= 3;
        memmove(text.data, text.data + 3, text.bytes);
    }
    fields->field[i].json = strndup(text.data, text.bytes);
    cli_need(fields->field[i].json != NULL);
    api_buffer_clear(&text);
    api_json_free(&document);
}

void cli_fields_clear(struct cli_fields *fields) {
    while (fields->count > 0) free(fields->field[--fields->count].json);
}

void cli_assign(struct cli_fields *fields, const char *assignment) {
    const char *sign = strchr(assignment, '=');
    if (!sign) cli_end(CLI_USAGE, "%s is not NAME=VALUE", assignment);
    char *name = strndup(assignment, (size_t)(sign - assignment));
    cli_need(name != NULL);
    cli_field(fields, name, sign + 1);
    free(name);
}

static void strict(struct cli_fields *fields, const char *name, const char *json) {
    struct api_json *document = parsed(json, strlen(json), name);
    api_json_free(&document);
    cli_field(fields, name, json);
}

void cli_list(struct cli_fields *fields, const char *name, const char *numbers) {
    char *text = malloc(strlen(numbers) + 3);
    cli_need(text != NULL);
    sprintf(text, "[%s]", numbers);
    strict(fields, name, text);
    free(text);
}

void cli_times(struct cli_fields *fields, const char *text) {
    char start[40], stop[40], mark[2], last[40], json[200];
    int end = 0;
    if (strchr(text, ',') && !strchr(text, ':')) {
        cli_list(fields, "times", text);
        return;
    }
    if (sscanf(text, "%39[-+.0-9eE]:%39[-+.0-9eE]%1[:/]%39[-+.0-9eE]%n", start, stop, mark, last,
               &end) < 4 ||
        text[end])
        cli_end(CLI_USAGE, "%s is neither START:STOP:STEP nor START:STOP/COUNT", text);
    snprintf(json, sizeof json, "{\"start\":%s,\"stop\":%s,\"%s\":%s}", start, stop,
             *mark == '/' ? "count" : "step", last);
    strict(fields, "times", json);
}

char *cli_axis(const char *text) {
    char name[20], arm[20], json[300];
    double start, stop;
    int count, end = 0;
    if (sscanf(text, "%19[a-z]%19[0-9]:%lf:%lf:%d%n", name, arm, &start, &stop, &count, &end) < 5) {
        strcpy(arm, "");
        if (sscanf(text, "%19[a-z]:%lf:%lf:%d%n", name, &start, &stop, &count, &end) < 4) end = 0;
    }
    if (!end || text[end] || !isfinite(start) || !isfinite(stop))
        cli_end(CLI_USAGE, "%s is not an axis such as theta1:-3:3:512", text);
    snprintf(json, sizeof json, "{\"vary\":\"%s\"%s%s,\"start\":%.17g,\"stop\":%.17g,\"count\":%d}",
             name, *arm ? ",\"arm\":" : "", arm, start, stop, count);
    char *copy = strdup(json);
    cli_need(copy != NULL);
    return copy;
}

/* whether the command line has member `name` of `object`, or, if `name` is NULL, any member of
 * it */
static int has(const struct cli_fields *fields, const char *object, const char *name, int first) {
    for (int i = first; i < fields->count; i++)
        if (!strcmp(fields->field[i].object, object) &&
            (!name || !strcmp(fields->field[i].name, name)))
            return 1;
    return 0;
}

/* writes an object: a value's members, replaced and extended by the command line's */
static void merged(struct api_buffer *out, const struct api_value *value, const char *object,
                   const struct cli_fields *fields) {
    assert(api_buffer_valid(out) && *object);
    cli_need(api_out_open(out, object, '{') == PEND_OK);
    for (struct api_value item = api_value_first(value); api_value_kind(&item) != API_MISSING;
         item = api_value_next(&item))
        if (!has(fields, object, item.key, 0))
            cli_need(api_out_key(out, item.key) == PEND_OK &&
                     api_canonical_write(&item, out) == PEND_OK);
    for (int i = 0; i < fields->count; i++)
        if (!strcmp(fields->field[i].object, object))
            cli_need(api_out_key(out, fields->field[i].name) == PEND_OK &&
                     api_buffer_text(out, fields->field[i].json) == PEND_OK);
    cli_need(api_buffer_add(out, "}", 1) == PEND_OK);
}

static void slurp(struct api_buffer *text, const char *path) {
    FILE *file = strcmp(path, "-") ? fopen(path, "rb") : stdin;
    if (!file) cli_die("%s: %s", path, strerror(errno));
    size_t got;
    do {
        if (api_buffer_room(text, 1 << 16) != PEND_OK) cli_die("%s is too large", path);
        text->bytes += got = fread(text->data + text->bytes, 1, 1 << 16, file);
    } while (got > 0);
    if (ferror(file)) cli_die("%s: %s", path, strerror(errno));
    if (file != stdin) fclose(file);
}

void cli_table(struct cli_fields *fields, const char *path) {
    struct api_buffer text, json;
    struct api_problem problem;
    api_buffer_init(&text, MOST_BYTES);
    api_buffer_init(&json, MOST_BYTES);
    api_problem_init(&problem);
    slurp(&text, path);
    enum pend_status status = api_form_text(text.data, text.bytes, 1, &json, &problem);
    if (status == PEND_INVALID) cli_die("%s: %s", path, problem.detail);
    cli_need(status == PEND_OK && api_buffer_add(&json, "", 1) == PEND_OK);
    cli_field(fields, "data.csv", json.data);
    api_buffer_clear(&text);
    api_buffer_clear(&json);
}

void cli_body(struct api_buffer *out, const char *path, const struct cli_fields *fields) {
    struct api_buffer text;
    assert(out->bytes == 0); /* the last byte of the buffer decides whether a comma is written */
    api_buffer_init(&text, MOST_BYTES);
    slurp(&text, path);
    struct api_json *document = parsed(text.data, text.bytes, path);
    struct api_value root = api_json_root(document);
    if (api_value_kind(&root) != API_OBJECT)
        cli_end(CLI_FAILED + cli_scheduled, "%s does not contain a JSON object", path);
    struct api_value pendulum = api_value_member(&root, "pendulum");
    struct api_value trials = api_value_member(&root, "trials"); // trials need no pendulum
    int tried = api_value_kind(&trials) != API_MISSING;
    int alone = (api_value_kind(&pendulum) == API_MISSING) > tried;
    cli_need(api_buffer_add(out, "{", 1) == PEND_OK);
    if (!tried) merged(out, alone ? &root : &pendulum, "pendulum", fields);
    for (struct api_value item = api_value_first(&root);
         !alone && api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) {
        if (!strcmp(item.key, "pendulum") || has(fields, "", item.key, 0) ||
            has(fields, item.key, NULL, 0))
            continue;
        cli_need(api_out_key(out, item.key) == PEND_OK &&
                 api_canonical_write(&item, out) == PEND_OK);
    }
    for (int i = 0; i < fields->count; i++) {
        const char *object = fields->field[i].object;
        struct api_value value = api_value_member(&root, object);
        if (!*object) {
            cli_need(api_out_key(out, fields->field[i].name) == PEND_OK &&
                     api_buffer_text(out, fields->field[i].json) == PEND_OK);
        } else if (strcmp(object, "pendulum") && !has(fields, object, NULL, i + 1)) {
            merged(out, &value, object, fields);
        }
    }
    cli_need(api_buffer_add(out, "}", 1) == PEND_OK);
    api_json_free(&document);
    api_buffer_clear(&text);
}
