#include "api/op/equations/equations.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "api/op/equations/equations_text.h"
#include "api/op/equations/template.h"
#include "api/op/terms_write.h"
#include "api/read/terms_fields.h"
#include "core/tree/rules.h"

enum {
    EQUATIONS_LISTED = 20,   /* maximum number of arms whose matrices and lists of formulas are
                              * written in full */
    EQUATIONS_LEFT_OUT = 10, /* numbers shown at the start of a longer list */
    EQUATIONS_LINE = 10,     /* numbers per line of a program */
    EQUATIONS_MATRIX = 10,   /* maximum number of columns of pmatrix in amsmath */
    EQUATIONS_SHORT = 2      /* maximum number of arms for which a row of (aaa) fits on a line */
};

enum index { ROW, COLUMN, HARMONIC, RULE, NOTHING };

struct form {
    const char *text, *comma, *wrap; /* the template; separator of numbers; line break */
    int joined, latex;
};
static const struct form forms[] = {
    [API_EQUATIONS_LATEX] = {api_equations_latex, ",\\,", "", 1, 1},
    [API_EQUATIONS_MATLAB] = {api_equations_matlab, "; ", " ...\n     ", 0, 0},
    [API_EQUATIONS_PYTHON] = {api_equations_python, ", ", "\n    ", 0, 0},
    [API_EQUATIONS_CURL] = {api_equations_curl, ",", "", 1, 0}};

struct place {
    const struct api_equations *equations;
    const struct pend_tree *tree;
    const struct pend_terms *terms; /* NULL = an ideal pendulum */
    const double *value;
    const struct form *form;
    int at[NOTHING]; /* the caller's arm of the row and of the column; harmonic, rule; -1 = none */
    int first;       /* whether the innermost loop is in its first iteration */
    int k, arg;      /* the current iteration, or index in a list; the name's argument */
};

struct name {
    const char *name;
    int (*count)(const struct place *p);     /* number of iterations of a section, or of numbers in
                                              * a list; NULL = 1 */
    enum index index;                        /* the index over which `count` counts */
    int (*holds)(const struct place *p);     /* returns whether iteration k is included; NULL =
                                              * always */
    double (*number)(const struct place *p); /* returns number k; NULL = the name is a section */
    int arg;
};

/* --- counts and conditions --- */

static int arms(const struct place *p) { return p->equations->tree->n; }
static int masses(const struct place *p) {
    return 3 * arms(p);
} /* counts the inertias of tips, rods and bodies */
static int harmonics(const struct place *p) { return p->terms ? p->terms->harmonics : 0; }
static int is_real(const struct place *p) { return p->terms != NULL; }
static int is_first(const struct place *p) { return p->first; }
static int is_explicit(const struct place *p) { return p->equations->is_explicit; }
static int is_several(const struct place *p) { return arms(p) > 1; }
static int is_listed(const struct place *p) { return arms(p) <= EQUATIONS_LISTED; }
static int is_narrow(const struct place *p) { return arms(p) <= EQUATIONS_MATRIX; }
static int is_short(const struct place *p) { return arms(p) <= EQUATIONS_SHORT; }
static int is_hung(const struct place *p) { return p->terms->hung[p->tree->place[p->at[ROW]]]; }
static int on_cart(const struct place *p) { return pend_terms_cart(p->terms); }

/* whether some arm, or a cart, has a number of this row */
static int has(const struct place *p, enum pend_term_row row) {
    int there = p->terms && p->terms->row[row] >= 0, has = there && !on_cart(p);
    for (int k = 1; there && k < p->terms->n && !has; k++)
        has = p->value[p->terms->row[row] + k] != 0;
    return has;
}

/* whether harmonic k drives a torque; otherwise it drives the pivot or the cart, which come
 * first */
static int drives_torque(const struct place *p, int k) {
    return p->terms->harmonic[k].drives >= on_cart(p);
}
static int of_torque(const struct place *p) { return drives_torque(p, p->k); }
static int of_pivot(const struct place *p) { return !drives_torque(p, p->k); }
static int of_row(const struct place *p) {
    return p->terms->harmonic[p->k].drives == p->tree->place[p->at[ROW]];
}

