#include "server/config/config.h"

enum pend_status srv_config_help(struct api_buffer *out) {
    struct srv_option row;
    PEND_TRY(api_buffer_text(
        out, "Usage: pendulumd [--option value]...\n"
             "Serves planar pendulum trees over HTTP.\n\n"
             "An option can also be set in the environment (PENDULUMD_MAX_QUEUE=10) and in the\n"
             "file of --config (max-queue = 10). The command line wins over the environment, the\n"
             "environment over the file, the file over the default, which is given in brackets.\n"
             "Bytes may end in K, M or G.\n\n"));
    for (int i = 0; srv_config_row(i, &row); i++) {
        PEND_TRY(api_buffer_format(out, "  --%s %s\n      %s", row.name,
                                   row.sample ? row.sample : "", row.meaning));
        PEND_TRY(row.start[0] ? api_buffer_format(out, " [%s]\n", row.start)
                              : api_buffer_text(out, "\n"));
    }
    return PEND_OK;
}

enum pend_status srv_config_table(struct api_buffer *out) {
    struct srv_option row;
    PEND_TRY(api_buffer_text(out, "| option | default | meaning |\n| --- | --- | --- |\n"));
    for (int i = 0; srv_config_row(i, &row); i++) {
        PEND_TRY(api_buffer_format(out, "| `--%s%s%s` | %s%s%s | %s |\n", row.name,
                                   row.sample ? " " : "", row.sample ? row.sample : "",
                                   row.start[0] ? "`" : "", row.start, row.start[0] ? "`" : "",
                                   row.meaning));
    }
    return PEND_OK;
}
