/* pendulum: motions, modes and maps of pendulum trees from a shell, by a server or without one.
 * Leaves to others: the body (request), receiving and writing the answer (remote, local, sink).
 * Invariant: exit status 0 means that the whole answer is where the user wanted it. */
#include <assert.h>
#include <ctype.h>
#include <getopt.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>
#include <time.h>

#include "api/base/engine.h"
#include "api/clients/cli/local.h"
#include "api/clients/cli/remote.h"
#include "api/clients/cli/request.h"
#include "api/json/did_you_mean.h"
#include "api/json/json_in.h"

static const char usage[] =
    "usage: pendulum run FILE --t START:STOP:STEP    motion of the pendulum in FILE (JSON)\n"
    "       pendulum modes FILE                      its modes of oscillation\n"
    "       pendulum map FILE --x AXIS --y AXIS      a map over two axes such as theta1:-3:3:512\n"
    "       pendulum ask ROUTE FILE                  any POST /v1/ROUTE\n"
    "       pendulum jobs                            your jobs; get ID, cancel ID\n"
    "  -o, --out FILE      .npz .h5 .parquet .mat .csv .json .ndjson .png .bin; - is standard\n"
    "                      output, as without this option\n"
    "      --as FORM       the format without a file: csv (default; json if no table exists),\n"
    "                      json, npz, ...\n"
    "      --theta A,B     initial angles; also --phi, --thetad, --phid, --unit deg\n"
    "      --method NAME   taylor (default), ode23, ...\n"
    "      --duration S    duration of a map; also --of OBSERVABLE (first_flip)\n"
    "  -f, --csv FILE      measurements for fits and tables: a table file, unchanged\n"
    "  -s, --set NAME=JSON any field: -s rtol=1e-9, -s pendulum.gravity=1.62\n"
    "      --job           submit as a job and wait for it; `get ID` returns it again\n"
    "      --detach        submit as a job, print its ID and exit\n"
    "      --key KEY       idempotency key of the job: repeating it makes no new job\n"
    "      --title TITLE   title of the job; with `jobs`: jobs whose title contains it\n"
    "      --status WORD   with `jobs`: accepted, running, successful, failed, dismissed\n"
    "      --local         compute here, without a server\n"
    "      --part K/N      with --local: part K of N of an ensemble, 1 <= K <= N; exit\n"
    "                      status 75: try again, 65: bad request\n"
    "      --server URL    default PENDULUM_URL or http://127.0.0.1:8080; PENDULUM_TOKEN is\n"
    "                      your secret\n"
    "      --patience S    how long to retry a busy server (60)\n";

/* getopt codes of options with a value: letters, then long options; text[code - AS] */
enum {
    LETTERS = 256,
    AS = LETTERS,
    OF,
    KEY,
    SERVER,
    PATIENCE,
    X,
    Y,
    TITLE,
    STATUS,
    PART,
    TEXTS,
    T = TEXTS,
    FIELD
};

static int of_job, detached, here; /* options without a value */

static const struct option options[] = {{"out", 1, 0, 'o'},
                                        {"as", 1, 0, AS},
                                        {"t", 1, 0, T},
                                        {"set", 1, 0, 's'},
                                        {"csv", 1, 0, 'f'},
                                        {"theta", 1, 0, FIELD},
                                        {"phi", 1, 0, FIELD},
                                        {"thetad", 1, 0, FIELD},
                                        {"phid", 1, 0, FIELD},
                                        {"unit", 1, 0, FIELD},
                                        {"method", 1, 0, FIELD},
                                        {"duration", 1, 0, FIELD},
                                        {"x", 1, 0, X},
                                        {"y", 1, 0, Y},
                                        {"of", 1, 0, OF},
                                        {"job", 0, &of_job, 1},
                                        {"key", 1, 0, KEY},
                                        {"title", 1, 0, TITLE},
                                        {"status", 1, 0, STATUS},
                                        {"detach", 0, &detached, 1},
                                        {"local", 0, &here, 1},
                                        {"part", 1, 0, PART},
                                        {"server", 1, 0, SERVER},
                                        {"patience", 1, 0, PATIENCE},
                                        {"help", 0, 0, 'h'},
                                        {"version", 0, 0, 'V'},
                                        {0, 0, 0, 0}};

static const struct {
    const char *ending, *media_type;
} forms[] = {{"csv", "text/csv"},
             {"json", "application/json"},
             {"npz", "application/x-npz"},
             {"parquet", "application/vnd.apache.parquet"},
             {"h5", "application/x-hdf5"},
             {"mat", "application/x-matlab-data"},
             {"ndjson", "application/x-ndjson"},
             {"png", "image/png"},
             {"bin", "application/octet-stream"}};

