#include "api/call/form.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

#include "api/base/text.h"
#include "api/call/canonical.h"
#include "api/encode/negotiate.h"
#include "api/read/field.h"

/* maximum number of lines in the head of a part, and maximum bytes of each */
enum { HEAD_LINES = 16, HEAD_LINE = 2000, SHOWN = 40 };

struct span {
    const char *at;
    size_t bytes;
};

struct form {
    const char *body, *end;
    char delimiter[API_FORM_BOUNDARY + 5]; /* CR LF -- boundary */
    size_t length;                         /* length of the delimiter */
    struct span request, table[API_FORM_TABLES];
    int tables;
    struct api_problem *problem;
};

/* ---- cutting */

/* sets the problem at a position; returns 0 */
static int form_fault(const struct form *form, const char *at, const char *text) {
    assert(at >= form->body && at <= form->end);
    api_problem_set(form->problem, 400, "the form is malformed at byte %zu of the body: %s",
                    (size_t)(at - form->body) + 1, text);
    return 0;
}

/* reads the boundary that separates the parts from Content-Type */
static int form_boundary(struct form *form, const char *content_type) {
    static const char also[] = "'()+_,-./:=? ";
    struct span boundary = {NULL, 0};
    (void)api_negotiate_parameter(content_type, strlen(content_type), "multipart/form-data",
                                  "boundary", &boundary.at, &boundary.bytes);
    int good = boundary.at && boundary.bytes >= 1 && boundary.bytes <= API_FORM_BOUNDARY &&
               boundary.at[boundary.bytes - 1] != ' ';
    for (size_t i = 0; good && i < boundary.bytes; i++) {
        char c = boundary.at[i];
        good = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               (c && strchr(also, c));
    }
    if (!good) {
        api_problem_set(form->problem, 400,
                        "Content-Type: multipart/form-data must name a boundary of 1 to %d "
                        "characters (RFC 2046)",
                        API_FORM_BOUNDARY);
        return 0;
    }
    memcpy(form->delimiter, "\r\n--", 4);
    memcpy(form->delimiter + 4, boundary.at, boundary.bytes);
    form->length = boundary.bytes + 4;
    return 1;
}

/* Returns the start of the next part after a boundary; NULL after the last boundary or an error. */
static const char *form_behind(const struct form *form, const char *at) {
    const char *end = form->end;
    if (end - at >= 2 && !memcmp(at, "--", 2)) {
        for (at += 2; at < end; at++)
            if (!strchr(" \t\r\n", *at) || !*at) {
                (void)form_fault(form, at, "nothing may follow the last boundary");
                break;
            }
        return NULL;
    }
    while (at < end && (*at == ' ' || *at == '\t')) at++;
    if (end - at >= 2 && !memcmp(at, "\r\n", 2)) return at + 2;
    (void)form_fault(form, at, "a boundary line must end here");
    return NULL;
}

/* reads one line of a part's head; Content-Disposition gives the part's name */
static int form_line(const struct form *form, struct span line, struct span *name) {
    static const char disposition[] = "Content-Disposition:",
                      coding[] = "Content-Transfer-Encoding:";
    const char *at = line.at;
    if (!memchr(at, ':', line.bytes) || memchr(at, 0, line.bytes))
        return form_fault(form, at, "this line of a part's header is not a header field");
    if (line.bytes >= sizeof coding && !strncasecmp(at, coding, sizeof coding - 1)) {
        struct span base64 = {memmem(at, line.bytes, "64", 2), 2},
                    quoted = {memmem(at, line.bytes, "uoted", 5), 5};
        if (base64.at || quoted.at)
            return form_fault(
                form, at, "this part has a Content-Transfer-Encoding header; send parts unencoded");
    }
    if (line.bytes < sizeof disposition || strncasecmp(at, disposition, sizeof disposition - 1))
        return 1;
    size_t skip = sizeof disposition - 1;
    if (name->at) return form_fault(form, at, "this part has a second Content-Disposition header");
    if (!api_negotiate_parameter(at + skip, line.bytes - skip, "form-data", "name", &name->at,
                                 &name->bytes))
        return form_fault(form, at, "this Content-Disposition is not form-data");
    return 1;
}

