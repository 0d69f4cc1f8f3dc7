#include "api/csv/csv_roles.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>

#include "api/csv/csv_words.h"

static const double degree = 3.14159265358979323846 / 180;

static const double epoch_s = 1e8;   /* instants beyond are seconds since 1970 */
static const double epoch_ms = 1e11; /* or milliseconds */
static const double step_ms = 5;     /* rows that are farther apart are milliseconds */

const char *api_csv_role_name(enum api_csv_role role) {
    static const char *const names[] = {"", "t", "theta", "phi", "x", "y", "thetad", "sigma"};
    assert((unsigned)role < sizeof names / sizeof *names);
    return names[role];
}

/* what is looked at together */
struct guess {
    struct api_csv_roles *roles;
    const struct api_csv *csv;
    const struct api_csv_hints *hints;
    struct api_csv_words words[API_CSV_COLUMNS];
    int generic; /* the columns are called X and Y, as a program for plots calls any two */
    int behind;  /* the first column of a second table; all, if there is none */
};

static void leave(struct api_csv_taken *taken, const char *why) {
    taken->role = API_CSV_NONE, taken->why = why;
}

/* --- time --- */

static int is_time(const struct guess *guess, int i) {
    const struct api_csv_column *column = &guess->csv->column[i];
    int words = guess->words[i].words;
    if (column->clocks > column->numbers) return 1;
    return (words & API_CSV_WORD_TIME) && column->numbers &&
           !(words & (API_CSV_WORD_ERROR | API_CSV_WORD_MODEL | API_CSV_WORD_SPEED));
}

