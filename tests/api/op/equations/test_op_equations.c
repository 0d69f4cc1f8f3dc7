/* The output for each kind of tree. That the formulas and programs are correct is tested by
 * tests/rules/equations.py. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

#define DOUBLE "\"pendulum\":{\"length\":[1,2],\"mass\":[3,0.5],\"parent\":[0,1]}"

TEST(equations_of_two_arms_are_those_of_the_textbook) {
    OWN(test_reply, free) reply = test_post(API_OP_EQUATIONS, "{" DOUBLE "}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/n") == 2);
    CHECK_TEXT(test_reply_text(&reply, "/form"), "explicit");
    CHECK_TEXT(test_reply_text(&reply, "/latex/S"), "S=\\begin{pmatrix}1&0\\\\1&1\\end{pmatrix}");
    CHECK_TEXT(test_reply_text(&reply, "/latex/B"),
               "B=S^{-\\mathsf{T}}=\\begin{pmatrix}1&-1\\\\0&1\\end{pmatrix}");
    CHECK_TEXT(test_reply_text(&reply, "/latex/M"),
               "M(\\phi)=\\begin{pmatrix}(m_{1}+m_{2})\\ell_{1}^{2}&m_{2}\\ell_{1}\\ell_{2}e^{"
               "\\mathrm{i}(\\phi_{2}-\\phi_{1})}\\\\m_{2}\\ell_{1}\\ell_{2}e^{\\mathrm{i}(\\phi_{"
               "1}-\\phi_{2})}&m_{2}\\ell_{2}^{2}\\end{pmatrix}");
    CHECK_TEXT(test_reply_text(&reply, "/latex/aaa"),
               "\\begin{aligned}&(m_{1}+m_{2})\\ell_{1}^{2}\\ddot{\\phi}_{1}+m_{2}\\ell_{1}\\ell_{"
               "2}\\cos(\\phi_{2}-\\phi_{1})\\ddot{\\phi}_{2}=m_{2}\\ell_{1}\\ell_{2}\\sin(\\phi_{"
               "2}-\\phi_{1})\\dot{\\phi}_{2}^{2}-g(m_{1}+m_{2})\\ell_{1}\\cos\\phi_{1}\\\\["
               "1ex]&m_{2}\\ell_{1}\\ell_{2}\\cos(\\phi_{1}-\\phi_{2})\\ddot{\\phi}_{1}+m_{2}\\"
               "ell_{2}^{2}\\ddot{\\phi}_{2}=m_{2}\\ell_{1}\\ell_{2}\\sin(\\phi_{1}-\\phi_{2})"
               "\\dot{\\phi}_{1}^{2}-gm_{2}\\ell_{2}\\cos\\phi_{2}\\end{aligned}");
    CHECK_TEXT(test_reply_text(&reply, "/latex/parameters"),
               "\\ell=(1,\\,2)\\,\\mathrm{m},\\qquad m=(3,\\,0.5)\\,\\mathrm{kg},\\qquad g=9.81\\,"
               "\\mathrm{m/s^{2}}");
}

TEST(equations_start_where_the_request_does) {
    OWN(test_reply, free) reply =
        test_post(API_OP_EQUATIONS, "{" DOUBLE ",\"initial\":{\"phi\":[1e-9,2],\"phid\":[0,-3]}}");
    CHECK_INT(reply.status, 200);
    CHECK(strstr(test_reply_text(&reply, "/code/matlab"), "phi0 = [1e-9; 2];") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/code/matlab"), "w0 = [0; -3];") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/code/python"),
                 "phi0 = np.array([1e-9, 2], dtype=float)") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/curl"),
                 "\"initial\":{\"phi\":[1e-9,2],\"phid\":[0,-3]}") != NULL);
}

/* a chain of n arms in some form, or in the usual one */
static struct test_reply chain(int n, const char *form) {
    char *body = malloc((size_t)n * 20 + 200), *at = body;
    at += sprintf(at, "{\"pendulum\":{\"length\":[1");
    for (int k = 1; k < n; k++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"mass\":[1");
    for (int k = 1; k < n; k++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"parent\":[0");
    for (int k = 1; k < n; k++) at += sprintf(at, ",%d", k);
    sprintf(at, "]}%s%s%s}", form ? ",\"form\":\"" : "", form ? form : "", form ? "\"" : "");
    struct test_reply reply = test_post(API_OP_EQUATIONS, body);
    free(body);
    return reply;
}

TEST(equations_are_explicit_up_to_eight_arms_and_can_be_up_to_twenty) {
    static const struct {
        int n;
        const char *asked, *form;
    } rows[] = {{1, NULL, "explicit"},        {8, NULL, "explicit"},
                {9, NULL, "compact"},         {9, "explicit", "explicit"},
                {20, "explicit", "explicit"}, {20, "compact", "compact"},
                {21, NULL, "compact"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        OWN(test_reply, free) reply = chain(rows[i].n, rows[i].asked);
        CHECK_INT(reply.status, 200);
        CHECK_TEXT(test_reply_text(&reply, "/form"), rows[i].form);
    }
    OWN(test_reply, free) reply = chain(21, "explicit");
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "/form", "at most 20 arms, this pendulum has 21"));
}

