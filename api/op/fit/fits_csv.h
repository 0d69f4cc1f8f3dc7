/* Measurements as a table of text: CSV, or what the program Tracker exports.
 * Leaves to others: everything else of a fit (fits_json).
 * Invariant: a fault names the line, from 1. */
#ifndef API_FITS_CSV_H
#define API_FITS_CSV_H

#include "api/json/json_in.h"
#include "core/fit/fit_problem.h"

enum { API_CSV_COLUMNS = 64, API_CSV_FIELDS = 256 };

/* What the head of a table says. */
struct api_csv {
    char separator; /* comma, semicolon or tab */
    int line;       /* of the head, from 1 */
    long rows;
    int t; /* the field of the instants */
    int columns, field[API_CSV_COLUMNS], arm[API_CSV_COLUMNS];
    enum pend_fit_kind kind[API_CSV_COLUMNS];
    int theta[API_CSV_COLUMNS];    /* an angle from hanging */
    double scale[API_CSV_COLUMNS]; /* rad or the camera's unit, of one of the table's */
    /* how many of the unit of places are a metre, where it is said; 0 = it is not; and the first
     * field that says so, from 0 */
    double per_m;
    int per_m_field;
};

/**
 * Reads the head of a table: the first line with a field `t`, or `t (s)`; lines before it, as those
 * that name the tracks, are passed over, and the mark of UTF-8. Fields phi_1, theta_1, x_2, y_2
 * name an arm; the i-th x and the i-th y without a number are those of listed arm i. A unit may
 * stand behind, as in theta_1 (deg). Other fields are passed over.
 *
 * text    a string of the document.
 * n       arms of the pendulum; the one arm of such a pendulum need not be listed.
 * listed   `count` arms from 0.
 * degrees  whether angles without a unit are in degrees.
 *
 * Every fault is added. O(bytes).
 */
void api_csv_head(struct api_csv *csv, const struct api_value *text, int n, int count,
                  const int listed[], int degrees, struct api_problem *problem);

/**
 * Reads the rows: numbers with a point, or with a comma where that does not separate; an empty
 * field was not measured.
 *
 * t     out, csv->rows.
 * data  out, [column * rows + row]; NaN where nothing was measured.
 *
 * Faults of the first lines that have any are added. O(bytes).
 */
void api_csv_rows(const struct api_csv *csv, const struct api_value *text, double t[],
                  double data[], struct api_problem *problem);

#endif
