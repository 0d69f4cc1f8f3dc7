#include "api/class/class_table.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/job_json.h"
#include "api/json/json_out.h"

enum {
    TABLE_DEPTH = 64,
    TABLE_PUPILS = 1 << 20,
    TALLY_VALUES = 24,
    TALLY_BINS = 12,
    TALLY_TEXTS = 100
};

/* A name in its parts: "answers/tide/3". */
struct table_name {
    char kind[24], id[API_CLASS_ID + 1];
    long pupil; /* number of the pupil; 0 = none */
};

/* splits the name of an item; an id of digits is the pupil's number */
static struct table_name table_name(const char *text) {
    struct table_name name = {.pupil = 0};
    size_t kind = strcspn(text, "/"), id = text[kind] ? strcspn(text + kind + 1, "/") : 0;
    const char *rest = text + kind + (id > 0) + id;
    memcpy(name.kind, text, kind < sizeof name.kind ? kind : sizeof name.kind - 1);
    memcpy(name.id, text + kind + (id > 0), id < sizeof name.id ? id : sizeof name.id - 1);
    int bare = !strcmp(name.kind, "pupils") || !strcmp(name.kind, "stages");
    name.pupil = strtol(bare ? name.id : rest + (*rest == '/'), NULL, 10);
    if (name.pupil < 0 || name.pupil > TABLE_PUPILS) name.pupil = 0;
    return name;
}

static enum pend_status table_open(const struct api_class_item *item, struct api_json **document) {
    struct api_problem problem;
    api_problem_init(&problem);
    enum pend_status status =
        api_json_new(document, item->value, item->bytes, TABLE_DEPTH, &problem);
    api_problem_clear(&problem);
    return status;
}

/* --- the table --- */

void api_class_names_clear(struct api_class_names *names) {
    for (long i = 0; i < names->count; i++) free(names->name[i]);
    free(names->name);
    *names = (struct api_class_names){0};
}

static enum pend_status names_add(struct api_class_names *names, long pupil, const char *text) {
    assert(pupil > 0 && pupil <= TABLE_PUPILS && names->count >= 0);
    if (pupil >= names->count) {
        long count = 2 * pupil + 16;
        char **more = realloc(names->name, (size_t)count * sizeof *more);
        if (!more) return PEND_NO_MEMORY;
        memset(more + names->count, 0, (size_t)(count - names->count) * sizeof *more);
        names->name = more;
        names->count = count;
    }
    char *copy = malloc(strlen(text) + 1);
    if (!copy) return PEND_NO_MEMORY;
    free(names->name[pupil]);
    names->name[pupil] = strcpy(copy, text);
    return PEND_OK;
}

enum pend_status api_class_table_begin(const struct api_class_names *names,
                                       struct api_buffer *out) {
    static const char *const heads[] = {
        "item,id,step,pupil,nickname,value,changed\r\n",
        "\xef\xbb\xbfitem,id,step,pupil,nickname,value,changed\r\n",
        "\xef\xbb\xbfitem;id;step;pupil;nickname;value;changed\r\n"};
    return api_buffer_text(out, heads[names->sheet]);
}

/* true if a spreadsheet reads the text as a formula, also after blanks or quotes, and with
 * full-width signs (U+FF0B, U+FF0D, U+FF1D, U+FF20) */
static int table_formula(const char *text) {
    static const char *const wide[] = {"\xef\xbc\x8b", "\xef\xbc\x8d", "\xef\xbc\x9d",
                                       "\xef\xbc\xa0"};
    text += strspn(text, " \"");
    for (size_t i = 0; i < sizeof wide / sizeof *wide; i++)
        if (!strncmp(text, wide[i], 3)) return 1;
    return *text && strchr("=+-@", *text);
}

/* Writes a text as a quoted cell, never a formula. Programs with other separators may split the
 * text: German Excel splits "a;=1+1" at ';'. */
static enum pend_status table_text(struct api_buffer *out, const char *text) {
    PEND_TRY(api_buffer_text(out, table_formula(text) || strspn(text, "\t\r\n") ? "\"'" : "\""));
    for (const char *at = text; *at; at++) {
        if (*at == '"') PEND_TRY(api_buffer_text(out, "\""));
        PEND_TRY(api_buffer_add(out, at, 1));
        if (strchr(";,\t\r\n", *at) && table_formula(at + 1)) PEND_TRY(api_buffer_text(out, "'"));
    }
    return api_buffer_text(out, "\"");
}

