/* The fields of an arm of a real pendulum, in one table: their names, ranges and units, and their
 * terms.
 * Leaves to others: reading them (terms_json), writing them (op/terms_write), their effect
 * (core/tree/terms). */
#pragma once

#include "core/tree/terms.h"

/* the names of the table, in its order; also the names of lists next to "length", "mass" and
 * "parent" */
#define API_TERMS_OF_ARMS                                                                          \
    "rod", "body", "at", "damping", "stiffness", "rest", "friction", "torque", "drag", "stop"
/* the fields of the whole pendulum, in every form */
#define API_TERMS_OF_ALL "drag_per_mass", "pivot"

enum api_terms_field {
    API_TERMS_ROD,
    API_TERMS_BODY,
    API_TERMS_AT,
    API_TERMS_DAMPING,
    API_TERMS_STIFFNESS,
    API_TERMS_REST,
    API_TERMS_FRICTION,
    API_TERMS_TORQUE,
    API_TERMS_DRAG,
    API_TERMS_STOP,
    API_TERMS_FIELDS
};

enum { API_TERMS_PARTS = 3 };

/* A number or a point of a field. */
struct api_terms_part {
    const char *name; /* name in the field's object; NULL if the field is not an object */
    enum pend_term_row row;
    int point;  /* two rows: a number along the arm, or [along, across] */
    int needed; /* required */
    double least;
    const char *unit; /* unit of the number; NULL ends the list of parts */
    /* the name, or the two names of a point, under which it occurs in axes and draws of ensembles,
     * in derivatives and fits */
    const char *varied[2];
};

enum api_terms_kind {
    API_TERMS_PLAIN,  /* the field's single part */
    API_TERMS_OBJECT, /* an object with its parts */
    API_TERMS_DRIVE,  /* the field's single part, or an object of that, "constant", "harmonics" and
                       * "table" */
    API_TERMS_RUBS,   /* an object with its parts, or Coulomb friction, which has no "speed" */
    API_TERMS_STOPS   /* an object of rules, without parts */
};

struct api_terms_row {
    const char *name;
    enum api_terms_kind kind;
    struct api_terms_part part[API_TERMS_PARTS + 1];
};

/** Returns the row of a field. O(1). */
const struct api_terms_row *api_terms_row(enum api_terms_field field);

/** Returns the name of a number of an arm in axes, draws, derivatives and fits: "friction_torque".
 * O(fields). */
const char *api_terms_varied(enum pend_term_row row);

/** Returns the default of a number of an arm; NAN for its position along its parent, whose default
 * is the parent's length. O(1). */
double api_terms_usual(enum pend_term_row row);