static int has_drives(const struct place *p) {
    return harmonics(p) > 0 && drives_torque(p, harmonics(p) - 1);
}
static int is_tracked(const struct place *p) {
    return p->terms && p->terms->one[PEND_TERM_PIVOT_TRACK] >= 0;
}
static int has_pivot(const struct place *p) {
    return p->terms && !on_cart(p) &&
           (p->terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0 || is_tracked(p) ||
            (harmonics(p) > 0 && !drives_torque(p, 0)));
}
static int moves(const struct place *p) { return has_pivot(p) || on_cart(p); }
static int has_drag_per_mass(const struct place *p) {
    return p->terms && p->terms->one[PEND_TERM_DRAG_PER_MASS] >= 0;
}
static int has_air(const struct place *p) {
    return has(p, PEND_TERM_DRAG) || has(p, PEND_TERM_DRAG_QUADRATIC);
}
static int is_ruled(const struct place *p) { return p->terms && p->terms->rules; }
static int is_controlled(const struct place *p) {
    return is_ruled(p) && p->terms->rules->controllers;
}
static int has_motor(const struct place *p) {
    return has(p, PEND_TERM_TORQUE) || has_drives(p) || is_ruled(p);
}
static int has_joints(const struct place *p) {
    return has(p, PEND_TERM_DAMPING) || has(p, PEND_TERM_STIFFNESS) || has(p, PEND_TERM_FRICTION) ||
           has_motor(p);
}

/* whether arm i is on the path from the pivot to the tip of arm k, including k */
static int carries(const struct place *p, int i, int k) {
    const int *place = p->tree->place;
    return place[i] <= place[k] && place[k] < p->tree->end[place[i]];
}
/* whether one arm is in the other's sub-tree: S^T diag(m) S is 0 elsewhere */
static int are_related(const struct place *p, int i, int k) {
    return carries(p, i, k) || carries(p, k, i);
}
static int on_path(const struct place *p) { return carries(p, p->k, p->at[ROW]); }
static int related(const struct place *p) { return are_related(p, p->at[ROW], p->k); }
static int others(const struct place *p) { return p->k != p->at[ROW] && related(p); }
static int is_diagonal(const struct place *p) { return p->at[ROW] == p->at[COLUMN]; }
static int is_related(const struct place *p) { return are_related(p, p->at[ROW], p->at[COLUMN]); }
static int is_other(const struct place *p) { return !is_diagonal(p) && is_related(p); }

/* --- numbers --- */

static double of_arm(const struct place *p, enum pend_term_row row, int i) {
    return pend_terms_get(p->terms, p->value, row, p->tree->place[i]);
}
static double length_of(const struct place *p, int i) { return p->tree->len[p->tree->place[i]]; }
static double mass_of(const struct place *p, int i) { return p->tree->mass[p->tree->place[i]]; }

static double from_1(const struct place *p) { return p->k + 1; }
static double length(const struct place *p) { return length_of(p, p->k); }
static double mass(const struct place *p) { return mass_of(p, p->k); }
static double parent(const struct place *p) {
    return api_tree_parent(p->equations->tree, p->k) + 1;
}
static double phi(const struct place *p) { return p->equations->phi[p->tree->place[p->k]]; }
static double rate(const struct place *p) { return p->equations->rate[p->tree->place[p->k]]; }
static double of_term(const struct place *p) { return of_arm(p, (enum pend_term_row)p->arg, p->k); }

static double inertia(const struct place *p) {
    double l = length(p);
    return of_arm(p, PEND_TERM_ROD, p->k) * l * l / 12 + of_arm(p, PEND_TERM_INERTIA, p->k);
}

/* coordinates of the attachment point of arm k on its parent, and whether it is the tip */
enum { HANG_X, HANG_Y, HANG_TIP };
static double hang(const struct place *p) {
    int above = api_tree_parent(p->equations->tree, p->k);
    int hung = above >= 0 && p->terms->hung[p->tree->place[p->k]];
    if (p->arg == HANG_TIP) return above >= 0 && !hung;
    if (hung) return of_arm(p, p->arg == HANG_X ? PEND_TERM_AT_X : PEND_TERM_AT_Y, p->k);
    return above < 0 || p->arg == HANG_Y ? 0 : length_of(p, above);
}

/* properties of a mass; the masses are those of the tips, then rods, then bodies */
enum { MASS_ARM, MASS_X, MASS_Y, MASS_KG };
static double mass_part(const struct place *p, int part) {
    int i = p->k % arms(p), kind = p->k / arms(p);
    if (part == MASS_ARM) return i + 1;
    if (part == MASS_Y) return kind < 2 ? 0 : of_arm(p, PEND_TERM_CENTER_Y, i);
    if (kind == 0) return part == MASS_X ? length_of(p, i) : mass_of(p, i);
    if (kind == 1) return part == MASS_X ? length_of(p, i) / 2 : of_arm(p, PEND_TERM_ROD, i);
    return of_arm(p, part == MASS_X ? PEND_TERM_CENTER_X : PEND_TERM_BODY, i);
}
static double of_mass(const struct place *p) { return mass_part(p, p->arg); }
static int is_mass(const struct place *p) { return p->k < arms(p) || mass_part(p, MASS_KG) > 0; }

