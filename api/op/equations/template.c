#include "api/op/equations/template.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { TEMPLATE_TAG = 40 }; /* maximum bytes of a tag */

/* the first occurrence of a string within at .. end, or end; the text continues after end, or is
 * terminated by a NUL */
static const char *template_find(const char *at, const char *end, const char *wanted) {
    size_t length = strlen(wanted);
    while ((at = memchr(at, *wanted, (size_t)(end - at))) && strncmp(at, wanted, length) != 0) at++;
    return at ? at : end;
}

static enum pend_status template_literal(const struct api_template *template, const char *at,
                                         const char *end, struct api_buffer *out) {
    while (template->joined && at < end) {
        const char *line = template_find(at, end, "\n");
        PEND_TRY(api_buffer_add(out, at, (size_t)(line - at)));
        for (at = line; at < end && (*at == '\n' || *at == ' '); at++) continue;
    }
    return api_buffer_add(out, at, (size_t)(end - at));
}

/* the position after a tag, or after the line end if the tag is alone on its line */
static const char *template_behind(const char *tag, const char *stop) {
    return tag[-1] == '\n' && stop[2] == '\n' ? stop + 3 : stop + 2;
}

static enum pend_status template_part(const struct api_template *template, const char *at,
                                      const char *end, struct api_buffer *out);

/* expands a section whose tag is at tag .. stop; moves `at` to the end of the section */
static enum pend_status template_section(const struct api_template *template, const char **at,
                                         const char *stop, const char *end,
                                         struct api_buffer *out) {
    const char *tag = *at, *name = tag + 3, *body = template_behind(tag, stop), *last = stop;
    int length = (int)(stop - name);
    do last = template_find(last + 1, end, "<</");
    while (last < end && (strncmp(last + 3, name, (size_t)length) != 0 || last[3 + length] != '>'));
    assert(last < end);
    int round = template->next(template->context, name, length, -1);
    if (tag[2] == '^' && round < 0) PEND_TRY(template_part(template, body, last, out));
    while (round >= 0) {
        if (tag[2] == '#') PEND_TRY(template_part(template, body, last, out));
        round = template->next(template->context, name, length, round);
    }
    *at = template_behind(last, last + 3 + length);
    return PEND_OK;
}

static enum pend_status template_part(const struct api_template *template, const char *at,
                                      const char *end, struct api_buffer *out) {
    for (;;) {
        const char *tag = template_find(at, end, "<<");
        PEND_TRY(template_literal(template, at, tag, out));
        if (tag == end) return PEND_OK;
        const char *stop = template_find(tag, end, ">>");
        at = tag;
        if (tag[2] == '#' || tag[2] == '^') {
            PEND_TRY(template_section(template, &at, stop, end, out));
        } else {
            PEND_TRY(template->write(template->context, tag + 2, (int)(stop - tag - 2), out));
            at = stop + 2;
        }
    }
}

enum pend_status api_template_fill(const struct api_template *template, const char *section,
                                   struct api_buffer *out) {
    // a template starts with a line end
    const char *at = template->text + 1, *end = strchr(at, '\0');
    if (section) {
        char tag[TEMPLATE_TAG];
        int length = snprintf(tag, sizeof tag, "\n<<#%s>>\n", section);
        assert(length < TEMPLATE_TAG);
        at = strstr(template->text, tag);
        assert(at);
        at += length;
        (void)snprintf(tag, sizeof tag, "\n<</%s>>\n", section);
        end = strstr(at, tag);
        assert(end);
        end++;
    }
    return template_part(template, at, end, out);
}