/* reads the head of a part; returns where its contents begin, NULL after an error */
static const char *form_head(const struct form *form, const char *at, struct span *name) {
    *name = (struct span){NULL, 0};
    for (int i = 0; i < HEAD_LINES; i++) {
        size_t left = (size_t)(form->end - at), most = left < HEAD_LINE ? left : HEAD_LINE;
        const char *stop = memmem(at, most, "\r\n", 2);
        if (!stop) break;
        if (stop == at && name->at) return at + 2;
        if (stop == at) break;
        if (!form_line(form, (struct span){at, (size_t)(stop - at)}, name)) return NULL;
        at = stop + 2;
    }
    (void)form_fault(form, at,
                     "a part begins with a few header lines, one of them Content-Disposition: "
                     "form-data with a name, and an empty line");
    return NULL;
}

static int form_take(struct form *form, struct span name, struct span part) {
    int request = name.bytes == 7 && !memcmp(name.at, "request", 7);
    if (request && !form->request.at) {
        form->request = part;
        return 1;
    }
    if (!request && name.bytes == 3 && !memcmp(name.at, "csv", 3)) {
        if (form->tables < API_FORM_TABLES) {
            form->table[form->tables++] = part;
            return 1;
        }
        api_problem_set(form->problem, 422, "the form has more than %d parts named csv",
                        API_FORM_TABLES);
        return 0;
    }
    int shown = name.bytes < SHOWN ? (int)name.bytes : SHOWN;
    api_problem_set(
        form->problem, 422,
        request ? "the form has two parts named %.*s"
                : "the form has an unknown part \"%.*s\"; its parts are request (the request "
                  "as JSON) and csv (a table)",
        shown, name.at);
    return 0;
}

static int form_cut(struct form *form) {
    size_t first = form->length - 2, bytes = (size_t)(form->end - form->body);
    if (bytes < first || memcmp(form->body, form->delimiter + 2, first) != 0)
        return form_fault(form, form->body,
                          "the body must start with the boundary given in Content-Type");
    const char *at = form->body + first;
    while ((at = form_behind(form, at))) {
        struct span name;
        const char *from = form_head(form, at, &name);
        if (!from) return 0;
        // the empty line after the head may belong to the delimiter, if the part is empty
        const char *stop =
            memmem(from - 2, (size_t)(form->end - from) + 2, form->delimiter, form->length);
        if (!stop) return form_fault(form, from, "this part has no closing boundary");
        struct span part = {from, stop > from ? (size_t)(stop - from) : 0};
        if (!form_take(form, name, part)) return 0;
        at = stop + form->length;
    }
    if (!form->problem->status && !form->request.at && form->tables)
        form->request = (struct span){"{}", 2};
    if (!form->problem->status && !form->request.at)
        api_problem_set(form->problem, 422,
                        "the form has no part named request, the request as JSON");
    return !form->problem->status;
}

/* ---- writing */

/* how to save as text a file that begins like this */
static const struct {
    const char *begins;
    size_t bytes;
    const char *save;
} programs[] = {
    {"PK\3\4", 4,
     "is an archive: save a spreadsheet as CSV, unpack a phyphox export, and write NPZ by "
     "numpy.savetxt"},
    {"\xd0\xcf\x11\xe0", 4, "is an Excel file (.xls): save it as CSV"},
    {"MATLAB 5.0", 10, "is a .mat file: writematrix([t theta], \"track.csv\") saves text"},
    {"\x93NUMPY", 6,
     "is a NumPy array: numpy.savetxt(\"track.csv\", array, delimiter=\",\") saves text"},
    {"\x1f\x8b", 2, "is compressed: unpack it"}};

