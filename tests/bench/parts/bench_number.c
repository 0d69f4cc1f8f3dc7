/* Writing a double: ours, C's printf and cJSON, for the numbers of a trajectory, for random bits,
 * and rounded.
 * Leaves to others: correctness (tests/api/number/test_number).
 * Invariant: every writer of a group writes the same numbers. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "api/number/number.h"
#include "tests/bench/parts/bench.h"

enum { COUNT = 4096 };

struct numbers {
    double value[COUNT];
    char text[COUNT * API_NUMBER_BYTES];
};

/* numbers like angles and velocities: all 17 digits, absolute values from 0 to 10 */
static struct numbers *everyday(void) {
    static struct numbers numbers;
    unsigned short seed[3] = {1};
    for (int i = 0; i < COUNT; i++) numbers.value[i] = 20 * erand48(seed) - 10;
    return &numbers;
}

static struct numbers *any_bits(void) {
    static struct numbers numbers;
    unsigned short seed[3] = {2};
    for (int i = 0; i < COUNT; i++)
        numbers.value[i] = ldexp(erand48(seed) - 0.5, (int)(2000 * erand48(seed)) - 1000);
    return &numbers;
}

static struct numbers *instants(void) {
    static struct numbers numbers;
    for (int i = 0; i < COUNT; i++) numbers.value[i] = i / 100.0;
    return &numbers;
}

static void ours(struct bench *bench, struct numbers *numbers, int digits) {
    while (bench_go(bench, COUNT)) {
        char *at = numbers->text;
        for (int i = 0; i < COUNT; i++) {
            at = digits ? api_number_write_digits(at, numbers->value[i], digits)
                        : api_number_write(at, numbers->value[i]);
            *at++ = ',';
        }
        if (at < numbers->text + 2 * COUNT) bench_broken("numbers that are too short");
    }
}

static void with_printf(struct bench *bench, struct numbers *numbers, int digits) {
    while (bench_go(bench, COUNT)) {
        char *at = numbers->text;
        for (int i = 0; i < COUNT; i++) at += sprintf(at, "%.*g,", digits, numbers->value[i]);
    }
}

/* as in an answer */
static void in_rows(struct bench *bench, struct numbers *numbers, int digits) {
    const struct api_number_rows rows = {COUNT / 4, 4, numbers->value, digits, '[', "],", 2};
    while (bench_go(bench, COUNT))
        if (api_number_write_rows(numbers->text, &rows) < numbers->text + 2 * COUNT)
            bench_broken("numbers that are too short");
}

BENCH(number_everyday_in_rows, "number") { in_rows(bench, everyday(), 0); }
BENCH(number_everyday_in_rows_to_6_digits, "number") { in_rows(bench, everyday(), 6); }
BENCH(number_everyday, "number") { ours(bench, everyday(), 0); }
BENCH(number_everyday_to_6_digits, "number") { ours(bench, everyday(), 6); }
BENCH(number_any_bits, "number") { ours(bench, any_bits(), 0); }
BENCH(number_instants, "number") { ours(bench, instants(), 0); }
BENCH(number_everyday_printf_17g, "number") { with_printf(bench, everyday(), 17); }
BENCH(number_everyday_printf_6g, "number") { with_printf(bench, everyday(), 6); }
BENCH(number_any_bits_printf_17g, "number") { with_printf(bench, any_bits(), 17); }

BENCH(number_everyday_cjson, "number") {
    struct numbers *numbers = everyday();
    cJSON *array = cJSON_CreateDoubleArray(numbers->value, COUNT);
    if (!array) bench_broken("out of memory");
    while (bench_go(bench, COUNT))
        if (!cJSON_PrintPreallocated(array, numbers->text, sizeof numbers->text, 0))
            bench_broken("cJSON");
    cJSON_Delete(array);
}

/* reading back what was written */
BENCH(number_everyday_read, "number") {
    struct numbers *numbers = everyday();
    double sum = 0;
    for (int i = 0; i < COUNT; i++)
        *api_number_write(numbers->text + i * API_NUMBER_BYTES, numbers->value[i]) = 0;
    while (bench_go(bench, COUNT))
        for (int i = 0; i < COUNT; i++) {
            const char *text = numbers->text + i * API_NUMBER_BYTES;
            sum += api_number_read(text, text + strlen(text));
        }
    if (isnan(sum)) bench_broken("a number that is none");
}
