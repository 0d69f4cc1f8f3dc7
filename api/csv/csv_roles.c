#include "api/csv/csv_roles.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

static const double epoch_s = 1e8;   /* s: a larger number counts seconds since 1970 */
static const double epoch_ms = 1e11; /* ms: a larger number counts milliseconds since 1970 */
static const double step_ms = 5;     /* a larger step between rows means milliseconds */

const char *api_csv_role_name(enum api_csv_role role) {
    static const char *const names[] = {"",      "t",      "theta",  "phi",       "joint",
                                        "x",     "y",      "thetad", "amplitude", "period",
                                        "along", "across", "cart",   "sigma"};
    assert((unsigned)role < sizeof names / sizeof *names);
    return names[role];
}

struct guess {
    struct api_csv_roles *roles;
    const struct api_csv *csv;
    const struct api_csv_hints *hints;
    struct api_csv_words words[API_CSV_COLUMNS];
    int generic; /* whether columns are only named X and Y, as plotting programs do */
    int behind;  /* first column of a second table; the number of columns = none */
    int given[API_CSV_COLUMNS]; /* whether the request names this column */
};

static int of_table(const struct guess *guess, int i) {
    return i < guess->behind || guess->given[i];
}

static void leave(struct api_csv_taken *taken, const char *why) {
    taken->role = API_CSV_NONE, taken->why = why;
}

/* --- time --- */

static int is_time(const struct guess *guess, int i) {
    const struct api_csv_column *column = &guess->csv->column[i];
    int words = guess->words[i].words;
    if (guess->roles->column[i].why || guess->roles->column[i].role != API_CSV_NONE) return 0;
    if (column->clocks > column->numbers) return 1;
    return (words & API_CSV_WORD_TIME) && column->numbers &&
           !(words &
             (API_CSV_WORD_ERROR | API_CSV_WORD_MODEL | API_CSV_WORD_SPEED | API_CSV_WORD_PERIOD));
}

/* finds the column of times: the first one with such a name, else the first increasing one */
static int time_find(struct guess *guess) {
    const struct api_csv *csv = guess->csv;
    for (int given = 1; given >= 0; given--)
        for (int i = 0; i < csv->columns; i++)
            if (guess->given[i] == given && is_time(guess, i)) return i;
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_column *column = &csv->column[i];
        int words = guess->words[i].words, named = words & ~(API_CSV_WORD_X | API_CSV_WORD_OTHER);
        if (guess->given[i] || guess->roles->column[i].why) continue;
        if (!column->rises || column->low >= column->high || column->numbers < csv->rows) continue;
        if (words & API_CSV_WORD_FRAME) {
            leave(&guess->roles->column[i], "counts frames: add a column of times in s");
            continue;
        }
        if (named) continue;
        guess->generic = (words & API_CSV_WORD_X) != 0;
        return i;
    }
    return -1;
}

static void time_take(struct guess *guess, int i) {
    const struct api_csv_column *column = &guess->csv->column[i];
    struct api_csv_taken *taken = &guess->roles->column[i];
    double unit = guess->words[i].s;
    int named = is_time(guess, i);
    *taken = (struct api_csv_taken){API_CSV_TIME, 0, -1, unit ? unit : 1, named, NULL};
    if (!taken->sure) taken->why = "its numbers increase from row to row: read as the time";
    guess->roles->time = i;
    if (column->clocks > column->numbers) {
        taken->unit = 1, guess->roles->origin = column->first;
        taken->why = "a time of day: counted from the first row";
    } else if (!unit && column->low > epoch_ms) {
        taken->unit = 1e-3, guess->roles->origin = column->first * 1e-3, taken->sure = 0;
        taken->why = "milliseconds since 1970: counted from the first row";
    } else if (column->low > epoch_s && (!unit || unit == 1)) {
        guess->roles->origin = column->first, taken->sure = 0;
        taken->why = "seconds since 1970: counted from the first row";
    } else if (!unit && column->step >= step_ms && isfinite(column->step)) {
        taken->unit = 1e-3, taken->sure = 0;
        taken->why = "rows are 5 or more apart: read as milliseconds";
    }
}

/* --- what is measured --- */