struct line { /* the parsed command line */
    struct cli_remote remote;
    struct cli_fields fields;
    const char *out, *text[TEXTS - LETTERS];
};

static const char *said(const struct line *line, int letter) {
    assert(letter >= LETTERS && letter < TEXTS);
    return line->text[letter - LETTERS];
}

static const char *accepted(const struct line *line) {
    const char *dot = line->out ? strrchr(line->out, '.') : NULL;
    if (dot && (strchr(dot, '/') || !dot[1])) dot = NULL; /* the dot belongs to a directory */
    const char *form = said(line, AS) ? said(line, AS) : dot ? dot + 1 : NULL;
    if (!form)
        return "text/csv, application/json;q=0.5"; /* not every operation has a table as its
                                                    * answer */
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++)
        if (!strcasecmp(forms[i].ending, form)) return forms[i].media_type;
    cli_end(CLI_USAGE,
            "unknown format %s: give csv, json, npz, h5, parquet, mat, ndjson, png or bin (--as)",
            form);
}

/* an initial value is a member of `initial`, as a text or a list; method and duration belong to the
 * request */
static void start(struct cli_fields *fields, const char *name, const char *value) {
    char whole[40];
    snprintf(whole, sizeof whole, "initial.%s", name);
    if (!strcmp(name, "method") || !strcmp(name, "duration")) {
        cli_field(fields, name, value);
    } else if (!strcmp(name, "unit")) {
        cli_field(fields, whole, value);
    } else {
        if (value[strspn(value, "0123456789+-.eE, ")])
            cli_end(CLI_USAGE, "--%s takes numbers such as 1,2.5, got \"%s\"", name, value);
        cli_list(fields, whole, value);
    }
}

static void read_options(struct line *line, int argc, char *argv[]) {
    int letter, which = 0;
    while ((letter = getopt_long(argc, argv, "o:s:f:hV", options, &which)) != -1) {
        switch (letter) {
        case 0:
            break; /* getopt has set the option's variable */
        case 'o':
            line->out = optarg;
            break;
        case 's':
            cli_assign(&line->fields, optarg);
            break;
        case 'f':
            cli_table(&line->fields, optarg);
            break;
        case T:
            cli_times(&line->fields, optarg);
            break;
        case FIELD:
            start(&line->fields, options[which].name, optarg);
            break;
        case 'h':
            fputs(usage, stdout);
            exit(0);
        case 'V':
            printf("pendulum %s, engine %s\n", api_version, api_engine_name);
            exit(0);
        case '?':
            cli_end(CLI_USAGE, "see pendulum --help");
        default:
            line->text[letter - LETTERS] = optarg;
        }
    }
    if (said(line, SERVER)) line->remote.url = said(line, SERVER);
    if (said(line, PATIENCE)) line->remote.patience = atof(said(line, PATIENCE));
    if (line->remote.token && !*line->remote.token) line->remote.token = NULL;
}

static struct api_json *state(struct line *line, const char *method, const char *path,
                              const struct api_buffer *body, const char *key) {
    struct cli_exchange exchange = {
        .method = method, .path = path, .body = body, .key = key, .title = said(line, TITLE)};
    struct cli_sink sink;
    struct api_problem problem;
    struct api_json *document;
    api_problem_init(&problem);
    cli_sink_open(&sink, "", NULL);
    long status = cli_remote_ask(&line->remote, &exchange, &sink);
    if (key && status != 202) cli_die("this server stores no jobs");
    if (api_json_new(&document, sink.text.data ? sink.text.data : "", sink.text.bytes, 16,
                     &problem) != PEND_OK)
        cli_die("%s%s: %s", line->remote.url, path, problem.detail);
    cli_sink_close(&sink);
    return document;
}

/* a member that is a text; "" if there is none */
static const char *member(const struct api_value *object, const char *name) {
    struct api_value value = api_value_member(object, name);
    const char *found = api_value_text(&value);
    return found ? found : "";
}

static const char *text(const struct api_json *document, const char *name) {
    struct api_value root = api_json_root(document);
    return member(&root, name);
}

static double number(const struct api_json *document, const char *name) {
    struct api_value root = api_json_root(document), value = api_value_member(&root, name);
    return api_value_number(&value);
}

/* checks that an id consists of lower-case letters, digits and hyphens, and that --local is not
 * given, because jobs need a server */
static void check_id(const char *id) {
    if (!*id || id[strspn(id, "abcdefghijklmnopqrstuvwxyz0123456789-")])
        cli_end(CLI_USAGE, "%s is not the id of a job", id);
    if (here) cli_end(CLI_USAGE, "--local cannot run jobs");
}

