#include "api/json/json_keys.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

enum { MOST = 200, BYTES = 40 };

TEST(json_keys_are_refused_once_they_are_there_whatever_their_length) {
    char text[MOST * BYTES + 1];
    struct api_key key[MOST] = {{NULL, 0}};
    OWN(api_keys, clear) keys = {0};
    size_t bytes = 0;
    int added = 0, refused = 0;
    for (int i = 0; i < MOST; i++) {
        key[i].text = text + bytes;
        /* lengths of 3 to 34 bytes, equal except for the last one */
        bytes += (size_t)sprintf(text + bytes, "%.*s%03d", i % 32,
                                 "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", i);
        key[i].bytes = (size_t)(text + bytes - key[i].text);
        added += api_keys_add(&keys, 0, MOST + 1, key[i]) == PEND_OK;
    }
    for (int i = 0; i < MOST; i++)
        refused += api_keys_add(&keys, 0, MOST + 1, key[i]) == PEND_INVALID;
    CHECK_INT(added, MOST);
    CHECK_INT(refused, MOST);
}

TEST(json_keys_of_another_object_do_not_count) {
    const char *text = "abab";
    struct api_keys keys = {0};
    CHECK_INT(api_keys_add(&keys, 0, 2, (struct api_key){text, 1}), PEND_OK);
    CHECK_INT(api_keys_add(&keys, 1, 2, (struct api_key){text + 2, 1}), PEND_OK);
    CHECK_INT(api_keys_add(&keys, 1, 2, (struct api_key){text, 1}), PEND_INVALID);
    CHECK_INT(api_keys_add(&keys, 1, 2, (struct api_key){text + 3, 1}), PEND_OK);
    CHECK_INT(api_keys_add(&keys, 1, 2, (struct api_key){text, 2}), PEND_LIMIT);
    /* the inner object closes */
    keys.count = 1;
    CHECK_INT(api_keys_add(&keys, 0, 2, (struct api_key){text + 2, 1}), PEND_INVALID);
    CHECK_INT(api_keys_add(&keys, 0, 2, (struct api_key){text + 3, 1}), PEND_OK);
    api_keys_clear(&keys);
    CHECK(!keys.count && !keys.key);
}
