#include "api/encode/zip64.h"

#include <string.h>

#include "tests/harness/test.h"

static uint64_t whole(const char *at, int bytes) {
    uint64_t x = 0;
    while (bytes--) x = x << 8 | (unsigned char)at[bytes];
    return x;
}

/* checks the position of a 64-bit field, and the number of fields */
static void wide(const char *extra, uint64_t length, const uint64_t field[], int fields) {
    CHECK_INT((long long)length, 4 + 8 * fields);
    CHECK_INT((long long)whole(extra, 2), 1);
    CHECK_INT((long long)whole(extra + 2, 2), 8 * fields);
    for (int i = 0; i < fields; i++) CHECK(whole(extra + 4 + 8 * i, 8) == field[i]);
}

TEST(a_small_member_of_an_archive_has_no_fields_of_64_bits) {
    const struct api_zip64_member member = {"t.npy", 0x12345678, 0xfffffffe, 0xfffffffe, 0};
    char local[API_ZIP64_LOCAL], central[API_ZIP64_CENTRAL], end[API_ZIP64_END];
    CHECK_INT(api_zip64_local(local, &member, API_ZIP64_MOST) - local, 30 + 5);
    CHECK_INT(api_zip64_central(central, &member, API_ZIP64_MOST) - central, 46 + 5);
    CHECK_INT(api_zip64_end(end, 3, 0xfffffffe, 153, API_ZIP64_MOST) - end, 22);
    CHECK(whole(local + 4, 2) == 20 && whole(central + 4, 2) == 20 && !whole(local + 28, 2));
    CHECK(whole(local + 18, 4) == 0xfffffffe && whole(central + 42, 4) == 0xfffffffe);
    CHECK(whole(end, 4) == 0x06054b50 && whole(end + 10, 2) == 3);
    CHECK(whole(end + 12, 4) == 153 && whole(end + 16, 4) == 0xfffffffe);
}

TEST(a_member_beyond_4_gib_has_its_sizes_in_64_bits_and_its_place_where_that_is_wanted) {
    const uint64_t large = 5000000000, far = 6000000000;
    const struct api_zip64_member early = {"phi.npy", 1, large, 40, 0},
                                  late = {"z.npy", 2, 9, far, 0},
                                  both = {"lambda.npy", 3, large, far, 0};
    char local[API_ZIP64_LOCAL], central[API_ZIP64_CENTRAL];
    CHECK_INT(api_zip64_local(local, &early, API_ZIP64_MOST) - local, 30 + 7 + 20);
    CHECK(whole(local + 4, 2) == 45 && whole(local + 18, 8) == UINT64_MAX);
    wide(local + 30 + 7, whole(local + 28, 2), (const uint64_t[]){large, large}, 2);
    CHECK_INT(api_zip64_central(central, &early, API_ZIP64_MOST) - central, 46 + 7 + 20);
    CHECK(whole(central + 4, 2) == 45 && whole(central + 6, 2) == 45);
    CHECK(whole(central + 20, 8) == UINT64_MAX && whole(central + 42, 4) == 40);
    wide(central + 46 + 7, whole(central + 30, 2), (const uint64_t[]){large, large}, 2);
    // a small member after a large one: only its position
    CHECK_INT(api_zip64_local(local, &late, API_ZIP64_MOST) - local, 30 + 5);
    api_zip64_central(central, &late, API_ZIP64_MOST);
    CHECK(whole(central + 20, 4) == 9 && whole(central + 42, 4) == 0xffffffff);
    wide(central + 46 + 5, whole(central + 30, 2), &far, 1);
    api_zip64_central(central, &both, API_ZIP64_MOST);
    wide(central + 46 + 10, whole(central + 30, 2), (const uint64_t[]){large, large, far}, 3);
}

TEST(an_archive_whose_directory_is_beyond_4_gib_ends_with_the_records_that_say_so) {
    const uint64_t begin = 11000000123;
    char end[API_ZIP64_END];
    CHECK_INT(api_zip64_end(end, 7, begin, 500, API_ZIP64_MOST) - end, 56 + 20 + 22);
    CHECK(whole(end, 4) == 0x06064b50 && whole(end + 4, 8) == 44);
    CHECK(whole(end + 24, 8) == 7 && whole(end + 32, 8) == 7);
    CHECK(whole(end + 40, 8) == 500 && whole(end + 48, 8) == begin);
    // the locator points to the 64-bit record
    CHECK(whole(end + 56, 4) == 0x07064b50 && whole(end + 64, 8) == begin + 500);
    CHECK(whole(end + 72, 4) == 1);
    CHECK(whole(end + 76, 4) == 0x06054b50 && whole(end + 88, 4) == 500);
    CHECK(whole(end + 92, 4) == 0xffffffff);
    // with a small bound the records are the same
    char small[API_ZIP64_END];
    CHECK_INT(api_zip64_end(small, 7, 200, 10, 100) - small, 56 + 20 + 22);
    CHECK(whole(small + 48, 8) == 200 && whole(small + 92, 4) == 0xffffffff);
}

TEST(a_streamed_member_tells_its_length_and_checksum_behind_it_and_in_the_directory) {
    const uint64_t large = 5000000000, far = 6000000000;
    const struct api_zip64_member small = {"a", 0x12345678, 9, 40, 1},
                                  wide_one = {"b", 7, large, far, 1};
    char local[API_ZIP64_LOCAL], central[API_ZIP64_CENTRAL], behind[API_ZIP64_BEHIND];
    CHECK_INT(api_zip64_local(local, &small, API_ZIP64_MOST) - local, 30 + 1 + 20);
    CHECK(whole(local, 4) == 0x04034b50 && whole(local + 4, 2) == 45 && whole(local + 6, 2) == 8);
    CHECK(whole(local + 14, 4) == 0 && whole(local + 18, 8) == UINT64_MAX);
    wide(local + 30 + 1, whole(local + 28, 2), (const uint64_t[]){0, 0}, 2);
    CHECK_INT(api_zip64_behind(behind, &small) - behind, API_ZIP64_BEHIND);
    CHECK(whole(behind, 4) == 0x08074b50 && whole(behind + 4, 4) == 0x12345678);
    CHECK(whole(behind + 8, 8) == 9 && whole(behind + 16, 8) == 9);
    CHECK_INT(api_zip64_central(central, &small, API_ZIP64_MOST) - central, 46 + 1);
    CHECK(whole(central + 6, 2) == 45 && whole(central + 8, 2) == 8);
    CHECK(whole(central + 16, 4) == 0x12345678 && whole(central + 20, 4) == 9);
    api_zip64_behind(behind, &wide_one);
    CHECK(whole(behind + 8, 8) == large && whole(behind + 16, 8) == large);
    CHECK_INT(api_zip64_central(central, &wide_one, API_ZIP64_MOST) - central, 46 + 1 + 28);
    wide(central + 46 + 1, whole(central + 30, 2), (const uint64_t[]){large, large, far}, 3);
}
