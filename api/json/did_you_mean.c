#include "api/json/did_you_mean.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

enum { NAME_BYTES = 64, NEAR_EDITS = 2 };

/* Other names of fields, methods, outputs and units, from other programs and papers. If a word
 * occurs in several rows, the first row with an allowed name counts. */
static const struct {
    const char *meant, *words;
} other_words[] = {
    /* parts of a request */
    {"pendulum", "tree system model"},
    {"initial", "state initial_state initial_conditions y0 x0 ic init"},
    {"duration", "time times t_end tmax stop"},
    {"times", "t time tspan t_span t_eval"},
    {"method", "solver integrator algorithm"},
    {"rtol", "tol tolerance reltol"},
    {"atol", "abstol"},
    {"step", "h dt by interval"},
    {"state", "initial"},
    {"number", "dtype"},
    {"form", "language lang"},
    /* members */
    {"vary", "parameter param variable quantity"},
    {"low", "min"},
    {"high", "max"},
    {"deviation", "std stddev sigma"},
    {"mean", "mu"},
    {"normal", "gaussian gauss"},
    {"lambda_max", "max_lambda"},
    {"lambda_min", "min_lambda"},
    /* a pendulum */
    {"L", "l"},
    {"length", "l lengths radius"},
    {"mass", "m masses weight"},
    {"gravity", "g grav"},
    {"parent", "parents"},
    {"name", "id label"},
    {"arms", "links bars"},
    {"S", "path"},
    {"damping", "b c"},
    {"stiffness", "k spring springs"},
    {"M", "mass_matrix"},
    /* instants */
    {"count", "step steps n num points samples"},
    {"start", "from min t0"},
    {"stop", "max to end t1 tmax t_max duration"},
    /* states and outputs; if both are allowed, the tip's */
    {"z", "position positions x y xy"},
    {"zd", "velocity velocities"},
    {"thetad", "velocity velocities omega theta_dot thetadot dtheta"},
    {"theta", "angle angles theta0"},
    {"phid", "phi_dot phidot dphi"},
    {"phidd", "acceleration accelerations"},
    {"lambda", "tension force forces"},
    {"energy", "energies E"},
    {"deg", "degree degrees"},
    {"rad", "radian radians"},
    /* methods and precisions */
    {"rkf45", "ode45 rk45 rk4 dopri5"},
    {"rk8pd", "dop853 ode89"},
    {"msadams", "ode113 lsoda odeint adams"},
    {"ode23", "rk23"},
    {"symplectic", "verlet leapfrog"},
    {"radau", "radau5 ode15s"},
    {"double", "float float64"},
    {"extended", "float128"},
    /* routes */
    {"/v1/trajectories", "/v1/trajectory /v1/simulate /v1/simulation /v1/simulations /v1/integrate "
                         "/v1/solve /v1/run /v1/motion"},
    {"/v1/modes", "/v1/frequencies /v1/eigenmodes /v1/eigenvalues"},
    {"/v1/forces", "/v1/energy /v1/accelerations"},
    {"/v1/sections", "/v1/poincare"},
    {"/v1/lyapunov", "/v1/exponents"},
    {"/v1/ensembles", "/v1/map /v1/sweep /v1/batch"},
    {"/v1/trees", "/v1/pendulum /v1/pendulums"},
    {"/v1/jobs", "/v1/tasks"},
    {"/openapi.json", "/v1/openapi.json /v1/swagger.json"},
};

/* objects, and fields that belong in them, at most API_NAME_PLACES in all */
static const struct {
    const char *place, *names;
} places[] = {
    {"pendulum", "arms length mass parent L m S gravity g damping pivot friction stiffness drag"},
    {"initial", "phi phid theta thetad phi0 phid0 theta0 omega0 amplitude unit"},
    {"times", "start stop count dt t0 t1 tmax t_end duration"},
    {"random", "seed draw"},
    {"body", "inertia center"},
};

