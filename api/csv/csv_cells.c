#include "api/csv/csv_cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CELL_BYTES = 48 };

static int is_blank(char c) { return c == ' ' || c == '\t'; }

static int is_digit(char c) { return c >= '0' && c <= '9'; }

const char *api_csv_line_end(const char *line) { return line + strcspn(line, "\r\n"); }

const char *api_csv_line_next(const char *line) {
    const char *end = api_csv_line_end(line);
    return end + (end[0] == '\r' && end[1] == '\n' ? 2 : *end != 0);
}

static struct api_csv_cell trimmed(const char *from, const char *end) {
    while (from < end && (is_blank(*from) || *from == '"')) from++;
    while (end > from && (is_blank(end[-1]) || end[-1] == '"')) end--;
    return (struct api_csv_cell){from, (int)(end - from)};
}

/* returns the end of the cell that begins at `at` */
static const char *cell_end(const char *at, const char *end, char separator) {
    for (int quoted = 0; at < end; at++) {
        if (*at == '"') quoted = !quoted;
        if (quoted) continue;
        if (*at == separator || (separator == ' ' && *at == '\t')) break;
    }
    return at;
}

int api_csv_cut(const char *line, char separator, struct api_csv_cell cell[API_CSV_COLUMNS]) {
    const char *end = api_csv_line_end(line), *at = line;
    int count = 0, blanks = separator == ' ';
    while (blanks && end > at && is_blank(end[-1])) end--;
    for (;;) {
        while (blanks && at < end && is_blank(*at)) at++;
        const char *stop = cell_end(at, end, separator);
        if (count < API_CSV_COLUMNS) cell[count] = trimmed(at, stop);
        count++;
        if (stop == end) return count;
        at = stop + 1;
    }
}

/* --- numbers --- */

/* returns the length of a sign or blank that takes several bytes, or 0; plain: its ASCII form */
static int odd_character(const char *at, int left, char *plain) {
    static const struct {
        const char *text;
        char plain; /* 0 = dropped */
    } odd[] = {
        {"\342\210\222", '-'}, {"\302\240", 0}, {"\342\200\257", 0}, {"\342\200\211", 0}, {"'", 0}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        int bytes = (int)strlen(odd[i].text);
        if (bytes > left || memcmp(at, odd[i].text, (size_t)bytes) != 0) continue;
        *plain = odd[i].plain;
        return bytes;
    }
    return 0;
}

/* copies the text of a cell in ASCII, without blanks or apostrophes between thousands; returns 0 if
 * it is too long */
static int cell_plain(const struct api_csv_cell *cell, char out[CELL_BYTES]) {
    int length = 0;
    if (cell->bytes >= CELL_BYTES) return 0;
    for (int i = 0; i < cell->bytes;) {
        char plain = 0;
        int bytes = odd_character(cell->at + i, cell->bytes - i, &plain);
        if (!bytes) plain = cell->at[i];
        if (plain) out[length++] = plain;
        i += bytes ? bytes : 1;
    }
    out[length] = 0;
    return 1;
}

/* true if every thousands mark has a digit before it and exactly three digits after it */
static int is_grouped(const char *text, char mark) {
    const char *at = text + (*text == '-' || *text == '+');
    if (!is_digit(*at)) return 0;
    for (at = strchr(text, mark); at; at = strchr(at + 1, mark))
        if (!is_digit(at[1]) || !is_digit(at[2]) || !is_digit(at[3]) || is_digit(at[4])) return 0;
    return 1;
}

static void drop(char *text, char mark) {
    char *to = text;
    for (const char *from = text; *from; from++)
        if (*from != mark) *to++ = *from;
    *to = 0;
}

/* reads a number with this decimal mark; returns 0 if the text is not a number */
static int text_number(char *text, int comma, double *x) {
    char decimal = comma ? ',' : '.', thousands = comma ? '.' : ',';
    if (strchr(text, thousands)) {
        // a number with a point, such as "1.5", may also occur in a table with decimal commas
        if (!is_grouped(text, thousands))
            decimal = thousands;
        else
            drop(text, thousands);
    }
    char *mark = strchr(text, decimal), *end;
    if (mark) *mark = '.';
    if (text[strspn(text, "+-.0123456789eE")]) return 0;
    *x = strtod(text, &end);
    return end > text && !*end && isfinite(*x);
}