/* the parts of a harmonic: amplitude, omega, phase */
static double wave(const struct place *p) { return p->value[p->terms->harmonic[p->k].at + p->arg]; }
/* the caller's number of the driven arm; for the pivot 1 = upwards */
static double driven(const struct place *p) {
    int drives = p->terms->harmonic[p->k].drives;
    return drives < 0 ? drives == PEND_DRIVE_PIVOT_Y : p->tree->order[drives] + 1;
}

static double number_of_arms(const struct place *p) { return arms(p); }
static double gravity(const struct place *p) { return p->equations->tree->loads.gravity; }
static double of_whole(const struct place *p) {
    return p->terms->one[p->arg] < 0 ? 0 : p->value[p->terms->one[p->arg]];
}
static double of_cart(const struct place *p) {
    return pend_terms_get(p->terms, p->value, (enum pend_term_row)p->arg, 0);
}
static double cart_mass(const struct place *p) { return p->tree->mass[0]; }
static double cart_x(const struct place *p) { return p->equations->phi[0]; }
static double cart_v(const struct place *p) { return p->equations->rate[0]; }

/* the tables of inputs: for arm 1 .. n, n + 1 = a cart, -1 and -2 = x and y of the pivot */
enum { TABLE_ARM, TABLE_LINEAR, TABLE_ZERO, TABLE_TRACK };
static int tables(const struct place *p) { return is_ruled(p) ? p->terms->rules->tables : 0; }
static const struct pend_table *table_of(const struct place *p) {
    return p->terms->rules->table + p->at[RULE];
}
static int instants(const struct place *p) { return table_of(p)->count; }
static double instant(const struct place *p) { return table_of(p)->t[p->k]; }
static double input(const struct place *p) { return table_of(p)->value[p->k]; }
static double of_table(const struct place *p) {
    const struct pend_table *table = table_of(p);
    const int track = table->drives < 0, zero = table->outside == PEND_OUTSIDE_ZERO,
              arm = track ? table->drives : p->tree->order[table->drives] + 1;
    return (int[]){arm, table->linear, zero, track}[p->arg];
}

/* rules: the tables; friction and stop of each arm; the controllers */
static int rules(const struct place *p) {
    return is_ruled(p) ? tables(p) + 2 * p->terms->n + p->terms->rules->controllers : 0;
}
static int is_rule(const struct place *p) {
    const struct pend_rules *all = p->terms->rules;
    int joint = p->k - all->tables, k = joint % p->terms->n;
    if (joint < 0 || joint >= 2 * p->terms->n) return 1;
    if (joint < p->terms->n) return all->holding && all->holding[k] > 0;
    return all->least && (isfinite(all->least[k]) || isfinite(all->most[k]));
}

/* entries of S, and of B = S^-T */
static double entry_of_s(const struct place *p) { return carries(p, p->at[COLUMN], p->at[ROW]); }
static double entry_of_b(const struct place *p) {
    if (is_diagonal(p)) return 1;
    return api_tree_parent(p->equations->tree, p->at[COLUMN]) == p->at[ROW] ? -1 : 0;
}
static double low(const struct place *p) {
    return 1 + (p->at[ROW] < p->at[COLUMN] ? p->at[ROW] : p->at[COLUMN]);
}
static double high(const struct place *p) {
    return 1 + (p->at[ROW] < p->at[COLUMN] ? p->at[COLUMN] : p->at[ROW]);
}

