#include "api/json/did_you_mean.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

enum { NAME_BYTES = 64, NEAR_EDITS = 2 };

/* Other names of fields, methods, outputs and units, from other programs and papers. Of several
 * rows with the same word the first allowed one counts. */
static const struct {
    const char *word, *meant;
} other_words[] = {
    /* parts of a request */
    {"tree", "pendulum"},
    {"system", "pendulum"},
    {"model", "pendulum"},
    {"state", "initial"},
    {"initial_state", "initial"},
    {"initial_conditions", "initial"},
    {"y0", "initial"},
    {"x0", "initial"},
    {"t", "times"},
    {"time", "duration"},
    {"time", "times"},
    {"tspan", "times"},
    {"t_span", "times"},
    {"t_eval", "times"},
    {"solver", "method"},
    {"integrator", "method"},
    {"algorithm", "method"},
    {"tol", "rtol"},
    {"tolerance", "rtol"},
    {"reltol", "rtol"},
    {"abstol", "atol"},
    {"h", "step"},
    {"ic", "initial"},
    {"init", "initial"},
    {"initial", "state"},
    {"times", "duration"},
    {"t_end", "duration"},
    {"tmax", "duration"},
    {"stop", "duration"},
    {"dtype", "number"},
    {"language", "form"},
    {"lang", "form"},
    /* members */
    {"parameter", "vary"},
    {"param", "vary"},
    {"variable", "vary"},
    {"quantity", "vary"},
    {"min", "low"},
    {"max", "high"},
    {"std", "deviation"},
    {"stddev", "deviation"},
    {"sigma", "deviation"},
    {"mu", "mean"},
    {"gaussian", "normal"},
    {"gauss", "normal"},
    {"max_lambda", "lambda_max"},
    {"min_lambda", "lambda_min"},
    /* a pendulum */
    {"l", "L"},
    {"l", "length"},
    {"lengths", "length"},
    {"radius", "length"},
    {"m", "mass"},
    {"masses", "mass"},
    {"weight", "mass"},
    {"g", "gravity"},
    {"grav", "gravity"},
    {"parents", "parent"},
    {"id", "name"},
    {"label", "name"},
    {"links", "arms"},
    {"bars", "arms"},
    {"path", "S"},
    {"b", "damping"},
    {"c", "damping"},
    {"k", "stiffness"},
    {"spring", "stiffness"},
    {"springs", "stiffness"},
    {"mass_matrix", "M"},
    /* instants */
    {"dt", "step"},
    {"by", "step"},
    {"interval", "step"},
    {"step", "count"},
    {"steps", "count"},
    {"n", "count"},
    {"num", "count"},
    {"points", "count"},
    {"samples", "count"},
    {"from", "start"},
    {"min", "start"},
    {"max", "stop"},
    {"t0", "start"},
    {"to", "stop"},
    {"end", "stop"},
    {"t1", "stop"},
    {"tmax", "stop"},
    {"t_max", "stop"},
    {"duration", "stop"},
    /* states and outputs: of a tip first, where both are there */
    {"position", "z"},
    {"positions", "z"},
    {"x", "z"},
    {"y", "z"},
    {"xy", "z"},
    {"velocity", "zd"},
    {"velocities", "zd"},
    {"velocity", "thetad"},
    {"velocities", "thetad"},
    {"angle", "theta"},
    {"angles", "theta"},
    {"theta0", "theta"},
    {"omega", "thetad"},
    {"theta_dot", "thetad"},
    {"thetadot", "thetad"},
    {"dtheta", "thetad"},
    {"phi_dot", "phid"},
    {"phidot", "phid"},
    {"dphi", "phid"},
    {"acceleration", "phidd"},
    {"accelerations", "phidd"},
    {"tension", "lambda"},
    {"force", "lambda"},
    {"forces", "lambda"},
    {"energies", "energy"},
    {"E", "energy"},
    {"degree", "deg"},
    {"degrees", "deg"},
    {"radian", "rad"},
    {"radians", "rad"},
    /* methods and precisions */
    {"ode45", "rkf45"},
    {"rk45", "rkf45"},
    {"rk4", "rkf45"},
    {"dopri5", "rkf45"},
    {"dop853", "rk8pd"},
    {"ode89", "rk8pd"},
    {"ode113", "msadams"},
    {"lsoda", "msadams"},
    {"odeint", "msadams"},
    {"adams", "msadams"},
    {"rk23", "ode23"},
    {"verlet", "symplectic"},
    {"leapfrog", "symplectic"},
    {"radau5", "radau"},
    {"ode15s", "radau"},
    {"float", "double"},
    {"float64", "double"},
    {"float128", "extended"},
    /* routes */
    {"/v1/trajectory", "/v1/trajectories"},
    {"/v1/simulate", "/v1/trajectories"},
    {"/v1/simulation", "/v1/trajectories"},
    {"/v1/simulations", "/v1/trajectories"},
    {"/v1/integrate", "/v1/trajectories"},
    {"/v1/solve", "/v1/trajectories"},
    {"/v1/run", "/v1/trajectories"},
    {"/v1/motion", "/v1/trajectories"},
    {"/v1/frequencies", "/v1/modes"},
    {"/v1/eigenmodes", "/v1/modes"},
    {"/v1/eigenvalues", "/v1/modes"},
    {"/v1/energy", "/v1/forces"},
    {"/v1/accelerations", "/v1/forces"},
    {"/v1/poincare", "/v1/sections"},
    {"/v1/exponents", "/v1/lyapunov"},
    {"/v1/map", "/v1/ensembles"},
    {"/v1/sweep", "/v1/ensembles"},
    {"/v1/batch", "/v1/ensembles"},
    {"/v1/pendulum", "/v1/trees"},
    {"/v1/pendulums", "/v1/trees"},
    {"/v1/tasks", "/v1/jobs"},
    {"/v1/openapi.json", "/openapi.json"},
    {"/v1/swagger.json", "/openapi.json"},
};

