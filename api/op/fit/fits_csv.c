#include "api/op/fit/fits_csv.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD_LINES = 20, FAULTY_LINES = 10, FIELD_BYTES = 64 };

static const double pi = 3.14159265358979323846;

/* a field: its text without blanks around it */
struct csv_field {
    const char *at;
    int bytes;
};

static int is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

static const char *line_end(const char *line) {
    const char *end = strchr(line, '\n');
    return end ? end : line + strlen(line);
}

/* cuts a line into fields; returns how many */
static int line_cut(const char *line, char separator, struct csv_field field[API_CSV_FIELDS]) {
    const char *end = line_end(line);
    int count = 0;
    while (count < API_CSV_FIELDS) {
        const char *stop = memchr(line, separator, (size_t)(end - line)), *last;
        last = stop ? stop : end;
        const char *from = line;
        while (from < last && (is_blank(*from) || *from == '"')) from++;
        while (last > from && (is_blank(last[-1]) || last[-1] == '"')) last--;
        field[count++] = (struct csv_field){from, (int)(last - from)};
        if (!stop) break;
        line = stop + 1;
    }
    return count;
}

static int line_empty(const char *line) {
    const char *end = line_end(line);
    for (; line < end; line++)
        if (!is_blank(*line)) return *line == '#';
    return 1;
}

static const char *line_next(const char *line) {
    const char *end = line_end(line);
    return *end ? end + 1 : end;
}

static int field_is(const struct csv_field *field, const char *name) {
    return field->bytes == (int)strlen(name) && !strncmp(field->at, name, strlen(name));
}

