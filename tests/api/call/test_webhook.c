/* Tests of api/call/webhook: which urls are accepted, and signatures as another library and the
 * specification make them. */
#include "api/call/webhook.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(urls_of_webhooks_have_one_reading) {
    static const char *const good[][2] = {
        {"https://example.org", "example.org"},
        {"https://example.org/a/b?c=d&e=%20", "example.org"},
        {"https://example.org?c", "example.org"},
        {"https://h-1.example.org:8443/x", "h-1.example.org"},
        {"https://[2001:db8::1]:444/x", "2001:db8::1"},
        {"https://192.0.2.1/", "192.0.2.1"},
    };
    static const char *const bad[] = {"",
                                      "http://example.org/",
                                      "HTTPS://example.org/",
                                      "https://",
                                      "https:///x",
                                      "https://u@example.org/",
                                      "https://u:p@example.org/",
                                      "https://example.org\\@evil/",
                                      "https://example.org/#f",
                                      "https://example.org/ x",
                                      "https://example.org/\xc3\xa4",
                                      "https://ex%61mple.org/",
                                      "https://example.org:0/",
                                      "https://example.org:65536/",
                                      "https://example.org:/",
                                      "https://example.org:443x/",
                                      "https://[::1/",
                                      "https://[::1]x/",
                                      "https://[fe80::1%25eth0]/",
                                      "https://b\xc3\xbc.example/",
                                      "file:///etc/passwd"};
    struct api_webhook_place place;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        const char *wrong = api_webhook_url(good[i][0], &place);
        CHECK_SAYING(!wrong, "%s %s", good[i][0], wrong);
        CHECK_TEXT(place.host, good[i][1]);
        CHECK_INT(place.port, i == 3 ? 8443 : i == 4 ? 444 : 443);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(api_webhook_url(bad[i], &place) != NULL, "%s", bad[i]);
}

/* the example of the specification's own libraries: the secret
 * whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw has 24 bytes, ours 32; so another library signs with ours
 */
TEST(signatures_are_those_of_another_library) {
    unsigned char key[API_WEBHOOK_KEY], mac[32];
    char secret[API_WEBHOOK_SECRET], signature[API_WEBHOOK_SIGNATURE];
    static const char signed_text[] = "msg_1.1614265330.{\"test\": 2432232314}";
    gnutls_datum_t raw = {mac, sizeof mac}, text = {NULL, 0};
    api_webhook_key("the operator's own secret of some length", "t:anna", key);
    CHECK(!gnutls_hmac_fast(GNUTLS_MAC_SHA256, "the operator's own secret of some length", 40,
                            "pendulumd webhooks of t:anna", 28, mac));
    CHECK(!memcmp(mac, key, sizeof key));
    api_webhook_secret(key, secret);
    CHECK(!gnutls_base64_encode2(&raw, &text));
    CHECK(!strncmp(secret, "whsec_", 6) && strlen(secret) == 6 + text.size &&
          !memcmp(secret + 6, text.data, text.size));
    gnutls_free(text.data);
    api_webhook_sign(key, "msg_1", "1614265330", "{\"test\": 2432232314}", 20, signature);
    CHECK(!gnutls_hmac_fast(GNUTLS_MAC_SHA256, key, sizeof key, signed_text, sizeof signed_text - 1,
                            mac));
    CHECK(!gnutls_base64_encode2(&raw, &text));
    CHECK(!strncmp(signature, "v1,", 3) && strlen(signature) == 3 + text.size &&
          !memcmp(signature + 3, text.data, text.size));
    gnutls_free(text.data);
}

TEST(the_id_of_a_message_is_the_jobs_and_does_not_tell_it) {
    char one[API_WEBHOOK_ID], again[API_WEBHOOK_ID], other[API_WEBHOOK_ID];
    api_webhook_id("abcdefghijklmnopqrstuvwxyz", one);
    api_webhook_id("abcdefghijklmnopqrstuvwxyz", again);
    api_webhook_id("abcdefghijklmnopqrstuvwxyy", other);
    CHECK_TEXT(one, again);
    CHECK(strcmp(one, other) != 0 && strlen(one) == 36 && !strstr(one, "abcdefghij"));
}

TEST(the_message_of_a_jobs_end_has_the_job) {
    const struct api_job job = {.id = "j",
                                .operation = "modes",
                                .status = "successful",
                                .message = "",
                                .title = "mine",
                                .version = "1",
                                .owner = "token",
                                .parts = 1,
                                .done = 1,
                                .created = 1000000,
                                .finished = 2000000,
                                .remaining = -1,
                                .results = 1};
    struct api_buffer out;
    api_buffer_init(&out, 4096);
    CHECK(api_webhook_write(&job, &out) == PEND_OK && api_buffer_add(&out, "", 1) == PEND_OK);
    CHECK(strstr(out.data,
                 "{\"type\":\"job.successful\",\"timestamp\":\"1970-01-01T00:00:02.000Z\","
                 "\"data\":{\"id\":\"j\"") == out.data);
    CHECK(strstr(out.data, "\"title\":\"mine\"") && !strstr(out.data, "notify"));
    api_buffer_clear(&out);
}
