#include "tests/wire/safe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "tests/harness/test.h"

void safe_path(const struct safe *safe, const char *name, char path[PATH]) {
    snprintf(path, PATH, "%s/%s", safe->directory, name);
}

void safe_write(const struct safe *safe, const char *name, const gnutls_datum_t *text) {
    char path[PATH];
    safe_path(safe, name, path);
    unlink(path);
    FILE *file = fopen(path, "w");
    if (!CHECK_SAYING(file != NULL, "%s", path)) return;
    CHECK(fwrite(text->data, 1, text->size, file) == text->size && !fclose(file));
    CHECK(!chmod(path, 0600));
}

int good(int code, const char *what) {
    return CHECK_SAYING(code >= 0, "%s: %s", what, gnutls_strerror(code));
}

void safe_make(struct safe *safe, const char *name, const char *purpose, int from, int to) {
    gnutls_x509_privkey_t key;
    gnutls_x509_crt_t crt;
    gnutls_datum_t text = {NULL, 0};
    char file[64];
    time_t now = time(NULL);
    static unsigned char serial = 1;
    good(gnutls_x509_privkey_init(&key), "key");
    good(gnutls_x509_privkey_generate(key, GNUTLS_PK_ECDSA,
                                      GNUTLS_CURVE_TO_BITS(GNUTLS_ECC_CURVE_SECP256R1), 0),
         "key");
    good(gnutls_x509_crt_init(&crt), "certificate");
    good(gnutls_x509_crt_set_version(crt, 3), "version");
    good(gnutls_x509_crt_set_dn_by_oid(crt, GNUTLS_OID_X520_COMMON_NAME, 0, name,
                                       (unsigned)strlen(name)),
         "name");
    serial++;
    good(gnutls_x509_crt_set_serial(crt, &serial, 1), "serial");
    gnutls_x509_crt_set_activation_time(crt, now + from * (time_t)DAY);
    gnutls_x509_crt_set_expiration_time(crt, now + to * (time_t)DAY);
    gnutls_x509_crt_set_basic_constraints(crt, !purpose, -1);
    if (purpose) good(gnutls_x509_crt_set_key_purpose_oid(crt, purpose, 0), "purpose");
    gnutls_x509_crt_set_subject_alt_name(crt, GNUTLS_SAN_DNSNAME, "localhost", 9, GNUTLS_FSAN_SET);
    good(gnutls_x509_crt_set_key(crt, key), "its key");
    good(gnutls_x509_crt_sign2(crt, purpose ? safe->authority : crt,
                               purpose ? safe->authority_key : key, GNUTLS_DIG_SHA256, 0),
         "signature");
    good(gnutls_x509_crt_export2(crt, GNUTLS_X509_FMT_PEM, &text), "PEM");
    snprintf(file, sizeof file, "%s.pem", name);
    safe_write(safe, file, &text);
    gnutls_free(text.data);
    good(gnutls_x509_privkey_export2(key, GNUTLS_X509_FMT_PEM, &text), "PEM");
    snprintf(file, sizeof file, "%s.key", name);
    safe_write(safe, file, &text);
    gnutls_free(text.data);
    if (!purpose && !safe->authority) {
        safe->authority = crt;
        safe->authority_key = key;
        return;
    }
    gnutls_x509_crt_deinit(crt);
    gnutls_x509_privkey_deinit(key);
}

int safe_begin(struct safe *safe) {
    *safe = (struct safe){.directory = "/tmp/pendulumd-test-XXXXXX"};
    if (!CHECK(mkdtemp(safe->directory) != NULL)) return 0;
    safe_make(safe, "ca", NULL, -1, 30);
    safe_make(safe, "server", GNUTLS_KP_TLS_WWW_SERVER, -1, 30);
    return 1;
}

void safe_end(struct safe *safe) {
    char command[96];
    gnutls_x509_crt_deinit(safe->authority);
    gnutls_x509_privkey_deinit(safe->authority_key);
    snprintf(command, sizeof command, "rm -rf '%s'", safe->directory);
    CHECK(!system(command));
}
