#include "server/http/tls.h"

#include <assert.h>
#include <dlfcn.h>
#include <gnutls/abstract.h>
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <time.h>

#include "server/sandbox/secret.h"

enum {
    TLS_CHAIN = 16,
    TLS_FILE = 1 << 20,
    TLS_ID = 64,
    TLS_FILES = 4 /* certificate, key, authority of clients, lists of what it has revoked */
};

const char srv_tls_priorities[] = "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2:%SERVER_PRECEDENCE";

/* The contents of the files at one reading. */
struct tls_set {
    gnutls_pcert_st chain[TLS_CHAIN];
    unsigned count;
    gnutls_privkey_t key;
    gnutls_x509_trust_list_t trust; /* NULL = clients need no certificate */
    struct tls_set
        *before; /* earlier sets are kept to the end, because a handshake may be using one */
};

struct srv_tls {
    char certificate[SRV_CONFIG_TEXT], key[SRV_CONFIG_TEXT], authority[SRV_CONFIG_TEXT],
        revoked[SRV_CONFIG_TEXT];
    pthread_mutex_t lock; /* guards set */
    struct tls_set *set;
    struct api_buffer asked; /* the authority's PEM text at the start */
};

static _Thread_local struct srv_tls *tls_here;

void srv_tls_here(struct srv_tls *tls) { tls_here = tls; }

static struct tls_set *tls_set(struct srv_tls *tls) {
    pthread_mutex_lock(&tls->lock);
    struct tls_set *set = tls->set;
    pthread_mutex_unlock(&tls->lock);
    return set;
}

/* --- files --- */

static void tls_set_free(struct tls_set *set) {
    while (set) {
        struct tls_set *before = set->before;
        for (unsigned i = 0; i < set->count; i++) gnutls_pcert_deinit(&set->chain[i]);
        if (set->key) gnutls_privkey_deinit(set->key);
        if (set->trust) gnutls_x509_trust_list_deinit(set->trust, 1);
        free(set);
        set = before;
    }
}

static enum pend_status tls_wrong(const char *what, const char *path, int code,
                                  struct pend_error *error) {
    return pend_fail(error, PEND_INVALID, -1, 0, "%s %.120s: %.80s", what, path,
                     gnutls_strerror(code));
}

/* Reads a file that need not be secret. */
static enum pend_status tls_read(const char *what, const char *path, struct api_buffer *out,
                                 struct pend_error *error) {
    gnutls_datum_t data;
    int code = gnutls_load_file(path, &data);
    if (code < 0) return tls_wrong(what, path, code, error);
    enum pend_status status = api_buffer_add(out, (const char *)data.data, data.size);
    gnutls_free(data.data);
    return status == PEND_OK
               ? status
               : pend_fail(error, PEND_INVALID, -1, 0, "%s %.120s is too long", what, path);
}

static gnutls_datum_t tls_datum(const struct api_buffer *text) {
    return (gnutls_datum_t){(unsigned char *)text->data, (unsigned)text->bytes};
}

/* Returns an error if a certificate is not valid at this time. */
static enum pend_status tls_timely(gnutls_x509_crt_t certificate, const char *path,
                                   struct pend_error *error) {
    time_t now = time(NULL), begin = gnutls_x509_crt_get_activation_time(certificate),
           end = gnutls_x509_crt_get_expiration_time(certificate);
    char text[32];
    struct tm part;
    if (now >= begin && now <= end) return PEND_OK;
    time_t told = now < begin ? begin : end;
    gmtime_r(&told, &part);
    strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &part);
    return pend_fail(error, PEND_INVALID, -1, 0, "the certificate %.120s %s %s", path,
                     now < begin ? "is good only from" : "has expired, at", text);
}

/* Returns an error if the key does not belong to the certificate. */
static enum pend_status tls_pair(const struct srv_tls *tls, gnutls_x509_crt_t certificate,
                                 gnutls_x509_privkey_t key, struct pend_error *error) {
    unsigned char one[TLS_ID], other[TLS_ID];
    size_t bytes = sizeof one, also = sizeof other;
    if (!gnutls_x509_crt_get_key_id(certificate, GNUTLS_KEYID_USE_SHA256, one, &bytes) &&
        !gnutls_x509_privkey_get_key_id(key, GNUTLS_KEYID_USE_SHA256, other, &also) &&
        bytes == also && !memcmp(one, other, bytes))
        return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "the key %.100s is not that of the certificate %.100s", tls->key,
                     tls->certificate);
}