int api_csv_is_angle(enum api_csv_role role) {
    return role == API_CSV_THETA || role == API_CSV_PHI || role == API_CSV_JOINT;
}

static enum api_csv_role role_of(const struct api_csv_words *words) {
    static const struct {
        enum api_csv_word word;
        enum api_csv_role role;
    } named[] = {{API_CSV_WORD_ALONG, API_CSV_ALONG},
                 {API_CSV_WORD_ACROSS, API_CSV_ACROSS},
                 {API_CSV_WORD_AMPLITUDE, API_CSV_AMPLITUDE},
                 {API_CSV_WORD_PERIOD, API_CSV_PERIOD},
                 {API_CSV_WORD_CART, API_CSV_CART},
                 {API_CSV_WORD_JOINT, API_CSV_JOINT},
                 {API_CSV_WORD_ANGLE, API_CSV_THETA},
                 {API_CSV_WORD_PHI, API_CSV_PHI},
                 {API_CSV_WORD_X, API_CSV_X},
                 {API_CSV_WORD_Y, API_CSV_Y}};
    int word = words->words;
    int turning = API_CSV_WORD_ANGLE | API_CSV_WORD_PHI;
    if ((word & API_CSV_WORD_RATE) || ((word & API_CSV_WORD_SPEED) && (word & turning)) ||
        (words->rad_s && !(word & API_CSV_WORD_OTHER)))
        return API_CSV_RATE;
    // "along_1 (m/s^2)" has the unit of another quantity
    int force = API_CSV_WORD_ALONG | API_CSV_WORD_ACROSS;
    if (!(word & force) && (word & (API_CSV_WORD_SPEED | API_CSV_WORD_OTHER | API_CSV_WORD_FRAME)))
        return API_CSV_NONE;
    for (size_t i = 0; i < sizeof named / sizeof *named; i++)
        if (word & named[i].word) return named[i].role;
    return words->rad ? API_CSV_THETA : API_CSV_NONE;
}

static int same_cell(const struct api_csv_cell *a, const struct api_csv_cell *b) {
    return a->bytes == b->bytes && (!a->bytes || !memcmp(a->at, b->at, (size_t)a->bytes));
}

/* 1-based position of this column's group among the groups of measured columns */
static int group_of(const struct guess *guess, int i) {
    const struct api_csv_column *column = guess->csv->column;
    int count = 1;
    for (int j = 0; j < i; j++) {
        int first = role_of(&guess->words[j]) != API_CSV_NONE && j != guess->roles->time;
        for (int k = 0; k < j && first; k++)
            first = role_of(&guess->words[k]) == API_CSV_NONE ||
                    !same_cell(&column[k].group, &column[j].group);
        if (first && same_cell(&column[j].group, &column[i].group)) return count;
        count += first;
    }
    return count;
}

/* true if the file counts arms from 0, so that the number 0 occurs */
static int from_zero(const struct guess *guess) {
    for (int i = 0; i < guess->behind; i++)
        if (guess->words[i].number == 0 && role_of(&guess->words[i]) != API_CSV_NONE) return 1;
    return 0;
}

/* returns the arm of a column, from 1; 0 if the pendulum has no such arm */
static int arm_of(struct guess *guess, int i, enum api_csv_role role, int seen[]) {
    static const struct api_csv_cell none = {"", 0};
    const struct api_csv_column *column = &guess->csv->column[i];
    int number = guess->words[i].number, arm,
        most = guess->hints->arms ? guess->hints->arms : API_CSV_COLUMNS;
    if (number >= 0) {
        arm = number + from_zero(guess);
    } else if (column->group.bytes && !guess->given[i]) {
        arm = api_csv_words_of(&column->group, &none).number;
        if (arm < 1) arm = group_of(guess, i);
    } else {
        arm = seen[role] + 1;
        int place = role == API_CSV_X || role == API_CSV_Y;
        seen[role] = arm;
        return place && arm <= guess->hints->count ? guess->hints->listed[arm - 1]
               : arm <= most                       ? arm
                                                   : 0;
    }
    seen[role] = arm > seen[role] ? arm : seen[role];
    return arm >= 1 && arm <= most ? arm : 0;
}

