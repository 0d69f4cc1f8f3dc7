#include "core/tree/rules.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

/* number of a table's instants before t, or up to and including t if `itself` */
static int table_before(const struct pend_table *table, double t, int itself) {
    int low = 0, high = table->count;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (table->t[middle] < t || (itself && table->t[middle] == t))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

double pend_rules_next(const struct pend_rules *rules, double now, int way) {
    double next = copysign(INFINITY, way);
    for (int i = 0; i < rules->tables; i++) {
        const struct pend_table *table = &rules->table[i];
        int at = way > 0 ? table_before(table, now, 1) : table_before(table, now, 0) - 1;
        if (at >= 0 && at < table->count)
            next = way > 0 ? fmin(next, table->t[at]) : fmax(next, table->t[at]);
    }
    return next;
}

/* a table's value at `now`, and its slope in the piece after `now`, or before it if way < 0 */
static double table_look(const struct pend_table *table, double now, int way, double *slope) {
    int last = table->count - 1, at = table_before(table, now, way > 0) - 1;
    *slope = 0;
    if (at < 0 || at == last)
        return table->outside == PEND_OUTSIDE_ZERO ? 0 : table->value[at < 0 ? 0 : last];
    if (!table->linear) return table->value[at];
    *slope = (table->value[at + 1] - table->value[at]) / (table->t[at + 1] - table->t[at]);
    // interpolate from the nearer end: at an end the value is then exact
    if (now - table->t[at] > table->t[at + 1] - now)
        return table->value[at + 1] + *slope * (now - table->t[at + 1]);
    return table->value[at] + *slope * (now - table->t[at]);
}

void pend_rules_spline(int count, const double t[], const double value[], double bend[],
                       double work[]) {
    bend[0] = work[0] = bend[count - 1] = 0;
    for (int i = 1; i < count - 1; i++) {
        double before = t[i] - t[i - 1], after = t[i + 1] - t[i];
        double turn = (value[i + 1] - value[i]) / after - (value[i] - value[i - 1]) / before;
        double pivot = 2 * (before + after) - before * work[i - 1];
        work[i] = after / pivot;
        bend[i] = (6 * turn - before * bend[i - 1]) / pivot;
    }
    for (int i = count - 2; i > 0; i--) bend[i] -= work[i] * bend[i + 1];
}

/* a coordinate of the pivot at `now` and its three derivatives in the piece on the given side, in
 * every second number */
static void table_track(const struct pend_table *table, double now, int way, double track[]) {
    int at = table_before(table, now, way > 0) - 1, last = table->count - 2;
    at = at < 0 ? 0 : at > last ? last : at;
    const double *t = table->t + at, *y = table->value + at, *bend = table->bend + at;
    double h = t[1] - t[0], a = (t[1] - now) / h, b = (now - t[0]) / h;
    double third = (a * a - 1) * a * bend[0] + (b * b - 1) * b * bend[1];
    track[0] = a * y[0] + b * y[1] + third * (h * h / 6);
    track[2] = (y[1] - y[0]) / h + ((1 - 3 * a * a) * bend[0] + (3 * b * b - 1) * bend[1]) * h / 6;
    track[4] = a * bend[0] + b * bend[1];
    track[6] = (bend[1] - bend[0]) / h;
}

void pend_rules_track(const struct pend_rules *rules, double now, int way, double track[8]) {
    for (int i = 0; i < rules->tables; i++) {
        const struct pend_table *table = &rules->table[i];
        if (table->drives < 0)
            table_track(table, now, way, track + (table->drives == PEND_DRIVE_PIVOT_Y));
    }
}

void pend_rules_inputs(const struct pend_rules *rules, const struct pend_terms *terms, double now,
                       int way, double value[], size_t stride) {
    int input = terms->row[PEND_TERM_INPUT], rise = terms->row[PEND_TERM_INPUT_RATE];
    assert(input >= 0 && rise >= 0 && terms->one[PEND_TERM_PIECE] >= 0);
    for (int k = 0; k < terms->n; k++)
        value[(size_t)(input + k) * stride] = value[(size_t)(rise + k) * stride] = 0;
    value[(size_t)terms->one[PEND_TERM_PIECE] * stride] = now;
    int at = terms->one[PEND_TERM_PIVOT_TRACK];
    double track[8] = {0};
    if (at >= 0) pend_rules_track(rules, now, way, track);
    for (int j = 0; j < 8 && at >= 0; j++) value[(size_t)(at + j) * stride] = track[j];
    for (int i = 0; i < rules->tables; i++) {
        const struct pend_table *table = &rules->table[i];
        double slope;
        if (table->drives < 0) continue;
        value[(size_t)(input + table->drives) * stride] += table_look(table, now, way, &slope);
        value[(size_t)(rise + table->drives) * stride] += slope;
    }
}

double pend_rules_piece(const struct pend_terms *terms, double now, int way, double value[],
                        size_t stride) {
    if (!terms || !terms->rules) return copysign(INFINITY, way);
    if (terms->row[PEND_TERM_INPUT] >= 0)
        pend_rules_inputs(terms->rules, terms, now, way, value, stride);
    return pend_rules_next(terms->rules, now, way);
}

/* estimated number of impacts at two stops `gap` apart, or at one stop, for swings at `rate` */
static double rules_impacts(double gap, double e, double span, double rate) {
    static const double shortest = 1e-6; // s, duration of a flight (core/integrate/pieces/joints.c)
    double flight = fmin(gap, M_PI) / rate, loss = -log(e), swings = span * rate / M_PI;
    if (!(e > 0) || !(rate > 0)) return swings;
    if (isfinite(gap))
        return fmax(swings, e < 1 ? log1p(span / flight * (1 / e - 1)) / loss : span / flight);
    double flights = e < 1 ? log(fmax(flight / shortest, 1)) / loss : INFINITY,
           part = span / flight;
    if (e < 1 && part * (1 - e) < 1) flights = fmin(flights, -log1p(-part * (1 - e)) / loss);
    return swings + fmin(flights, e < 1 ? flights : part);
}

double pend_rules_pieces(const struct pend_rules *rules, int n, double span, double rate) {
    double pieces = 0;
    if (!rules) return 0;
    for (int i = 0; i < rules->tables; i++) pieces += rules->table[i].count;
    for (int i = 0; i < rules->controllers; i++) pieces += span / rules->controller[i].period;
    for (int k = 0; k < n; k++) {
        if (rules->sliding && rules->sliding[k] > 0) pieces += span * rate / M_PI;
        if (!rules->least || (isinf(rules->least[k]) && isinf(rules->most[k]))) continue;
        pieces +=
            rules_impacts(rules->most[k] - rules->least[k], rules->restitution[k], span, rate);
    }
    return pieces;
}

enum pend_status pend_rules_check(const struct pend_rules *rules, const int order[], double first,
                                  double last, struct pend_error *error) {
    if (rules->controllers && last < first)
        return pend_fail(error, PEND_INVALID, -1, last,
                         "controllers need instants that go forward in time, but these go backward "
                         "from %.15g s to %.15g s",
                         first, last);
    for (int i = 0; i < rules->tables; i++) {
        const struct pend_table *table = &rules->table[i];
        double from = table->t[0], to = table->t[table->count - 1];
        int arm = table->drives < 0 ? -1 : order[table->drives];
        char which[40] = "the pivot";
        if (arm >= 0) snprintf(which, sizeof which, "arm %d", arm + 1);
        if (table->outside != PEND_OUTSIDE_REFUSE) continue;
        if (fmin(first, last) >= from && fmax(first, last) <= to) continue;
        return pend_fail(
            error, PEND_INVALID, arm, fmin(first, last) < from ? first : last,
            "the motion goes from %.15g to %.15g s, but a table of %s covers only %.15g to "
            "%.15g s: extend the table%s",
            first, last, which, from, to,
            arm < 0 ? "" : ", or give \"outside\": \"hold\" or \"zero\"");
    }
    return PEND_OK;
}
