/* Reads the integration method and its settings from JSON: method, rtol, atol, step, precision,
 * accuracy.
 * Leaves to others: the methods and their ranges (core/integrate/methods/method).
 * Invariant: settings are in the range of the chosen method. */
#pragma once

#include "api/read/tree_json.h"
#include "core/integrate/methods/method.h"

struct api_method {
    const struct pend_method *method; /* NULL if it is invalid */
    double rtol, atol, step;          /* 0 = the method's default */
    int atol_given;                   /* whether atol was given, so that 0 means 0 and not the
                                       * default */
    double accuracy;                  /* rad, > 0: the error up to which the horizon extends */
};

/**
 * Reads the fields method, rtol, atol, step, precision and accuracy of a request.
 *
 * root    the request's object.
 * tree    the result of api_tree_read, for methods that need its modes; of an invalid tree the
 *         known parts are used.
 *
 * Every error is added to the problem.
 */
void api_method_read(struct api_method *method, const struct api_value *root,
                     const struct api_tree *tree, const struct api_limits *limits,
                     struct api_problem *problem);

/** Returns a sentence that says which supported setting gives more correct digits. */
const char *api_method_advice(const struct api_method *method);

/** Returns the field accuracy of a request; 1e-6 if it is missing or invalid. */
double api_accuracy_read(const struct api_value *root, struct api_problem *problem);
