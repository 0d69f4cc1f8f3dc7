#include "core/integrate/methods/method.h"

#include <assert.h>
#include <string.h>

double pend_times_at(const struct pend_times *times, long i) {
    assert(i >= 0 && i < times->count);
    if (times->list) return times->list[i];
    /* if the step divides the span, the last instant of a grid is exactly its end */
    if ((double)i == times->divisor) return times->start + times->span;
    return times->start + (double)i * times->span / times->divisor;
}

void pend_times_list(const struct pend_times *times, long first, int count, double t[]) {
    assert(first >= 0 && count >= 0 && count <= times->count - first);
    if (times->list) {
        memcpy(t, times->list + first, (size_t)count * sizeof *t);
        return;
    }
    double base = (double)first, start = times->start, span = times->span, divisor = times->divisor;
    // whole numbers of this size are exact in doubles
    for (int i = 0; i < count; i++) t[i] = start + (base + i) * span / divisor;
    double last = divisor - base;
    if (last >= 0 && last < count && last == (int)last) t[(int)last] = start + span;
}

void pend_stepper_counts_carry(struct pend_stepper_counts *counts,
                               struct pend_checkpoint *checkpoint) {
    pend_checkpoint_counts(checkpoint, &counts->steps, 1);
    pend_checkpoint_counts(checkpoint, &counts->rejected, 1);
    pend_checkpoint_counts(checkpoint, &counts->evaluations, 1);
}

static const struct pend_method *const method_table[] = {
    &pend_method_taylor,  &pend_method_ode23,      &pend_method_rkf45,  &pend_method_rk8pd,
    &pend_method_msadams, &pend_method_symplectic, &pend_method_linear, &pend_method_radau,
};

enum { METHOD_COUNT = sizeof method_table / sizeof *method_table };

const struct pend_method *pend_method_at(int i) {
    return i >= 0 && i < METHOD_COUNT ? method_table[i] : NULL;
}

const struct pend_method *pend_method_find(const char *name) {
    for (int i = 0; i < METHOD_COUNT; i++)
        if (!strcmp(method_table[i]->name, name)) return method_table[i];
    return NULL;
}
