/* The answers of a class as a table for spreadsheets, and as histograms.
 * Leaves to others: reading the items, in the order of their changes (server/classes).
 * Invariant: a spreadsheet never reads a pupil's text as a formula; numbers are the shortest that
 * read back to the same double. */
#pragma once

#include "api/class/class_json.h"

/* The format of a table. */
enum api_class_sheet {
    API_CLASS_SHEET_PLAIN, /* RFC 4180 */
    API_CLASS_SHEET_POINT, /* with a byte order mark, for spreadsheets */
    API_CLASS_SHEET_COMMA  /* also with decimal commas, and semicolons between cells */
};

/* The nicknames of the pupils read so far; initialized with {0}. */
struct api_class_names {
    enum api_class_sheet sheet;
    char **name; /* by pupil number; NULL if unknown */
    long count;
};

/** Frees the nicknames. */
void api_class_names_clear(struct api_class_names *names);

/** Appends the header of the table: item,id,step,pupil,nickname,value,changed. Fails as
 * api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_class_table_begin(const struct api_class_names *names,
                                                       struct api_buffer *out);

/**
 * Appends the rows of an item as CSV (RFC 4180): one for a question (its text), a solution, an
 * answer and the state of a pupil's stage; one for each step of a hand-in; none for other items. A
 * possible formula at the beginning of a text, or after a character that some program takes for a
 * separator
 * (; , tab, line end), gets a ' before it.
 *
 * names  the pupils' nicknames, which come before their answers.
 *
 * PEND_INVALID    the stored item is damaged.
 * Otherwise fails as api_buffer_room does. O(item).
 */
PEND_MUST_CHECK enum pend_status api_class_table_add(const struct api_class_item *item,
                                                     struct api_class_names *names,
                                                     struct api_buffer *out);

/* The answers to one question; initialized with {0}. */
struct api_class_tally {
    long answers;
    double *number; /* the numbers among the answers, `numbers` of them */
    long numbers, room;
    struct api_class_tally_text {
        char *text;
        long count;
    } * text; /* the different texts, `texts` of them */
    long texts, text_room;
};

/** Frees the answers. */
void api_class_tally_clear(struct api_class_tally *tally);

/** Counts an answer. PEND_INVALID as for api_class_table_add, PEND_NO_MEMORY. O(different texts).
 */
PEND_MUST_CHECK enum pend_status api_class_tally_add(const struct api_class_item *item,
                                                     struct api_class_tally *tally);

/** Appends the histogram: {"answers", "values": [{"value", "count"}], "bins": [{"from", "to",
 * "count"}]}. Up to 24 different numbers are listed one by one; more are counted in twelve bins of
 * equal width, of which the last includes its upper end. Texts are always listed, at most 100, the
 * most frequent first. Sorts the numbers. Fails as api_buffer_room does. O(n log n). */
PEND_MUST_CHECK enum pend_status api_class_tally_write(struct api_class_tally *tally,
                                                       struct api_buffer *out);