static int is_taken(const struct guess *guess, int i, enum api_csv_role role, int arm) {
    for (int j = 0; j < guess->csv->columns; j++)
        if (j != i && guess->roles->column[j].role == role && guess->roles->column[j].arm == arm)
            return 1;
    return 0;
}

/* returns the reason why a column cannot be used; NULL if it can */
static const char *column_unfit(const struct guess *guess, int i, enum api_csv_role role, int arm) {
    const struct api_csv_words *words = &guess->words[i];
    if (!guess->csv->column[i].numbers) return "has no number";
    if (words->words & API_CSV_WORD_MODEL) return "its name says model, not measurement";
    if (api_csv_is_angle(role) && (words->pixels || words->m || words->s))
        return "its unit is not a unit of angles";
    if (!arm) return "names no arm of this pendulum";
    if ((role == API_CSV_AMPLITUDE || role == API_CSV_PERIOD) && guess->hints->arms > 1)
        return "is measured only for a pendulum of one arm";
    if (role == API_CSV_CART && !guess->hints->cart) return "the pendulum has no cart";
    return is_taken(guess, i, role, arm) ? "another column has the same quantity of this arm"
                                         : NULL;
}

static void column_doubt(const struct guess *guess, int i) {
    struct api_csv_taken *taken = &guess->roles->column[i];
    int numbered = guess->words[i].number >= 0 || guess->csv->column[i].group.bytes;
    if (taken->role == API_CSV_PHI)
        taken->why =
            "phi is measured from the positive real axis; angles from the vertical are theta";
    if (guess->hints->arms > 1 && !numbered && !guess->hints->count)
        taken->sure = 0, taken->why = "its name has no arm number: arms are assigned in order";
    if (guess->generic)
        taken->why = "read as the angle from the vertical: the columns are only named x and y";
}

static void column_take(struct guess *guess, int i, int seen[]) {
    struct api_csv_taken *taken = &guess->roles->column[i];
    int words = guess->words[i].words;
    enum api_csv_role role = role_of(&guess->words[i]);
    if (taken->why || taken->role != API_CSV_NONE) return;
    // standard errors get their roles later, when the measured columns are known
    if (words & (API_CSV_WORD_ERROR | API_CSV_WORD_PRIME) || role == API_CSV_NONE) return;
    if (guess->generic && !guess->given[i]) role = API_CSV_THETA;
    int arm = words & API_CSV_WORD_MODEL ? 0 : arm_of(guess, i, role, seen);
    taken->why = column_unfit(guess, i, role, arm);
    if (taken->why) return;
    guess->roles->measured++;
    *taken = (struct api_csv_taken){role, arm, -1, 0, !guess->generic || guess->given[i], NULL};
    if (!guess->given[i]) column_doubt(guess, i);
}

/* of a gyroscope's axes, takes the one with the largest rates: the axis of the swing */
static void axes_take(struct guess *guess) {
    static const int axes = API_CSV_WORD_X | API_CSV_WORD_Y | API_CSV_WORD_OTHER;
    int best = -1, count = 0;
    double most = 0;
    for (int i = 0; i < guess->behind; i++) {
        const struct api_csv_column *column = &guess->csv->column[i];
        const struct api_csv_words *words = &guess->words[i];
        int axis = !guess->given[i] && role_of(words) == API_CSV_RATE && words->number < 0 &&
                   (words->words & axes) && column->numbers;
        if (!axis) continue;
        leave(&guess->roles->column[i], "another axis of the gyroscope has the larger rates");
        if (count++ && column->high - column->low <= most) continue;
        best = i, most = column->high - column->low;
    }
    if (best < 0) return;
    guess->roles->column[best].why = NULL;
}

/* drops rates, amplitudes and periods next to angles: programs compute them from the angles, so
 * they add no information */
static void rates_drop(struct guess *guess) {
    for (int i = 0; i < guess->csv->columns; i++) {
        struct api_csv_taken *taken = &guess->roles->column[i];
        int beside = 0;
        if (taken->role < API_CSV_RATE || taken->role > API_CSV_PERIOD || guess->given[i]) continue;
        for (int j = 0; j < guess->csv->columns; j++) {
            const struct api_csv_taken *other = &guess->roles->column[j];
            beside |= other->arm == taken->arm && other->role >= API_CSV_THETA &&
                      other->role <= API_CSV_Y;
        }
        if (!beside) continue;
        leave(taken, "programs often compute this from the angle, which is in the table: name it "
                     "in \"columns\" if it was measured separately");
        taken->arm = 0, taken->sure = 1, guess->roles->measured--;
    }
}