static const struct name names[] = {
    // the most frequent names come first
    {"i", arms, ROW, NULL, from_1, 0},
    {"j", arms, COLUMN, NULL, from_1, 0},
    // conditions and loops
    {"first", is_first, NOTHING, NULL, NULL, 0},
    {"explicit", is_explicit, NOTHING, NULL, NULL, 0},
    {"real", is_real, NOTHING, NULL, NULL, 0},
    {"several", is_several, NOTHING, NULL, NULL, 0},
    {"listed", is_listed, NOTHING, NULL, NULL, 0},
    {"narrow", is_narrow, NOTHING, NULL, NULL, 0},
    {"short", is_short, NOTHING, NULL, NULL, 0},
    {"hung", is_hung, NOTHING, NULL, NULL, 0},
    {"cart", on_cart, NOTHING, NULL, NULL, 0},
    {"pivot", has_pivot, NOTHING, NULL, NULL, 0},
    {"moves", moves, NOTHING, NULL, NULL, 0},
    {"drives", has_drives, NOTHING, NULL, NULL, 0},
    {"motor", has_motor, NOTHING, NULL, NULL, 0},
    {"joints", has_joints, NOTHING, NULL, NULL, 0},
    {"air", has_air, NOTHING, NULL, NULL, 0},
    {"drag_per_mass", has_drag_per_mass, NOTHING, NULL, NULL, 0},
    {"diagonal", is_diagonal, NOTHING, NULL, NULL, 0},
    {"is_related", is_related, NOTHING, NULL, NULL, 0},
    {"is_other", is_other, NOTHING, NULL, NULL, 0},
    {"rows", arms, ROW, NULL, NULL, 0},
    {"columns", arms, COLUMN, NULL, NULL, 0},
    {"path", arms, COLUMN, on_path, NULL, 0},
    {"related", arms, COLUMN, related, NULL, 0},
    {"others", arms, COLUMN, others, NULL, 0},
    {"ruled", is_ruled, NOTHING, NULL, NULL, 0},
    {"controlled", is_controlled, NOTHING, NULL, NULL, 0},
    {"tracked", is_tracked, NOTHING, NULL, NULL, 0},
    {"tables", tables, RULE, NULL, NULL, 0},
    {"rule", rules, RULE, is_rule, NULL, 0},
    {"driving", harmonics, HARMONIC, of_row, NULL, 0},
    {"moving", harmonics, HARMONIC, of_pivot, NULL, 0},
    // numbers: a list, or in a loop over it the current number
    {"n", NULL, NOTHING, NULL, number_of_arms, 0},
    {"gravity", NULL, NOTHING, NULL, gravity, 0},
    {"low", NULL, NOTHING, NULL, low, 0},
    {"high", NULL, NOTHING, NULL, high, 0},
    {"entry_of_S", NULL, NOTHING, NULL, entry_of_s, 0},
    {"entry_of_B", NULL, NOTHING, NULL, entry_of_b, 0},
    {"length", arms, ROW, NULL, length, 0},
    {"mass", arms, ROW, NULL, mass, 0},
    {"parent", arms, ROW, NULL, parent, 0},
    {"phi", arms, ROW, NULL, phi, 0},
    {"phid", arms, ROW, NULL, rate, 0},
    {"inertias", arms, ROW, NULL, inertia, 0},
    {"hang_x", arms, ROW, NULL, hang, HANG_X},
    {"hang_y", arms, ROW, NULL, hang, HANG_Y},
    {"at_tip", arms, ROW, NULL, hang, HANG_TIP},
    {"on", masses, NOTHING, is_mass, of_mass, MASS_ARM},
    {"place_x", masses, NOTHING, is_mass, of_mass, MASS_X},
    {"place_y", masses, NOTHING, is_mass, of_mass, MASS_Y},
    {"masses", masses, NOTHING, is_mass, of_mass, MASS_KG},
    {"amplitude", harmonics, HARMONIC, of_torque, wave, 0},
    {"omega", harmonics, HARMONIC, of_torque, wave, 1},
    {"phase", harmonics, HARMONIC, of_torque, wave, 2},
    {"driven", harmonics, HARMONIC, of_torque, driven, 0},
    {"amplitude0", harmonics, HARMONIC, of_pivot, wave, 0},
    {"omega0", harmonics, HARMONIC, of_pivot, wave, 1},
    {"phase0", harmonics, HARMONIC, of_pivot, wave, 2},
    {"up", harmonics, HARMONIC, of_pivot, driven, 0},
    {"gamma", NULL, NOTHING, NULL, of_whole, PEND_TERM_DRAG_PER_MASS},
    {"pivot_x", NULL, NOTHING, NULL, of_whole, PEND_TERM_PIVOT_ACCELERATION_X},
    {"pivot_y", NULL, NOTHING, NULL, of_whole, PEND_TERM_PIVOT_ACCELERATION_Y},
    {"rail", NULL, NOTHING, NULL, of_whole, PEND_TERM_RAIL},
    {"cart_mass", NULL, NOTHING, NULL, cart_mass, 0},
    {"cart_damping", NULL, NOTHING, NULL, of_cart, PEND_TERM_DAMPING},
    {"cart_stiffness", NULL, NOTHING, NULL, of_cart, PEND_TERM_STIFFNESS},
    {"cart_force", NULL, NOTHING, NULL, of_cart, PEND_TERM_TORQUE},
    {"cart_x", NULL, NOTHING, NULL, cart_x, 0},
    {"cart_v", NULL, NOTHING, NULL, cart_v, 0},
    {"table_t", instants, NOTHING, NULL, instant, 0},
    {"table_value", instants, NOTHING, NULL, input, 0},
    {"table_arm", NULL, NOTHING, NULL, of_table, TABLE_ARM},
    {"table_linear", NULL, NOTHING, NULL, of_table, TABLE_LINEAR},
    {"table_zero", NULL, NOTHING, NULL, of_table, TABLE_ZERO},
    {"table_track", NULL, NOTHING, NULL, of_table, TABLE_TRACK},
};