/* fields and the object that contains them */
static const struct {
    const char *name, *place;
} places[] = {
    {"arms", "pendulum"},      {"length", "pendulum"},   {"mass", "pendulum"},
    {"parent", "pendulum"},    {"L", "pendulum"},        {"m", "pendulum"},
    {"S", "pendulum"},         {"gravity", "pendulum"},  {"g", "pendulum"},
    {"damping", "pendulum"},   {"pivot", "pendulum"},    {"friction", "pendulum"},
    {"stiffness", "pendulum"}, {"drag", "pendulum"},     {"phi", "initial"},
    {"phid", "initial"},       {"theta", "initial"},     {"thetad", "initial"},
    {"phi0", "initial"},       {"phid0", "initial"},     {"theta0", "initial"},
    {"omega0", "initial"},     {"amplitude", "initial"}, {"unit", "initial"},
    {"start", "times"},        {"stop", "times"},        {"count", "times"},
    {"dt", "times"},           {"t0", "times"},          {"t1", "times"},
    {"tmax", "times"},         {"t_end", "times"},       {"duration", "times"},
    {"seed", "random"},        {"draw", "random"},
};

/* words for what belongs in a header field */
static const struct {
    const char *name, *field;
} heads[] = {{"format", "Accept: text/csv"},
             {"accept", "Accept: text/csv"},
             {"async", "Prefer: respond-async"},
             {"job", "Prefer: respond-async"},
             {"wait", "Prefer: respond-async, wait=30"},
             {"title", "Job-Title: ..."},
             {"token", "Authorization: Bearer ..."}};

static_assert(sizeof places / sizeof *places <= API_NAME_PLACES, "all of them fit a list");

static int name_lower(char c) { return c >= 'A' && c <= 'Z' ? c + 32 : (unsigned char)c; }

static int least_of_three(int a, int b, int c) {
    int least = a < b ? a : b;
    return least < c ? least : c;
}

/* the edit distance of a and b, transpositions of neighbours included; case is ignored */
static int name_edits(const char *a, const char *b) {
    int rows[3][NAME_BYTES + 1], *before = rows[0], *last = rows[1], *now = rows[2];
    int m = (int)strlen(a), n = (int)strlen(b);
    assert(m <= NAME_BYTES && n <= NAME_BYTES);
    for (int j = 0; j <= n; j++) last[j] = j;
    for (int i = 1; i <= m; i++) {
        now[0] = i;
        for (int j = 1; j <= n; j++) {
            int differ = name_lower(a[i - 1]) != name_lower(b[j - 1]);
            now[j] = least_of_three(last[j] + 1, now[j - 1] + 1, last[j - 1] + differ);
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

const char *api_did_you_mean(const char *name, const char *const allowed[]) {
    for (int i = 0; allowed[i]; i++)
        if (!strcasecmp(name, allowed[i])) return allowed[i];
    for (size_t i = 0; i < sizeof other_words / sizeof *other_words; i++) {
        if (strcasecmp(name, other_words[i].word)) continue;
        const char *meant = name_among(other_words[i].meant, allowed);
        if (meant) return meant;
    }
    return api_name_nearest(name, allowed);
}

const char *api_name_place(const char *name, const char *const allowed[]) {
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (!strcmp(name, places[i].name)) return name_among(places[i].place, allowed);
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