TEST(equations_of_a_large_tree_are_short_formulas_and_whole_programs) {
    OWN(test_reply, free) reply = chain(5000, NULL);
    CHECK_INT(reply.status, 200);
    CHECK(strlen(test_reply_text(&reply, "/latex/S")) < 200);
    CHECK(strlen(test_reply_text(&reply, "/latex/parameters")) < 300);
    CHECK(strstr(test_reply_text(&reply, "/latex/S"), "p=(0,\\,1,\\,2,") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/latex/S"), "\\ldots,\\,4999)") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/code/matlab"), "; 4999];") != NULL);
}

TEST(equations_tell_nothing_back_but_numbers) {
    OWN(test_reply, free) reply =
        test_post(API_OP_EQUATIONS, "{\"pendulum\":{\"arms\":[{\"name\":\"');evil(\\\"\\n%\","
                                    "\"length\":1,\"mass\":1}]}}");
    CHECK_INT(reply.status, 200);
    CHECK(!strstr(reply.out.data, "evil"));
}

TEST(equations_from_a_mode_that_is_beyond_all_numbers_are_a_problem) {
    OWN(test_reply, free) reply = test_post(
        API_OP_EQUATIONS,
        "{\"pendulum\":{\"length\":[4e-324,1.5,0.75],\"mass\":[1,1,1],\"parent\":[0,1,2]},"
        "\"initial\":{\"mode\":3,\"amplitude\":1}}");
    CHECK_SAYING(reply.status == 422 || reply.status == 200, "%d", reply.status);
    CHECK(!strstr(reply.out.data, "nan") && !strstr(reply.out.data, "inf"));
}

/* a formula of a reply */
static const char *formula(const struct test_reply *reply, const char *name) {
    char at[40];
    snprintf(at, sizeof at, "/latex/%s", name);
    const char *text = test_reply_text(reply, at);
    return text ? text : "";
}

TEST(equations_of_a_damped_driven_pendulum_have_its_terms_and_no_others) {
    OWN(test_reply, free) reply = test_post(
        API_OP_EQUATIONS,
        "{\"pendulum\":{\"length\":[1],\"mass\":[2],\"parent\":[0],\"damping\":[0.5],\"torque\":[{"
        "\"harmonics\":[{\"amplitude\":-1.5,\"omega\":3,\"phase\":-0.25}]}]}}");
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(test_reply_text(&reply, "/form"), "compact");
    CHECK_TEXT(
        formula(&reply, "aaa"),
        "\\operatorname{Re}M(\\phi)\\;\\ddot{\\phi}=\\operatorname{Im}M(\\phi)\\;\\dot{\\phi}^{"
        "2}-\\operatorname{Im}\\bigl[e^{-\\mathrm{i}\\phi}h\\,(\\mathrm{i}g)\\bigr]+B\\tau");
    CHECK_TEXT(
        formula(&reply, "loads"),
        "\\begin{aligned}\\tau&=T-c\\,\\dot{q},\\qquad q=B^{\\mathsf{T}}\\phi+\\tfrac{\\pi}{2}r,"
        "\\quad r_{k}=1\\text{ at the pivot, else }0\\\\T_{1}&=0-1.5\\cos(3\\,t-0.25)\\end{"
        "aligned}");
    const char *python = test_reply_text(&reply, "/code/python"),
               *matlab = test_reply_text(&reply, "/code/matlab");
    CHECK(strstr(python, "tau -= c * r\n") && strstr(python, "tau += D @ (A * np.cos(omega * t"));
    CHECK(!strstr(python, "pivot(t)") && !strstr(python, "np.tanh") && !strstr(python, "air("));
    CHECK(strstr(matlab, "    - c .* r(w) ...\n") && !strstr(matlab, "gamma"));
    CHECK(
        strstr(test_reply_text(&reply, "/curl"),
               "\"arms\":[{\"name\":\"1\",\"length\":1,\"mass\":2,\"damping\":0.5,\"torque\":{") !=
        NULL);
}