static int is_name(const char *name, const char *wanted, int length) {
    return *name == *wanted && strncmp(name, wanted, (size_t)length) == 0 && !name[length];
}

/* finds a name in the table, or among the names of arms' numbers in ensembles */
static struct name name_find(const char *wanted, int length) {
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (is_name(names[i].name, wanted, length)) return names[i];
    for (int row = 0; row < PEND_TERM_OWN_ROWS; row++)
        if (is_name(api_terms_varied((enum pend_term_row)row), wanted, length))
            return (struct name){"", arms, ROW, NULL, of_term, row};
    assert(!"a template names existing values");
    return names[0];
}

/* whether a list is written as one number: inside its loop, or if it has a single entry */
static int name_single(const struct place *p, const struct name *name) {
    return !name->count || (name->index != NOTHING && p->at[name->index] >= 0);
}

static double name_number(struct place *p, const struct name *name, int k) {
    p->k = k, p->arg = name->arg;
    return name->number(p);
}

static double name_one(struct place *p, const struct name *name) {
    return name_number(p, name, name->count ? p->at[name->index] : 0);
}

/* --- functions of templates --- */

static int equations_next(void *context, const char *wanted, int length, int round) {
    struct place *p = context;
    struct name name = name_find(wanted, length);
    if (name.number) {
        int there =
            name_single(p, &name) ? name_one(p, &name) != 0 : has(p, (enum pend_term_row)name.arg);
        return round < 0 && there ? 0 : -1;
    }
    int count = name.count(p), first = round < 0;
    for (p->k = round + 1; name.holds && p->k < count && !name.holds(p);) p->k++;
    round = p->k < count ? p->k : -1;
    if (name.index != NOTHING) p->at[name.index] = round, p->first = first;
    return round;
}

static enum pend_status write_number(const struct place *p, double number, struct api_buffer *out) {
    PEND_TRY(api_buffer_room(out, API_NUMBER_BYTES));
    char *at = out->data + out->bytes, *end = api_number_write(at, number), *exponent = at;
    while (exponent < end && (*exponent != 'e' || !p->form->latex)) exponent++;
    int power = 0, negative = exponent + 1 < end && exponent[1] == '-';
    for (char *digit = exponent + 1 + negative; digit < end; digit++)
        power = 10 * power + (*digit - '0');
    out->bytes = (size_t)(exponent - out->data);
    return exponent < end ? api_buffer_format(out, "\\cdot10^{%s%d}", negative ? "-" : "", power)
                          : PEND_OK;
}

/* writes the numbers and their separators; a formula shows only the first and last of a long
 * list */
static enum pend_status write_list(struct place *p, const struct name *name,
                                   struct api_buffer *out) {
    int count = name->count(p), written = 0;
    for (int k = 0; k < count; k++) {
        p->k = k;
        if (name->holds && !name->holds(p)) continue;
        if (written) PEND_TRY(api_buffer_text(out, p->form->comma));
        if (written && written % EQUATIONS_LINE == 0) PEND_TRY(api_buffer_text(out, p->form->wrap));
        if (p->form->latex && count > EQUATIONS_LISTED && written == EQUATIONS_LEFT_OUT) {
            PEND_TRY(api_buffer_text(out, "\\ldots,\\,"));
            k = count - 1;
        }
        PEND_TRY(write_number(p, name_number(p, name, k), out));
        written++;
    }
    return PEND_OK;
}

/* writes (m_{2}+m_{3}): the masses in the sub-tree of the deeper one of the row's and the column's
 * arm */