/* Adds a chain of certificates to the set if its first is valid now and belongs to the key. */
static enum pend_status tls_chain(const struct srv_tls *tls, struct tls_set *set,
                                  const struct api_buffer *text, gnutls_x509_privkey_t key,
                                  struct pend_error *error) {
    gnutls_x509_crt_t list[TLS_CHAIN];
    unsigned count = TLS_CHAIN;
    gnutls_datum_t data = tls_datum(text);
    int code = gnutls_x509_crt_list_import(list, &count, &data, GNUTLS_X509_FMT_PEM,
                                           GNUTLS_X509_CRT_LIST_FAIL_IF_UNSORTED);
    if (code < 0) return tls_wrong("the certificate", tls->certificate, code, error);
    enum pend_status status = tls_timely(list[0], tls->certificate, error);
    if (status == PEND_OK) status = tls_pair(tls, list[0], key, error);
    for (unsigned i = 0; i < count; i++) {
        if (status == PEND_OK) {
            code = gnutls_pcert_import_x509(&set->chain[i], list[i], 0);
            set->count += code >= 0;
            if (code < 0) status = tls_wrong("the certificate", tls->certificate, code, error);
        }
        gnutls_x509_crt_deinit(list[i]);
    }
    return status;
}

static enum pend_status tls_authority(const struct srv_tls *tls, struct tls_set *set,
                                      const struct api_buffer *text, struct pend_error *error) {
    gnutls_datum_t data = tls_datum(text);
    int code = gnutls_x509_trust_list_init(&set->trust, 0);
    if (code >= 0)
        code = gnutls_x509_trust_list_add_trust_mem(set->trust, &data, NULL, GNUTLS_X509_FMT_PEM, 0,
                                                    0);
    if (code > 0) return PEND_OK;
    return tls_wrong("the authority of clients", tls->authority,
                     code ? code : GNUTLS_E_NO_CERTIFICATE_FOUND, error);
}

/* Whether each list is signed by one of the authorities in the text, and none is overdue. */
static enum pend_status tls_lists_fit(const struct srv_tls *tls, const gnutls_x509_crl_t list[],
                                      unsigned count, const struct api_buffer *authority,
                                      struct pend_error *error) {
    gnutls_x509_crt_t *issuer = NULL;
    unsigned issuers = 0, wrong = 0, status = 0;
    gnutls_datum_t data = tls_datum(authority);
    int code = gnutls_x509_crt_list_import2(&issuer, &issuers, &data, GNUTLS_X509_FMT_PEM, 0);
    for (unsigned i = 0; code >= 0 && i < count; i++) {
        code = gnutls_x509_crl_verify(list[i], issuer, issuers, 0, &status);
        wrong |= status;
    }
    for (unsigned i = 0; i < issuers; i++) gnutls_x509_crt_deinit(issuer[i]);
    gnutls_free(issuer);
    if (code >= 0 && count && !wrong) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0, "the list of revoked certificates %.150s %s",
                     tls->revoked,
                     wrong & GNUTLS_CERT_REVOCATION_DATA_SUPERSEDED
                         ? "is overdue: the time for the next one has passed"
                         : "is not signed by the authority of clients");
}

/* Adds the lists of revoked certificates to the set. */
static enum pend_status tls_revoked(const struct srv_tls *tls, struct tls_set *set,
                                    const struct api_buffer text[TLS_FILES],
                                    struct pend_error *error) {
    gnutls_x509_crl_t *list = NULL;
    unsigned count = 0, added = 0;
    gnutls_datum_t data = tls_datum(&text[3]);
    int code = gnutls_x509_crl_list_import2(&list, &count, &data, GNUTLS_X509_FMT_PEM, 0);
    if (code < 0) return tls_wrong("the list of revoked certificates", tls->revoked, code, error);
    enum pend_status status = tls_lists_fit(tls, list, count, &text[2], error);
    /* What is added belongs to the set; of two lists of one authority the newer one stays, and 0 is
     * returned. */
    while (status == PEND_OK && added < count) {
        code = gnutls_x509_trust_list_add_crls(set->trust, &list[added], 1, 0, 0);
        added++;
        if (code < 0)
            status = tls_wrong("the list of revoked certificates", tls->revoked, code, error);
    }
    for (unsigned i = added; i < count; i++) gnutls_x509_crl_deinit(list[i]);
    gnutls_free(list);
    return status;
}

/* Parses the texts of the files. */
static enum pend_status tls_fill(const struct srv_tls *tls, struct tls_set *set,
                                 struct api_buffer text[TLS_FILES], struct pend_error *error) {
    gnutls_x509_privkey_t key = NULL;
    gnutls_datum_t data = tls_datum(&text[1]);
    int code = gnutls_x509_privkey_init(&key);
    if (code >= 0) code = gnutls_x509_privkey_import2(key, &data, GNUTLS_X509_FMT_PEM, NULL, 0);
    if (code >= 0) code = gnutls_privkey_init(&set->key);
    if (code >= 0) code = gnutls_privkey_import_x509(set->key, key, GNUTLS_PRIVKEY_IMPORT_COPY);
    enum pend_status status = code < 0 ? tls_wrong("the key", tls->key, code, error)
                                       : tls_chain(tls, set, &text[0], key, error);
    if (status == PEND_OK && text[2].bytes) status = tls_authority(tls, set, &text[2], error);
    if (status == PEND_OK && strcmp(tls->revoked, "none"))
        status = tls_revoked(tls, set, text, error);
    if (key) gnutls_x509_privkey_deinit(key);
    return status;
}

