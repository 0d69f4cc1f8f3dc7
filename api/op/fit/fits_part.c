#include "api/op/fit/fits_part.h"

#include <math.h>
#include <stdlib.h>

int api_fit_part_fits(double rows, double columns, double *taken, const struct api_value *data,
                      const struct api_reading *reading) {
    double most = reading->limits->answer_bytes;
    *taken += rows * (2 * columns + 1) * sizeof(double);
    if (*taken <= most) return 1;
    api_value_fault(data, reading->problem,
                    API_CODE_LIMIT "would take %.0f bytes of memory, rows times columns of all "
                                   "runs, more than the limit max-answer-bytes of %.0f",
                    *taken, most);
    return 0;
}

enum pend_status api_fit_part_room(struct api_fit_part *part, long rows, int columns,
                                   const struct api_value *data,
                                   const struct api_reading *reading) {
    size_t count = (size_t)rows * (size_t)columns;
    if (!api_fit_part_fits((double)rows, columns, part->taken, data, reading)) return PEND_INVALID;
    part->t = malloc((size_t)(rows + 1) * sizeof(double));
    part->data = malloc((count + 1) * sizeof(double));
    part->each = malloc((count + 1) * sizeof(double));
    if (!part->t || !part->data || !part->each) return PEND_NO_MEMORY;
    for (size_t i = 0; i < count; i++) part->data[i] = NAN;
    part->rows = rows, part->columns = columns;
    return PEND_OK;
}
