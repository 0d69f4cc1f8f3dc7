#include "api/json/name_meant.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

enum { NAME_BYTES = 64, NEAR_EDITS = 2 };

/* what other programs, papers and people call a field, a method, an output or a unit; of several
 * rows of a word the first that is allowed counts */
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
    /* a pendulum */
    {"l", "L"},
    {"l", "length"},
    {"lengths", "length"},
    {"radius", "length"},
    {"m", "mass"},
    {"masses", "mass"},
    {"weight", "mass"},
    {"g", "gravity"},
    {"parents", "parent"},
    {"id", "name"},
    {"label", "name"},
    {"links", "arms"},
    {"bars", "arms"},
    {"path", "S"},
    {"b", "damping"},
    {"c", "damping"},
    {"k", "stiffness"},
    /* instants */
    {"dt", "step"},
    {"steps", "count"},
    {"n", "count"},
    {"num", "count"},
    {"points", "count"},
    {"samples", "count"},
    {"from", "start"},
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
    {"radau", "taylor"},
    {"ode15s", "taylor"},
    {"float", "double"},
    {"float64", "double"},
    {"float128", "quad"},
};

/* fields, and the object that they stand in */
static const struct {
    const char *name, *place;
} places[] = {
    {"arms", "pendulum"}, {"length", "pendulum"},  {"mass", "pendulum"},  {"parent", "pendulum"},
    {"L", "pendulum"},    {"m", "pendulum"},       {"S", "pendulum"},     {"gravity", "pendulum"},
    {"g", "pendulum"},    {"damping", "pendulum"}, {"pivot", "pendulum"}, {"phi", "initial"},
    {"phid", "initial"},  {"theta", "initial"},    {"thetad", "initial"}, {"phi0", "initial"},
    {"phid0", "initial"}, {"theta0", "initial"},   {"omega0", "initial"}, {"amplitude", "initial"},
    {"unit", "initial"},  {"start", "times"},      {"stop", "times"},     {"count", "times"},
    {"dt", "times"},      {"t0", "times"},         {"t1", "times"},       {"tmax", "times"},
};

_Static_assert(sizeof places / sizeof *places <= API_NAME_PLACES, "all of them fit a list");

static int name_lower(char c) { return c >= 'A' && c <= 'Z' ? c + 32 : (unsigned char)c; }

static int least_of_three(int a, int b, int c) {
    int least = a < b ? a : b;
    return least < c ? least : c;
}

/* insertions, deletions, replacements and swaps of neighbours that turn a into b; upper case
 * counts as lower */
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

/* the same name among those allowed, or NULL */
static const char *name_among(const char *name, const char *const allowed[]) {
    for (int i = 0; allowed[i]; i++)
        if (!strcmp(name, allowed[i])) return allowed[i];
    return NULL;
}

const char *api_name_meant(const char *name, const char *const allowed[]) {
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