static int is_missing(const char *text) {
    static const char *const words[] = {"nan", "na", "n/a", "#n/a", "null", "none", "-",
                                        "--",  "?",  ".",   "inf",  "-nan", "nil"};
    char small[CELL_BYTES];
    size_t i = 0;
    for (; text[i]; i++)
        small[i] = (char)(text[i] >= 'A' && text[i] <= 'Z' ? text[i] + 32 : text[i]);
    small[i] = 0;
    for (i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcmp(small, words[i])) return 1;
    return !*text;
}

/* --- clocks --- */

/* converts a date to days since 1970-01-01 (H. Hinnant, "chrono-compatible low-level date
 * algorithms") */
static double days_of(int year, int month, int day) {
    year -= month <= 2;
    int era = (year >= 0 ? year : year - 399) / 400;
    int of_era = year - era * 400;
    int of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
    return era * 146097.0 + of_era * 365.0 + of_era / 4 - of_era / 100 + of_year - 719468.0;
}

/* reads a date in front of a time, "2026-11-27" or "27.11.2026"; returns the text after it, NULL if
 * there is no date */
static const char *date_read(const char *text, double *days) {
    int part[3];
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        char *end;
        if (!is_digit(*at)) return NULL;
        part[i] = (int)strtol(at, &end, 10);
        if (end - at > 4) return NULL;
        at = end;
        if (i < 2 && !strchr("-./", *at++)) return NULL;
    }
    int first = part[0] > 31, year = first ? part[0] : part[2], day = first ? part[2] : part[0];
    if (part[1] < 1 || part[1] > 12 || day < 1 || day > 31 || year < 1000) return NULL;
    *days = days_of(year, part[1], day);
    return *at == 'T' || *at == ' ' ? at + 1 : NULL;
}

/* reads "[date ]h:m[:s]" or "m:s.f"; returns 0 for any other text */
static int clock_read(char *text, double *x) {
    double days = 0, part[3];
    const char *at = date_read(text, &days);
    int count = 0;
    char *comma = strchr(text, ',');
    if (comma) *comma = '.';
    if (!at) at = text;
    for (; count < 3; count++) {
        char *end;
        if (!is_digit(*at)) return 0;
        part[count] = strtod(at, &end);
        at = end;
        if (*at != ':') break;
        at++;
    }
    if (*at == 'Z') at++;
    if (*at || count < 1 || count > 2) return 0;
    // two numbers are hours and minutes, but minutes and seconds if the second has a fraction
    int minutes = count == 1 && part[1] != floor(part[1]);
    *x = days * 86400 + (minutes ? part[0] * 60 + part[1] : part[0] * 3600 + part[1] * 60);
    if (count == 2) *x += part[2];
    return 1;
}

enum api_csv_kind api_csv_read(const struct api_csv_cell *cell, int comma, double *x) {
    char text[CELL_BYTES], copy[CELL_BYTES];
    if (!cell_plain(cell, text)) return API_CSV_WORD;
    memcpy(copy, text, sizeof copy);
    if (is_missing(text)) return API_CSV_EMPTY;
    if (text_number(text, comma, x)) return API_CSV_NUMBER;
    return clock_read(copy, x) ? API_CSV_CLOCK : API_CSV_WORD;
}

int api_csv_mark(const struct api_csv_cell *cell) {
    char text[CELL_BYTES];
    if (!cell_plain(cell, text) || text[strspn(text, "+-.,0123456789eE")]) return 0;
    const char *comma = strrchr(text, ','), *point = strrchr(text, '.');
    if (comma && point) return comma > point ? 1 : -1;
    if (!comma && !point) return 0;
    // "1,234" may be one thousand or a fraction; "0,234" must be a fraction
    if (is_grouped(text, comma ? ',' : '.') && fabs(strtod(text, NULL)) >= 1) return 0;
    return comma ? 1 : -1;
}
