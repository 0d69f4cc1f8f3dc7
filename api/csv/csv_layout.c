#include "api/csv/csv_layout.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    SAMPLE = 400, /* rows that determine the layout */
    LINES = 2000, /* lines of the file in which these rows are sought */
    FEW_SWINGS = 5,
    HEADS = 3 /* lines above the rows in which names, groups and units are sought */
};

static const double two_pi = 6.28318530717958647692;

static int is_row(const char *line, char separator, int *width, int *words) {
    struct api_csv_cell cell[API_CSV_COLUMNS];
    int count = api_csv_cut(line, separator, cell), numbers = 0;
    if (count > API_CSV_COLUMNS) count = API_CSV_COLUMNS;
    *words = 0;
    for (int i = 0; i < count; i++) {
        double x;
        enum api_csv_kind kind = api_csv_read(&cell[i], 0, &x);
        if (kind == API_CSV_WORD) kind = api_csv_read(&cell[i], 1, &x);
        numbers += kind == API_CSV_NUMBER || kind == API_CSV_CLOCK;
        *words += kind == API_CSV_WORD;
    }
    *width = count;
    return count > 1 && numbers > 0;
}

static int is_bare(const char *line) {
    return !line[strspn(line, " \t,;\"")] || strchr("\r\n", line[strspn(line, " \t,;\"")]);
}

static int is_comment(const char *line) {
    line += strspn(line, " \t\"");
    return *line == '#' || *line == '%' || !strncmp(line, "//", 2);
}

/* The start of the table if this is the separator: the first of two rows of equal width, or the
 * only row. `rows` is the number of rows of that width in the sample. */
struct start {
    const char *at;
    int line, width, words;
    long rows;
};

static void start_find(const char *text, char separator, int words_allowed, struct start *found) {
    struct start now = {NULL, 0, 0, 0, 0};
    int number = 1, width, words;
    *found = now;
    for (const char *line = text; *line && found->rows + now.rows < SAMPLE && number < LINES;
         line = api_csv_line_next(line), number++) {
        if (is_bare(line) || is_comment(line)) continue;
        if (!is_row(line, separator, &width, &words)) continue;
        if (words && (!words_allowed || width <= words + 1)) continue;
        if (!now.rows || width != now.width) {
            if (now.rows > found->rows) *found = now;
            now = (struct start){line, number, width, words, 0};
        }
        now.rows++;
    }
    if (now.rows > found->rows) *found = now;
}

/* returns the separator that gives the most rows; among equals the first in this list */
static char layout_separator(const char *text, struct start *best) {
    static const char separators[] = "\t;, ";
    char found = 0;
    for (int words = 0; words < 2 && !found; words++) {
        for (const char *c = separators; *c; c++) {
            struct start start;
            start_find(text, *c, words, &start);
            if (start.rows > (found ? best->rows : 0)) *best = start, found = *c;
        }
    }
    return found;
}

/* --- names --- */

static int head_cut(const struct api_csv *csv, const char *line,
                    struct api_csv_cell cell[API_CSV_COLUMNS]) {
    memset(cell, 0, API_CSV_COLUMNS * sizeof *cell);
    // the characters that make the line a comment
    if (is_comment(line)) line += strspn(line, "#%/ \t\"");
    return api_csv_cut(line, csv->separator, cell);
}

/* true if a line has only units, and at least two of them */
static int is_units(const struct api_csv_cell cell[], int count) {
    int units = 0;
    for (int i = 0; i < count && i < API_CSV_COLUMNS; i++) {
        if (!cell[i].bytes) continue;
        if (!api_csv_is_unit(&cell[i])) return 0;
        units++;
    }
    return units > 1;
}

/* reads the lines above the rows, starting with the nearest */
static int head_lines(const char *text, const struct start *start, const char *line[HEADS],
                      int number[HEADS]) {
    int count = 0, at = 1;
    for (const char *now = text; now < start->at; now = api_csv_line_next(now), at++) {
        if (is_bare(now)) continue;
        for (int i = HEADS - 1; i > 0; i--) line[i] = line[i - 1], number[i] = number[i - 1];
        line[0] = now, number[0] = at;
        if (count < HEADS) count++;
    }
    return count;
}

static void layout_names(struct api_csv *csv, const char *text, const struct start *start) {
    struct api_csv_cell cell[API_CSV_COLUMNS];
    const char *line[HEADS] = {NULL};
    int number[HEADS] = {0}, lines = head_lines(text, start, line, number), at = 0;
    int count = lines ? head_cut(csv, line[0], cell) : 0;
    if (count > 1 && is_units(cell, count)) {
        for (int i = 0; i < csv->columns; i++) csv->column[i].unit = cell[i];
        at = 1;
        count = lines > 1 ? head_cut(csv, line[1], cell) : 0;
    }
    // a line with another number of cells is a title
    if (at >= lines || count < 2 || count > csv->columns + 1) return;
    csv->head = number[at];
    for (int i = 0; i < csv->columns; i++) csv->column[i].name = cell[i];
    if (at + 1 >= lines) return;
    count = head_cut(csv, line[at + 1], cell);
    // a name that spans several columns, such as a tracked body's, applies to each of them
    struct api_csv_cell now = {NULL, 0};
    for (int i = 0; i < csv->columns && count == csv->columns; i++) {
        if (cell[i].bytes) now = cell[i];
        csv->column[i].group = now;
    }
}

