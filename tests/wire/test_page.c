/* The page's documents and files, as a browser fetches them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/ask.h"

/* the path of the page's files as a document contains it: relative to the document; "" with a
 * failed check if there is none */
static void page_of(struct test_server *server, const char *path, char page[64]) {
    OWN(test_reply, clear) reply;
    page[0] = 0;
    CHECK_INT(test_request(server, &reply, "GET", path, "", NULL), 200);
    const char *at = reply.body ? strstr(reply.body, "\"page/") : NULL;
    CHECK_SAYING(at != NULL, "%s names no file of the page", path);
    if (at) snprintf(page, 64, "/%.21s", at + 1);
    CHECK(strspn(page + 6, "0123456789abcdef") == 16);
    CHECK(!strstr(reply.body, "@PAGE@"));
}

TEST(documents_of_the_page_may_load_from_this_server_only) {
    static const char *const path[] = {"/", "/docs"};
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(test_request(server, &reply, "GET", path[i], "", NULL), 200);
        CHECK_TEXT(test_reply_header(&reply, "Content-Type"), "text/html; charset=utf-8");
        CHECK_TEXT(test_reply_header(&reply, "Cache-Control"), "no-cache");
        CHECK_TEXT(test_reply_header(&reply, "X-Content-Type-Options"), "nosniff");
        CHECK_TEXT(test_reply_header(&reply, "Referrer-Policy"), "no-referrer");
        const char *policy = test_reply_header(&reply, "Content-Security-Policy");
        CHECK(policy &&
              !strncmp(policy, "default-src 'none'; script-src 'self' 'wasm-unsafe-eval' 'sha256-",
                       65));
        // the engine, and nothing else that a page could make from text
        CHECK(policy && !strstr(policy, "unsafe-inline") && !strstr(policy, "'unsafe-eval"));
        CHECK(policy && strstr(policy, "frame-ancestors 'none'"));
        CHECK(reply.body && !strstr(reply.body, "=\"http") && !strstr(reply.body, "=\"//"));
        test_reply_clear(&reply);
    }
}

TEST(the_code_of_a_room_leads_to_the_page_in_it_and_nothing_else_does) {
    static const struct {
        const char *method, *path;
        int status;
        const char *to;
    } row[] = {{"GET", "/PK7TRA", 302, "./?room=PK7TRA"},
               {"GET", "/pk7tra", 302, "./?room=PK7TRA"},
               {"HEAD", "/PK7TRA", 302, "./?room=PK7TRA"},
               {"GET", "/PK7T", 404, NULL},
               {"GET", "/PK7TRR", 302, "./?room=PK7TRR"},
               {"GET", "/PK7TRRR", 404, NULL},
               {"GET", "/readyz", 200, NULL},
               {"GET", "/PK1TR", 404, NULL},
               {"GET", "/PK7TRA/", 404, NULL},
               {"POST", "/PK7TRA", 405, NULL},
               {"POST", "/nowhere", 404, NULL}};
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        CHECK_INT(test_request(server, &reply, row[i].method, row[i].path, "", NULL),
                  row[i].status);
        const char *to = test_reply_header(&reply, "Location");
        CHECK_TEXT(to ? to : "", row[i].to ? row[i].to : "");
        test_reply_clear(&reply);
    }
}

TEST(only_the_embed_view_may_be_framed_and_only_by_whom_the_option_lists) {
    static const struct {
        const char *list, *path, *frames;
    } row[] = {
        {"*", "/?embed=1", "frame-ancestors *"},
        {"*", "/?room=PK7TRA&embed=1", "frame-ancestors *"},
        {"*", "/?embed=10", "frame-ancestors 'none'"},
        {"*", "/?noembed=1", "frame-ancestors 'none'"},
        {"*", "/docs?embed=1", "frame-ancestors 'none'"},
        {"none", "/?embed=1", "frame-ancestors 'none'"},
        {"https://a.example,https://b.example", "/?embed=1",
         "frame-ancestors https://a.example https://b.example"},
    };
    struct test_reply reply;
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const char *options[] = {"--frame-ancestors", row[i].list, NULL};
        OWN(test_server, stop) *server = test_server_start(options);
        REQUIRE(server != NULL);
        CHECK_INT(test_request(server, &reply, "GET", row[i].path, "", NULL), 200);
        const char *policy = test_reply_header(&reply, "Content-Security-Policy");
        const char *frames = policy ? strstr(policy, "frame-ancestors") : NULL;
        CHECK_TEXT(frames ? frames : "", row[i].frames);
        test_reply_clear(&reply);
    }
}

