#include "api/link/oembed.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

#define HOST "school.example:8080"
#define URL "url=https%3A%2F%2Fschool.example%3A8080"
#define VIEW "https://school.example:8080/?embed=1"

TEST(links_to_the_page_become_frames_of_its_embed_view) {
    static const struct {
        const char *query, *link;
        long width, height;
    } row[] = {
        {URL, VIEW, 720, 480},
        {URL "%2F", VIEW, 720, 480},
        {URL "/%23d%3Dq1b-_&format=json", VIEW "#d=q1b-_", 720, 480},
        {URL "/%3Flength%3D1,1%26theta%3D90&maxwidth=500&maxheight=100000",
         VIEW "&length=1,1&theta=90", 500, 480},
        {"maxheight=90&dnt=1&url=http://school.example:8080/?embed=0%26lang=de%26embed#s=x",
         "http://school.example:8080/?embed=1&lang=de#s=x", 720, 90},
        {"url=HTTPS://SCHOOL.example:8080?sheet=period",
         "HTTPS://SCHOOL.example:8080/?embed=1&sheet=period", 720, 480},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct api_oembed wanted = {.link = ""};
        OWN(api_problem, clear) problem;
        api_problem_init(&problem);
        CHECK_INT(api_oembed_read(row[i].query, HOST, &wanted, &problem), PEND_OK);
        CHECK_TEXT(wanted.link, row[i].link);
        CHECK_INT(wanted.width, row[i].width);
        CHECK_INT(wanted.height, row[i].height);
    }
}

TEST(what_is_no_link_to_the_page_is_refused) {
    static const struct {
        const char *query, *host;
        int status;
    } row[] = {
        {NULL, HOST, 422},
        {"", HOST, 422},
        {"format=json", HOST, 422},
        {"url", HOST, 422},
        {URL "&" URL, HOST, 422},
        {URL "%2", HOST, 422},
        {URL "%2G", HOST, 422},
        {URL "%00", HOST, 422},
        {URL "%", HOST, 422},
        {URL "%22onload=alert(1)", HOST, 422},
        {URL "/%3Cscript%3E", HOST, 422},
        {URL "/%27", HOST, 422},
        {URL "/%C3%A4", HOST, 422},
        {URL "/%0d%0a", HOST, 422},
        {"url=javascript:alert(1)", HOST, 422},
        {"url=/", HOST, 422},
        {URL "&maxwidth=0", HOST, 422},
        {URL "&maxwidth=-1", HOST, 422},
        {URL "&maxwidth=1e3", HOST, 422},
        {URL "&maxheight=100001", HOST, 422},
        {URL "&maxheight=12345678901234567890", HOST, 422},
        {URL "&format=xml", HOST, 501},
        {URL "&format=JSON", HOST, 501},
        {URL, "school.example", 404},
        {URL, NULL, 404},
        {URL ".evil.example/", HOST, 404},
        {"url=https://school.example:8080@evil.example/", HOST, 404},
        {"url=https://evil.example/?https://school.example:8080/", HOST, 404},
        {URL "/docs", HOST, 404},
        {URL "/PK7TRA", HOST, 404},
        {URL "//evil.example/", HOST, 404},
        {URL "/%3Froom%3DPK7TRA", HOST, 404},
        {URL "/%3Flength%3D1%26room", HOST, 404},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct api_oembed wanted = {.width = 7};
        OWN(api_problem, clear) problem;
        api_problem_init(&problem);
        CHECK_INT(api_oembed_read(row[i].query, row[i].host, &wanted, &problem), PEND_INVALID);
        CHECK_INT(problem.status, row[i].status);
        CHECK(wanted.width == 7 && *problem.detail);
    }
}

TEST(a_link_as_long_as_a_request_may_be_fits_and_a_longer_one_is_refused) {
    static const char head[] = "url=http://h/#d=";
    char query[2048];
    for (int bytes = 1000; bytes < 2000; bytes++) {
        struct api_oembed wanted;
        OWN(api_problem, clear) problem;
        memset(query, 'x', (size_t)bytes);
        memcpy(query, head, sizeof head - 1);
        query[bytes] = 0;
        api_problem_init(&problem);
        int short_enough = bytes - 4 <= API_OEMBED_URL;
        CHECK_INT(api_oembed_read(query, "h", &wanted, &problem),
                  short_enough ? PEND_OK : PEND_INVALID);
        if (short_enough)
            CHECK_INT((long)strlen(wanted.link), bytes - 4 + 8);
        else
            CHECK_INT(problem.status, 422);
    }
}