/* assigns columns without names: one angle per arm, or positions of the tips */
static void unnamed_take(struct guess *guess) {
    const struct api_csv *csv = guess->csv;
    int column[API_CSV_COLUMNS], count = 0;
    for (int i = 0; i < guess->behind; i++)
        if (i != guess->roles->time && !csv->column[i].name.bytes && csv->column[i].numbers &&
            !guess->roles->column[i].why)
            column[count++] = i;
    int arms = guess->hints->arms ? guess->hints->arms : 1;
    int places = count == 2 * arms, angles = count >= 1 && count <= arms;
    for (int k = 0; k < count && (places || angles); k++) {
        enum api_csv_role role = !places ? API_CSV_THETA : k % 2 ? API_CSV_Y : API_CSV_X;
        guess->roles->column[column[k]] = (struct api_csv_taken){
            role,
            1 + (places ? k / 2 : k),
            -1,
            0,
            0,
            places ? "read as positions of the tips, x before y: the file has no column names"
                   : "read as angles from the vertical: the file has no column names"};
        guess->roles->measured++;
    }
}

/* --- errors --- */

/* returns the measured column that a column of errors belongs to: same quantity and arm, else the
 * nearest to the left */
static int error_of(const struct guess *guess, int i) {
    enum api_csv_role role = role_of(&guess->words[i]);
    int number = guess->words[i].number, before = -1;
    for (int j = 0; j < guess->csv->columns; j++) {
        const struct api_csv_taken *other = &guess->roles->column[j];
        if (other->role == API_CSV_NONE || other->role == API_CSV_SIGMA) continue;
        if (guess->generic || role == API_CSV_NONE) {
            int prime = guess->words[i].words & API_CSV_WORD_PRIME;
            int same = (guess->words[i].words & guess->words[j].words &
                        (API_CSV_WORD_X | API_CSV_WORD_Y)) != 0;
            if (prime ? same : j < i) before = j;
        } else if (other->role == role && (number < 0 || number == guess->words[j].number)) {
            return j;
        }
    }
    return before;
}

static void errors_take(struct guess *guess) {
    struct api_csv_taken *roles = guess->roles->column;
    for (int i = 0; i < guess->csv->columns; i++) {
        struct api_csv_taken *taken = &roles[i];
        const struct api_csv_column *column = &guess->csv->column[i];
        if (!(guess->words[i].words & (API_CSV_WORD_ERROR | API_CSV_WORD_PRIME))) continue;
        if (taken->role != API_CSV_NONE || taken->why || !column->numbers) continue;
        if (!of_table(guess, i)) continue;
        int of = error_of(guess, i);
        if (of < 0 || roles[of].role == API_CSV_TIME)
            leave(taken, "the error of a quantity that is not in this file");
        else if (column->low < 0)
            leave(taken, "its name says error, but it has values below 0");
        else
            *taken =
                (struct api_csv_taken){
                    .role = API_CSV_SIGMA, .arm = roles[of].arm, .of = of, .sure = 1},
            roles[of].of = i;
    }
}

/* --- units --- */

static int in_rad(enum api_csv_role role) {
    return api_csv_is_angle(role) || role == API_CSV_AMPLITUDE;
}

/* returns the size in rad of an angle without a unit: as the request or other columns say, else
 * guessed from the range */
static double angle_unit(const struct guess *guess, int *sure) {
    double named = 0;
    int wide = 0;
    for (int i = 0; i < guess->csv->columns; i++) {
        if (!in_rad(guess->roles->column[i].role)) continue;
        if (guess->words[i].rad) named = guess->words[i].rad;
        const struct api_csv_column *column = &guess->csv->column[i];
        // a swing is less than a full turn, but a rotation in one direction may be more
        wide |= column->swings && 2 * column->wide > column->swings;
        wide |= guess->roles->column[i].role == API_CSV_AMPLITUDE && column->high > 4;
    }
    *sure = named || guess->hints->degrees >= 0;
    if (named) return named;
    if (guess->hints->degrees >= 0) return guess->hints->degrees ? degree : 1;
    return wide ? degree : 1;
}

