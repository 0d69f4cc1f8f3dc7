/* Templates of programs and formulas.
 * Leaves to others: the values of the names (equations).
 * Invariant: the template decides all text except for what `write` appends.
 *
 *     <<name>>                 the text that `write` appends <<#name>>...<</name>>    the text in
 *     between, once for each iteration of `next` <<^name>>...<</name>>    the text in between if
 *     there is no iteration
 *
 * Sections nest, but not inside a section of the same name. If a tag of a section is alone on its
 * line, that line end is removed. */
#pragma once

#include "api/base/buffer.h"

struct api_template {
    const char *text;
    int joined; /* whether line ends, and the spaces after them, are removed */
    void *context;
    /** Starts a section if `round` is -1, otherwise continues it. Returns the index of the
     * iteration, -1 at the end. The name is not terminated by a NUL. */
    int (*next)(void *context, const char *name, int length, int round);
    /** Appends the value of a name; fails as api_buffer_room does. */
    enum pend_status (*write)(void *context, const char *name, int length, struct api_buffer *out);
};

/** Appends the template's text with all names replaced. section: expand only this section, whose
 * tags are on lines of their own; NULL = everything. Fails as `write` and api_buffer_add do. */
PEND_MUST_CHECK enum pend_status api_template_fill(const struct api_template *template,
                                                   const char *section, struct api_buffer *out);