static enum pend_status write_masses(const struct place *p, struct api_buffer *out) {
    int i = p->at[ROW], j = p->at[COLUMN], arm = j >= 0 && carries(p, i, j) ? j : i;
    int place = p->tree->place[arm], many = p->tree->end[place] > place + 1, written = 0;
    if (many) PEND_TRY(api_buffer_text(out, "("));
    for (int k = 0; k < arms(p); k++)
        if (carries(p, arm, k))
            PEND_TRY(api_buffer_format(out, "%sm_{%d}", written++ ? "+" : "", k + 1));
    return many ? api_buffer_text(out, ")") : PEND_OK;
}

/* writes a rule in words, in characters that LaTeX, MATLAB and Python allow in texts */
static enum pend_status write_rule(const struct place *p, struct api_buffer *out) {
    static const char *const laws[] = {"-K (x - reference)",
                                       "p e + i (sum of e times the period) + d de/dt",
                                       "g (E* - E) r, near its reference the next law,"};
    const struct pend_rules *all = p->terms->rules;
    int n = p->terms->n, joint = p->at[RULE] - all->tables, c = joint - 2 * n;
    int k = joint < 0 ? table_of(p)->drives : c < 0 ? joint % n : all->controller[c].drives;
    if (k < 0 || (!k && on_cart(p)))
        PEND_TRY(api_buffer_text(out, k < 0 ? "the pivot: " : "the cart: "));
    else
        PEND_TRY(api_buffer_format(out, "arm %d: ", p->tree->order[k] + 1));
    if (joint < 0) {
        const struct pend_table *table = table_of(p);
        const char *way = k < 0           ? "on the natural cubic spline through them"
                          : table->linear ? "linear between two instants"
                                          : "each held until the next instant";
        return api_buffer_format(out, "a table of %d inputs from t = %.6g to %.6g s, %s",
                                 table->count, table->t[0], table->t[table->count - 1], way);
    }
    if (c >= 0) {
        const struct pend_controller *of = &all->controller[c];
        return api_buffer_format(
            out, "a controller holds for %.6g s each %s %d samples later, from %.6g to %.6g",
            of->period, laws[all->law[of->law].kind], of->delay, of->low, of->high);
    }
    if (joint < n)
        return api_buffer_format(out, "friction of %.6g in motion, up to %.6g at rest",
                                 all->sliding[k], all->holding[k]);
    return api_buffer_format(out, "a stop from %.6g to %.6g; an impact turns the rate r to -%.6g r",
                             all->least[k], all->most[k], all->restitution[k]);
}

/* expands a name: <<name>> is a number, a list or a text; <<+name>> is a number that follows others
 * in a sum */
static enum pend_status equations_name(void *context, const char *wanted, int length,
                                       struct api_buffer *out) {
    struct place *p = context;
    const struct pend_loads *loads = &p->equations->tree->loads;
    int sign = *wanted == '+';
    if (is_name("whole_terms", wanted, length)) return api_terms_write_whole(p->tree, loads, out);
    if (is_name("arm_terms", wanted, length))
        return api_terms_write_arm(loads, p->tree->place[p->at[ROW]], out);
    if (is_name("masses_of", wanted, length)) return write_masses(p, out);
    if (is_name("rule", wanted, length)) return write_rule(p, out);
    struct name name = name_find(wanted + sign, length - sign);
    if (!name_single(p, &name)) return write_list(p, &name, out);
    double number = name_one(p, &name);
    if (sign && number >= 0) PEND_TRY(api_buffer_text(out, "+"));
    return write_number(p, number, out);
}

const char *api_equations_formula(const struct api_tree *tree, int i) {
    static const char *const all[] = {"parameters", "S",   "B",     "z",    "M",
                                      "aaa",        "bbb", "loads", "rules"};
    assert(i >= 0);
    return i < (int)(sizeof all / sizeof *all) - !tree->terms - !tree->rules ? all[i] : NULL;
}

enum pend_status api_equations_write(const struct api_equations *equations,
                                     enum api_equations_form form, const char *formula,
                                     struct api_buffer *out) {
    const struct api_tree *tree = equations->tree;
    assert(pend_tree_valid(tree->tree) && (form == API_EQUATIONS_LATEX) == (formula != NULL));
    struct place place = {.equations = equations,
                          .tree = tree->tree,
                          .terms = tree->loads.terms,
                          .value = tree->loads.value,
                          .form = &forms[form],
                          .at = {-1, -1, -1, -1}};
    struct api_template template = {forms[form].text, forms[form].joined, &place, equations_next,
                                    equations_name};
    return api_template_fill(&template, formula, out);
}