/* whether a table is plain text; adds a problem at the first other byte */
static int table_plain(const struct span *table, int number, struct api_problem *problem) {
    for (size_t k = 0; k < sizeof programs / sizeof *programs; k++)
        if (table->bytes >= programs[k].bytes &&
            !memcmp(table->at, programs[k].begins, programs[k].bytes)) {
            api_problem_set(problem, 422, "part csv number %d %s", number, programs[k].save);
            return 0;
        }
    for (size_t at = 0; at < table->bytes; at++) {
        unsigned char c = (unsigned char)table->at[at];
        if ((c >= ' ' && c != 127) || (c && strchr("\t\r\n", c))) continue;
        api_problem_set(problem, 422,
                        "byte %zu of part csv number %d is a control character: a table is text",
                        at + 1, number);
        return 0;
    }
    return 1;
}

/* whether a table is UTF-16, judging by the byte order mark at its start */
static int is_utf16(const struct span *table) {
    return table->bytes >= 2 &&
           (!memcmp(table->at, "\xff\xfe", 2) || !memcmp(table->at, "\xfe\xff", 2));
}

/* appends UTF-16 or ISO 8859-1 as the inside of a JSON string; control characters and those beyond
 * U+FFFF become '?' */
static enum pend_status table_convert(const struct span *table, struct api_buffer *out) {
    size_t wide = is_utf16(table);
    int low = !wide || (unsigned char)table->at[0] == 0xff;
    for (size_t at = 2 * wide; at + wide < table->bytes; at += 1 + wide) {
        unsigned first = (unsigned char)table->at[at];
        unsigned second = wide ? (unsigned char)table->at[at + 1] : 0;
        unsigned c = low ? second << 8 | first : first << 8 | second;
        char text[3] = {(char)(0xe0 | c >> 12), (char)(0x80 | (c >> 6 & 0x3f)),
                        (char)(0x80 | (c & 0x3f))};
        int bytes = c < 0x80 ? 1 : c < 0x800 ? 2 : 3;
        if (bytes == 2) text[1] = (char)(0xc0 | c >> 6);
        int control = (c < ' ' && !strchr("\t\r\n", (int)c)) || !c;
        if (control || (c >= 0xd800 && c < 0xe000)) c = '?', bytes = 1;
        if (bytes == 1) text[2] = (char)c;
        PEND_TRY(api_text_escape(out, text + 3 - bytes, (size_t)bytes));
    }
    return PEND_OK;
}

enum pend_status api_form_text(const char *text, size_t bytes, int number, struct api_buffer *out,
                               struct api_problem *problem) {
    struct span table = {text, bytes};
    int utf8 = !is_utf16(&table);
    if (bytes >= 3 && !memcmp(text, "\xef\xbb\xbf", 3)) table.at += 3, table.bytes -= 3;
    if (utf8 && !table_plain(&table, number, problem)) return PEND_INVALID;
    for (size_t at = 0; at < table.bytes && utf8;) {
        int length = api_text_utf8(table.at + at, table.bytes - at);
        utf8 = length > 0, at += (size_t)length;
    }
    PEND_TRY(api_buffer_text(out, "\""));
    PEND_TRY(utf8 ? api_text_escape(out, table.at, table.bytes) : table_convert(&table, out));
    return api_buffer_text(out, "\"");
}

/* appends an object with one more member, a table */
static enum pend_status form_with(const struct form *form, const struct api_value *object, int i,
                                  struct api_buffer *out) {
    struct api_value had = api_value_member(object, "csv");
    if (api_value_kind(&had) != API_MISSING) {
        api_value_fault(&had, form->problem,
                        API_CODE_CONFLICT
                        "is also sent as a part of the form: leave one of them out");
        return PEND_INVALID;
    }
    PEND_TRY(api_buffer_text(out, "{"));
    API_VALUE_EACH (member, api_value_first(object)) {
        PEND_TRY(api_out_key(out, member.key));
        PEND_TRY(api_canonical_write(&member, out));
    }
    PEND_TRY(api_out_key(out, "csv"));
    PEND_TRY(api_form_text(form->table[i].at, form->table[i].bytes, i + 1, out, form->problem));
    return api_buffer_text(out, "}");
}