TEST(the_answer_holds_a_frame_whose_attributes_nothing_ends) {
    struct api_oembed wanted = {.link = "http://h/?embed=1&length=1,1&theta=9#d=a\\b", 300, 200};
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1 << 16);
    CHECK_INT(api_oembed_write(&wanted, &out), PEND_OK);
    CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
    CHECK_TEXT(
        out.data,
        "{\"version\":\"1.0\",\"type\":\"rich\",\"title\":\"Pendulum of 2 arms\",\"provider_name\":"
        "\"pendulumd\",\"provider_url\":\"http://h/\",\"width\":300,\"height\":200,\"html\":"
        "\"<iframe src=\\\"http://h/?embed=1&amp;length=1,1&amp;theta=9#d=a\\\\b\\\" "
        "width=\\\"300\\\" height=\\\"200\\\" title=\\\"Pendulum of 2 arms\\\" "
        "style=\\\"border:0\\\" loading=\\\"lazy\\\" allow=\\\"fullscreen\\\"></iframe>\"}");
    api_buffer_clear(&out);
    api_buffer_init(&out, 100);
    CHECK_INT(api_oembed_write(&wanted, &out), PEND_LIMIT);
}

TEST(a_link_has_the_title_that_it_names) {
    static const struct {
        const char *link, *title, *attribute;
    } row[] = {
        {"http://h/?embed=1&title=Two%20side%20by%20side#d=x", "Two side by side", NULL},
        {"http://h/?embed=1&length=1,1&title=Kr%C3%A4ne&lang=de", "Kr\303\244ne", NULL},
        {"http://h/?embed=1&title=%22%3E%3Cb%3E%26'#d=x", "\\\"><b>&'",
         "&#34;&#62;&#60;b&#62;&amp;&#39;"},
        {"http://h/?embed=1&title=%FF&length=1", "\357\277\275", NULL},
        {"http://h/?embed=1&title=%2&length=1,2", "Pendulum of 2 arms", NULL},
        {"http://h/?embed=1&title=&sheet=period", "Worksheet: period", NULL},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct api_oembed wanted = {.width = 300, .height = 200};
        char json[300], attribute[300];
        OWN(api_buffer, clear) out;
        snprintf(wanted.link, sizeof wanted.link, "%s", row[i].link);
        api_buffer_init(&out, 1 << 16);
        CHECK_INT(api_oembed_write(&wanted, &out), PEND_OK);
        CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
        snprintf(json, sizeof json, "\"title\":\"%s\"", row[i].title);
        const char *held = row[i].attribute ? row[i].attribute : row[i].title;
        snprintf(attribute, sizeof attribute, " title=\\\"%s\\\" style", held);
        CHECK_SAYING(strstr(out.data, json) && strstr(out.data, attribute), "%s: %s", json,
                     out.data);
    }
}

TEST(the_tag_names_the_document_it_stands_in_and_a_strange_host_has_none) {
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1 << 16);
    CHECK_INT(api_oembed_tag("https", "h:1", "length=1,1&a=\"><b>", &out), PEND_OK);
    CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
    CHECK_TEXT(out.data, "<link rel=\"alternate\" type=\"application/json+oembed\" title="
                         "\"pendulumd\" href=\"https://h:1/oembed?format=json&amp;url=https%3A%2F"
                         "%2Fh%3A1%2F%3Flength%3D1%2C1%26a%3D%22%3E%3Cb%3E\">\n");
    out.bytes = 0;
    CHECK_INT(api_oembed_tag("http", NULL, "length=1", &out), PEND_OK);
    CHECK_INT(api_oembed_tag("http", "h\"><script>", "length=1", &out), PEND_OK);
    CHECK_INT(api_oembed_tag("http", "", "length=1", &out), PEND_OK);
    CHECK_INT((long)out.bytes, 0);
}

TEST(readable_links_and_worksheets_tell_what_is_shown_and_others_do_not) {
    static const struct {
        const char *query;
        int tells;
    } row[] = {{NULL, 0},       {"", 0},         {"lang=de", 0},          {"lengths=1", 0},
               {"length=1", 1}, {"&&length", 1}, {"lang=de&length=1", 1}, {"sheet=period", 1},
               {"a=length", 0}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        CHECK_INT(api_oembed_tells(row[i].query), row[i].tells);
}
