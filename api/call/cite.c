#include "api/call/cite.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "api/call/job_json.h"

enum { CITE_DATE = 10 }; /* letters of a date, 2026-01-31 */

enum pend_status api_cite_digest(struct api_cite *cite) {
    struct api_digest_stream *stream = api_digest_begin();
    if (!stream) return PEND_NO_MEMORY;
    api_digest_add(stream, cite->request, cite->request_bytes);
    api_digest_end(&stream, cite->digest);
    return PEND_OK;
}

/* what an operation computes, for people */
static const char *cite_what(const char *operation) {
    static const struct {
        const char *operation, *what;
    } row[] = {{"trajectories", "Trajectory"},
               {"ensembles", "Ensemble of motions"},
               {"lyapunov", "Lyapunov exponents"},
               {"sections", "Poincare sections"},
               {"modes", "Modes"},
               {"forces", "Forces"},
               {"response", "Linear response"},
               {"fits", "Fit"},
               {"orbits", "Periodic orbits"}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        if (!strcmp(row[i].operation, operation)) return row[i].what;
    return "Run";
}

void api_cite_name(const struct api_cite *cite, char name[API_CITE_NAME]) {
    if (cite->title[0])
        snprintf(name, API_CITE_NAME, "%s", cite->title);
    else
        snprintf(name, API_CITE_NAME, "%s of a planar pendulum tree (run %.8s)",
                 cite_what(cite->operation), cite->id);
}

/* appends a text within braces, so that TeX prints it as it is */
static enum pend_status cite_text(const char *text, struct api_buffer *out) {
    static const struct {
        char letter;
        const char *tex;
    } special[] = {{'\\', "{\\textbackslash}"},
                   {'~', "{\\textasciitilde}"},
                   {'^', "{\\textasciicircum}"},
                   {'{', "{\\textbraceleft}"},
                   {'}', "{\\textbraceright}"},
                   {'#', "\\#"},
                   {'$', "\\$"},
                   {'%', "\\%"},
                   {'&', "\\&"},
                   {'_', "\\_"},
                   {'"', "{\\textquotedbl}"}};
    for (; *text; text++) {
        size_t i = 0, count = sizeof special / sizeof *special;
        while (i < count && special[i].letter != *text) i++;
        if (i < count)
            PEND_TRY(api_buffer_text(out, special[i].tex));
        else
            PEND_TRY(api_buffer_add(out, text, 1));
    }
    return PEND_OK;
}

static enum pend_status cite_field(const char *name, const char *text, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(out, ",\n  %s = {{", name));
    PEND_TRY(cite_text(text, out));
    return api_buffer_text(out, "}}");
}

enum pend_status api_cite_write(const struct api_cite *cite, struct api_buffer *out) {
    char name[API_CITE_NAME], date[CITE_DATE + 1] = "1970-01-01";
    struct api_buffer text;
    assert(cite->finished > 0 && cite->digest[0]);
    api_buffer_init(&text, 256);
    PEND_TRY(api_job_time(&text, "d", cite->finished));
    /* "d":"2026-01-31T... */
    if (text.bytes > 5 + CITE_DATE) memcpy(date, text.data + 5, CITE_DATE);
    api_buffer_clear(&text);
    api_cite_name(cite, name);
    PEND_TRY(api_buffer_format(out, "@misc{pendulumd-%s", cite->id));
    PEND_TRY(cite_field("title", name, out));
    if (cite->author && cite->author[0]) {
        /* a person's name is not kept together, so that it is sorted by its last part */
        PEND_TRY(api_buffer_text(out, ",\n  author = {"));
        PEND_TRY(cite_text(cite->author, out));
        PEND_TRY(api_buffer_text(out, "}"));
    } else {
        PEND_TRY(cite_field("author", "pendulumd", out));
    }
    PEND_TRY(api_buffer_format(out, ",\n  year = {%.4s},\n  month = {%.2s},\n  date = {%s}", date,
                               date + 5, date));
    PEND_TRY(cite_field("howpublished", "Computed by pendulumd", out));
    if (cite->version[0]) PEND_TRY(cite_field("version", cite->version, out));
    PEND_TRY(api_buffer_format(out, ",\n  url = {%s/v1/jobs/%s/results}", cite->origin, cite->id));
    PEND_TRY(api_buffer_format(out, ",\n  note = {Operation %s, request SHA-256 %s%s%s}\n}\n",
                               cite->operation, cite->digest, cite->version[0] ? ", version " : "",
                               cite->version));
    return PEND_OK;
}