static enum pend_status table_value(struct api_buffer *out, const struct api_value *value,
                                    enum api_class_sheet sheet) {
    char digits[API_OUT_NUMBER_BYTES];
    const char *text = api_value_text(value);
    if (text) return table_text(out, text);
    if (api_value_kind(value) != API_NUMBER) return PEND_OK;
    char *end = api_out_digits(digits, api_value_number(value), 0),
         *point = memchr(digits, '.', (size_t)(end - digits));
    if (sheet == API_CLASS_SHEET_COMMA && point) *point = ',';
    return api_buffer_add(out, digits, (size_t)(end - digits));
}

static enum pend_status table_row(const struct api_class_item *item, const struct table_name *name,
                                  const char *step, const struct api_value *value,
                                  const struct api_class_names *names, struct api_buffer *out) {
    assert(name->pupil >= 0);
    const char *nickname = name->pupil < names->count ? names->name[name->pupil] : NULL;
    struct api_buffer changed;
    const char *part = names->sheet == API_CLASS_SHEET_COMMA ? ";" : ",";
    PEND_TRY(api_buffer_format(out, "%s%s%s%s%s%s", name->kind, part, name->id, part, step, part));
    if (name->pupil) PEND_TRY(api_buffer_format(out, "%ld", name->pupil));
    PEND_TRY(api_buffer_text(out, part));
    if (nickname) PEND_TRY(table_text(out, nickname));
    PEND_TRY(api_buffer_text(out, part));
    PEND_TRY(table_value(out, value, names->sheet));
    api_buffer_init(&changed, 128);
    /* "changed":"2026-01-31T09:30:00.125Z" */
    enum pend_status status = api_job_time(&changed, "changed", item->changed);
    if (status == PEND_OK && changed.bytes > 12)
        status = api_buffer_format(out, "%s%.*s", part, (int)changed.bytes - 12, changed.data + 11);
    api_buffer_clear(&changed);
    PEND_TRY(status);
    return api_buffer_text(out, "\r\n");
}

static enum pend_status table_handin(const struct api_class_item *item,
                                     const struct table_name *name, const struct api_value *root,
                                     const struct api_class_names *names, struct api_buffer *out) {
    struct api_value answers = api_value_member(root, "answers"),
                     answer = api_value_first(&answers);
    for (; api_value_kind(&answer) != API_MISSING; answer = api_value_next(&answer)) {
        const char *id = api_value_text(API_MEMBER(&answer, "step"));
        PEND_TRY(table_row(item, name, id ? id : "", API_MEMBER(&answer, "value"), names, out));
    }
    return PEND_OK;
}

static enum pend_status table_rows(const struct api_class_item *item, const struct api_value *root,
                                   struct api_class_names *names, struct api_buffer *out) {
    static const struct {
        const char *kind, *member;
    } shown[] = {
        {"questions", "text"}, {"solutions", "value"}, {"answers", "value"}, {"stages", "state"}};
    struct table_name name = table_name(item->name);
    if (!strcmp(name.kind, "pupils")) {
        const char *text = api_value_text(API_MEMBER(root, "nickname"));
        return text && name.pupil ? names_add(names, name.pupil, text) : PEND_OK;
    }
    if (!strcmp(name.kind, "handins")) return table_handin(item, &name, root, names, out);
    for (size_t i = 0; i < sizeof shown / sizeof *shown; i++) {
        if (strcmp(name.kind, shown[i].kind)) continue;
        struct api_value value = api_value_member(root, shown[i].member);
        if (api_value_kind(&value) == API_MISSING) return PEND_OK;
        return table_row(item, &name, "", &value, names, out);
    }
    return PEND_OK;
}

enum pend_status api_class_table_add(const struct api_class_item *item,
                                     struct api_class_names *names, struct api_buffer *out) {
    struct api_json *document = NULL;
    if (!item->bytes) return PEND_OK;
    enum pend_status status = table_open(item, &document);
    if (status == PEND_OK) {
        struct api_value root = api_json_root(document);
        status = table_rows(item, &root, names, out);
    }
    api_json_free(&document);
    return status;
}

/* --- histograms --- */

void api_class_tally_clear(struct api_class_tally *tally) {
    for (long i = 0; i < tally->texts; i++) free(tally->text[i].text);
    free(tally->text);
    free(tally->number);
    *tally = (struct api_class_tally){0};
}