TEST(the_service_worker_is_asked_for_anew_and_names_the_files_of_the_page) {
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    char page[64];
    REQUIRE(server != NULL);
    page_of(server, "/", page);
    CHECK_INT(test_request(server, &reply, "GET", "/sw.js", "", NULL), 200);
    CHECK_TEXT(test_reply_header(&reply, "Content-Type"), "text/javascript; charset=utf-8");
    CHECK_TEXT(test_reply_header(&reply, "Cache-Control"), "no-cache");
    CHECK_TEXT(test_reply_header(&reply, "Service-Worker-Allowed"), "/");
    CHECK(reply.body && strstr(reply.body, page + 1) && strstr(reply.body, "lib/katex.js"));
    CHECK(reply.body && !strstr(reply.body, "@FILES@") && !strstr(reply.body, "index.html"));
}

/* one request whose reply, not text, is not recorded */
static int fetch(struct test_server *server, struct test_reply *reply, const char *path,
                 const char *headers) {
    OWN(test_client, close) client;
    char text[400];
    *reply = (struct test_reply){0};
    if (!test_client_open(&client, test_server_port(server))) return 0;
    snprintf(text, sizeof text, "GET %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\n%s\r\n", path,
             headers);
    test_client_say(&client, text);
    return test_client_receive(&client, reply, 0, TEST_PATIENCE);
}

/* of lib/, so that the page's own files do not matter here */
static const struct {
    const char *file, *type;
    int packed;
} file[] = {
    {"lib/katex.js", "text/javascript; charset=utf-8", 1},
    {"lib/katex.css", "text/css; charset=utf-8", 1},
    {"lib/katex.js", "text/javascript; charset=utf-8", 1},
    {"lib/katex.css", "text/css; charset=utf-8", 1},
    {"lib/qrcode.js", "text/javascript; charset=utf-8", 1},
    {"lib/licenses.txt", "text/plain; charset=utf-8", 1},
    {"lib/fonts/KaTeX_Main-Regular.woff2", "font/woff2", 0},
};
enum { FILES = sizeof file / sizeof *file };

TEST(files_of_the_page_are_kept_for_ever_and_come_gzipped_to_who_takes_that) {
    static const char *const accept[] = {"", "Accept-Encoding: gzip, deflate, br, zstd\r\n",
                                         "Accept-Encoding: gzip;q=0, zstd\r\n"};
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    char page[64], path[160];
    REQUIRE(server != NULL);
    page_of(server, "/", page);
    for (int i = 0; i < FILES; i++) {
        size_t plain = 0;
        for (int k = 0; k < 3; k++) {
            snprintf(path, sizeof path, "%s/%s", page, file[i].file);
            CHECK_INT(fetch(server, &reply, path, accept[k]), 200);
            CHECK_TEXT(test_reply_header(&reply, "Content-Type"), file[i].type);
            CHECK_TEXT(test_reply_header(&reply, "Cache-Control"),
                       "public, max-age=31536000, immutable");
            CHECK_TEXT(test_reply_header(&reply, "Vary"), "Accept-Encoding");
            const char *coding = test_reply_header(&reply, "Content-Encoding");
            int packed = k == 1 && file[i].packed;
            CHECK_INT(coding && !strcmp(coding, "gzip"), packed);
            CHECK_INT(reply.body_bytes > 2 && !memcmp(reply.body, "\x1f\x8b", 2), packed);
            if (!k) plain = reply.body_bytes;
            CHECK(packed ? reply.body_bytes < plain : reply.body_bytes == plain);
            test_reply_clear(&reply);
        }
    }
}

TEST(a_file_of_the_page_that_the_browser_has_is_not_sent_again) {
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    char page[64], path[2][160], headers[160];
    REQUIRE(server != NULL);
    page_of(server, "/docs", page);
    snprintf(path[0], sizeof path[0], "/");
    snprintf(path[1], sizeof path[1], "%s/lib/katex.js", page);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(test_request(server, &reply, "GET", path[i], "", NULL), 200);
        const char *etag = test_reply_header(&reply, "ETag");
        snprintf(headers, sizeof headers, "If-None-Match: %.100s\r\n", etag ? etag : "");
        test_reply_clear(&reply);
        CHECK_INT(test_request(server, &reply, "GET", path[i], headers, NULL), 304);
        CHECK_INT((long long)reply.body_bytes, 0);
        CHECK(test_reply_header(&reply, "ETag") != NULL);
        test_reply_clear(&reply);
    }
}