static void get(struct line *line, const char *id) {
    check_id(id);
    char path[200], kept[33];
    long pause_ms = 20;
    for (;;) {
        snprintf(path, sizeof path, "/v1/jobs/%.60s", id);
        struct api_json *job = state(line, "GET", path, NULL, NULL);
        const char *status = text(job, "status");
        int done = (int)number(job, "progress"),
            ended = strcmp(status, "accepted") && strcmp(status, "running");
        cli_progress("[%-25.*s] %d %% %s", done / 4, "#########################", done, status);
        if (ended && strcmp(status, "successful"))
            cli_end(CLI_JOB, "the job %s is %s: %s", id, status, text(job, "message"));
        api_json_free(&job);
        if (ended) break;
        nanosleep(&(struct timespec){pause_ms / 1000, pause_ms % 1000 * 1000000}, NULL);
        pause_ms = pause_ms < 700 ? pause_ms * 3 / 2 : 1000;
    }
    snprintf(path, sizeof path, "/v1/jobs/%.60s/results", id);
    struct cli_exchange exchange = {
        .method = "HEAD", .path = path, .accept = accepted(line), .resumes = 1};
    struct cli_sink sink;
    cli_sink_open(&sink, "", NULL);
    cli_remote_ask(&line->remote, &exchange, &sink);
    cli_sink_close(&sink);
    /* the ETag becomes part of a file name, so only its letters and digits are kept */
    size_t length = 0;
    for (const char *c = exchange.etag; *c && length < sizeof kept - 1; c++)
        if (isalnum((unsigned char)*c)) kept[length++] = *c;
    if (length == 0) cli_die("%s sends no ETag with its results", line->remote.url);
    kept[length] = '\0';
    exchange.method = "GET";
    cli_sink_open(&sink, line->out, kept);
    cli_remote_ask(&line->remote, &exchange, &sink);
    cli_sink_close(&sink);
}

/* the part that --part names; 0 of 0 without it */
static struct cli_part part_of(const struct line *line) {
    struct cli_part part = {0};
    const char *named = said(line, PART);
    int end = 0;
    if (!named) return part;
    cli_scheduled = 1;
    sscanf(named, "%ld/%ld%n", &part.part, &part.parts, &end);
    if (!end || named[end] || part.part < 1 || part.part > part.parts || !here)
        cli_end(CLI_USAGE, "--part takes K/N, 1 <= K <= N, and needs --local; got %s", named);
    return part;
}

/* sends a request, or computes it in this process, or submits it as a job */
static void ask(struct line *line, const char *route, const char *file) {
    struct api_buffer body;
    struct cli_sink sink;
    char path[200], key[40];
    struct cli_part part = part_of(line);
    if (!strcmp(accepted(line), "image/png") && strcmp(route, "ensembles"))
        cli_end(CLI_USAGE, "%s has no picture: .png is a form of map and ask ensembles", route);
    if (here && (of_job || detached)) cli_end(CLI_USAGE, "--local cannot run jobs");
    api_buffer_init(&body, 1 << 30);
    cli_body(&body, file, &line->fields);
    snprintf(path, sizeof path, "/v1/%.60s", route);
    if ((of_job || detached || said(line, KEY)) && !here) {
        unsigned long random[2];
        if (getrandom(random, sizeof random, 0) != sizeof random) cli_die("no random number");
        snprintf(key, sizeof key, "%016lx%016lx", random[0], random[1]);
        struct api_json *job =
            state(line, "POST", path, &body, said(line, KEY) ? said(line, KEY) : key);
        if (detached)
            puts(text(job, "id"));
        else
            fprintf(stderr, "job %s\n", text(job, "id")), get(line, text(job, "id"));
        api_json_free(&job);
    } else {
        const char *accept = accepted(line);
        struct cli_exchange exchange = {
            .method = "POST", .path = path, .body = &body, .accept = accept};
        cli_sink_open(&sink, line->out, NULL);
        if (here)
            cli_local(route, &body, accept, part, &sink);
        else
            cli_remote_ask(&line->remote, &exchange, &sink);
        cli_sink_close(&sink);
    }
    api_buffer_clear(&body);
}

