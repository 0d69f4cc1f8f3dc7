#include "api/read/times_json.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const times_fields[] = {"start", "stop", "step", "count", NULL};

static const double divides_within = 1e-9; /* relative to the number of steps */

struct grid {
    double start, stop, step;
    long count; /* 0 = the grid is defined by its step */
};

/* the span for which start + span is exactly stop, if one of the nearest doubles is such */
static double grid_span(double start, double stop) {
    double span = stop - start, up = nextafter(span, INFINITY), down = nextafter(span, -INFINITY);
    if (start + span != stop && start + up == stop) return up;
    if (start + span != stop && start + down == stop) return down;
    return span;
}

/* if the step is a decimal, writes it as an integer divided by 1, 10, 100, ...; the instants are
 * then correctly rounded */
static int grid_is_decimal(double step, struct pend_times *times) {
    double divisor = 1;
    for (int places = 0; places <= 15; places++, divisor *= 10) {
        double span = rint(step * divisor);
        if (span == 0 || fabs(span) > 0x1p53 || span / divisor != step) continue;
        times->span = span;
        times->divisor = divisor;
        return 1;
    }
    return 0;
}

/* sets the instants of a grid by its step, whose direction and count are already checked */
static void grid_by_step(const struct grid *grid, struct pend_times *times) {
    double step = copysign(grid->step, grid->stop - grid->start),
           ratio = (grid->stop - grid->start) / step;
    double whole = rint(ratio);
    int divides = whole > 0 && fabs(ratio - whole) <= divides_within * whole;
    times->count = (long)(divides ? whole : floor(ratio)) + 1;
    int decimal = grid_is_decimal(step, times);
    if (decimal && (!divides || pend_times_at(times, times->count - 1) == grid->stop)) return;
    times->span = divides ? grid_span(grid->start, grid->stop) : step;
    times->divisor = divides ? whole : 1;
}

static void grid_by_count(const struct grid *grid, struct pend_times *times) {
    times->count = grid->count;
    times->span = grid_span(grid->start, grid->stop);
    times->divisor = grid->count > 1 ? (double)(grid->count - 1) : 1;
}

static void fault_count(const struct api_value *value, double count,
                        const struct api_limits *limits, struct api_problem *problem) {
    api_value_fault(
        value, problem,
        API_CODE_LIMIT
        "asks for %.15g instants, more than the limit %s of %.0f: ask for fewer at a time",
        count, api_limits_name(limits, &limits->samples), limits->samples);
}

/* adds an error for a step that leads away from stop, or gives too many instants */
static void check_step(const struct api_value *value, const struct grid *grid,
                       const struct api_limits *limits, struct api_problem *problem) {
    double span = grid->stop - grid->start, count = floor(fabs(span / grid->step)) + 1;
    if (grid->step < 0 && span > 0)
        api_value_fault(value, problem,
                        API_CODE_OUT_OF_RANGE
                        "must be positive to get from %.15g to %.15g s, got %.15g",
                        grid->start, grid->stop, grid->step);
    else if (count > limits->samples)
        fault_count(value, count, limits, problem);
    else if (span != 0 && fabs(grid->step) > fabs(span) * (1 + divides_within))
        api_value_fault(value, problem,
                        API_CODE_OUT_OF_RANGE
                        "must be at most %.15g s, the time from start to stop, got %.15g",
                        fabs(span), fabs(grid->step));
}

static void check_count(const struct api_value *value, const struct grid *grid,
                        const struct api_limits *limits, struct api_problem *problem) {
    if ((double)grid->count > limits->samples)
        fault_count(value, (double)grid->count, limits, problem);
    if (grid->count == 1 && grid->start != grid->stop)
        api_value_fault(
            value, problem,
            API_CODE_OUT_OF_RANGE
            "must be at least 2 for the instants to begin at start and end at stop, got 1");
    if (grid->count > 1 && grid->start == grid->stop)
        api_value_fault(value, problem,
                        API_CODE_OUT_OF_RANGE
                        "must be 1 if start and stop are the same instant, got %ld",
                        grid->count);
}

/* adds an error for a grid that has both a step and a count, or neither */
static void check_one(const struct api_value *value, const struct api_value *count, int by_step,
                      int by_count, struct api_problem *problem) {
    if (by_step && by_count)
        api_value_fault(count, problem,
                        API_CODE_CONFLICT "cannot be combined with step: give one of the two");
    if (!by_step && !by_count && !api_value_meant(value, "step", problem) &&
        !api_value_meant(value, "count", problem))
        api_value_fault(value, problem, API_CODE_MISSING "must have a \"step\" or a \"count\"");
}

