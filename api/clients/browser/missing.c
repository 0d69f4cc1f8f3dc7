/* Replacements for the parts of libraries that Debian does not have for WebAssembly: four functions
 * of cJSON on trees that the engine has built itself, and a stable sort. Also stubs of the
 * operations, methods and representations that engine.mk leaves out; using one calls `elsewhere`.
 * Leaves to others: omitted functions that the module imports; the script rejects them and
 * `elsewhere`, and then asks a server.
 * Invariant: sorting order and nodes are the same as the libraries', as far as the engine uses
 * them. */
#include "api/clients/browser/missing.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/op/op.h"
#include "api/read/method_json.h"

int cJSON_GetArraySize(const cJSON *array) {
    int count = 0;
    for (const cJSON *node = array ? array->child : NULL; node; node = node->next) count++;
    return count;
}

cJSON *cJSON_GetArrayItem(const cJSON *array, int index) {
    cJSON *node = array ? array->child : NULL;
    while (node && index > 0) {
        node = node->next;
        index--;
    }
    return index < 0 ? NULL : node;
}

cJSON *cJSON_GetObjectItemCaseSensitive(const cJSON *object, const char *name) {
    cJSON *node = object ? object->child : NULL;
    while (node && (!node->string || strcmp(node->string, name))) node = node->next;
    return node;
}

cJSON_bool cJSON_IsTrue(const cJSON *node) { return node && (node->type & 0xff) == cJSON_True; }

/* Sorts by merging halves, as glibc does, so that equal items keep their order. O(count log
 * count). */
static void sort(char *data, char *spare, size_t count, size_t size,
                 int (*order)(const void *, const void *, void *), void *context) {
    size_t half = count / 2, low = 0, high = half;
    if (count < 2) return;
    sort(data, spare, half, size, order, context);
    sort(data + half * size, spare, count - half, size, order, context);
    for (size_t i = 0; i < count; i++) {
        int first = low < half &&
                    (high == count || order(data + low * size, data + high * size, context) <= 0);
        memcpy(spare + i * size, data + (first ? low++ : high++) * size, size);
    }
    memcpy(data, spare, count * size);
}

void qsort_r(void *data, size_t count, size_t size,
             int (*order)(const void *, const void *, void *), void *context) {
    char *spare = malloc(count * size + 1);
    if (!spare) abort();
    sort(data, spare, count, size, order, context);
    free(spare);
}

void elsewhere(void);

static double elsewhere_bytes(const struct api_table *table) {
    (void)table;
    elsewhere();
    return 0;
}

static enum pend_status elsewhere_open(void **stepper, const struct pend_problem *problem,
                                       struct pend_error *error) {
    (void)stepper, (void)problem, (void)error;
    elsewhere();
    return PEND_INVALID;
}

/* a server checks what the request may contain */
#define METHOD(id, title)                                                                          \
    const struct pend_method pend_method_##id = {.name = title,                                    \
                                                 .summary = "",                                    \
                                                 .flags =                                          \
                                                     PEND_METHOD_TOLERANCES | PEND_METHOD_LANDS,   \
                                                 .rtol_default = 1e-6,                             \
                                                 .rtol_max = INFINITY,                             \
                                                 .atol_max = INFINITY,                             \
                                                 .open = elsewhere_open}
METHOD(rkf45, "rkf45");
METHOD(rk8pd, "rk8pd");
METHOD(msadams, "msadams");
METHOD(taylor_extended, "taylor");

#define FORMAT(id, type, samples)                                                                  \
    const struct api_format api_format_##id = {.media_type = type,                                 \
                                               .samples_only = samples,                            \
                                               .writer_bytes = sizeof(struct api_writer),          \
                                               .bytes = elsewhere_bytes}
FORMAT(npz, "application/x-npz", 1);
FORMAT(parquet, "application/vnd.apache.parquet", 1);
FORMAT(hdf5, "application/x-hdf5", 1);
FORMAT(mat, "application/x-matlab-data", 1);
FORMAT(png, "image/png", 2);
FORMAT(raw, "", 1);

/* the engine opens none of these operations */
#define OPERATION(id) const struct api_op api_op_##id = {.name = ""}
OPERATION(ensembles);
OPERATION(lyapunov);
OPERATION(sections);
OPERATION(controllers);
OPERATION(response);
OPERATION(fits);