TEST(what_is_no_file_of_the_page_is_not_found) {
    static const char *const rest[] = {"",
                                       "/",
                                       "/nothing",
                                       "/lib",
                                       "/lib/",
                                       "/lib/../index.html",
                                       "/index.html",
                                       "/docs.html",
                                       "/sw.js",
                                       "/package.json",
                                       "/lib/katex.js/",
                                       "//lib/katex.js"};
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    char page[64], path[160];
    REQUIRE(server != NULL);
    page_of(server, "/", page);
    for (size_t i = 0; i < sizeof rest / sizeof *rest; i++) {
        snprintf(path, sizeof path, "%s%s", page, rest[i]);
        test_request(server, &reply, "GET", path, "", NULL);
        if (reply.status != 404) printf("  %s\n", path);
        ask_problem(&reply, 404, NULL);
        test_reply_clear(&reply);
    }
    /* the files of another build are refused */
    page[8] = page[8] == '0' ? '1' : '0';
    snprintf(path, sizeof path, "%s/lib/katex.js", page);
    test_request(server, &reply, "GET", path, "", NULL);
    ask_problem(&reply, 404, NULL);
}

/* the value after `name` in a document, up to the next quotation mark, with its &amp; decoded; ""
 * without it */
static void value_of(const char *document, const char *name, char value[], size_t cap) {
    const char *at = document ? strstr(document, name) : NULL;
    size_t length = 0;
    value[0] = 0;
    if (!at) return;
    for (at += strlen(name); *at && !strchr("\"\\", *at) && length + 1 < cap; at++) {
        value[length++] = *at;
        if (!strncmp(at, "&amp;", 5)) at += 4;
    }
    value[length] = 0;
}

TEST(a_readable_link_tells_of_its_frame_which_is_one_of_the_embed_view) {
    static const char link[] = "/?length=1,1&theta=90,45&lang=de";
    char href[600], frame[600];
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "GET", link, "", NULL), 200);
    CHECK(reply.body && strstr(reply.body, "</html>") && strstr(reply.body, "main.js"));
    const char *policy = test_reply_header(&reply, "Content-Security-Policy");
    CHECK(policy && strstr(policy, "frame-ancestors 'none'"));
    value_of(reply.body, "json+oembed\" title=\"pendulumd\" href=\"http://localhost", href,
             sizeof href);
    test_reply_clear(&reply);
    CHECK(!strncmp(href, "/oembed?format=json&url=http%3A%2F%2Flocalhost", 46));
    CHECK_INT(test_request(server, &reply, "GET", href, "", NULL), 200);
    value_of(reply.body, "iframe src=\\\"http://localhost", frame, sizeof frame);
    test_reply_clear(&reply);
    CHECK_TEXT(frame, "/?embed=1&length=1,1&theta=90,45&lang=de");
    CHECK_INT(test_request(server, &reply, "GET", frame, "", NULL), 200);
    policy = test_reply_header(&reply, "Content-Security-Policy");
    CHECK(policy && strstr(policy, "frame-ancestors *"));
    CHECK(reply.body && !strstr(reply.body, "oembed"));
}

TEST(the_scheme_of_a_frame_is_that_of_a_trusted_proxy_and_nobody_else_says_it) {
    static const char ask[] = "X-Forwarded-Proto: https\r\n";
    const char *trusting[] = {"--trusted-proxy", "127.0.0.1", NULL};
    for (int trusted = 0; trusted < 2; trusted++) {
        OWN(test_reply, clear) reply = {0};
        OWN(test_server, stop) *server = test_server_start(trusted ? trusting : NULL);
        REQUIRE(server != NULL);
        CHECK_INT(test_request(server, &reply, "GET", "/?length=1", ask, NULL), 200);
        CHECK(reply.body && strstr(reply.body, trusted ? "href=\"https://localhost/oembed?"
                                                       : "href=\"http://localhost/oembed?"));
    }
}

TEST(a_server_that_nobody_may_frame_describes_no_frames) {
    const char *options[] = {"--frame-ancestors", "none", NULL};
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(options);
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "GET", "/?length=1", "", NULL), 200);
    CHECK(reply.body && !strstr(reply.body, "oembed"));
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", "/oembed?url=http://localhost/", "", NULL), 404);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", "/oembed?url=http://y/", "", NULL), 404);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", "/oembed?url=x", "", NULL), 422);
    test_reply_clear(&reply);
    CHECK_INT(
        test_request(server, &reply, "GET", "/oembed?url=http://localhost/&format=xml", "", NULL),
        501);
}