/* reads start and stop; returns false after an error */
static int read_ends(struct grid *grid, const struct api_value *value,
                     struct api_problem *problem) {
    struct api_value start = api_value_member(value, "start"),
                     stop = api_value_member(value, "stop");
    api_value_usual_number(&start, 0);
    int good = api_value_read_number(&start, -INFINITY, INFINITY, "s", &grid->start, problem) >= 0;
    return api_field_needed(&stop, problem) &&
           api_value_read_number(&stop, -INFINITY, INFINITY, "s", &grid->stop, problem) > 0 && good;
}

static void read_grid(struct api_times *times, const struct api_value *value,
                      const struct api_limits *limits, struct api_problem *problem) {
    struct grid grid = {0};
    struct api_value step = api_value_member(value, "step"),
                     count = api_value_member(value, "count");
    (void)api_value_only(value, times_fields, problem);
    int ends = read_ends(&grid, value, problem);
    int by_step = api_value_read_number(&step, -INFINITY, INFINITY, "s", &grid.step, problem);
    int by_count = api_field_whole(&count, 1, 1000000000, &grid.count, problem);
    if (by_step > 0 && grid.step == 0)
        api_value_fault(&step, problem, API_CODE_OUT_OF_RANGE "must not be 0");
    check_one(value, &count, by_step, by_count, problem);
    if (ends && !isfinite(grid.stop - grid.start))
        api_value_fault(value, problem,
                        API_CODE_OUT_OF_RANGE "must not span more time than a double can hold");
    if (!ends || !isfinite(grid.stop - grid.start)) return;

    if (by_step > 0 && grid.step != 0) check_step(&step, &grid, limits, problem);
    if (by_count > 0) check_count(&count, &grid, limits, problem);
    if (problem->status) return;
    times->times.start = grid.start;
    if (by_count)
        grid_by_count(&grid, &times->times);
    else
        grid_by_step(&grid, &times->times);
}

/* adds an error for every instant that does not continue in the direction of the first two */
static void check_list(const struct api_value *value, int count, const double list[],
                       struct api_problem *problem) {
    double direction = count > 1 && list[1] < list[0] ? -1 : 1;
    if (count == 3 && list[0] < list[1] && list[2] > 0 && list[2] < list[1] - list[0]) {
        struct api_value item = api_value_item(value, 2);
        api_value_fault(&item, problem,
                        API_CODE_ORDER
                        "must be greater than the instant before it (%.15g), got %.15g; a grid is "
                        "{\"start\": %.15g, \"stop\": %.15g, \"step\": %.15g}",
                        list[1], list[2], list[0], list[1], list[2]);
        return;
    }
    for (int i = 1; i < count; i++) {
        if (direction * list[i] > direction * list[i - 1]) continue;
        struct api_value item = api_value_item(value, i);
        api_value_fault(&item, problem,
                        API_CODE_ORDER "must be %s than the instant before it (%.15g), got %.15g",
                        direction < 0 ? "less" : "greater", list[i - 1], list[i]);
    }
}

static enum pend_status read_list(struct api_times *times, const struct api_value *value,
                                  const struct api_limits *limits, struct api_problem *problem) {
    int count = 0;
    const double *list = api_value_numbers(value, &count);
    if (!list) {
        (void)api_field_numbers(value, 0, "", NULL, problem);
        return PEND_INVALID;
    }
    if (!count)
        api_value_fault(value, problem, API_CODE_WRONG_COUNT "must have at least one instant");
    if (count > limits->samples)
        fault_count(value, count, limits, problem);
    else
        check_list(value, count, list, problem);
    if (problem->status) return PEND_INVALID;
    times->list = malloc((size_t)count * sizeof *list);
    if (!times->list) return PEND_NO_MEMORY;
    memcpy(times->list, list, (size_t)count * sizeof *list);
    assert(count >= 1 && count <= limits->samples);
    times->times = (struct pend_times){.count = count, .divisor = 1, .list = times->list};
    return PEND_OK;
}

enum pend_status api_times_read(struct api_times *times, const struct api_value *value,
                                const struct api_limits *limits, struct api_problem *problem) {
    *times = (struct api_times){0};
    if (!api_field_needed(value, problem)) return PEND_INVALID;
    if (api_value_kind(value) == API_ARRAY) return read_list(times, value, limits, problem);
    if (api_value_kind(value) == API_STRING || api_value_kind(value) == API_NUMBER) {
        char found[API_FOUND_BYTES];
        api_value_found(value, found);
        api_value_fault(value, problem,
                        API_CODE_WRONG_TYPE "must be a grid, as {\"start\": 0, \"stop\": 5, "
                                            "\"step\": 0.01}, or a list of instants, got %s",
                        found);
        return PEND_INVALID;
    }
    if (!api_field_object(value, NULL, problem)) return PEND_INVALID;
    read_grid(times, value, limits, problem);
    assert(times->times.count >= 0 && !times->list);
    return problem->status ? PEND_INVALID : PEND_OK;
}

void api_times_clear(struct api_times *times) {
    free(times->list);
    *times = (struct api_times){0};
}