/* names of header fields to use instead of a member */
static const struct {
    const char *name, *field;
} heads[] = {{"format", "Accept: text/csv"},
             {"accept", "Accept: text/csv"},
             {"async", "Prefer: respond-async"},
             {"job", "Prefer: respond-async"},
             {"wait", "Prefer: respond-async, wait=30"},
             {"title", "Job-Title: ..."},
             {"token", "Authorization: Bearer ..."}};

static int name_lower(char c) { return c >= 'A' && c <= 'Z' ? c + 32 : (unsigned char)c; }

/* the edit distance of a and b, counting a swap of neighbours once; case is ignored */
static int name_edits(const char *a, const char *b) {
    int rows[3][NAME_BYTES + 1], *before = rows[0], *last = rows[1], *now = rows[2];
    int m = (int)strlen(a), n = (int)strlen(b);
    assert(m <= NAME_BYTES && n <= NAME_BYTES);
    for (int j = 0; j <= n; j++) last[j] = j;
    for (int i = 1; i <= m; i++) {
        now[0] = i;
        for (int j = 1; j <= n; j++) {
            int differ = name_lower(a[i - 1]) != name_lower(b[j - 1]);
            int least = last[j] < now[j - 1] ? last[j] + 1 : now[j - 1] + 1;
            now[j] = least < last[j - 1] + differ ? least : last[j - 1] + differ;
            int swap = i > 1 && j > 1 && name_lower(a[i - 1]) == name_lower(b[j - 2]) &&
                       name_lower(a[i - 2]) == name_lower(b[j - 1]);
            if (swap && before[j - 2] + 1 < now[j]) now[j] = before[j - 2] + 1;
        }
        int *spare = before;
        before = last;
        last = now;
        now = spare;
    }
    return last[n];
}

const char *api_name_nearest(const char *name, const char *const allowed[]) {
    const char *nearest = NULL;
    int least = NEAR_EDITS + 1;
    if (strlen(name) > NAME_BYTES) return NULL;
    for (int i = 0; allowed[i]; i++) {
        if (strlen(allowed[i]) > NAME_BYTES) continue;
        int edits = name_edits(name, allowed[i]);
        if (edits >= least || (edits && edits >= (int)strlen(allowed[i]))) continue;
        least = edits;
        nearest = allowed[i];
    }
    return nearest;
}

/* the allowed name that equals `name`, or NULL */
static const char *name_among(const char *name, const char *const allowed[]) {
    for (int i = 0; allowed[i]; i++)
        if (!strcmp(name, allowed[i])) return allowed[i];
    return NULL;
}

/* true if `same` accepts the name with a word of the list */
static int name_listed(const char *name, const char *list,
                       int (*same)(const char *, const char *, size_t)) {
    size_t bytes = strlen(name);
    for (; *list; list += strspn(list, " ")) {
        size_t word = strcspn(list, " ");
        if (word == bytes && !same(list, name, bytes)) return 1;
        list += word;
    }
    return 0;
}

const char *api_did_you_mean(const char *name, const char *const allowed[]) {
    for (int i = 0; allowed[i]; i++)
        if (!strcasecmp(name, allowed[i])) return allowed[i];
    for (size_t i = 0; i < sizeof other_words / sizeof *other_words; i++) {
        if (!name_listed(name, other_words[i].words, strncasecmp)) continue;
        const char *meant = name_among(other_words[i].meant, allowed);
        if (meant) return meant;
    }
    return api_name_nearest(name, allowed);
}

const char *api_name_place(const char *name, const char *const allowed[]) {
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (name_listed(name, places[i].names, strncmp))
            return name_among(places[i].place, allowed);
    return NULL;
}

int api_name_outer(const char *name) {
    static const char *const outer[] = {
        "initial", "times", "method", "rtol", "atol",   "output", "duration",    "state", "theta",
        "thetad",  "phi",   "phid",   "unit", "theta0", "phi0",   "observables", NULL};
    return name_among(name, outer) != NULL;
}

const char *api_name_head(const char *name) {
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++)
        if (!strcasecmp(name, heads[i].name)) return heads[i].field;
    return NULL;
}
