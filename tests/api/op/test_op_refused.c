#include "tests/api/post.h"
#include "tests/harness/test.h"

TEST(faults_of_what_operations_ask_for_have_their_pointers) {
    test_refused_rows("tests/api/op/refused.txt");
}
