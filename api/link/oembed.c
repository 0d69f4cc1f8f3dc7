#include "api/link/oembed.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "api/json/json_out.h"

enum { OEMBED_VALUE = 1100, OEMBED_TITLE = 256 }; /* bytes; a request's target has at most 1023 */
#define FRAME_END "\" style=\"border:0\" loading=\"lazy\" allow=\"fullscreen\"></iframe>"

static const char oembed_unreserved[] =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
static const char oembed_host[] =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._:[]";
/* reserved characters of a link, except quotes, which could end an attribute */
static const char oembed_reserved[] = ":/?#[]@!$&()*+,;=%";

/* The decoded parameters of a request; "" = absent. */
struct oembed_query {
    char url[OEMBED_VALUE], format[32], maxwidth[32], maxheight[32];
};

/* --- the query --- */

/* Decodes %XX. Returns 0 if the text is too long, malformed or contains a NUL. */
static int oembed_decode(const char *text, size_t bytes, char *out, size_t cap) {
    size_t length = 0;
    for (size_t i = 0; i < bytes; i++) {
        int letter = (unsigned char)text[i];
        if (letter == '%') {
            int whole = i + 2 < bytes;
            const char pair[] = {whole ? text[i + 1] : 0, whole ? text[i + 2] : 0, 0};
            if (strspn(pair, "0123456789abcdefABCDEF") != 2) return 0;
            letter = (int)strtol(pair, NULL, 16);
            i += 2;
        }
        if (!letter || length + 1 >= cap) return 0;
        out[length++] = (char)letter;
    }
    out[length] = 0;
    return 1;
}

static int oembed_parameters(const char *query, struct oembed_query *asked,
                             struct api_problem *problem) {
    const struct {
        const char *name;
        char *value;
        size_t cap;
    } known[] = {{"url", asked->url, sizeof asked->url},
                 {"format", asked->format, sizeof asked->format},
                 {"maxwidth", asked->maxwidth, sizeof asked->maxwidth},
                 {"maxheight", asked->maxheight, sizeof asked->maxheight}};
    for (const char *part = query; part && *part;) {
        size_t bytes = strcspn(part, "&"), name = strcspn(part, "=&");
        for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
            if (strlen(known[i].name) != name || strncmp(part, known[i].name, name)) continue;
            int sound =
                part[name] == '=' && !*known[i].value &&
                oembed_decode(part + name + 1, bytes - name - 1, known[i].value, known[i].cap);
            if (sound) continue;
            api_problem_set(problem, 422,
                            "%s must occur once, encoded as in RFC 3986: %%23 for #, %%26 for &",
                            known[i].name);
            return 0;
        }
        part += bytes + (part[bytes] == '&');
    }
    return 1;
}

static int oembed_size(const char *name, const char *text, long plain, long *size,
                       struct api_problem *problem) {
    long wanted = plain;
    if (*text) {
        int digits = strlen(text) <= 6 && strspn(text, "0123456789") == strlen(text);
        wanted = digits ? strtol(text, NULL, 10) : 0;
        if (wanted < 1 || wanted > API_OEMBED_MOST) {
            api_problem_set(problem, 422, "%s must be a number of pixels from 1 to %d, got %.32s",
                            name, API_OEMBED_MOST, text);
            return 0;
        }
    }
    *size = wanted < plain ? wanted : plain;
    return 1;
}

/* --- the link --- */

/* Finds the next parameter of a link's query: its first byte, and its length, which is 0 at the
 * end. */
static size_t oembed_part(const char **at, const char *end) {
    while (*at < end && **at == '&') (*at)++;
    const char *stop = *at < end ? memchr(*at, '&', (size_t)(end - *at)) : NULL;
    return (size_t)((stop ? stop : end) - *at);
}

static int oembed_is(const char *part, size_t bytes, const char *name) {
    size_t length = strlen(name);
    return bytes >= length && !strncmp(part, name, length) &&
           (bytes == length || part[length] == '=');
}

