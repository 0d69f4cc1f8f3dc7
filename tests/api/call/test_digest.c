#include "api/call/digest.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

struct text {
    char digest[API_DIGEST_BYTES];
};

static struct text digest_of(const char *json) {
    static const char *const parts[] = {"a", "", NULL};
    struct text text = {""};
    OWN(api_json, free) *document = NULL;
    struct api_problem problem;
    api_problem_init(&problem);
    CHECK_SAYING(api_json_new(&document, json, strlen(json), 16, &problem) == PEND_OK, "%s", json);
    if (!document) return text;
    struct api_value root = api_json_root(document);
    api_digest(text.digest, parts, &root);
    return text;
}

/* SHA-256 of "s\1as\0" and of the same followed by "b\1", as sha256sum computes it */
TEST(digest_is_sha_256_of_the_canonical_form) {
    static const char *const parts[] = {"a", "", NULL};
    char digest[API_DIGEST_BYTES];
    api_digest(digest, parts, NULL);
    CHECK_TEXT(digest, "fb4f439eb71110cf0a8f104dc390980ba0996d0c36012852e05614899c2b8b20");
    CHECK_TEXT(digest_of("true").digest,
               "54eb9b2b21f5391d07ddabd3760bb91617c5c351f67237dffde2439de7de52b0");
}

TEST(digest_of_the_same_value_in_other_words_is_the_same) {
    static const char *const same[][2] = {
        {"{\"a\":1,\"b\":[2,3],\"c\":{\"d\":null}}",
         " { \"c\":{\"d\" : null},\n\"b\":[2.0,3e0], \"a\":10e-1 }"},
        {"\"\\u00e9/\"", "\"\xc3\xa9\\/\""},
        {"[0.1,1000]", "[1E-1,1e3]"},
    };
    for (size_t i = 0; i < sizeof same / sizeof *same; i++)
        CHECK_TEXT(digest_of(same[i][0]).digest, digest_of(same[i][1]).digest);
}

TEST(digest_of_values_that_differ_differs) {
    enum { COUNT = 42 };
    char values[] =
        "1|\"1\"|[1]|[[1]]|true|false|null|[]|{}|[{}]|\"\"|[0]|[-0.0]|0|-0.0|[1,2]|[2,1]|"
        "[12]|[255]|[256]|[1.5]|[1,2.5]|[\"a\",\"b\"]|[\"ab\",\"\"]|[\"ab\"]|{\"a\":\"b\"}|"
        "{\"a\":{}}|{\"a\":[]}|{\"ab\":1}|{\"a\":1}|{\"a\":[1]}|{\"a\":null}|[[1,2],[3]]|"
        "[[1],[2,3]]|[[1,2,3]]|[\"s\"]|{\"b\":1}|{\"a\":true}|[null,1]|[1,null]|[-1]|[1e300]";
    char *rest = values, *other[COUNT];
    for (int i = 0; i < COUNT; i++) REQUIRE((other[i] = strsep(&rest, "|")) != NULL);
    CHECK(!rest);
    struct text text[COUNT];
    for (int i = 0; i < COUNT; i++) {
        text[i] = digest_of(other[i]);
        for (int j = 0; j < i; j++)
            CHECK_SAYING(strcmp(text[i].digest, text[j].digest) != 0, "%s and %s", other[i],
                         other[j]);
    }
}

/* across the boundaries of the blocks that are hashed */
TEST(digest_of_long_arrays_depends_on_every_item) {
    static char json[6000];
    for (int count = 250; count < 262; count++) {
        char seen[API_DIGEST_BYTES] = "";
        for (int changed = -1; changed < count; changed += 83) {
            size_t used = 0;
            for (int i = 0; i < count; i++)
                used += (size_t)sprintf(json + used, "%s%d", i ? "," : "[", i == changed ? 7 : 3);
            strcpy(json + used, "]");
            struct text text = digest_of(json);
            CHECK(strcmp(text.digest, seen) != 0);
            memcpy(seen, text.digest, sizeof seen);
        }
    }
}

TEST(seal_is_of_the_bytes_and_of_their_place) {
    unsigned char seal[API_SEAL_BYTES], other[API_SEAL_BYTES];
    char data[300];
    memset(data, 7, sizeof data);
    api_seal(seal, "place", 3, data, sizeof data);
    api_seal(other, "place", 3, data, sizeof data);
    CHECK(!memcmp(seal, other, sizeof seal));
    api_seal(other, "place", 4, data, sizeof data);
    CHECK(memcmp(seal, other, sizeof seal));
    api_seal(other, "plac", 3, data, sizeof data);
    CHECK(memcmp(seal, other, sizeof seal));
    api_seal(other, "place", 3, data, sizeof data - 1);
    CHECK(memcmp(seal, other, sizeof seal));
    data[200] ^= 1;
    api_seal(other, "place", 3, data, sizeof data);
    CHECK(memcmp(seal, other, sizeof seal));
}