static enum pend_status tally_number(struct api_class_tally *tally, double number) {
    assert(tally->numbers <= tally->room);
    if (tally->numbers == tally->room) {
        long room = 2 * tally->room + 64;
        double *more = realloc(tally->number, (size_t)room * sizeof *more);
        if (!more) return PEND_NO_MEMORY;
        tally->number = more;
        tally->room = room;
    }
    tally->number[tally->numbers++] = number;
    return PEND_OK;
}

static enum pend_status tally_text(struct api_class_tally *tally, const char *text) {
    for (long i = 0; i < tally->texts; i++)
        if (!strcmp(tally->text[i].text, text)) {
            tally->text[i].count++;
            return PEND_OK;
        }
    assert(tally->texts <= tally->text_room);
    if (tally->texts == tally->text_room) {
        long room = 2 * tally->text_room + 64;
        struct api_class_tally_text *more = realloc(tally->text, (size_t)room * sizeof *more);
        if (!more) return PEND_NO_MEMORY;
        tally->text = more;
        tally->text_room = room;
    }
    char *copy = malloc(strlen(text) + 1);
    if (!copy) return PEND_NO_MEMORY;
    tally->text[tally->texts++] = (struct api_class_tally_text){strcpy(copy, text), 1};
    return PEND_OK;
}

enum pend_status api_class_tally_add(const struct api_class_item *item,
                                     struct api_class_tally *tally) {
    struct api_json *document = NULL;
    enum pend_status status = table_open(item, &document);
    if (status == PEND_OK) {
        struct api_value root = api_json_root(document), value = api_value_member(&root, "value");
        const char *text = api_value_text(&value);
        status = text ? tally_text(tally, text) : tally_number(tally, api_value_number(&value));
    }
    tally->answers += status == PEND_OK;
    api_json_free(&document);
    return status;
}

static int tally_order(const void *one, const void *other) {
    double a = *(const double *)one, b = *(const double *)other;
    return (a > b) - (a < b);
}

static int tally_often(const void *one, const void *other) {
    const struct api_class_tally_text *a = one, *b = other;
    if (a->count != b->count) return a->count < b->count ? 1 : -1;
    return strcmp(a->text, b->text);
}

static enum pend_status tally_values(const struct api_class_tally *tally, struct api_buffer *out) {
    for (long i = 0, k; i < tally->numbers; i = k) {
        for (k = i; k < tally->numbers && tally->number[k] <= tally->number[i];) k++;
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_number(out, "value", tally->number[i], 0));
        PEND_TRY(api_out_whole(out, "count", k - i));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    for (long i = 0; i < tally->texts && i < TALLY_TEXTS; i++) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_text(out, "value", tally->text[i].text));
        PEND_TRY(api_out_whole(out, "count", tally->text[i].count));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return PEND_OK;
}

/* lower edge of bin i, computed from halves, because the full width may overflow a double */
static double tally_edge(const struct api_class_tally *tally, int i) {
    assert(i >= 0 && i <= TALLY_BINS && tally->numbers > 0);
    double part = (double)i / TALLY_BINS;
    return tally->number[0] * (1 - part) + tally->number[tally->numbers - 1] * part;
}

static enum pend_status tally_bins(const struct api_class_tally *tally, struct api_buffer *out) {
    long at = 0;
    for (int i = 0; i < TALLY_BINS; i++) {
        double to = tally_edge(tally, i + 1);
        long first = at;
        while (at < tally->numbers && (i == TALLY_BINS - 1 || tally->number[at] < to)) at++;
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_number(out, "from", tally_edge(tally, i), 0));
        PEND_TRY(api_out_number(out, "to", to, 0));
        PEND_TRY(api_out_whole(out, "count", at - first));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return PEND_OK;
}

enum pend_status api_class_tally_write(struct api_class_tally *tally, struct api_buffer *out) {
    long different = 0;
    if (tally->numbers)
        qsort(tally->number, (size_t)tally->numbers, sizeof *tally->number, tally_order);
    if (tally->texts) qsort(tally->text, (size_t)tally->texts, sizeof *tally->text, tally_often);
    for (long i = 0; i < tally->numbers; i++)
        different += !i || tally->number[i] > tally->number[i - 1];
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_whole(out, "answers", tally->answers));
    PEND_TRY(api_out_open(out, "values", '['));
    if (different <= TALLY_VALUES) PEND_TRY(tally_values(tally, out));
    PEND_TRY(api_buffer_text(out, "]"));
    PEND_TRY(api_out_open(out, "bins", '['));
    if (different > TALLY_VALUES) PEND_TRY(tally_bins(tally, out));
    assert(tally->answers >= tally->numbers);
    return api_buffer_text(out, "]}");
}
