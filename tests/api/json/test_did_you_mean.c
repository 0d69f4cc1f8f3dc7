#include "api/json/did_you_mean.h"

#include "tests/harness/test.h"

static const char *const root[] = {"pendulum", "initial", "times", "method", "rtol", "step", NULL};
static const char *const arm[] = {"name", "parent", "length", "mass", NULL};

TEST(a_name_is_meant_by_other_words_before_letters) {
    CHECK_TEXT(api_did_you_mean("lenght", arm), "length");
    CHECK_TEXT(api_did_you_mean("id", arm), "name");
    CHECK_TEXT(api_did_you_mean("m", arm), "mass");
    CHECK_TEXT(api_did_you_mean("T", root), "times");
    CHECK_TEXT(api_did_you_mean("RelTol", root), "rtol");
    CHECK(!api_did_you_mean("colour", arm) && !api_name_nearest("id", arm));
}

TEST(a_word_means_only_what_is_allowed) {
    static const char *const tips[] = {"zd", "thetad", NULL}, *const states[] = {"thetad", NULL};
    CHECK_TEXT(api_did_you_mean("velocity", tips), "zd");
    CHECK_TEXT(api_did_you_mean("velocity", states), "thetad");
    CHECK(!api_did_you_mean("velocity", root));
}

TEST(a_field_is_told_the_object_that_it_belongs_in) {
    CHECK_TEXT(api_name_place("S", root), "pendulum");
    CHECK_TEXT(api_name_place("theta", root), "initial");
    CHECK_TEXT(api_name_place("dt", root), "times");
    CHECK(!api_name_place("S", arm) && !api_name_place("colour", root));
}

TEST(the_same_letters_count_before_another_word) {
    static const char *const lists[] = {"length", "mass", "L", "m", NULL};
    CHECK_TEXT(api_did_you_mean("M", lists), "m");
    CHECK_TEXT(api_did_you_mean("l", lists), "L");
    CHECK_TEXT(api_did_you_mean("Masses", lists), "mass");
}

TEST(what_stands_beside_the_pendulum_or_in_the_head_is_known) {
    CHECK(api_name_outer("theta") && api_name_outer("times") && !api_name_outer("mass"));
    CHECK_TEXT(api_name_head("Format"), "Accept: text/csv");
    CHECK(!api_name_head("rtol"));
}
