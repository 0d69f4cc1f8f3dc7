#include "api/call/crate.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/job_json.h"
#include "api/call/zip.h"
#include "api/json/json_out.h"

enum { CRATE_TEXT = 8192, CRATE_METADATA = 65536, CRATE_URL = 512, CRATE_FILE = 24 };

const char api_crate_request[] = "request.json";
const char api_crate_metadata[] = "ro-crate-metadata.json";
const char api_crate_media_type[] = "application/zip";
const char api_crate_file[] = "crate.zip";

static const char crate_cite[] = "cite.bib", crate_readme[] = "README.md";

struct api_crate {
    struct api_cite cite;
    struct api_zip zip;
    struct api_digest_stream *digest; /* of the results so far */
    const struct api_format *format;
    char results[CRATE_FILE]; /* the name of the results' file */
    uint64_t bytes;           /* of the results so far */
    size_t cite_bytes, readme_bytes;
    char columns[API_COLUMNS_TEXT];
    char text[]; /* the texts of `cite` */
};

enum pend_status api_crate_new(struct api_crate **crate, const struct api_cite *cite) {
    assert(cite->digest[0] && cite->finished > 0);
    struct api_cite own = *cite;
    if (!own.author) own.author = "";
    if (!own.license) own.license = "";
    const char **const text[] = {&own.id,     &own.operation, &own.title,  &own.version,
                                 &own.origin, &own.author,    &own.license};
    enum { TEXTS = sizeof text / sizeof *text };
    size_t bytes = 0;
    for (int i = 0; i < TEXTS; i++) bytes += strlen(*text[i]) + 1;
    struct api_crate *made = *crate = calloc(1, sizeof *made + bytes);
    if (!made) return PEND_NO_MEMORY;
    char *at = made->text;
    for (int i = 0; i < TEXTS; i++) {
        const char *from = *text[i];
        *text[i] = at;
        at = stpcpy(at, from) + 1;
    }
    made->cite = own;
    made->digest = api_digest_begin();
    if (!made->digest) api_crate_free(crate);
    return *crate ? PEND_OK : PEND_NO_MEMORY;
}

void api_crate_free(struct api_crate **crate) {
    if (*crate) api_digest_end(&(*crate)->digest, NULL);
    free(*crate);
    *crate = NULL;
}

void api_crate_etag(const struct api_crate *crate, char digest[API_DIGEST_BYTES]) {
    char answer[API_DIGEST_BYTES];
    memcpy(answer, digest, sizeof answer);
    const struct api_cite *cite = &crate->cite;
    const char *const parts[] = {"crate",      answer,        cite->id, cite->origin,
                                 cite->author, cite->license, NULL};
    api_digest(digest, parts, NULL);
}

/* the end of the name of a file in a representation: "csv", "ndjson" */
static const char *crate_extension(const struct api_format *format) {
    const char *type = format->media_type, *dash = strrchr(type, '-');
    if (format->extension) return format->extension;
    return format->bare ? "bin" : dash ? dash + 1 : strrchr(type, '/') + 1;
}

const struct api_format *api_crate_format(const char *extension) {
    const struct api_format *format;
    for (int i = 0; (format = api_format_at(i)); i++)
        if (!strcmp(crate_extension(format), extension)) return format;
    return NULL;
}

/* --- before the results --- */

static enum pend_status crate_write_readme(const struct api_crate *crate, struct api_buffer *out) {
    const struct api_cite *cite = &crate->cite;
    char name[API_CITE_NAME];
    api_cite_name(cite, name);
    PEND_TRY(api_buffer_format(out, "# %s\n\n", name));
    PEND_TRY(api_buffer_format(
        out,
        "A computation of pendulumd %s, job %s.\n"
        "`%s` is what was asked, `%s` the answer without the seconds that it took,\n"
        "`%s` an entry for a bibliography, and `%s` says all this to programs.\n\n",
        cite->version, cite->id, api_crate_request, crate->results, crate_cite,
        api_crate_metadata));
    PEND_TRY(api_buffer_format(out,
                               "Run it again, here or anywhere:\n\n"
                               "    curl -o again.%s -H 'Content-Type: application/json' \\\n"
                               "        -H 'Accept: %s' --data-binary @%s \\\n"
                               "        %s/v1/%s\n\n",
                               crate_extension(crate->format), crate->format->media_type,
                               api_crate_request, cite->origin, cite->operation));
    return api_buffer_text(
        out, "Prove that the results are the request's, bit for bit (exit status 0):\n\n"
             "    pendulumd --replay crate.zip > again\n\n"
             "An engine of another version, or a processor without fused multiply-add, may differ\n"
             "in the last digits. The program says which engine it has.\n");
}

/* adds a text that `write` makes */
static enum pend_status crate_add(struct api_crate *crate, const char *name, size_t *bytes,
                                  enum pend_status (*write)(const struct api_crate *crate,
                                                            struct api_buffer *out),
                                  size_t most, struct api_buffer *out) {
    struct api_buffer text;
    api_buffer_init(&text, most);
    enum pend_status status = write(crate, &text);
    if (status == PEND_OK) status = api_zip_add(&crate->zip, name, text.data, text.bytes, out);
    *bytes = text.bytes;
    api_buffer_clear(&text);
    return status;
}

