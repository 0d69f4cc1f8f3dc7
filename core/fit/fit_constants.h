/* The tuning constants of fits, a row each: value, unit, what it decides, and in brackets the test
 * that fails at three times the value or a third. A row without has none yet.
 * Leaves to others: limits of requests (api/base/limits). Invariant: no other file of the folder
 * has such a number by name. */
#pragma once

/* Step of the search at which a window of rows that will grow is done. Unit: relative.
 * [wrong_requests_of_fits_are_told_what_helps] */
static const double fit_rough = 1e-3;
/* Step at which the search of all rows has converged. Unit: relative.
 * [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_fine = 1e-6;
/* The same of a search that begins anew in a curved valley. Unit: relative. */
static const double fit_finest = 1e-12;
/* Most iterations in a window that will grow. [wrong_requests_of_fits_are_told_what_helps] */
enum { FIT_WINDOW_ITERATIONS = 12 };
/* Iterations of all rows after which bounds are examined. */
enum { FIT_BOUND_ITERATIONS = 16 };
/* Later rows are taken in while they are foretold to this standard deviation. Unit: rad, or the
 * reach. [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_foretold = 0.4;
/* Cap of a motion's steps, and as many for each arm and swing. Unit: steps. */
enum { FIT_STEPS = 200 };
/* Residual where there is no motion. Unit: residual. */
static const double fit_nowhere = 1e6;
/* A motion that explains less does not follow the data. Unit: of the squares.
 * [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_explained = 0.9;
/* A motion that explains more follows them without further tests. Unit: of the squares.
 * [fits_of_synthetic_data_are_within_three_standard_errors] */
static const double fit_clear = 0.99;
/* What is left is rounding: the data are met exactly. Unit: of the squares. */
static const double fit_exact = 1e-12;
/* Mean residual from which on they are no noise. Unit: sigma. */
static const double fit_strange = 3;
/* Neighbouring residuals with more in common are no noise. Unit: of the squares. */
static const double fit_common = 0.5;
/* Neighbours that are needed to tell. Unit: pairs. */
enum { FIT_PAIRS = 16 };
/* An unknown that moved farther is reported as not identifiable. Unit: of its start. */
static const double fit_away = 1e6;
/* A smaller fall of the squares is rounding, after a search begun anew. Unit: of the variance. */
static const double fit_fall = 0.01;
/* Most unknowns whose second derivatives are computed. Unit: unknowns. */
enum { FIT_BENDS = 16 };
/* What one more step may gain at a minimum, beside fit_step. Unit: of the squares.
 * [searches_in_a_curved_valley_go_on_to_its_lowest_place] */
static const double fit_minimum = 1e-6;
/* The same in squared standard errors. Unit: of the variance. */
static const double fit_step = 1e-4;
/* By how much data that are met exactly may be missed. Unit: rtol. */
static const double fit_loose = 300;
/* Rounding of a motion; smaller effects of an unknown are none. Unit: relative. */
static const double fit_rounding = 1e-13;
/* Least singular value, over the largest, whose direction is identifiable. Unit: relative.
 * [fits_say_by_how_much_wanted_frequencies_cannot_be_had] */
static const double fit_least = 1e-9;
/* Largest standard error at which a smaller one is identifiable. Unit: sizes. */
static const double fit_unsure = 1e3;
/* Slopes whose squares can still be summed. */
static const double fit_largest = 1e140;
/* Part in blind directions from which on an unknown is reported alone. Unit: of a square.
 * [fits_to_data_at_rest_name_one_by_one_what_they_do_not_tell] */
static const double fit_alone = (1 - 1e-6);
/* A blind direction with less of its own repeats others. Unit: of a length. */
static const double fit_left = 0.1;
/* A smaller bend of the squares is no minimum. Unit: of the slopes'. */
static const double fit_flat = 1e-6;
/* Steps of differences of slopes. Unit: relative. */
static const double fit_curve_step = 1e-4;
/* Error of a motion in those differences. Unit: rtol. */
static const double fit_curve_margin = 10;
/* Effect of an unknown at its bound that counts as none. Unit: of the data. */
static const double fit_unmoved = 1e-6;
/* How far inside the bound such an unknown begins again. Unit: of the interval. */
static const double fit_little = 1e-3;
/* Significance of the tests of the model. Unit: p-value. */
static const double fit_level = 1e-3;
/* Least noise of measurements without a sigma. Unit: of a column. */
static const double fit_known_best = 1e-6;
/* Errors are withheld where less is left to tell the noise by. Unit: of the data. */
static const double fit_freedom = 0.25;
/* One of so many may be an outlier. Unit: measurements.
 * [fits_list_outliers_and_robust_losses_pass_them_by] */
enum { FIT_OUTLIERS = 10 };
/* Degrees of freedom that are needed to accept a model untested. */
enum { FIT_FREEDOM = 3 };
/* Places on less of a circle give no scale. Unit: of the spread. */
static const double fit_circle_flat = 1e-9;
/* Residuals beyond it are those of another motion. Unit: noise. */
static const double fit_noisy = 10;
/* By how much the first rows may leave a steady pace. Unit: rad. */
static const double fit_bent = 0.1;
/* The first step over the longest of the next, above which the first row is an outlier. Of a
 * parabola it is at most 5 / 3. */
static const double fit_outlier = 5;
/* On each side, through which a parabola goes. Unit: rows. */
enum { FIT_BESIDE = 2 };
/* First rows whose pace is the rate, and places that a circle needs. Unit: rows. */
enum { FIT_FIRST = 5 };
/* Most arms where one without a tip is placed in a line with others. Unit: arms. */
enum { FIT_LINE_ARMS = 30 };
/* First rows in which such an arm is looked for. Unit: rows. */
enum { FIT_LINE_ROWS = 64 };
/* Least rows of a piece. Unit: rows. */
enum { FIT_PIECE_ROWS = 4 };
/* Most pieces. Unit: pieces. */
enum { FIT_PIECES = 24 };
/* Rounds of tighter joints. Unit: rounds. */
enum { FIT_ROUNDS = 4 };
/* Iterations in a round. */
enum { FIT_ROUND_ITERATIONS = 15 };
/* Most measurements that are cut. Unit: numbers. */
enum { FIT_PIECE_NUMBERS = 16384 };
/* How far joints gape at first; a tenth of that in each round after it. Unit: sigma. */
static const double fit_gape = 10;
/* Length of a piece: a tip over the top takes as long for half a turn. Unit: swing. */
static const double fit_piece = 0.25;