/* Writes the link of the embed view. Returns 0 if the link is to a classroom. */
static int oembed_view(const char *url, const char *path, struct api_oembed *out) {
    const char *query = path + (*path == '/'), *rest = query + strcspn(query, "#");
    size_t length = (size_t)(path - url);
    assert(strlen(url) + sizeof "/?embed=1&" < API_OEMBED_LINK);
    memcpy(out->link, url, length);
    length += (size_t)snprintf(out->link + length, API_OEMBED_LINK - length, "/?embed=1");
    const char *at = query + (*query == '?');
    for (size_t bytes; (bytes = oembed_part(&at, rest)) > 0; at += bytes) {
        if (oembed_is(at, bytes, "room")) return 0;
        if (oembed_is(at, bytes, "embed")) continue;
        length +=
            (size_t)snprintf(out->link + length, API_OEMBED_LINK - length, "&%.*s", (int)bytes, at);
    }
    snprintf(out->link + length, API_OEMBED_LINK - length, "%s", rest);
    return 1;
}

/* Returns 1 if all characters are valid in a link. */
static int oembed_sound(const char *url) {
    while (*url && (strchr(oembed_unreserved, *url) || strchr(oembed_reserved, *url))) url++;
    return !*url;
}

/* Reads a link to the page. Returns 0 and sets the problem for any other link. */
static int oembed_link(const char *url, const char *host, struct api_oembed *out,
                       struct api_problem *problem) {
    size_t scheme = !strncasecmp(url, "https://", 8) ? 8 : strncasecmp(url, "http://", 7) ? 0 : 7;
    if (!scheme || !oembed_sound(url)) {
        api_problem_set(problem, 422,
                        "url must be a link that begins with http:// or https:// and has only "
                        "characters that are valid in a link");
        return 0;
    }
    size_t bytes = strcspn(url + scheme, "/?#");
    const char *path = url + scheme + bytes;
    int ours = host && strlen(host) == bytes && !strncasecmp(url + scheme, host, bytes);
    int page = *path != '/' || !path[1] || strchr("?#", path[1]);
    if (ours && page && oembed_view(url, path, out)) return 1;
    api_problem_set(problem, 404,
                    "only links to this server's page can be embedded: http://%.100s/, optionally "
                    "with a query and a fragment, and not links to classrooms",
                    host ? host : "its.host");
    return 0;
}

enum pend_status api_oembed_read(const char *query, const char *host, struct api_oembed *wanted,
                                 struct api_problem *problem) {
    struct oembed_query asked = {.url = ""};
    struct api_oembed read = {.link = ""};
    assert(wanted && problem && !problem->status);
    if (!oembed_parameters(query, &asked, problem)) return PEND_INVALID;
    if (*asked.format && strcmp(asked.format, "json")) {
        api_problem_set(problem, 501, "format must be json, got %.32s", asked.format);
        return PEND_INVALID;
    }
    if (!*asked.url || strlen(asked.url) > API_OEMBED_URL) {
        api_problem_set(problem, 422,
                        *asked.url ? "url must have at most %d characters"
                                   : "url is missing: the link to embed",
                        API_OEMBED_URL);
        return PEND_INVALID;
    }
    if (!oembed_size("maxwidth", asked.maxwidth, API_OEMBED_WIDTH, &read.width, problem) ||
        !oembed_size("maxheight", asked.maxheight, API_OEMBED_HEIGHT, &read.height, problem) ||
        !oembed_link(asked.url, host, &read, problem))
        return PEND_INVALID;
    assert(read.width > 0 && read.height > 0 && *read.link);
    *wanted = read;
    return PEND_OK;
}

/* --- the answer --- */

static enum pend_status oembed_attribute(const char *text, struct api_buffer *out) {
    for (; *text; text++)
        PEND_TRY(*text == '&'             ? api_buffer_text(out, "&amp;")
                 : strchr("\"'<>", *text) ? api_buffer_format(out, "&#%d;", *text)
                                          : api_buffer_add(out, text, 1));
    return PEND_OK;
}

