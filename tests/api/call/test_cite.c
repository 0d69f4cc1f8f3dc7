/* Tests of api/call/cite: an entry for BibTeX. */
#include "api/call/cite.h"

#include <string.h>

#include "tests/harness/test.h"

static const struct api_cite of_a_run = {.id = "5yzah1f1xfh7br5x7b899d1hh3",
                                         .operation = "ensembles",
                                         .title = "",
                                         .version = "0.1.0+0123456789abcdef",
                                         .origin = "https://pendulum.example",
                                         .created = INT64_C(951825600000000),
                                         .started = INT64_C(951825600000000),
                                         .finished = INT64_C(951825600250000),
                                         .request = "abc",
                                         .request_bytes = 3};

/* the entry of a run; "" where it fails */
static const char *entry(const struct api_cite *cite, struct api_buffer *out) {
    struct api_cite own = *cite;
    api_buffer_init(out, 65536);
    if (!CHECK(api_cite_digest(&own) == PEND_OK && api_cite_write(&own, out) == PEND_OK &&
               api_buffer_add(out, "", 1) == PEND_OK))
        return "";
    return out->data;
}

TEST(an_entry_says_what_was_computed_when_where_by_what_and_of_which_request) {
    struct api_buffer out;
    const char *text = entry(&of_a_run, &out);
    /* the digest of "abc" as FIPS 180-4 has it */
    static const char *const said[] = {
        "@misc{pendulumd-5yzah1f1xfh7br5x7b899d1hh3,\n",
        "title = {{Ensemble of motions of a planar pendulum tree (run 5yzah1f1)}}",
        "year = {2000},\n  month = {02},\n  date = {2000-02-29}",
        "version = {{0.1.0+0123456789abcdef}}",
        "url = {https://pendulum.example/v1/jobs/5yzah1f1xfh7br5x7b899d1hh3/results}",
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"};
    for (size_t i = 0; i < sizeof said / sizeof *said; i++)
        CHECK_SAYING(strstr(text, said[i]) != NULL, "%s is not in %s", said[i], text);
    api_buffer_clear(&out);
}

TEST(what_tex_takes_for_commands_stands_in_an_entry_as_text) {
    static const struct {
        const char *title, *tex;
    } known[] = {{"50 % of #3 & _x_ for $5", "50 \\% of \\#3 \\& \\_x\\_ for \\$5"},
                 {"a{b}c", "a{\\textbraceleft}b{\\textbraceright}c"},
                 {"\\input~^", "{\\textbackslash}input{\\textasciitilde}{\\textasciicircum}"},
                 {"say \"x\"", "say {\\textquotedbl}x{\\textquotedbl}"},
                 {"Schwünge", "Schwünge"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct api_cite cite = of_a_run;
        struct api_buffer out;
        cite.title = known[i].title;
        const char *text = entry(&cite, &out), *at = strstr(text, "title = {{");
        int depth = 0;
        CHECK_SAYING(at && !strncmp(at + 10, known[i].tex, strlen(known[i].tex)) &&
                         !strncmp(at + 10 + strlen(known[i].tex), "}},\n", 4),
                     "%s", text);
        for (const char *p = text; *p; p++) depth += *p == '{' ? 1 : *p == '}' ? -1 : 0;
        CHECK_INT(depth, 0);
        api_buffer_clear(&out);
    }
}
