#include "api/op/ensemble/picture_json.h"

#include <string.h>

static const char *const fields[] = {"of", "arm", "scale", NULL};

enum { PIXELS_MOST = 16384 }; /* maximum number of pixels along one side */

/* observables that can be drawn; of these, those that suit a logarithmic scale: times and tiny
 * numbers */
static const unsigned drawn =
    1u << API_SEE_FIRST_FLIP | 1u << API_SEE_FLIP_TIME | 1u << API_SEE_FLIPS |
    1u << API_SEE_LAMBDA_MAX | 1u << API_SEE_LAMBDA_MIN | 1u << API_SEE_SIGN_CHANGE |
    1u << API_SEE_ENERGY_DRIFT | 1u << API_SEE_LYAPUNOV | 1u << API_SEE_SETTLED;
static const unsigned logarithmic = 1u << API_SEE_FIRST_FLIP | 1u << API_SEE_FLIP_TIME |
                                    1u << API_SEE_SIGN_CHANGE | 1u << API_SEE_ENERGY_DRIFT;

/* the named observable, or the first that can be drawn; -1 and an error if there is none */
static int picture_of(const struct api_observables *seen, const struct api_value *of,
                      const struct api_value *picture, struct api_problem *problem) {
    const char *names[API_SEE_COUNT + 1] = {0};
    int number[API_SEE_COUNT], count = 0, chosen = 0;
    for (int i = 0; i < API_SEE_COUNT; i++) {
        if (!(seen->wanted & drawn & 1u << i)) continue;
        names[count] = api_observables_name((enum api_observable)i);
        number[count++] = i;
    }
    if (!count) {
        api_value_fault(
            picture, problem,
            API_CODE_MISSING
            "needs an observable to draw: first_flip, flip_time, flips, lambda_max, lambda_min, "
            "sign_change, energy_drift, lyapunov or settled");
        return -1;
    }
    return api_field_word(of, names, &chosen, problem) < 0 ? -1 : number[chosen];
}

void api_picture_read(struct api_observables *seen, const struct api_members *members,
                      const struct api_tree *tree, const struct api_reading *reading) {
    static const char *const scales[] = {"linear", "log", NULL};
    struct api_value picture = api_value_member(reading->root, "picture");
    struct api_value arm = api_value_member(&picture, "arm");
    struct api_problem *problem = reading->problem;
    const long *count = members->axis_count;
    long number = 1;
    if (!reading->format->picture && api_value_kind(&picture) == API_MISSING) return;
    if (api_value_kind(&picture) != API_MISSING) {
        if (!api_field_object(&picture, fields, problem)) return;
    }
    if (members->axes != 2)
        api_value_fault(&picture, problem,
                        API_CODE_MISSING "a picture needs a \"grid\" of two axes");
    else if (count[0] > PIXELS_MOST || count[1] > PIXELS_MOST)
        api_value_fault(&picture, problem,
                        API_CODE_LIMIT "a picture has at most %d members on each axis",
                        PIXELS_MOST);
    int chosen = picture_of(seen, API_MEMBER(&picture, "of"), &picture, problem);
    if (chosen < 0) return;
    int column = seen->at[chosen], width = seen->table.column[column].width,
        log = logarithmic >> chosen & 1;
    if (!width && api_value_kind(&arm) != API_MISSING)
        api_value_fault(&arm, problem,
                        API_CODE_NOT_APPLICABLE
                        "has no meaning for \"%s\", which belongs to no arm",
                        api_observables_name((enum api_observable)chosen));
    else
        (void)api_field_whole(&arm, 1, tree->n, &number, problem);
    (void)api_field_word(API_MEMBER(&picture, "scale"), scales, &log, problem);
    if (problem->status) return;
    seen->table.picture = (struct api_table_picture){
        .across = count[0], .column = column, .arm = (int)number - 1, .logarithmic = log};
}