static void map(struct line *line, char **word) {
    char grid[700], of[100];
    if (!said(line, X) || !said(line, Y)) cli_end(CLI_USAGE, "a map has two axes, --x and --y");
    char *x = cli_axis(said(line, X)), *y = cli_axis(said(line, Y));
    snprintf(grid, sizeof grid, "[%s,%s]", x, y);
    snprintf(of, sizeof of, "[\"%.80s\"]", said(line, OF) ? said(line, OF) : "first_flip");
    cli_field(&line->fields, "grid", grid);
    cli_field(&line->fields, "observables", of);
    ask(line, "ensembles", word[1]);
    free(x), free(y);
}

/* appends a parameter to a path's query, with the value percent-encoded */
static void filter(char *path, size_t room, const char *name, const char *value) {
    size_t at = strlen(path);
    if (!value) return;
    if (at + strlen(name) + 2 + 3 * strlen(value) >= room) cli_die("%s is too long", name);
    at += (size_t)snprintf(path + at, room - at, "&%s=", name);
    for (; *value; value++)
        at += (size_t)snprintf(path + at, room - at, "%%%02X", (unsigned char)*value);
}

static void jobs(struct line *line, char **word) {
    (void)word;
    char path[1000] = "/v1/jobs?limit=100";
    filter(path, sizeof path, "title", said(line, TITLE));
    filter(path, sizeof path, "status", said(line, STATUS));
    while (*path) {
        struct api_json *page = state(line, "GET", path, NULL, NULL);
        struct api_value root = api_json_root(page), list = api_value_member(&root, "jobs");
        *path = '\0';
        for (struct api_value job = api_value_first(&list); api_value_kind(&job) != API_MISSING;
             job = api_value_next(&job)) {
            struct api_value done = api_value_member(&job, "progress");
            const char *title = member(&job, "title");
            printf("%s %3.0f %% %-12s %-12s %s%s%s\n", member(&job, "id"), api_value_number(&done),
                   member(&job, "status"), member(&job, "operation"), member(&job, "created"),
                   *title ? " " : "", title);
        }
        struct api_value links = api_value_member(&root, "links");
        for (struct api_value link = api_value_first(&links); api_value_kind(&link) != API_MISSING;
             link = api_value_next(&link)) {
            if (!strcmp(member(&link, "rel"), "next"))
                snprintf(path, sizeof path, "%s", member(&link, "href"));
        }
        api_json_free(&page);
    }
}

static void run(struct line *line, char **word) { ask(line, "trajectories", word[1]); }

static void modes(struct line *line, char **word) { ask(line, "modes", word[1]); }

static void any(struct line *line, char **word) { ask(line, word[1], word[2]); }

static void fetch(struct line *line, char **word) { get(line, word[1]); }

static void cancel(struct line *line, char **word) {
    char path[200];
    check_id(word[1]);
    snprintf(path, sizeof path, "/v1/jobs/%.60s", word[1]);
    struct api_json *job = state(line, "DELETE", path, NULL, NULL);
    puts(text(job, "status"));
    api_json_free(&job);
}

static const struct {
    const char *name;
    int words; /* number of words after it */
    void (*work)(struct line *line, char **word);
} commands[] = {{"run", 1, run},   {"modes", 1, modes}, {"map", 1, map},      {"ask", 2, any},
                {"jobs", 0, jobs}, {"get", 1, fetch},   {"cancel", 1, cancel}};
enum { COMMANDS = sizeof commands / sizeof *commands };

static void mistaken(const char *word) {
    const char *names[COMMANDS + 1] = {NULL};
    for (int i = 0; i < COMMANDS; i++) names[i] = commands[i].name;
    const char *meant = api_did_you_mean(word, names);
    if (meant) cli_end(CLI_USAGE, "unknown command %s; did you mean %s?", word, meant);
    cli_end(CLI_USAGE, "unknown command %s: see pendulum --help", word);
}

int main(int argc, char *argv[]) {
    const char *url = getenv("PENDULUM_URL");
    struct line line = {
        .remote = {url && *url ? url : "http://127.0.0.1:8080", getenv("PENDULUM_TOKEN"), 60, 0}};
    read_options(&line, argc, argv);
    char **word = argv + optind;
    int i = 0, words = argc - optind - 1;
    if (words < 0)
        cli_end(
            CLI_USAGE,
            "a command is needed: run, modes, map, ask, jobs, get or cancel; see pendulum --help");
    while (i < COMMANDS && strcmp(word[0], commands[i].name)) i++;
    if (i == COMMANDS) mistaken(word[0]);
    if (words != commands[i].words)
        cli_end(CLI_USAGE, "%s takes %d argument%s, got %d: see pendulum --help", word[0],
                commands[i].words, commands[i].words == 1 ? "" : "s", words);
    commands[i].work(&line, word);
    cli_progress("%s", "");
    cli_fields_clear(&line.fields);
    return 0;
}