/* Reads the files about clients' certificates that there are. */
static enum pend_status tls_read_clients(const struct srv_tls *tls,
                                         struct api_buffer text[TLS_FILES],
                                         struct pend_error *error) {
    if (strcmp(tls->authority, "none"))
        PEND_TRY(tls_read("the authority of clients", tls->authority, &text[2], error));
    if (!strcmp(tls->revoked, "none")) return PEND_OK;
    return tls_read("the list of revoked certificates", tls->revoked, &text[3], error);
}

/* Reads the files into a new set. */
static enum pend_status tls_load(struct srv_tls *tls, struct tls_set **set,
                                 struct pend_error *error) {
    struct api_buffer text[TLS_FILES];
    struct tls_set *made = *set = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    for (int i = 0; i < TLS_FILES; i++) api_buffer_init(&text[i], TLS_FILE);
    enum pend_status status = tls_read("the certificate", tls->certificate, &text[0], error);
    if (status == PEND_OK) status = srv_secret_read(tls->key, &text[1], NULL, error);
    if (status == PEND_OK) status = tls_read_clients(tls, text, error);
    if (status == PEND_OK) status = tls_fill(tls, made, text, error);
    if (status == PEND_OK && !tls->asked.bytes && text[2].bytes)
        status = api_buffer_add(&tls->asked, text[2].data, text[2].bytes) == PEND_OK
                     ? api_buffer_add(&tls->asked, "", 1)
                     : PEND_NO_MEMORY;
    if (text[1].data) explicit_bzero(text[1].data, text[1].bytes);
    for (int i = 0; i < TLS_FILES; i++) api_buffer_clear(&text[i]);
    if (status == PEND_OK) return status;
    tls_set_free(made);
    *set = NULL;
    return status;
}

enum pend_status srv_tls_new(struct srv_tls **tls, const struct srv_config *config,
                             struct pend_error *error) {
    *tls = NULL;
    int sealed = strcmp(config->tls_certificate, "none") != 0;
    if (sealed != (strcmp(config->tls_key, "none") != 0) ||
        (!sealed && strcmp(config->tls_client_authority, "none")))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--tls-certificate and --tls-key go together, and "
                         "--tls-client-authority with both");
    if (strcmp(config->tls_client_revoked, "none") && !strcmp(config->tls_client_authority, "none"))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "--tls-client-revoked goes with --tls-client-authority");
    if (!sealed) return PEND_OK;
    struct srv_tls *made = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    memcpy(made->certificate, config->tls_certificate, sizeof made->certificate);
    memcpy(made->key, config->tls_key, sizeof made->key);
    memcpy(made->authority, config->tls_client_authority, sizeof made->authority);
    memcpy(made->revoked, config->tls_client_revoked, sizeof made->revoked);
    pthread_mutex_init(&made->lock, NULL);
    api_buffer_init(&made->asked, TLS_FILE);
    enum pend_status status = tls_load(made, &made->set, error);
    if (status != PEND_OK)
        srv_tls_free(&made);
    else
        *tls = made;
    return status;
}