static enum pend_status crate_write_cite(const struct api_crate *crate, struct api_buffer *out) {
    return api_cite_write(&crate->cite, out);
}

enum pend_status api_crate_begin(struct api_crate *crate, const struct api_format *format,
                                 const struct api_table *table, struct api_buffer *out) {
    const struct api_cite *cite = &crate->cite;
    assert(!crate->format);
    crate->format = format;
    snprintf(crate->results, sizeof crate->results, "results.%.12s", crate_extension(format));
    if (table->count) api_table_columns(table, crate->columns);
    PEND_TRY(api_zip_add(&crate->zip, api_crate_request, cite->request, cite->request_bytes, out));
    PEND_TRY(
        crate_add(crate, crate_readme, &crate->readme_bytes, crate_write_readme, CRATE_TEXT, out));
    PEND_TRY(crate_add(crate, crate_cite, &crate->cite_bytes, crate_write_cite, CRATE_TEXT, out));
    return api_zip_begin(&crate->zip, crate->results, out);
}

void api_crate_pass(struct api_crate *crate, const struct api_buffer *out, size_t from) {
    assert(crate->format && from <= out->bytes);
    if (from == out->bytes) return;
    api_zip_pass(&crate->zip, out->data + from, out->bytes - from);
    api_digest_add(crate->digest, out->data + from, out->bytes - from);
    crate->bytes += out->bytes - from;
}

/* --- the metadata --- */

static enum pend_status crate_ref(struct api_buffer *out, const char *name, const char *id) {
    PEND_TRY(api_out_open(out, name, '{'));
    PEND_TRY(api_out_text(out, "@id", id));
    return api_buffer_text(out, "}");
}

static enum pend_status crate_entity(struct api_buffer *out, const char *id, const char *type) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "@id", id));
    return api_out_text(out, "@type", type);
}

/* ids that follow each other, NULL behind the last */
static enum pend_status crate_refs(struct api_buffer *out, const char *name,
                                   const char *const id[]) {
    PEND_TRY(api_out_open(out, name, '['));
    for (int i = 0; id[i]; i++) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_buffer_text(out, "{"));
        PEND_TRY(api_out_text(out, "@id", id[i]));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "]");
}

static enum pend_status crate_file(struct api_buffer *out, const char *name, const char *type,
                                   uint64_t bytes, const char *digest, const char *description) {
    PEND_TRY(crate_entity(out, name, "File"));
    PEND_TRY(api_out_text(out, "name", name));
    PEND_TRY(api_out_text(out, "description", description));
    PEND_TRY(api_out_text(out, "encodingFormat", type));
    char text[24];
    snprintf(text, sizeof text, "%llu", (unsigned long long)bytes);
    PEND_TRY(api_out_text(out, "contentSize", text));
    if (digest) PEND_TRY(api_out_text(out, "sha256", digest));
    return api_buffer_text(out, "}");
}

static const char *crate_license(const struct api_cite *cite) {
    return cite->license[0] ? cite->license : "#license";
}

static enum pend_status crate_write_root(const struct api_crate *crate, struct api_buffer *out) {
    const struct api_cite *cite = &crate->cite;
    const char *const parts[] = {api_crate_request, crate->results, crate_cite, crate_readme, NULL};
    char name[API_CITE_NAME], url[CRATE_URL];
    api_cite_name(cite, name);
    PEND_TRY(crate_entity(out, api_crate_metadata, "CreativeWork"));
    PEND_TRY(crate_ref(out, "about", "./"));
    PEND_TRY(crate_ref(out, "conformsTo", "https://w3id.org/ro/crate/1.1"));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(crate_entity(out, "./", "Dataset"));
    PEND_TRY(crate_ref(out, "conformsTo", "https://w3id.org/ro/wfrun/process/0.5"));
    PEND_TRY(api_out_text(out, "name", name));
    PEND_TRY(api_out_text(out, "description",
                          "A request to pendulumd, a server for planar pendulum trees, and its "
                          "results, which anybody can compute again to the same bits"));
    PEND_TRY(api_job_time(out, "datePublished", cite->finished));
    PEND_TRY(crate_ref(out, "license", crate_license(cite)));
    if (cite->author[0]) PEND_TRY(crate_ref(out, "author", "#author"));
    snprintf(url, sizeof url, "%.300s/v1/jobs/%.40s", cite->origin, cite->id);
    PEND_TRY(api_out_text(out, "url", url));
    PEND_TRY(api_out_text(out, "identifier", cite->id));
    PEND_TRY(crate_refs(out, "hasPart", parts));
    PEND_TRY(crate_ref(out, "mentions", "#run"));
    return api_buffer_text(out, "}");
}

