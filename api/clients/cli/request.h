/* A request's body, composed of a file and the options on the command line.
 * Leaves to others: the meaning of the fields (api/op); unknown names are passed on.
 * Invariant: every number of the file keeps its value to the last bit; a body is JSON. */
#pragma once

#include "api/base/buffer.h"

enum { CLI_FIELDS = 100 };

/* Members that replace members of the file or are added to them. */
struct cli_fields {
    int count;
    struct {
        char object[40]; /* "pendulum", "initial" or another member; "" = the request itself */
        char name[40];
        char *json;
    } field[CLI_FIELDS];
};

/* Exit statuses: a failure of files or memory, a wrong command line, a refused request, a server
 * that does not answer, a failed or cancelled job. */
enum { CLI_FAILED = 1, CLI_USAGE, CLI_REFUSED, CLI_AWAY, CLI_JOB, CLI_BAD = 65, CLI_AGAIN = 75 };

/* Non-zero: a scheduler runs this program. Any failure to read or write, and a signal, then end it
 * with CLI_AGAIN, everything else with CLI_BAD. */
extern int cli_scheduled;

/** Prints "pendulum: " and the message on standard error, and ends the program with the status. */
void cli_end(int status, const char *format, ...) __attribute__((format(printf, 2, 3), noreturn));
#define cli_die(...) cli_end(CLI_FAILED, __VA_ARGS__)

/** Prints a warning of the computation on standard error. */
void cli_warn(const char *text);

/** Ends the program unless `good`, the result of an allocation or of a write to memory. */
void cli_need(int good);

/** Ends the program with CLI_REFUSED and the words of a problem in JSON: its detail, then one line
 * per error, with the option instead of its field. */
void cli_refuse(long status, const struct api_buffer *problem) __attribute__((noreturn));

/** Adds NAME or OBJECT.NAME; a value that is not JSON becomes a text. Ends the program if there are
 * too many. */
void cli_field(struct cli_fields *fields, const char *name, const char *value);
void cli_fields_clear(struct cli_fields *fields);

/** Adds NAME=VALUE; ends the program if there is no =. */
void cli_assign(struct cli_fields *fields, const char *assignment);

/** Adds the list "1,2,3" as a JSON array. */
void cli_list(struct cli_fields *fields, const char *name, const char *numbers);

/** Adds `times`: "0:5:0.01" is start, stop, step; "0:5/501" start, stop, count; else a list. */
void cli_times(struct cli_fields *fields, const char *text);

/** Adds the table in a file as `data.csv`; "-" is standard input. Ends the program if it is not
 * text. */
void cli_table(struct cli_fields *fields, const char *path);

/** Returns the axis "theta1:-3:3:512" as JSON, to be freed; ends the program if it is invalid. */
char *cli_axis(const char *text);

/** Appends the body. path: a file with a request or only a pendulum; "-" is standard input. Ends
 * the program if it cannot be read or is not JSON. */
void cli_body(struct api_buffer *out, const char *path, const struct cli_fields *fields);