static void angle_take(struct api_csv_taken *taken, double own, double angle, int sure) {
    taken->unit = own ? own : angle;
    if (own || sure) return;
    taken->sure = 0;
    if (taken->why) return;
    taken->why = angle == 1 ? "has no unit: read as rad, by the size of its swings"
                            : "has no unit: read as degrees, by the size of its swings";
}

/* returns the unit of a measured column, not of angles, whose name has none */
static double other_unit(const struct api_csv_words *words, enum api_csv_role role, double angle,
                         double metre) {
    if (role == API_CSV_X || role == API_CSV_Y) return words->pixels ? 0 : metre;
    return role == API_CSV_RATE ? angle : 1;
}

static void units_take(struct guess *guess) {
    int sure, columns = guess->csv->columns;
    double angle = angle_unit(guess, &sure), metre = 0;
    for (int i = 0; i < columns; i++)
        if (of_table(guess, i) && guess->words[i].m) metre = guess->words[i].m;
    // errors have the units of the columns that they belong to
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < columns; i++) {
            struct api_csv_taken *taken = &guess->roles->column[i];
            const struct api_csv_words *words = &guess->words[i];
            double own = words->rad + words->rad_s + words->m + words->s; // at most one is set
            if ((taken->role == API_CSV_SIGMA) != pass || taken->role <= API_CSV_TIME) continue;
            if (in_rad(taken->role))
                angle_take(taken, words->rad, angle, sure);
            else
                taken->unit = own    ? own
                              : pass ? guess->roles->column[taken->of].unit
                                     : other_unit(words, taken->role, angle, metre);
        }
}

/* Reads a column's name or its replacement in the request; the unit may be the column's. */
static void words_take(struct guess *guess, int i) {
    static const struct api_csv_cell none = {"", 0};
    const struct api_csv_column *column = &guess->csv->column[i];
    const struct api_csv_cell *given = i < guess->hints->gives ? &guess->hints->given[i] : &none;
    struct api_csv_words own = api_csv_words_of(&column->name, &column->unit);
    guess->roles->column[i].of = -1, guess->words[i] = own;
    if (i >= guess->hints->gives || !given->at) return;
    guess->given[i] = 1;
    struct api_csv_words *words = &guess->words[i];
    *words = api_csv_words_of(given, &none);
    if (!given->bytes) leave(&guess->roles->column[i], "left out by the request");
    if (words->s || words->rad || words->m || words->rad_s || words->pixels) return;
    words->s = own.s, words->rad = own.rad, words->m = own.m, words->rad_s = own.rad_s;
    words->pixels = own.pixels;
}

/* a second table begins with a second column of times */
static void second_find(struct guess *guess, int time) {
    int columns = guess->csv->columns;
    for (int i = time + 1; i < columns && time >= 0; i++)
        if (!guess->given[i] && is_time(guess, i) && i < guess->behind) guess->behind = i;
    guess->roles->second = guess->behind < columns;
    for (int i = guess->behind; i < columns; i++)
        if (!guess->given[i])
            leave(&guess->roles->column[i], "belongs to a second table next to the first");
}

void api_csv_guess(struct api_csv_roles *roles, const struct api_csv *csv,
                   const struct api_csv_hints *hints) {
    struct guess guess = {.roles = roles, .csv = csv, .hints = hints};
    int seen[API_CSV_SIGMA + 1] = {0};
    assert(roles && csv && hints->arms >= 0);
    *roles = (struct api_csv_roles){.time = -1};
    guess.behind = csv->columns;
    for (int i = 0; i < csv->columns; i++) words_take(&guess, i);
    int time = time_find(&guess);
    if (time >= 0) time_take(&guess, time);
    second_find(&guess, time);
    axes_take(&guess);
    for (int given = 1; given >= 0; given--)
        for (int i = 0; i < csv->columns; i++)
            if (guess.given[i] == given && i != time) column_take(&guess, i, seen);
    if (!roles->measured) unnamed_take(&guess);
    rates_drop(&guess);
    errors_take(&guess);
    units_take(&guess);
}
