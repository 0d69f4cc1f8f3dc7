#include "server/store/store_statements.h"

#include <assert.h>

static_assert((int)SQL_COUNT <= (int)SRV_SQL_STATEMENTS, "a connection keeps every statement");

const char *const srv_statement_text[SQL_COUNT] = {
#define X(name, text) text,
    STATEMENTS(X)
#undef X
};