/* the title of a link: its parameter `title`, its worksheet or the number of its arms */
static void oembed_title(const char *link, char title[OEMBED_TITLE]) {
    const char *named = strstr(link, "&title="), *length = strstr(link, "&length=");
    const char *sheet = strstr(link, "&sheet=");
    size_t bytes = named ? strcspn(named + 7, "&#") : 0;
    if (bytes && oembed_decode(named + 7, bytes, title, OEMBED_TITLE)) return;
    int arms = 1;
    for (const char *at = length ? length + 8 : ""; *at && *at != '&' && *at != '#'; at++)
        arms += *at == ',' || !strncasecmp(at, "%2C", 3);
    if (arms > 1)
        snprintf(title, 64, "Pendulum of %d arms", arms);
    else if (sheet && !length)
        snprintf(title, 64, "Worksheet: %.*s", (int)strcspn(sheet + 7, "&#%") % 40, sheet + 7);
    else
        snprintf(title, 64, length ? "Single pendulum" : "Pendulum");
}

static enum pend_status oembed_frame(const struct api_oembed *wanted, const char *title,
                                     struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "<iframe src=\""));
    PEND_TRY(oembed_attribute(wanted->link, out));
    PEND_TRY(api_buffer_format(out, "\" width=\"%ld\" height=\"%ld\" title=\"", wanted->width,
                               wanted->height));
    PEND_TRY(oembed_attribute(title, out));
    return api_buffer_add(out, FRAME_END, sizeof FRAME_END);
}

enum pend_status api_oembed_write(const struct api_oembed *wanted, struct api_buffer *out) {
    struct api_buffer frame;
    char title[OEMBED_TITLE];
    int home = (int)(strcspn(wanted->link, "?") + 1);
    assert(wanted->width > 0 && wanted->height > 0 && home > 8);
    api_buffer_init(&frame, 5 * API_OEMBED_LINK + 2048);
    oembed_title(wanted->link, title);
    enum pend_status status = oembed_frame(wanted, title, &frame);
    if (status == PEND_OK) status = api_buffer_text(out, "{\"version\":\"1.0\",\"type\":\"rich\"");
    if (status == PEND_OK) status = api_out_text(out, "title", title);
    if (status == PEND_OK) status = api_buffer_text(out, ",\"provider_name\":\"pendulumd\"");
    if (status == PEND_OK)
        status = api_buffer_format(out, ",\"provider_url\":\"%.*s\"", home - 1, wanted->link);
    if (status == PEND_OK) status = api_out_whole(out, "width", wanted->width);
    if (status == PEND_OK) status = api_out_whole(out, "height", wanted->height);
    if (status == PEND_OK) status = api_out_text(out, "html", frame.data);
    if (status == PEND_OK) status = api_buffer_text(out, "}");
    api_buffer_clear(&frame);
    return status;
}

/* --- the tag --- */

static enum pend_status oembed_encode(const char *text, struct api_buffer *out) {
    for (; *text; text++)
        PEND_TRY(strchr(oembed_unreserved, *text)
                     ? api_buffer_add(out, text, 1)
                     : api_buffer_format(out, "%%%02X", (unsigned)(unsigned char)*text));
    return PEND_OK;
}

enum pend_status api_oembed_tag(const char *scheme, const char *host, const char *query,
                                struct api_buffer *out) {
    assert(scheme && !strncmp(scheme, "http", 4));
    if (!host || !*host || strspn(host, oembed_host) != strlen(host)) return PEND_OK;
    PEND_TRY(api_buffer_format(out,
                               "<link rel=\"alternate\" type=\"application/json+oembed\" "
                               "title=\"pendulumd\" href=\"%s://%s/oembed?format=json&amp;url=",
                               scheme, host));
    PEND_TRY(api_buffer_format(out, "%s%%3A%%2F%%2F", scheme));
    PEND_TRY(oembed_encode(host, out));
    PEND_TRY(api_buffer_text(out, "%2F%3F"));
    PEND_TRY(oembed_encode(query ? query : "", out));
    return api_buffer_text(out, "\">\n");
}

int api_oembed_tells(const char *query) {
    const char *end = query ? query + strlen(query) : NULL;
    for (size_t bytes; query && (bytes = oembed_part(&query, end)) > 0; query += bytes)
        if (oembed_is(query, bytes, "length") || oembed_is(query, bytes, "sheet") ||
            oembed_is(query, bytes, "example"))
            return 1;
    return 0;
}
