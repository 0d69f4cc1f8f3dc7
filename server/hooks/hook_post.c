#include "server/hooks/hook_post.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>

#include <curl/curl.h>

#include "api/base/engine.h"
#include "server/hooks/hook_address.h"

enum {
    POST_ADDRESSES = 8,
    POST_PINNED = API_WEBHOOK_HOST + 16 + POST_ADDRESSES * 50,
    POST_HEAD = 16384
};

/* What libcurl's callbacks know. */
struct post {
    const struct srv_peers *networks;
    size_t head; /* bytes of it that came */
    int refused;
};

/* the last look at an address, whatever libcurl makes of what it was told */
static curl_socket_t post_open(void *context, curlsocktype purpose, struct curl_sockaddr *address) {
    struct post *post = context;
    if (purpose != CURLSOCKTYPE_IPCXN || !srv_hook_address_may(&address->addr, post->networks)) {
        post->refused = 1;
        return CURL_SOCKET_BAD;
    }
    return socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
}

static size_t post_head(char *data, size_t size, size_t count, void *context) {
    struct post *post = context;
    (void)data;
    post->head += size * count;
    return post->head > POST_HEAD ? 0 : size * count;
}

/* of a body nothing is read: its beginning ends the transfer */
static size_t post_body(char *data, size_t size, size_t count, void *context) {
    (void)data, (void)size, (void)count, (void)context;
    return 0;
}

/* Looks a name up, once, and writes its addresses as libcurl is to use them: "host:443:a,b". One
 * that is refused refuses the name. An address of IPv6 is itself, and has no form there: "". */
static enum srv_hook_end post_pin(const struct api_webhook_place *place,
                                  const struct srv_peers *networks, char pinned[POST_PINNED]) {
    const struct addrinfo wish = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    struct addrinfo *found = NULL;
    enum srv_hook_end end = SRV_HOOK_ANSWERED;
    int count = 0;
    if (getaddrinfo(place->host, NULL, &wish, &found)) return SRV_HOOK_NOWHERE;
    size_t used = (size_t)snprintf(pinned, POST_PINNED, "%s:%d:", place->host, place->port);
    for (const struct addrinfo *at = found; at && end == SRV_HOOK_ANSWERED; at = at->ai_next) {
        char text[NI_MAXHOST];
        if (!srv_hook_address_may(at->ai_addr, networks))
            end = SRV_HOOK_REFUSED;
        else if (count < POST_ADDRESSES &&
                 !getnameinfo(at->ai_addr, at->ai_addrlen, text, sizeof text, NULL, 0,
                              NI_NUMERICHOST) &&
                 strlen(text) < 46)
            used += (size_t)snprintf(pinned + used, POST_PINNED - used,
                                     at->ai_family == AF_INET6 ? "%s[%s]" : "%s%s",
                                     count++ ? "," : "", text);
    }
    freeaddrinfo(found);
    if (strchr(place->host, ':')) pinned[0] = 0;
    return end == SRV_HOOK_ANSWERED && !count ? SRV_HOOK_NOWHERE : end;
}

/* the fields of a message; NULL without memory */
static struct curl_slist *post_fields(const struct srv_hook_message *message) {
    const char *const field[][2] = {
        {"Content-Type", "application/json"},      {"webhook-id", message->id},
        {"webhook-timestamp", message->timestamp}, {"webhook-signature", message->signatures},
        {"User-Agent", "pendulumd/" API_VERSION},  {"Expect", ""}};
    struct curl_slist *list = NULL;
    for (size_t i = 0; i < sizeof field / sizeof *field; i++) {
        char line[512];
        snprintf(line, sizeof line, "%s:%s%s", field[i][0], *field[i][1] ? " " : "", field[i][1]);
        struct curl_slist *longer = curl_slist_append(list, line);
        if (!longer) {
            curl_slist_free_all(list);
            return NULL;
        }
        list = longer;
    }
    return list;
}

/* everything that differs from what libcurl does by itself */
static int post_set(CURL *curl, const struct srv_hook_message *message, const char *authority,
                    struct post *post, struct curl_slist *fields, struct curl_slist *pinned) {
    int bad = 0;
#define SET(option, value) bad |= curl_easy_setopt(curl, option, value) != CURLE_OK
    SET(CURLOPT_URL, message->url);
    SET(CURLOPT_PROTOCOLS_STR, "https");
    SET(CURLOPT_HTTP_VERSION, (long)CURL_HTTP_VERSION_1_1);
    SET(CURLOPT_FOLLOWLOCATION, 0L);
    SET(CURLOPT_PROXY, "");
    SET(CURLOPT_NOSIGNAL, 1L);
    SET(CURLOPT_CONNECTTIMEOUT, (long)SRV_HOOK_CONNECT_S);
    SET(CURLOPT_TIMEOUT, (long)SRV_HOOK_SECONDS);
    SET(CURLOPT_RESOLVE, pinned);
    SET(CURLOPT_OPENSOCKETFUNCTION, post_open);
    SET(CURLOPT_OPENSOCKETDATA, post);
    SET(CURLOPT_HEADERFUNCTION, post_head);
    SET(CURLOPT_HEADERDATA, post);
    SET(CURLOPT_WRITEFUNCTION, post_body);
    SET(CURLOPT_HTTPHEADER, fields);
    SET(CURLOPT_POST, 1L);
    SET(CURLOPT_POSTFIELDS, message->body);
    SET(CURLOPT_POSTFIELDSIZE, (long)message->bytes);
    if (strcmp(authority, "none")) SET(CURLOPT_CAINFO, authority);
#undef SET
    return !bad;
}

/* posts a message, and says what was answered; returns 0 where it could not begin */
static int post_transfer(const struct srv_hook_message *message, const char *authority,
                         const char *pinned, struct post *post, long *answered) {
    CURL *curl = curl_easy_init();
    struct curl_slist *fields = post_fields(message);
    struct curl_slist *pins = *pinned ? curl_slist_append(NULL, pinned) : NULL;
    int ready = curl && fields && (pins || !*pinned) &&
                post_set(curl, message, authority, post, fields, pins);
    /* how the transfer ended says little: a body that is not read is an error, and no matter */
    if (ready) (void)curl_easy_perform(curl);
    if (ready) curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, answered);
    curl_slist_free_all(fields);
    curl_slist_free_all(pins);
    if (curl) curl_easy_cleanup(curl);
    return ready;
}

enum srv_hook_end srv_hook_post(const struct srv_hook_message *message,
                                const struct srv_peers *networks, const char *authority,
                                int *status) {
    struct post post = {.networks = networks};
    struct api_webhook_place place;
    char pinned[POST_PINNED];
    long answered = 0;
    *status = 0;
    if (api_webhook_url(message->url, &place)) return SRV_HOOK_REFUSED;
    enum srv_hook_end end = post_pin(&place, networks, pinned);
    if (end != SRV_HOOK_ANSWERED) return end;
    if (curl_global_init(CURL_GLOBAL_DEFAULT)) return SRV_HOOK_BROKEN;
    int ready = post_transfer(message, authority, pinned, &post, &answered);
    curl_global_cleanup();
    if (!ready) return SRV_HOOK_BROKEN;
    *status = answered >= 100 && answered <= 999 ? (int)answered : 0;
    return *status ? SRV_HOOK_ANSWERED : post.refused ? SRV_HOOK_REFUSED : SRV_HOOK_NOWHERE;
}