/* appends the runs with one table each */
static enum pend_status form_runs(const struct form *form, const struct api_value *runs,
                                  struct api_buffer *out) {
    int count = api_value_count(runs), objects = api_value_kind(runs) == API_ARRAY;
    struct api_value run = api_value_first(runs);
    for (; objects && api_value_kind(&run) != API_MISSING; run = api_value_next(&run))
        objects = api_value_kind(&run) == API_OBJECT;
    if (!objects || count != form->tables) {
        api_value_fault(runs, form->problem,
                        API_CODE_WRONG_COUNT
                        "must be an array of %d objects, one for each part named csv",
                        form->tables);
        return PEND_INVALID;
    }
    PEND_TRY(api_buffer_text(out, "["));
    run = api_value_first(runs);
    for (int i = 0; i < count; i++, run = api_value_next(&run)) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(form_with(form, &run, i, out));
    }
    return api_buffer_text(out, "]");
}

/* appends `data` with the tables */
static enum pend_status form_data(const struct form *form, const struct api_value *data,
                                  struct api_buffer *out) {
    struct api_value runs = api_value_member(data, "runs");
    int several = api_value_kind(&runs) != API_MISSING;
    if (api_value_kind(data) != API_MISSING && !api_field_object(data, NULL, form->problem))
        return PEND_INVALID;
    if (!several && form->tables > 1) {
        api_value_fault(&runs, form->problem,
                        API_CODE_MISSING "is required with several parts named csv: an array of %d "
                                         "objects, one for each run, each at least {}",
                        form->tables);
        return PEND_INVALID;
    }
    if (!several) return form_with(form, data, 0, out);
    PEND_TRY(api_buffer_text(out, "{"));
    API_VALUE_EACH (member, api_value_first(data)) {
        PEND_TRY(api_out_key(out, member.key));
        PEND_TRY(strcmp(member.key, "runs") ? api_canonical_write(&member, out)
                                            : form_runs(form, &member, out));
    }
    return api_buffer_text(out, "}");
}

static enum pend_status form_write(const struct form *form, const struct api_value *root,
                                   struct api_buffer *out) {
    struct api_value data = api_value_member(root, "data"), member = api_value_first(root);
    if (!api_field_object(root, NULL, form->problem)) return PEND_INVALID;
    PEND_TRY(api_buffer_text(out, "{"));
    for (; api_value_kind(&member) != API_MISSING; member = api_value_next(&member)) {
        if (!strcmp(member.key, "data")) continue;
        PEND_TRY(api_out_key(out, member.key));
        PEND_TRY(api_canonical_write(&member, out));
    }
    PEND_TRY(api_out_key(out, "data"));
    PEND_TRY(form_data(form, &data, out));
    return api_buffer_text(out, "}");
}

enum pend_status api_form_json(const char *content_type, const char *body, size_t bytes,
                               const struct api_limits *limits, struct api_buffer *out,
                               struct api_problem *problem) {
    struct form form = {.body = body, .end = body + bytes, .problem = problem};
    struct api_json *document = NULL;
    assert(!out->bytes && body);
    if (!form_boundary(&form, content_type) || !form_cut(&form)) return PEND_INVALID;
    if (!form.tables) return api_buffer_add(out, form.request.at, form.request.bytes);
    enum pend_status status =
        api_json_new(&document, form.request.at, form.request.bytes, (int)limits->depth, problem);
    if (status == PEND_OK) {
        struct api_value root = api_json_root(document);
        status = form_write(&form, &root, out);
    }
    api_json_free(&document);
    return status;
}