/* whether a field is the name of the time, which is in s */
static int field_time(const struct csv_field *field) {
    static const char *const names[] = {"t", "t (s)", "t [s]", "t(s)", "t[s]"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (field_is(field, names[i])) return 1;
    return 0;
}

/* what separates the fields of a line */
static char line_separator(const char *line) {
    const char *end = line_end(line);
    for (const char *c = "\t;,"; *c; c++)
        if (memchr(line, *c, (size_t)(end - line))) return *c;
    return ',';
}

/* what a field of the head is among, and how many x and y without a number there were */
struct csv_context {
    int n, count;
    const int *listed;
    int degrees, pairs[2];
    const struct api_value *text;
    struct api_problem *problem;
};

/* the arm, from 1, of an x or y without a number; 0 after a fault */
static long head_listed(const struct api_csv *csv, struct csv_context *context, const char *name) {
    int i = context->pairs[*name == 'y']++;
    assert(*name == 'x' || *name == 'y');
    if (i < context->count && context->listed[i] >= 0) return context->listed[i] + 1;
    if (context->n == 1 && !i) return 1;
    api_value_fault(
        context->text, context->problem,
        API_CODE_UNKNOWN_NAME
        "line %d: %s number %d is of no arm: list the arms in \"arms\", or call it %s_1",
        csv->line, name, i + 1, name);
    return 0;
}

/* the arm, from 1, of an angle without a number, which is not in doubt of one arm; 0 after a fault
 */
static long head_angle(const struct api_csv *csv, const struct csv_context *context,
                       const char *name) {
    assert(context->n >= 1);
    if (context->n == 1) return 1;
    api_value_fault(context->text, context->problem,
                    API_CODE_UNKNOWN_NAME
                    "line %d: %s is of no arm: call it %s_1, say; a column that is not to be "
                    "fitted needs another name",
                    csv->line, name, name);
    return 0;
}

/* Cuts the unit off a name, as of "theta_1 (deg)" or "x [px]"; returns what one of it is of an
 * angle, rad, `scale` where there is none, 0 if that is no unit of an angle. */
static double name_unit(char *name, double scale) {
    static const char *const units[] = {"rad", "deg", "degrees", "\302\260"};
    char *open = strpbrk(name, "([");
    if (!open) return scale;
    char *unit = open + 1, *close = unit + strcspn(unit, ")]");
    *close = 0;
    while (open > name && is_blank(open[-1])) open--;
    *open = 0;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (!strcmp(unit, units[i])) return i ? pi / 180 : 1;
    return 0;
}

/* how many of the unit that stands behind a name are a metre; 0 = there is none, or none that is
 * known */
static double name_per_m(const char *name) {
    static const struct {
        const char *unit;
        double per_m;
    } units[] = {{"m", 1}, {"cm", 100}, {"mm", 1000}};
    const char *open = strpbrk(name, "([");
    size_t bytes = open ? strcspn(open + 1, ")]") : 0;
    for (size_t i = 0; i < sizeof units / sizeof *units && open; i++)
        if (bytes == strlen(units[i].unit) && !strncmp(open + 1, units[i].unit, bytes))
            return units[i].per_m;
    return 0;
}

/* Cuts the arm's number off a name, as of "theta_1": from 1, 0 where it is none, -1 without one. */
static long name_arm(char *name) {
    char *mark = strrchr(name, '_'), *end;
    if (!mark) return -1;
    long arm = strtol(mark + 1, &end, 10);
    assert(end);
    *mark = 0;
    return *end ? 0 : arm;
}

/* whether the arm and the unit of a column are such; faults them */
static int head_good(const struct api_csv *csv, const char *name, long arm, double unit, int place,
                     const struct csv_context *context) {
    if (arm < 1 || arm > context->n)
        api_value_fault(context->text, context->problem,
                        API_CODE_UNKNOWN_NAME "line %d: %s names no arm of this pendulum, 1 to %d",
                        csv->line, name, context->n);
    else if (unit == 0)
        api_value_fault(context->text, context->problem,
                        API_CODE_UNKNOWN_NAME
                        "line %d: field %d has a unit that no angle has here: rad or deg",
                        csv->line, place + 1);
    else
        return 1;
    return 0;
}

/* keeps what places are measured in; one camera has one unit */
static void head_per_m(struct api_csv *csv, double per_m, int place,
                       const struct csv_context *context) {
    if (per_m > 0 && !csv->per_m) csv->per_m = per_m, csv->per_m_field = place;
    if (per_m > 0 && per_m != csv->per_m)
        api_value_fault(context->text, context->problem,
                        API_CODE_CONFLICT
                        "line %d: fields %d and %d have units of their own: give all in one",
                        csv->line, csv->per_m_field + 1, place + 1);
}

/* adds the column of a field, unless it is of nothing that is known here */
static void head_field(struct api_csv *csv, const struct csv_field *field, int place,
                       struct csv_context *context) {
    static const char *const names[] = {"phi", "theta", "x", "y"};
    static const enum pend_fit_kind kinds[] = {PEND_FIT_PHI, PEND_FIT_PHI, PEND_FIT_X, PEND_FIT_Y};
    char name[FIELD_BYTES];
    if (field->bytes >= FIELD_BYTES || csv->columns == API_CSV_COLUMNS) return;
    memcpy(name, field->at, (size_t)field->bytes);
    name[field->bytes] = 0;
    double per_m = name_per_m(name), unit = name_unit(name, context->degrees ? pi / 180 : 1);
    long arm = name_arm(name);
    int which = 0;
    while (which < 4 && strcmp(name, names[which]) != 0) which++;
    int angle = which < 2, alone = arm < 0;
    if (which == 4) return;
    if (alone) arm = angle ? head_angle(csv, context, name) : head_listed(csv, context, name);
    if (alone && !arm) return;
    if (!head_good(csv, name, arm, angle ? unit : 1, place, context)) return;
    if (!angle) head_per_m(csv, per_m, place, context);
    csv->scale[csv->columns] = angle ? unit : 1;
    csv->field[csv->columns] = place, csv->arm[csv->columns] = (int)arm - 1;
    csv->kind[csv->columns] = kinds[which], csv->theta[csv->columns] = which == 1;
    csv->columns++;
}

void api_csv_head(struct api_csv *csv, const struct api_value *text, int n, int count,
                  const int listed[], int degrees, struct api_problem *problem) {
    static const char mark[] = "\357\273\277"; // of UTF-8, which spreadsheets write in front
    const char *line = api_value_text(text);
    struct csv_field field[API_CSV_FIELDS];
    struct csv_context context = {n, count, listed, degrees, {0, 0}, text, problem};
    int fields = 0;
    assert(line);
    if (!strncmp(line, mark, sizeof mark - 1)) line += sizeof mark - 1;
    *csv = (struct api_csv){.line = 1, .t = -1};
    for (; *line && csv->line <= HEAD_LINES; line = line_next(line), csv->line++) {
        csv->separator = line_separator(line);
        fields = line_cut(line, csv->separator, field);
        for (int i = 0; i < fields && csv->t < 0; i++)
            if (field_time(&field[i])) csv->t = i;
        if (csv->t >= 0) break;
    }
    if (csv->t < 0) {
        api_value_fault(text, problem,
                        API_CODE_MISSING
                        "has no line with the names of its columns, one of which is t, in s");
        return;
    }
    // where no pendulum could be read, that has been said
    for (int i = 0; i < fields && n; i++) head_field(csv, &field[i], i, &context);
    if (!csv->columns && !problem->status)
        api_value_fault(text, problem,
                        API_CODE_MISSING
                        "line %d: names nothing that is measured: theta_1, phi_1, x_1, y_1, x, y",
                        csv->line);
    for (line = line_next(line); *line; line = line_next(line)) csv->rows += !line_empty(line);
    if (!csv->rows)
        api_value_fault(text, problem, API_CODE_WRONG_COUNT "has no rows below line %d", csv->line);
}

/* the number of a field; 0 if it is none */
static int field_number(const struct csv_field *field, char separator, double *x) {
    char number[FIELD_BYTES], *end;
    if (!field->bytes || field->bytes >= FIELD_BYTES) return 0;
    memcpy(number, field->at, (size_t)field->bytes);
    number[field->bytes] = 0;
    char *comma = separator == ',' ? NULL : strchr(number, ',');
    if (comma) *comma = '.';
    *x = strtod(number, &end);
    return !*end && isfinite(*x);
}

/* one row; returns whether it is good */
static int row_read(const struct api_csv *csv, const struct csv_field field[], int fields, long row,
                    int line, double t[], double data[], const struct api_value *text,
                    struct api_problem *problem) {
    if (csv->t >= fields || !field_number(&field[csv->t], csv->separator, &t[row])) {
        api_value_fault(text, problem, API_CODE_WRONG_TYPE "line %d: t must be a number", line);
        return 0;
    }
    for (int c = 0; c < csv->columns; c++) {
        double *to = &data[c * csv->rows + row];
        int at = csv->field[c];
        if (at >= fields || !field[at].bytes) continue;
        if (!field_number(&field[at], csv->separator, to)) {
            api_value_fault(text, problem,
                            API_CODE_WRONG_TYPE
                            "line %d: field %d must be a number, or empty where nothing was "
                            "measured, got %.*s",
                            line, at + 1, field[at].bytes < 20 ? field[at].bytes : 20,
                            field[at].at);
            return 0;
        }
        *to *= csv->scale[c];
        if (csv->theta[c]) *to -= pi / 2;
    }
    return 1;
}

void api_csv_rows(const struct api_csv *csv, const struct api_value *text, double t[],
                  double data[], struct api_problem *problem) {
    const char *line = api_value_text(text);
    struct csv_field field[API_CSV_FIELDS];
    long row = 0;
    int number = 1, faulty = 0;
    assert(line && csv->t >= 0);
    for (; *line && faulty < FAULTY_LINES; line = line_next(line), number++) {
        if (number <= csv->line || line_empty(line)) continue;
        int fields = line_cut(line, csv->separator, field);
        faulty += !row_read(csv, field, fields, row, number, t, data, text, problem);
        row++;
    }
}