void srv_tls_free(struct srv_tls **tls) {
    struct srv_tls *gone = *tls;
    *tls = NULL;
    if (!gone) return;
    tls_set_free(gone->set);
    api_buffer_clear(&gone->asked);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

enum pend_status srv_tls_reload(struct srv_tls *tls, struct pend_error *error) {
    struct tls_set *set;
    assert(tls->set);
    PEND_TRY(tls_load(tls, &set, error));
    pthread_mutex_lock(&tls->lock);
    set->before = tls->set;
    tls->set = set;
    pthread_mutex_unlock(&tls->lock);
    return PEND_OK;
}

/* --- handshakes --- */

static int tls_show(gnutls_session_t session, const gnutls_datum_t *names, int count,
                    const gnutls_pk_algorithm_t *algorithms, int algorithm_count,
                    gnutls_pcert_st **chain, unsigned *length, gnutls_privkey_t *key) {
    (void)session, (void)names, (void)count, (void)algorithms, (void)algorithm_count;
    if (!tls_here) return -1;
    struct tls_set *set = tls_set(tls_here);
    *chain = set->chain;
    *length = set->count;
    *key = set->key;
    return 0;
}

void *srv_tls_callback(void) {
    union {
        gnutls_certificate_retrieve_function2 *function;
        void *pointer;
    } callback = {.function = tls_show};
    return callback.pointer;
}

const char *srv_tls_trust(const struct srv_tls *tls) {
    return tls->asked.bytes ? tls->asked.data : NULL;
}

/* The certificates that a client has shown; returns their number. */
static unsigned tls_shown(gnutls_session_t session, gnutls_x509_crt_t list[TLS_CHAIN]) {
    unsigned count = 0, good = 0;
    const gnutls_datum_t *raw = gnutls_certificate_get_peers(session, &count);
    for (unsigned i = 0; raw && i < count && i < TLS_CHAIN; i++) {
        if (gnutls_x509_crt_init(&list[good]) < 0) break;
        if (gnutls_x509_crt_import(list[good], &raw[i], GNUTLS_X509_FMT_DER) >= 0) {
            good++;
            continue;
        }
        gnutls_x509_crt_deinit(list[good]);
        break;
    }
    return good;
}

static const char *tls_reason(unsigned status) {
    if (status & GNUTLS_CERT_REVOKED) return "it was revoked";
    if (status &
        (GNUTLS_CERT_REVOCATION_DATA_SUPERSEDED | GNUTLS_CERT_REVOCATION_DATA_ISSUED_IN_FUTURE))
        return "the server's list of revoked certificates is out of date";
    if (status & GNUTLS_CERT_EXPIRED) return "it has expired";
    if (status & GNUTLS_CERT_NOT_ACTIVATED) return "its time has not begun";
    if (status & GNUTLS_CERT_SIGNER_NOT_FOUND) return "another authority has signed it";
    if (status & GNUTLS_CERT_PURPOSE_MISMATCH) return "it is not made for clients";
    if (status & GNUTLS_CERT_INSECURE_ALGORITHM) return "it is signed by a method that is not safe";
    return "it is not valid";
}

int srv_tls_client_fits(struct srv_tls *tls, void *session, char why[SRV_TLS_WHY]) {
    gnutls_x509_crt_t list[TLS_CHAIN];
    gnutls_typed_vdata_st purpose = {.type = GNUTLS_DT_KEY_PURPOSE_OID,
                                     .data = (unsigned char *)GNUTLS_KP_TLS_WWW_CLIENT};
    unsigned status = 0, count;
    struct tls_set *set = tls_set(tls);
    why[0] = 0;
    if (!set->trust) return 1;
    count = session ? tls_shown(session, list) : 0;
    int code = count ? gnutls_x509_trust_list_verify_crt2(set->trust, list, count, &purpose, 1, 0,
                                                          &status, NULL)
                     : 0;
    for (unsigned i = 0; i < count; i++) gnutls_x509_crt_deinit(list[i]);
    if (count && code >= 0 && !status) return 1;
    if (!count)
        snprintf(why, SRV_TLS_WHY, "this connection has shown none");
    else
        snprintf(why, SRV_TLS_WHY, "that of this connection does not fit: %s", tls_reason(status));
    return 0;
}

/* --- bytes --- */

void srv_tls_send(void *session, const void *data, size_t bytes) {
    for (const char *at = data; bytes;) {
        ssize_t sent = gnutls_record_send(session, at, bytes);
        if (sent <= 0) return;
        at += sent;
        bytes -= (size_t)sent;
    }
}

/* libmicrohttpd reads TLS connections by this function. Like recv it is replaced here, so that the
 * strict reader sees the decrypted bytes first. */
ssize_t tls_record_recv(gnutls_session_t session, void *data,
                        size_t bytes) __asm__("gnutls_record_recv");

typedef ssize_t tls_record_recv_fn(gnutls_session_t session, void *data, size_t bytes);

/* The function of GnuTLS itself. */
static tls_record_recv_fn *tls_recv(void) {
    static _Thread_local tls_record_recv_fn *found;
    union {
        void *pointer;
        tls_record_recv_fn *function;
    } symbol;
    if (found) return found;
    symbol.pointer = dlsym(RTLD_NEXT, "gnutls_record_recv");
    return found = symbol.function;
}

ssize_t tls_record_recv(gnutls_session_t session, void *data, size_t bytes) {
    tls_record_recv_fn *receive = tls_recv();
    struct srv_recv_hook *hook = srv_recv_hook_at(gnutls_transport_get_int(session));
    ssize_t got;
    size_t shown = 0;
    if (!receive) return GNUTLS_E_INTERNAL_ERROR;
    /* For a stream that was refused the function reports that the client has ended it. */
    if (hook && hook->strict.status) return 0;
    do {
        got = receive(session, data, bytes);
        if (!hook || got <= 0) return got;
        shown = srv_recv_hook_show(hook, data, (size_t)got);
    } while (!shown && !hook->strict.status);
    return (ssize_t)shown;
}