/* the column of the instants: one that is called so, else the first whose numbers rise */
static int time_find(struct guess *guess) {
    const struct api_csv *csv = guess->csv;
    for (int i = 0; i < csv->columns; i++)
        if (is_time(guess, i)) return i;
    for (int i = 0; i < csv->columns; i++) {
        const struct api_csv_column *column = &csv->column[i];
        int words = guess->words[i].words, named = words & ~(API_CSV_WORD_X | API_CSV_WORD_OTHER);
        if (!column->rises || column->low >= column->high || column->numbers < csv->rows) continue;
        if (words & API_CSV_WORD_FRAME) {
            leave(&guess->roles->column[i], "counts pictures: the instants in s are wanted, or a "
                                            "column of them");
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
    *taken = (struct api_csv_taken){API_CSV_TIME, 0, -1, unit ? unit : 1, is_time(guess, i), NULL};
    if (!taken->sure) taken->why = "its numbers rise from row to row: taken for the time";
    guess->roles->time = i;
    if (column->clocks > column->numbers) {
        taken->unit = 1, guess->roles->origin = column->first;
        taken->why = "a clock: counted from its first row";
    } else if (!unit && column->low > epoch_ms) {
        taken->unit = 1e-3, guess->roles->origin = column->first * 1e-3, taken->sure = 0;
        taken->why = "milliseconds since 1970: counted from the first row";
    } else if (column->low > epoch_s && (!unit || unit == 1)) {
        guess->roles->origin = column->first, taken->sure = 0;
        taken->why = "seconds since 1970: counted from the first row";
    } else if (!unit && column->step >= step_ms && isfinite(column->step)) {
        taken->unit = 1e-3, taken->sure = 0;
        taken->why = "rows are 5 or more apart: taken for milliseconds";
    }
}

/* --- what is measured --- */

static int is_angle(enum api_csv_role role) { return role == API_CSV_THETA || role == API_CSV_PHI; }

static enum api_csv_role role_of(const struct api_csv_words *words) {
    int word = words->words;
    if (words->rad_s || (word & API_CSV_WORD_RATE) ||
        ((word & API_CSV_WORD_SPEED) && (word & (API_CSV_WORD_ANGLE | API_CSV_WORD_PHI))))
        return API_CSV_RATE;
    if (word & (API_CSV_WORD_SPEED | API_CSV_WORD_OTHER | API_CSV_WORD_FRAME)) return API_CSV_NONE;
    if (word & API_CSV_WORD_ANGLE) return API_CSV_THETA;
    if (word & API_CSV_WORD_PHI) return API_CSV_PHI;
    if (word & API_CSV_WORD_X) return API_CSV_X;
    if (word & API_CSV_WORD_Y) return API_CSV_Y;
    return words->rad ? API_CSV_THETA : API_CSV_NONE;
}

static int same_cell(const struct api_csv_cell *a, const struct api_csv_cell *b) {
    if (a->bytes != b->bytes) return 0;
    for (int i = 0; i < a->bytes; i++)
        if (a->at[i] != b->at[i]) return 0;
    return 1;
}

/* the place of a column's group among those over what is measured, from 1 */
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

/* whether arms are counted from 0: a column has that number */
static int from_zero(const struct guess *guess) {
    for (int i = 0; i < guess->behind; i++)
        if (guess->words[i].number == 0 && role_of(&guess->words[i]) != API_CSV_NONE) return 1;
    return 0;
}

/* the arm of a column, from 1; 0 where it has none of this pendulum */
static int arm_of(struct guess *guess, int i, enum api_csv_role role, int seen[]) {
    static const struct api_csv_cell none = {"", 0};
    const struct api_csv_column *column = &guess->csv->column[i];
    int number = guess->words[i].number, arm;
    if (number >= 0) {
        arm = number + from_zero(guess);
    } else if (column->group.bytes) {
        arm = api_csv_words_of(&column->group, &none).number;
        if (arm < 1) arm = group_of(guess, i);
    } else {
        arm = seen[role] + 1;
        int place = role == API_CSV_X || role == API_CSV_Y;
        seen[role] = arm;
        return place && arm <= guess->hints->count ? guess->hints->listed[arm - 1]
               : arm <= guess->hints->arms         ? arm
                                                   : 0;
    }
    seen[role] = arm > seen[role] ? arm : seen[role];
    return arm >= 1 && arm <= guess->hints->arms ? arm : 0;
}

static int is_taken(const struct guess *guess, int i, enum api_csv_role role, int arm) {
    for (int j = 0; j < i; j++)
        if (guess->roles->column[j].role == role && guess->roles->column[j].arm == arm) return 1;
    return 0;
}

/* why a column is not used, by its name, its unit and its numbers; NULL where it may be */
static const char *column_unfit(const struct guess *guess, int i, enum api_csv_role role, int arm) {
    const struct api_csv_words *words = &guess->words[i];
    if (!guess->csv->column[i].numbers) return "has no number";
    if (words->words & API_CSV_WORD_MODEL) return "is called a model's, not measured";
    if (is_angle(role) && (words->pixels || words->m || words->s))
        return "has a unit that no angle has";
    if (!arm) return "names no arm of this pendulum";
    return is_taken(guess, i, role, arm) ? "a column before it is the same of this arm" : NULL;
}

static void column_take(struct guess *guess, int i, int seen[]) {
    struct api_csv_taken *taken = &guess->roles->column[i];
    int words = guess->words[i].words;
    enum api_csv_role role = role_of(&guess->words[i]);
    // standard errors come later, when what they are of is known
    if (words & (API_CSV_WORD_ERROR | API_CSV_WORD_PRIME) || role == API_CSV_NONE) return;
    if (guess->generic) role = API_CSV_THETA;
    int arm = words & API_CSV_WORD_MODEL ? 0 : arm_of(guess, i, role, seen);
    taken->why = column_unfit(guess, i, role, arm);
    if (taken->why) return;
    *taken = (struct api_csv_taken){role, arm, -1, 0, !guess->generic, NULL};
    if (role == API_CSV_PHI)
        taken->why = "phi counts from the positive real axis; from hanging it is theta";
    if (guess->hints->arms > 1 && guess->words[i].number < 0 &&
        !guess->csv->column[i].group.bytes && !guess->hints->count)
        taken->sure = 0, taken->why = "no number names its arm: arms are taken in order";
    if (guess->generic) taken->why = "taken for the angle from hanging: nothing names it";
    guess->roles->measured++;
}

/* columns without names: as many angles as arms, or places of the tips */
static void unnamed_take(struct guess *guess) {
    const struct api_csv *csv = guess->csv;
    int column[API_CSV_COLUMNS], count = 0;
    for (int i = 0; i < guess->behind; i++)
        if (i != guess->roles->time && !csv->column[i].name.bytes && csv->column[i].numbers)
            column[count++] = i;
    int places = count == 2 * guess->hints->arms,
        angles = count >= 1 && count <= guess->hints->arms;
    for (int k = 0; k < count && (places || angles); k++) {
        enum api_csv_role role = !places ? API_CSV_THETA : k % 2 ? API_CSV_Y : API_CSV_X;
        guess->roles->column[column[k]] = (struct api_csv_taken){
            role,
            1 + (places ? k / 2 : k),
            -1,
            0,
            0,
            places ? "taken for places of the tips, x before y: the file has no names"
                   : "taken for angles from hanging: the file has no names"};
        guess->roles->measured++;
    }
}

/* --- errors --- */

/* the column that an error is of: that of its own words and arm, else the nearest before it */
static int error_of(const struct guess *guess, int i) {
    enum api_csv_role role = role_of(&guess->words[i]);
    int number = guess->words[i].number, before = -1;
    for (int j = 0; j < guess->behind; j++) {
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
    for (int i = 0; i < guess->behind; i++) {
        struct api_csv_taken *taken = &guess->roles->column[i];
        const struct api_csv_column *column = &guess->csv->column[i];
        if (!(guess->words[i].words & (API_CSV_WORD_ERROR | API_CSV_WORD_PRIME))) continue;
        if (taken->role != API_CSV_NONE || taken->why || !column->numbers) continue;
        int of = error_of(guess, i);
        if (of < 0 || guess->roles->column[of].role == API_CSV_TIME)
            leave(taken, "an error of what is not measured here");
        else if (column->low < 0)
            leave(taken, "is called an error, but has values below 0");
        else
            *taken =
                (struct api_csv_taken){API_CSV_SIGMA, guess->roles->column[of].arm, of, 0, 1, NULL};
    }
}

/* --- units --- */

/* rad that a number without a unit is: as is said, as other columns are, or by their size */
static double angle_unit(const struct guess *guess, int *sure) {
    double named = 0;
    int wide = 0;
    for (int i = 0; i < guess->behind; i++) {
        if (!is_angle(guess->roles->column[i].role)) continue;
        if (guess->words[i].rad) named = guess->words[i].rad;
        const struct api_csv_column *column = &guess->csv->column[i];
        // what swings does not swing by more than a turn, but it may turn over in one direction
        wide |= column->swings && 2 * column->wide > column->swings;
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
    taken->why = angle == 1 ? "no unit is named: taken for rad, by the size of its swings"
                            : "no unit is named: taken for degrees, by the size of its swings";
}

static void units_take(struct guess *guess) {
    int sure;
    double angle = angle_unit(guess, &sure), metre = 0;
    for (int i = 0; i < guess->behind; i++)
        if (guess->words[i].m) metre = guess->words[i].m;
    for (int i = 0; i < guess->behind; i++) {
        struct api_csv_taken *taken = &guess->roles->column[i];
        const struct api_csv_words *words = &guess->words[i];
        if (is_angle(taken->role)) angle_take(taken, words->rad, angle, sure);
        if (taken->role == API_CSV_RATE) taken->unit = words->rad_s ? words->rad_s : angle;
        if (taken->role == API_CSV_X || taken->role == API_CSV_Y)
            taken->unit = words->pixels ? 0 : words->m ? words->m : metre;
    }
    for (int i = 0; i < guess->behind; i++) {
        struct api_csv_taken *taken = &guess->roles->column[i];
        const struct api_csv_words *words = &guess->words[i];
        double own = words->rad + words->rad_s + words->m; // at most one is there
        if (taken->role == API_CSV_SIGMA)
            taken->unit = own ? own : guess->roles->column[taken->of].unit;
    }
}

void api_csv_guess(struct api_csv_roles *roles, const struct api_csv *csv,
                   const struct api_csv_hints *hints) {
    struct guess guess = {.roles = roles, .csv = csv, .hints = hints};
    int seen[API_CSV_SIGMA + 1] = {0};
    assert(roles && csv && hints->arms >= 1);
    *roles = (struct api_csv_roles){.time = -1};
    guess.behind = csv->columns;
    for (int i = 0; i < csv->columns; i++) {
        roles->column[i].of = -1;
        guess.words[i] = api_csv_words_of(&csv->column[i].name, &csv->column[i].unit);
    }
    int time = time_find(&guess);
    if (time >= 0) time_take(&guess, time);
    for (int i = time + 1; i < csv->columns && time >= 0; i++)
        if (is_time(&guess, i) && i < guess.behind) guess.behind = i;
    for (int i = guess.behind; i < csv->columns; i++)
        roles->column[i].why = "is of a second table beside the first";
    for (int i = 0; i < guess.behind; i++)
        if (i != time) column_take(&guess, i, seen);
    if (!roles->measured) unnamed_take(&guess);
    errors_take(&guess);
    units_take(&guess);
}
