#include "api/encode/negotiate.h"

#include <string.h>

#include "tests/harness/test.h"

TEST(json_bodies_are_known_by_their_content_type) {
    static const char *const good[] = {"application/json",
                                       "Application/JSON",
                                       "application/json; charset=utf-8",
                                       "application/json;charset=\"UTF-8\"",
                                       " application/json ;charset=UTF8 ",
                                       "application/json; profile=x"};
    static const char *const bad[] = {"",
                                      "text/plain",
                                      "application/x-www-form-urlencoded",
                                      "json",
                                      "application/jsonx",
                                      "application/json; charset=latin1",
                                      "text/json",
                                      "application/problem+json",
                                      "application/json; charset=\"",
                                      "application/json, text/plain"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        CHECK_SAYING(api_negotiate_json(good[i]), "%s", good[i]);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(!api_negotiate_json(bad[i]), "%s", bad[i]);
    CHECK(!api_negotiate_json(NULL));
}

/* the media type chosen for samples, or "" */
static const char *chosen(const char *accept) {
    const struct api_format *format = api_negotiate_format(accept, 1);
    return format ? format->media_type : "";
}

TEST(accept_chooses_by_quality_and_nearness) {
    static const struct {
        const char *accept, *media_type;
    } cases[] = {
        {NULL, "application/json"},
        {"", "application/json"},
        {"  , ,", "application/json"},
        {"*/*", "application/json"},
        {"text/csv", "text/csv"},
        {"TEXT/CSV", "text/csv"},
        {"text/*", "text/csv"},
        {"application/*", "application/json"},
        {"text/csv, application/json", "application/json"},
        {"text/csv;q=1.0, application/json;q=0.9", "text/csv"},
        {"text/csv;q=0.5, application/json;q=0.501", "application/json"},
        {"application/json;q=0, */*", "application/x-ndjson"},
        {"*/*;q=0.1, text/csv;q=0.2", "text/csv"},
        {"text/*;q=0.9, text/csv;q=0.1, application/json;q=0.5", "application/json"},
        {"text/html, application/xhtml+xml, application/xml;q=0.9, */*;q=0.8", "application/json"},
        {"text/csv;header=present;q=0.7, application/json;q=0.6", "text/csv"},
        {"text/csv; Q=0.9 , application/json ; q=0.8", "text/csv"},
        {"text/csv;x=\"a,b;q=0\";q=1, application/json;q=0.5", "text/csv"},
        {"text/csv;q=2, application/json;q=0.1", "application/json"},
        {"text/csv;q=abc, application/json;q=0.1", "application/json"},
        {"text/html", ""},
        {"application/json;q=0", ""},
        {"application/json;q=0.000, text/*;q=0", ""},
        {"application/problem+json", ""},
        {"image/*", ""},
        {"*", ""},
        {"json", ""},
        {"text/csv;q=1.0000", ""},
        {"text/csv;q=", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        CHECK_SAYING(!strcmp(chosen(cases[i].accept), cases[i].media_type), "%s chose \"%s\"",
                     cases[i].accept, chosen(cases[i].accept));
}

TEST(only_json_is_served_where_there_are_no_samples) {
    CHECK(!api_negotiate_format("text/csv", 0));
    CHECK(api_negotiate_format("text/csv, */*;q=0.1", 0) == &api_format_json);
}

TEST(a_refusal_lists_what_is_served) {
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    api_negotiate_refuse(&problem, 1);
    CHECK_INT(problem.status, 406);
    CHECK(strstr(problem.detail,
                 "application/json, application/x-ndjson, text/csv, application/octet-stream"));
    api_problem_clear(&problem);
    api_negotiate_refuse(&problem, 0);
    CHECK(strstr(problem.detail, "application/json") && !strstr(problem.detail, "text/csv"));
}
