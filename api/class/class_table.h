/* What a class has answered, as a table for a spreadsheet, and how often each answer came.
 * Leaves to others: reading the items, in the order of their versions (server/classes).
 * Invariant: a text of a pupil's is a text to a spreadsheet too, never a formula; numbers are the
 * shortest that read back to the same double. */
#ifndef API_CLASS_TABLE_H
#define API_CLASS_TABLE_H

#include "api/class/class_json.h"

/* How a table is written. */
enum api_class_sheet {
    API_CLASS_SHEET_PLAIN, /* RFC 4180 */
    API_CLASS_SHEET_POINT, /* with the mark of UTF-8 first, for spreadsheets */
    API_CLASS_SHEET_COMMA  /* the same where numbers have a comma: cells part at semicolons */
};

/* The nicknames of the pupils that were met; begins as {0}. */
struct api_class_names {
    enum api_class_sheet sheet;
    char **name; /* by number, `count` of them, NULL where there is none */
    long count;
};

/** Frees them. */
void api_class_names_clear(struct api_class_names *names);

/** Appends the header of the table: item,id,step,pupil,nickname,value,changed. Fails as
 * api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_class_table_begin(const struct api_class_names *names,
                                                       struct api_buffer *out);

/**
 * Appends the rows of an item, CSV as RFC 4180 has it: one for a question (its text), a solution,
 * an answer and the state of a pupil's stage, one for each step of what is handed in; none for
 * others. What a spreadsheet could take for a formula at the beginning of a text, or within it
 * where a cell may part (; , tab, line end), has a ' in front, so that no spreadsheet of any
 * language computes it.
 *
 * names  the pupils' nicknames, which come before their answers.
 *
 * PEND_INVALID    the item's value is not what was kept.
 * Fails else as api_buffer_room does. O(item).
 */
PEND_MUST_CHECK enum pend_status api_class_table_add(const struct api_class_item *item,
                                                     struct api_class_names *names,
                                                     struct api_buffer *out);

/* Answers to one question; begins as {0}. */
struct api_class_tally {
    long answers;
    double *number; /* `numbers` of them */
    long numbers, room;
    struct api_class_tally_text {
        char *text;
        long count;
    } * text; /* `texts` different ones */
    long texts, text_room;
};

/** Frees it. */
void api_class_tally_clear(struct api_class_tally *tally);

/** Counts an answer. PEND_INVALID as api_class_table_add, PEND_NO_MEMORY. O(different texts). */
PEND_MUST_CHECK enum pend_status api_class_tally_add(const struct api_class_item *item,
                                                     struct api_class_tally *tally);

/**
 * Appends the histogram: {"answers", "values": [{"value", "count"}], "bins": [{"from", "to",
 * "count"}]}. Each value of its own where there are 24 different numbers or fewer, else twelve
 * bins of one width from the least to the greatest, of which the last has its end too; texts always
 * of their own, those that came most often first, 100 at most. Sorts the numbers. Fails as
 * api_buffer_room does. O(n log n).
 */
PEND_MUST_CHECK enum pend_status api_class_tally_write(struct api_class_tally *tally,
                                                       struct api_buffer *out);

#endif