/* --- rows --- */

static void layout_mark(struct api_csv *csv, const char *begin) {
    long comma = 0, point = 0, either = 0, rows = 0;
    for (const char *line = begin; *line && rows < SAMPLE; line = api_csv_line_next(line), rows++) {
        struct api_csv_cell cell[API_CSV_COLUMNS];
        int count = api_csv_cut(line, csv->separator, cell);
        for (int i = 0; i < count && i < csv->columns; i++) {
            int mark = api_csv_mark(&cell[i]);
            comma += mark > 0, point += mark < 0;
            either += !mark && memchr(cell[i].at, ',', (size_t)cell[i].bytes) != NULL;
        }
    }
    csv->comma = comma > point || (!comma && !point && either);
    csv->doubtful = !comma && !point && either;
}

/* updates the swing between turning points, and counts complete ones */
static void column_swing(struct api_csv_column *column, double step) {
    int way = (step > 0) - (step < 0);
    if (!way) return;
    if (column->way && way != column->way) {
        double size = column->last - column->from, mid = column->from + size / 2;
        double weight =
            column->swings++ ? size * size : 0; // the first swing starts at no turning point
        column->wide += fabs(size) > two_pi;
        column->weight += weight, column->weights += weight * weight;
        column->mid += weight * mid, column->mids += weight * mid * mid;
        column->reach += weight * fabs(size) / 2;
        column->from = column->last;
    }
    column->way = way;
}

int api_csv_center(const struct api_csv_column *column, double *center, double *error,
                   double *reach) {
    double weight = column->weight, count = weight * weight / column->weights;
    if (!(count >= FEW_SWINGS)) return 0;
    *center = column->mid / weight, *reach = column->reach / weight;
    *error = sqrt(fmax(column->mids / weight - *center * *center, 0) / count);
    return 1;
}

static void column_add(struct api_csv_column *column, enum api_csv_kind kind, double x, long row,
                       int line) {
    long before = column->numbers + column->clocks;
    if (kind == API_CSV_WORD && !column->words++) column->word_line = line;
    if (kind != API_CSV_NUMBER && kind != API_CSV_CLOCK) return;
    column->numbers += kind == API_CSV_NUMBER, column->clocks += kind == API_CSV_CLOCK;
    if (!before) {
        column->first = column->low = column->high = x;
        column->rises = row == 0, column->step = INFINITY, column->from = x;
    } else {
        double step = x - column->last;
        if (step < 0) column->rises = 0;
        column_swing(column, step);
        if (step != 0) column->step = fmin(column->step, fabs(step));
        column->low = fmin(column->low, x), column->high = fmax(column->high, x);
    }
    column->last = x;
}

/* reads a line of the table; returns 0 if it is not a row */
static int line_read(const struct api_csv *csv, const char *line, enum api_csv_kind kind[],
                     double value[]) {
    struct api_csv_cell cell[API_CSV_COLUMNS];
    if (is_bare(line) || is_comment(line)) return 0;
    int count = api_csv_cut(line, csv->separator, cell), numbers = 0;
    for (int i = 0; i < csv->columns; i++) {
        value[i] = NAN, kind[i] = API_CSV_EMPTY;
        if (i >= count || i >= API_CSV_COLUMNS) continue;
        double x;
        kind[i] = api_csv_read(&cell[i], csv->comma, &x);
        if (kind[i] == API_CSV_NUMBER || kind[i] == API_CSV_CLOCK) value[i] = x, numbers++;
    }
    return numbers > 0;
}

int api_csv_row(const struct api_csv *csv, const char **at, int *line, double value[]) {
    enum api_csv_kind kind[API_CSV_COLUMNS];
    while (**at) {
        const char *now = *at;
        *at = api_csv_line_next(now);
        ++*line;
        if (line_read(csv, now, kind, value)) return 1;
    }
    return 0;
}

static void layout_rows(struct api_csv *csv) {
    enum api_csv_kind kind[API_CSV_COLUMNS];
    double value[API_CSV_COLUMNS];
    int number = csv->first;
    for (const char *line = csv->begin; *line; line = api_csv_line_next(line), number++) {
        if (!line_read(csv, line, kind, value)) {
            if (is_bare(line) || is_comment(line)) continue;
            csv->passed++;
            continue;
        }
        for (int i = 0; i < csv->columns; i++)
            column_add(&csv->column[i], kind[i], value[i], csv->rows, number);
        csv->rows++;
    }
}

int api_csv_look(struct api_csv *csv, const char *text) {
    static const char mark[] =
        "\357\273\277"; // spreadsheets write the byte order mark of UTF-8 at the start
    struct start start = {NULL, 0, 0, 0, 0};
    assert(csv && text);
    if (!strncmp(text, mark, sizeof mark - 1)) text += sizeof mark - 1;
    *csv = (struct api_csv){.separator = layout_separator(text, &start)};
    if (!csv->separator) return 0;
    csv->first = start.line, csv->begin = start.at, csv->columns = start.width;
    layout_mark(csv, start.at);
    layout_names(csv, text, &start);
    layout_rows(csv);
    assert(csv->rows >= 1 && csv->columns >= 2);
    return 1;
}