static enum pend_status crate_write_run(const struct api_crate *crate, struct api_buffer *out) {
    const struct api_cite *cite = &crate->cite;
    char url[CRATE_URL], name[API_CITE_NAME];
    api_cite_name(cite, name);
    PEND_TRY(crate_entity(out, "#run", "CreateAction"));
    PEND_TRY(api_out_text(out, "name", name));
    PEND_TRY(crate_ref(out, "instrument", "#pendulumd"));
    PEND_TRY(crate_ref(out, "object", api_crate_request));
    PEND_TRY(crate_ref(out, "result", crate->results));
    PEND_TRY(crate_ref(out, "target", "#entry"));
    PEND_TRY(crate_ref(out, "actionStatus", "http://schema.org/CompletedActionStatus"));
    PEND_TRY(api_job_time(out, "startTime", cite->started ? cite->started : cite->created));
    PEND_TRY(api_job_time(out, "endTime", cite->finished));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(crate_entity(out, "#entry", "EntryPoint"));
    snprintf(url, sizeof url, "%.300s/v1/%.60s", cite->origin, cite->operation);
    PEND_TRY(api_out_text(out, "name", cite->operation));
    PEND_TRY(api_out_text(out, "httpMethod", "POST"));
    PEND_TRY(api_out_text(out, "urlTemplate", url));
    PEND_TRY(api_out_text(out, "encodingType", "application/json"));
    PEND_TRY(api_out_text(out, "contentType", crate->format->media_type));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(crate_entity(out, "#pendulumd", "SoftwareApplication"));
    PEND_TRY(api_out_text(out, "name", "pendulumd"));
    PEND_TRY(api_out_text(out, "description", "A server for planar pendulum trees"));
    PEND_TRY(api_out_text(out, "url", cite->origin));
    PEND_TRY(api_out_text(out, "softwareVersion", cite->version));
    return api_buffer_text(out, "}");
}

/* whose it is, and under which license, as whoever asks for the crate says */
static enum pend_status crate_write_rights(const struct api_cite *cite, struct api_buffer *out) {
    int stated = cite->license[0] != 0;
    PEND_TRY(crate_entity(out, crate_license(cite), "CreativeWork"));
    PEND_TRY(api_out_text(out, "name", stated ? cite->license : "Not stated"));
    PEND_TRY(api_out_text(out, "description",
                          stated ? "The license under which request and results may be used, as "
                                   "whoever asked for this crate says"
                                 : "Whoever posted the request decides under which license request "
                                   "and results may be used; the server does not know it"));
    PEND_TRY(api_buffer_text(out, "}"));
    if (!cite->author[0]) return PEND_OK;
    PEND_TRY(crate_entity(out, "#author", "Person"));
    PEND_TRY(api_out_text(out, "name", cite->author));
    return api_buffer_text(out, "}");
}

static enum pend_status crate_write_about(const struct api_cite *cite, struct api_buffer *out) {
    PEND_TRY(crate_write_rights(cite, out));
    PEND_TRY(crate_entity(out, "https://w3id.org/ro/wfrun/process/0.5", "CreativeWork"));
    PEND_TRY(api_out_text(out, "name", "Process Run Crate"));
    PEND_TRY(api_out_text(out, "version", "0.5"));
    return api_buffer_text(out, "}");
}

static enum pend_status crate_write_files(const struct api_crate *crate, const char *digest,
                                          struct api_buffer *out) {
    const struct api_cite *cite = &crate->cite;
    PEND_TRY(crate_file(out, api_crate_request, "application/json", cite->request_bytes,
                        cite->digest, "What was asked"));
    char description[API_COLUMNS_TEXT + 64];
    snprintf(description, sizeof description,
             "The answer, without the seconds that it took; its columns: %s", crate->columns);
    PEND_TRY(crate_file(out, crate->results, crate->format->media_type, crate->bytes, digest,
                        description));
    PEND_TRY(crate_file(out, crate_cite, "application/x-bibtex", crate->cite_bytes, NULL,
                        "An entry for a bibliography"));
    return crate_file(out, crate_readme, "text/markdown", crate->readme_bytes, NULL,
                      "How to compute it again, and how to prove that the bits are the same");
}

static enum pend_status crate_write_metadata(const struct api_crate *crate, const char *digest,
                                             struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "{\"@context\":[\"https://w3id.org/ro/crate/1.1/context\","
                                  "{\"sha256\":\"http://schema.org/sha256\"}]"));
    PEND_TRY(api_out_open(out, "@graph", '['));
    PEND_TRY(crate_write_root(crate, out));
    PEND_TRY(crate_write_files(crate, digest, out));
    PEND_TRY(crate_write_run(crate, out));
    PEND_TRY(crate_write_about(&crate->cite, out));
    return api_buffer_text(out, "]}\n");
}

enum pend_status api_crate_end(struct api_crate *crate, struct api_buffer *out) {
    char digest[API_DIGEST_BYTES];
    struct api_buffer text;
    assert(crate->format && crate->digest);
    api_digest_end(&crate->digest, digest);
    PEND_TRY(api_zip_close(&crate->zip, out));
    api_buffer_init(&text, CRATE_METADATA);
    enum pend_status status = crate_write_metadata(crate, digest, &text);
    if (status == PEND_OK)
        status = api_zip_add(&crate->zip, api_crate_metadata, text.data, text.bytes, out);
    api_buffer_clear(&text);
    return status == PEND_OK ? api_zip_end(&crate->zip, out) : status;
}
