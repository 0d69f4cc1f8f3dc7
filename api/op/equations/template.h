/* Text with places to fill in, for programs and formulas.
 * Leaves to others: what the names mean (equations_names).
 * Invariant: the template decides all text except for what `write` appends.
 *
 *     <<name>>                 what `write` appends
 *     <<#name>>...<</name>>    the text in between, once for each round that `next` counts
 *     <<^name>>...<</name>>    the text in between if there is no round
 *
 * Sections nest, but not inside a section of the same name. The end of a line on which such a tag
 * stands alone does not count. */
#ifndef API_TEMPLATE_H
#define API_TEMPLATE_H

#include "api/base/buffer.h"

struct api_template {
    const char *text;
    int joined; /* ends of lines, and the spaces behind them, are left out */
    void *context;
    /** Begins a section if `round` is -1, goes on with it if not; returns the round, -1 at the end.
     * The name is not terminated. */
    int (*next)(void *context, const char *name, int length, int round);
    /** Appends what a name stands for; fails as api_buffer_room does. */
    enum pend_status (*write)(void *context, const char *name, int length, struct api_buffer *out);
};

/** Appends the template's text, filled in; section: of this one alone, which stands on lines of its
 * own, NULL = all. Fails as `write` and api_buffer_add do. */
PEND_MUST_CHECK enum pend_status api_template_fill(const struct api_template *template,
                                                   const char *section, struct api_buffer *out);

#endif
