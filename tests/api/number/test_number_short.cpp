extern "C" {
#include "tests/harness/test.h"
}

#include "api/number/number.h"
#include "api/number/number_short.h"

#include <math.h>
#include <string.h>

/* sizes from 1e-6 to 1e8, both signs, sometimes with few digits, a carry, a tie or zero */
static double number(unsigned long long *seed, int everyday) {
    int way = everyday ? 9 : test_random_int(seed, 60);
    double size = pow(10, test_random_int(seed, 15) - 7), sign = test_random_int(seed, 2) ? 1 : -1;
    if (way == 0) return sign * 0.0;
    if (way == 1) return sign * test_random_int(seed, 1000) * size;
    if (way == 2) return sign * (1 - pow(10, -1 - test_random_int(seed, 12))) * size;
    if (way == 3) return sign * (test_random_int(seed, 1 << 20) + 0.5) / 1024;
    return everyday ? 20 * test_random(seed) - 10 : sign * test_random(seed) * size;
}

/* errors compared with numbers written one by one, and the number of batches that were accepted */
static int faults_of(int everyday, int *taken, int batches) {
    unsigned long long seed = 5;
    int faults = 0;
    *taken = 0;
    for (int batch = 0; batch < batches; batch++) {
        int digits = 1 + batch % api::SHORT_DIGITS;
        double x[api::short_batch::COUNT];
        for (double &value : x) value = number(&seed, everyday);
        api::short_batch numbers(digits);
        if (!numbers.take(x)) continue;
        ++*taken;
        for (int i = 0; i < api::short_batch::COUNT; i++) {
            char got[API_NUMBER_BYTES] = {}, want[API_NUMBER_BYTES] = {};
            long bytes = numbers.write(got, x, i) - got;
            faults += bytes != api_number_write_digits(want, x[i], digits) - want ||
                      memcmp(got, want, (size_t)bytes);
        }
    }
    return faults;
}

TEST(number_short_is_that_written_alone) {
    int taken, batches = 60000;
    CHECK_INT(faults_of(0, &taken, batches), 0);
    CHECK(taken > 300);
    CHECK_INT(faults_of(1, &taken, batches), 0);
    CHECK(taken > batches / 3);
}
