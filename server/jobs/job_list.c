#include "server/jobs/jobs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/jobs/job_events.h"
#include "server/jobs/store_request.h"
#include "server/work/admission.h"

enum { LIST_PAGE = 100, LIST_DEFAULT = 20, LIST_NEXT = 1024, LIST_VALUE = 3 * SRV_TITLE_BYTES };

struct list {
    struct srv_job_wish wish;
    int count;
    char operation[SRV_TITLE_BYTES], title[SRV_TITLE_BYTES], since[SRV_TITLE_BYTES],
        before[SRV_TITLE_BYTES];
    char last[SRV_ID_BYTES]; /* start of the next page; "" = none */
    struct srv_job job[LIST_PAGE];
};

/* --- the query --- */

static const char *const list_names[] = {"before",    "limit", "status",
                                         "operation", "title", "since"};
enum { BEFORE, LIMIT, STATUS, OPERATION, TITLE, SINCE, NAMES };

/* Decodes a value. A plus sign is a blank, except in an instant. */
static int list_value(int i, const char *value, size_t bytes, char text[SRV_TITLE_BYTES]) {
    char raw[LIST_VALUE];
    if (bytes > sizeof raw) return 0;
    for (size_t k = 0; k < bytes; k++) raw[k] = i == TITLE && value[k] == '+' ? ' ' : value[k];
    return srv_jobs_title(raw, bytes, text);
}

static int list_read_state(const char *word, struct srv_job_wish *wish) {
    for (wish->state = 0; wish->state < SRV_JOB_STATES; wish->state++)
        if (!strcmp(word, srv_job_word(wish->state))) return 1;
    return 0;
}

/* Reads one name=value of the query. Returns 0 if it is unknown or repeated. */
static int list_read_one(const char *name, size_t letters, const char *value, size_t bytes,
                         struct list *list, unsigned *seen) {
    struct srv_job_wish *wish = &list->wish;
    char text[SRV_TITLE_BYTES];
    int i = 0;
    while (i < NAMES && (strlen(list_names[i]) != letters || strncmp(list_names[i], name, letters)))
        i++;
    if (i == NAMES || *seen & 1u << i || !list_value(i, value, bytes, text)) return 0;
    *seen |= 1u << i;
    switch (i) {
    case BEFORE:
        memcpy(list->before, text, sizeof text);
        wish->before = list->before;
        return srv_store_request_id_good(text);
    case LIMIT:
        if (strlen(text) > 3 || text[strspn(text, "0123456789")]) return 0;
        wish->most = atoi(text);
        return wish->most >= 1 && wish->most <= LIST_PAGE;
    case STATUS:
        return list_read_state(text, wish);
    case OPERATION:
        memcpy(list->operation, text, sizeof text);
        wish->operation = list->operation;
        return 1;
    case TITLE:
        memcpy(list->title, text, sizeof text);
        wish->title = list->title;
        return 1;
    default:
        memcpy(list->since, text, sizeof text);
        return api_job_instant(text, &wish->since);
    }
}

/* Reads the query. Returns 0 if it is invalid. */
static int list_read(const char *query, struct list *list) {
    unsigned seen = 0;
    list->wish = (struct srv_job_wish){.state = SRV_JOB_STATES, .most = LIST_DEFAULT};
    for (const char *at = query; at && *at; at += *at == '&') {
        size_t letters = strcspn(at, "=&"), equals = at[letters] == '=';
        const char *value = at + letters + equals;
        size_t bytes = strcspn(value, "&");
        if (!list_read_one(at, letters, value, bytes, list, &seen)) return 0;
        at = value + bytes;
    }
    assert(list->wish.most >= 1 && list->wish.most <= LIST_PAGE);
    return 1;
}

/* --- the answer --- */

/* Appends &name=value; percent-encodes all bytes except letters, digits and "-._". */
static void list_write_one(char path[LIST_NEXT], const char *name, const char *value) {
    char text[LIST_VALUE + 1];
    size_t bytes = 0, had = strlen(path);
    for (const char *at = value; *at; at++) {
        int plain = (*at >= '0' && *at <= '9') || (*at >= 'a' && *at <= 'z') ||
                    (*at >= 'A' && *at <= 'Z') || strchr("-._", *at);
        bytes += (size_t)snprintf(text + bytes, sizeof text - bytes, plain ? "%c" : "%%%02X",
                                  (unsigned char)*at);
    }
    snprintf(path + had, LIST_NEXT - had, "&%s=%s", name, bytes ? text : "");
}

/* Writes the path of the next page, with the parameters of this one. */
static void list_next(const struct list *list, char path[LIST_NEXT]) {
    const struct srv_job_wish *wish = &list->wish;
    snprintf(path, LIST_NEXT, "/v1/jobs?before=%s&limit=%d", list->last, wish->most);
    if (wish->state < SRV_JOB_STATES) list_write_one(path, "status", srv_job_word(wish->state));
    if (wish->operation) list_write_one(path, "operation", wish->operation);
    if (wish->since) list_write_one(path, "since", list->since);
    if (wish->title) list_write_one(path, "title", wish->title);
}

static enum srv_stored list_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    struct list *list = asked->more;
    return srv_store_list(store, asked->exchange->identity.key, &list->wish, list->job,
                          &list->count, list->last);
}

static void list_answer(struct srv_exchange *exchange, const struct list *list) {
    assert(list->count >= 0 && list->count <= LIST_PAGE);
    struct api_job view[LIST_PAGE];
    char path[LIST_NEXT];
    for (int i = 0; i < list->count; i++) view[i] = srv_job_view(&list->job[i]);
    if (list->last[0]) list_next(list, path);
    if (api_jobs_write(view, list->count, list->last[0] ? path : NULL, &exchange->answer) !=
        PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, 200, "application/json");
    srv_exchange_header(exchange, "Cache-Control", "no-store");
    size_t room = list->last[0] ? strlen(path) + sizeof "<>; rel=\"next\"" : 0;
    char *link = room ? srv_exchange_text(exchange, room) : NULL;
    if (!link) return;
    snprintf(link, room, "<%s>; rel=\"next\"", path);
    srv_exchange_header(exchange, "Link", link);
}

static void list_found(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored == SRV_STORED)
        list_answer(asked->exchange, asked->more);
    else
        srv_store_request_refuse(asked, stored);
    srv_store_request_end(asked);
}

void srv_job_list(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &srv_store_request_jobs);
    if (!asked) return;
    asked->more_free = free;
    asked->more = calloc(1, sizeof(struct list));
    if (!asked->more)
        srv_exchange_busy(exchange, 1, "out of memory");
    else if (!list_read(exchange->query, asked->more))
        srv_exchange_problem(
            exchange, 422,
            "the query may contain, each once: status=WORD, operation=WORD, title=WORDS, "
            "since=INSTANT (as 2026-01-31T09:30:00Z), before=ID and limit=1 to %d; got ?%.100s",
            LIST_PAGE, exchange->query);
    else if (exchange->identity.kind == SRV_IDENTITY_ADDRESS)
        srv_admission_challenge(
            exchange,
            "only jobs submitted with a token can be listed, since an address may be shared");
    if (exchange->status)
        srv_store_request_end(asked);
    else
        srv_store_request_ask(asked, SRV_ASK_READ, list_find, list_found);
}
