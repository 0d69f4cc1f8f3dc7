#include "core/integrate/methods/method.h"

#include <math.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(times_of_a_decimal_grid_are_the_decimals) {
    const struct pend_times times = {.count = 501, .start = 0, .span = 5, .divisor = 500};
    int same = 0;
    for (long i = 0; i <= 500; i++) same += pend_times_at(&times, i) == (double)i / 100;
    CHECK_INT(same, 501);
    CHECK(0.01 * 35 != 0.35); /* the result of adding or multiplying steps */
}

TEST(times_of_a_grid_end_at_its_end) {
    unsigned long long seed = 1;
    int ends = 0, plain = 0;
    for (int i = 0; i < 1000; i++) {
        double span = test_random(&seed) - 0.5, divisor = 1 + test_random_int(&seed, 1000);
        const struct pend_times times = {
            .count = (long)divisor + 1, .start = 0, .span = span, .divisor = divisor};
        ends += pend_times_at(&times, times.count - 1) == span;
        plain += divisor * span / divisor == span;
    }
    CHECK_INT(ends, 1000);
    CHECK(plain < 1000);
}

TEST(times_of_a_grid_whose_step_does_not_divide_it_stop_short) {
    const struct pend_times times = {.count = 4, .start = 1, .span = -1, .divisor = 3.5};
    CHECK(pend_times_at(&times, 0) == 1);
    CHECK(pend_times_at(&times, 3) == 1 - 3 / 3.5);
}

TEST(times_of_a_list_are_the_list) {
    const double list[] = {3, -1, 7};
    const struct pend_times times = {.count = 3, .list = list};
    for (long i = 0; i < 3; i++) CHECK(pend_times_at(&times, i) == list[i]);
}

TEST(times_in_one_list_are_the_times_one_by_one) {
    const double list[] = {3, -1, 7, 8};
    const struct pend_times times[] = {
        {.count = 501, .span = 5, .divisor = 500},
        {.count = 4, .start = 1, .span = -1, .divisor = 3.5},
        {.count = 1000001, .start = 0.1, .span = 0.7, .divisor = 1e6},
        {.count = 4, .list = list}};
    int same = 0, compared = 0;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        long starts[] = {0, 1, times[i].count / 2, times[i].count - 3};
        for (int j = 0; j < 4; j++) {
            double t[64];
            int count = times[i].count - starts[j] < 64 ? (int)(times[i].count - starts[j]) : 64;
            pend_times_list(&times[i], starts[j], count, t);
            for (int k = 0; k < count; k++) same += t[k] == pend_times_at(&times[i], starts[j] + k);
            compared += count;
        }
    }
    CHECK_INT(same, compared);
    CHECK(compared > 400);
}

TEST(methods_are_those_of_the_contract) {
    const char *const name[] = {"taylor",  "ode23",      "rkf45",  "rk8pd",
                                "msadams", "symplectic", "linear", "radau"};
    int count = sizeof name / sizeof *name;
    for (int i = 0; i < count; i++) {
        REQUIRE(pend_method_at(i));
        CHECK_TEXT(pend_method_at(i)->name, name[i]);
        CHECK(pend_method_find(name[i]) == pend_method_at(i));
    }
    CHECK(!pend_method_at(count));
    CHECK(!pend_method_at(-1));
    CHECK(!pend_method_find("euler"));
    CHECK(!pend_method_find(""));
}

static int range_holds(double min, double value, double max) {
    return min <= value && value <= max;
}

TEST(methods_describe_themselves) {
    const struct pend_method *method;
    for (int i = 0; (method = pend_method_at(i)); i++) {
        int obeys = (method->flags & PEND_METHOD_TOLERANCES) != 0;
        CHECK_SAYING(strlen(method->summary) > 20 && strchr(method->summary, '.'),
                     "%s has no summary", method->name);
        CHECK(method->open && method->step && method->at && method->counts && method->close);
        if (obeys)
            CHECK(method->rtol_min > 0 &&
                  range_holds(method->rtol_min, method->rtol_default, method->rtol_max));
        if (obeys)
            CHECK(method->atol_min >= 0 &&
                  range_holds(method->atol_min, pend_method_atol(method, method->rtol_max),
                              method->atol_max));
        if (!obeys) CHECK(method->rtol_max == 0 && method->atol_max == 0);
        CHECK(((method->flags & PEND_METHOD_FIXED_STEP) != 0) == (method->step_max > 0));
        if (method->extended)
            CHECK(!strcmp(method->extended->name, method->name) && !method->extended->extended);
    }
}
