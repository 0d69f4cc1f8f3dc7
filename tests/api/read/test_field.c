#include "api/read/field.h"

#include <math.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* a document, its root, and the problem that receives the errors */
struct field_case {
    struct api_json *document;
    struct api_problem problem;
    struct api_value root;
};

static void begin(struct field_case *test, const char *text) {
    api_problem_init(&test->problem);
    CHECK(!api_json_new(&test->document, text, strlen(text), 9, &test->problem));
    test->root = api_json_root(test->document);
}

static void end(struct field_case *test) {
    api_problem_clear(&test->problem);
    api_json_free(&test->document);
}

TEST(a_list_of_numbers_is_read_with_nan_for_its_faults) {
    struct field_case test;
    double out[3] = {7, 7, 7};
    begin(&test, "{\"good\":[1,2,3],\"short\":[4],\"mixed\":[5,\"x\",6],\"word\":\"y\"}");
    struct api_value good = api_value_member(&test.root, "good"),
                     lacking = api_value_member(&test.root, "lacking");
    struct api_value few = api_value_member(&test.root, "short"),
                     mixed = api_value_member(&test.root, "mixed");
    struct api_value word = api_value_member(&test.root, "word");
    CHECK_INT(api_field_numbers(&lacking, 3, "arm", out, &test.problem), 0);
    CHECK(out[0] == 7);
    CHECK_INT(api_field_numbers(&good, 3, "arm", out, &test.problem), 1);
    CHECK(out[0] == 1 && out[1] == 2 && out[2] == 3);
    CHECK_INT(test.problem.count, 0);
    CHECK_INT(api_field_numbers(&few, 3, "arm", out, &test.problem), -1);
    CHECK(out[0] == 4 && isnan(out[1]) && isnan(out[2]));
    CHECK_INT(api_field_numbers(&mixed, 3, "arm", out, &test.problem), -1);
    CHECK(out[0] == 5 && isnan(out[1]) && out[2] == 6);
    CHECK_INT(api_field_numbers(&word, 3, "arm", out, &test.problem), -1);
    CHECK(isnan(out[0]));
    CHECK_INT(api_field_numbers(&good, 0, "", NULL, &test.problem), 1);
    CHECK_INT(test.problem.count, 3);
    end(&test);
}

TEST(whole_numbers_words_and_truths_are_left_alone_unless_good) {
    struct field_case test;
    static const char *const words[] = {"left", "right", NULL};
    long whole = 5;
    int word = 5, truth = 5;
    begin(
        &test,
        "{\"n\":3,\"half\":0.5,\"word\":\"right\",\"wrong\":\"rihgt\",\"true\":true,\"no\":null}");
    struct api_value n = api_value_member(&test.root, "n"),
                     half = api_value_member(&test.root, "half");
    struct api_value right = api_value_member(&test.root, "word"),
                     wrong = api_value_member(&test.root, "wrong");
    struct api_value yes = api_value_member(&test.root, "true"),
                     no = api_value_member(&test.root, "no");
    CHECK_INT(api_field_whole(&half, 0, 9, &whole, &test.problem), -1);
    CHECK_INT(api_field_whole(&n, 4, 9, &whole, &test.problem), -1);
    CHECK_INT(whole, 5);
    CHECK_INT(api_field_whole(&n, 3, 3, &whole, &test.problem), 1);
    CHECK_INT(whole, 3);
    CHECK_INT(api_field_word(&wrong, words, &word, &test.problem), -1);
    CHECK_INT(word, 5);
    CHECK(strstr(test.problem.faults[2].detail, "did you mean \"right\"?"));
    CHECK_INT(api_field_word(&right, words, &word, &test.problem), 1);
    CHECK_INT(word, 1);
    CHECK_INT(api_field_truth(&no, &truth, &test.problem), -1);
    CHECK_INT(truth, 5);
    CHECK_INT(api_field_truth(&yes, &truth, &test.problem), 1);
    CHECK_INT(truth, 1);
    CHECK_INT(test.problem.count, 4);
    end(&test);
}

TEST(a_word_that_is_part_of_others_leads_to_them_and_long_lists_end_at_a_word) {
    struct field_case test;
    static const char *const words[] = {"friction_torque",
                                        "friction_speed",
                                        "the_first_of_many_words_that_are_long_indeed",
                                        "the_second_of_many_words_that_are_long_indeed",
                                        "the_third_of_many_words_that_are_long_indeed",
                                        "the_fourth_of_many_words_that_are_long_indeed",
                                        "the_fifth_of_many_words_that_are_long_indeed",
                                        "the_sixth_of_many_words_that_are_long_indeed",
                                        NULL};
    int word = 5;
    begin(&test, "{\"part\":\"friction\",\"none\":\"something else\",\"empty\":\"\"}");
    struct api_value part = api_value_member(&test.root, "part"),
                     none = api_value_member(&test.root, "none"),
                     empty = api_value_member(&test.root, "empty");
    CHECK_INT(api_field_word(&part, words, &word, &test.problem), -1);
    CHECK_TEXT(test.problem.faults[0].detail,
               "is not known; did you mean one of \"friction_torque\", \"friction_speed\"?");
    CHECK_INT(api_field_word(&none, words, &word, &test.problem), -1);
    CHECK(strstr(test.problem.faults[1].detail, "indeed\", and others, got the text \"something"));
    CHECK(strstr(test.problem.faults[1].detail, "must be one of \"friction_torque\", "));
    CHECK_INT(api_field_word(&empty, words, &word, &test.problem), -1);
    CHECK(strstr(test.problem.faults[2].detail, "must be one of \"friction_torque\", "));
    CHECK_INT(word, 5);
    end(&test);
}

TEST(faults_of_pendulums_states_times_and_methods_have_their_pointers) {
    test_refused_rows("tests/api/read/refused.txt");
}