TEST(equations_of_a_pendulum_with_everything_are_whole) {
    OWN(test_reply, free) reply = test_post(API_OP_EQUATIONS, "{" TEST_REAL_TREE "}");
    CHECK_INT(reply.status, 200);
    CHECK(strstr(formula(&reply, "aaa"), "+\\ddot{z}_{0}") == NULL);
    CHECK(strstr(formula(&reply, "aaa"), "h\\,(\\ddot{z}_{0}+\\mathrm{i}g)") != NULL);
    CHECK(strstr(formula(&reply, "aaa"), "Z^{\\mathsf{H}}F") != NULL);
    CHECK(strstr(formula(&reply, "loads"), "-f\\tanh(\\dot{q}/s)") != NULL);
    CHECK(strstr(formula(&reply, "parameters"), "\\gamma=0.05\\,\\mathrm{1/s}") != NULL);
    CHECK(strstr(formula(&reply, "z"), "H_{2,1}=0.5+0.1\\,\\mathrm{i}") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/curl"), "\"drag_per_mass\":0.05") != NULL);
}

/* their correctness is tested by tests/rules/equations.py */
TEST(equations_on_a_cart_have_its_own_and_no_others) {
    OWN(test_reply, free) reply = test_post(
        API_OP_EQUATIONS,
        "{\"pendulum\":{\"length\":[1],\"mass\":[2],\"parent\":[0],\"pivot\":{\"cart\":{\"mass\":3,"
        "\"angle\":0.25,\"damping\":0.5,\"force\":{\"constant\":-4,\"harmonics\":[{"
        "\"amplitude\":1.5,\"omega\":3}]}}}},\"initial\":{\"phi\":[1],\"cart\":{\"x\":7}}}");
    CHECK_INT(reply.status, 200);
    CHECK(strstr(formula(&reply, "aaa"), "h\\,(\\ddot{z}_{0}+\\mathrm{i}g)") != NULL);
    CHECK(!strstr(formula(&reply, "aaa"), "\\tau") && !strstr(formula(&reply, "parameters"), "c="));
    CHECK_TEXT(
        formula(&reply, "loads"),
        "\\begin{aligned}z_{0}&=\\rho\\,x,\\qquad\\rho=e^{0.25\\,\\mathrm{i}}\\\\3\\,\\bigl(\\ddot{"
        "x}+g\\operatorname{Im}\\rho\\bigr)&=-\\operatorname{Re}\\Bigl[\\bar{\\rho}\\Bigl(\\sum_{"
        "r}m_{r}\\bigl(\\ddot{z}_{r}+\\mathrm{i}g\\bigr)\\Bigr)\\Bigr]-0.5\\,\\dot{x}-4"
        "+1.5\\cos(3\\,t)\\end{aligned}");
    CHECK(strstr(test_reply_text(&reply, "/code/python"), "\nx0 = 7  #") != NULL);
    CHECK(!strstr(test_reply_text(&reply, "/code/python"), "torques("));
    CHECK(strstr(test_reply_text(&reply, "/code/matlab"), "\nM0 = 3;  %") != NULL);
    CHECK(strstr(test_reply_text(&reply, "/curl"), "\"cart\":{\"x\":7,\"v\":0}") != NULL);
}

TEST(equations_have_their_rules_in_words) {
    OWN(test_reply, free) reply =
        test_post(API_OP_EQUATIONS, "{\"pendulum\":{\"arms\":[{\"length\":1,\"mass\":1,"
                                    "\"friction\":{\"torque\":0.1,\"static\":0.2},\"torque\":{"
                                    "\"table\":{\"t\":[0,2],\"value\":[1,3],\"hold\":\"linear\"}}},"
                                    "{\"parent\":\"1\",\"length\":1,\"mass\":1,\"stop\":{"
                                    "\"min\":-2,\"restitution\":0.5}}],\"pivot\":{\"y\":{"
                                    "\"table\":{\"t\":[0,1],\"value\":[0,1]}}},\"control\":[{"
                                    "\"joint\":2,\"period\":0.02,\"delay\":1,\"limit\":[-5,5],"
                                    "\"law\":{\"feedback\":{\"gains\":[1,2,3,4]}}}]}}");
    static const char *const words[] = {
        "arm 1: a table of 2 inputs from t = 0 to 2 s, linear between two instants",
        "the pivot: a table of 2 inputs from t = 0 to 1 s, on the natural cubic spline",
        "arm 1: friction of 0.1 in motion, up to 0.2 at rest",
        "arm 2: a stop from -2 to inf; an impact turns the rate r to -0.5 r",
        ("arm 2: a controller holds for 0.02 s each -K (x - reference) 1 samples later, from -5 to "
         "5")};
    static const char *const places[] = {"/latex/rules", "/code/matlab", "/code/python"};
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        for (int k = 0; k < 3; k++) {
            const char *text = test_reply_text(&reply, places[k]);
            CHECK_SAYING(text && strstr(text, words[i]), "%s: %s", words[i], reply.out.data);
        }
    CHECK(strstr(formula(&reply, "loads"), "T_{2}&=0+u_{2}"));
    CHECK(strstr(test_reply_text(&reply, "/code/python"), "(-2, 0, 0, [0, 1], [0, 1])"));
    CHECK(strstr(test_reply_text(&reply, "/curl"), "# without \"control\": add it"));
}
