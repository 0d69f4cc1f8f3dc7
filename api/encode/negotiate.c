#include "api/encode/negotiate.h"

#include <string.h>
#include <strings.h>

/* a part of a field's value */
struct piece {
    const char *text;
    size_t bytes;
};

static int piece_is(struct piece piece, const char *text) {
    return piece.bytes == strlen(text) && !strncasecmp(piece.text, text, piece.bytes);
}

static struct piece piece_trim(struct piece piece) {
    while (piece.bytes && strchr(" \t", piece.text[0])) piece.text++, piece.bytes--;
    while (piece.bytes && strchr(" \t", piece.text[piece.bytes - 1])) piece.bytes--;
    return piece;
}

/* takes the part before the next separator outside quotes, and drops the separator */
static struct piece piece_take(const char **rest, const char *end, char separator) {
    const char *at = *rest;
    int quoted = 0;
    while (at < end && (quoted || *at != separator)) {
        if (*at == '"') quoted = !quoted;
        if (quoted && *at == '\\' && at + 1 < end) at++;
        at++;
    }
    struct piece piece = {*rest, (size_t)(at - *rest)};
    *rest = at < end ? at + 1 : end;
    return piece_trim(piece);
}

/* splits name=value; removes the quotes of a quoted value */
static void piece_parameter(struct piece piece, struct piece *name, struct piece *value) {
    const char *rest = piece.text, *end = piece.text + piece.bytes;
    *name = piece_take(&rest, end, '=');
    *value = piece_trim((struct piece){rest, (size_t)(end - rest)});
    if (value->bytes >= 2 && value->text[0] == '"' && value->text[value->bytes - 1] == '"')
        *value = (struct piece){value->text + 1, value->bytes - 2};
}

int api_negotiate_json(const char *content_type) {
    if (!content_type) return 0;
    const char *rest = content_type, *end = content_type + strlen(content_type);
    if (!piece_is(piece_take(&rest, end, ';'), "application/json")) return 0;
    while (rest < end) {
        struct piece name, value;
        piece_parameter(piece_take(&rest, end, ';'), &name, &value);
        if (piece_is(name, "charset") && !piece_is(value, "utf-8") && !piece_is(value, "utf8"))
            return 0;
    }
    return 1;
}

int api_negotiate_parameter(const char *value, size_t bytes, const char *type, const char *name,
                            const char **text, size_t *size) {
    const char *rest = value, *end = value + bytes;
    *text = NULL, *size = 0;
    if (!piece_is(piece_take(&rest, end, ';'), type)) return 0;
    while (rest < end && !*text) {
        struct piece key, found;
        piece_parameter(piece_take(&rest, end, ';'), &key, &found);
        if (piece_is(key, name)) *text = found.text, *size = found.bytes;
    }
    return 1;
}

/* a qvalue (0 .. 1, up to three decimals) in thousandths; -1 if it is malformed */
static int quality(struct piece piece) {
    if (!piece.bytes || piece.bytes > 5 || (piece.text[0] != '0' && piece.text[0] != '1'))
        return -1;
    if (piece.bytes > 1 && piece.text[1] != '.') return -1;
    int thousandths = 1000 * (piece.text[0] - '0'), unit = 100;
    for (size_t i = 2; i < piece.bytes; i++, unit /= 10) {
        if (piece.text[i] < '0' || piece.text[i] > '9') return -1;
        thousandths += unit * (piece.text[i] - '0');
    }
    return thousandths <= 1000 ? thousandths : -1;
}

/* how specifically a media range matches a type: 3 the subtype, 2 the type, 1 any, 0 not */
static int range_fits(struct piece range, const char *media_type) {
    size_t kind = strcspn(media_type, "/") + 1;
    if (piece_is(range, media_type)) return 3;
    if (range.bytes == kind + 1 && range.text[kind] == '*' &&
        !strncasecmp(range.text, media_type, kind))
        return 2;
    return piece_is(range, "*/*");
}

/* the q of a type according to an Accept header, in thousandths; 0 if it is not acceptable */
static int accept_quality(const char *accept, const char *media_type) {
    int best_fit = 0, best = 0;
    const char *rest = accept, *end = accept + strlen(accept);
    while (rest < end) {
        struct piece element = piece_take(&rest, end, ',');
        const char *parameters = element.text, *element_end = element.text + element.bytes;
        int fit = range_fits(piece_take(&parameters, element_end, ';'), media_type), q = 1000;
        while (parameters < element_end) {
            struct piece name, value;
            piece_parameter(piece_take(&parameters, element_end, ';'), &name, &value);
            if (piece_is(name, "q")) q = quality(value);
        }
        if (q < 0 || fit < best_fit || (fit == best_fit && q < best)) continue;
        best_fit = fit;
        best = q;
    }
    return best_fit ? best : 0;
}

const struct api_format *api_negotiate_format(const char *accept, int samples) {
    int best_quality = 0;
    if (!accept || !accept[strspn(accept, " \t,")]) return api_format_at(0);
    const struct api_format *best = NULL;
    // nearly all clients send a single lower-case media type
    for (int i = 0; (best = api_format_at(i)); i++)
        if (best->samples_only <= samples && !strcmp(accept, best->media_type)) return best;
    for (int i = 0; api_format_at(i); i++) {
        const struct api_format *format = api_format_at(i);
        if (format->samples_only > samples) continue;
        int q = accept_quality(accept, format->media_type);
        if (q <= best_quality) continue;
        best_quality = q;
        best = format;
    }
    return best;
}

void api_negotiate_refuse(struct api_problem *problem, int samples) {
    char served[API_FORMATS_TEXT];
    api_format_list(served, samples, 0);
    api_problem_set(problem, 406, "Accept allows none of the representations served here: %s",
                    served);
}
