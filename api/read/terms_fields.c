#include "api/read/terms_fields.h"

#include <assert.h>
#include <math.h>

#define MORE_THAN_0 4.9406564584124654e-324

/* m/s, default speed of the drag law. At this speed a body of a centimeter in air has a Reynolds
 * number of 7, far below those at which drag is quadratic; from 0.1 m/s on it changes the drag by
 * less than 0.5 %. Steps near a turning point have a length of about speed / acceleration, a
 * millisecond. */
static const double usual_drag_speed = 0.01;

static const struct api_terms_row fields[API_TERMS_FIELDS] = {
    [API_TERMS_ROD] = {"rod",
                       API_TERMS_PLAIN,
                       {{NULL, PEND_TERM_ROD, 0, 1, MORE_THAN_0, "kg", {"rod"}}}},
    [API_TERMS_BODY] =
        {"body",
         API_TERMS_OBJECT,
         {{"mass", PEND_TERM_BODY, 0, 1, MORE_THAN_0, "kg", {"body_mass"}},
          {"center", PEND_TERM_CENTER_X, 1, 1, -INFINITY, "m", {"center_x", "center_y"}},
          {"inertia", PEND_TERM_INERTIA, 0, 0, 0, "kg m^2", {"inertia"}}}},
    [API_TERMS_AT] = {"at",
                      API_TERMS_PLAIN,
                      {{NULL, PEND_TERM_AT_X, 1, 1, -INFINITY, "m", {"at_x", "at_y"}}}},
    [API_TERMS_DAMPING] = {"damping",
                           API_TERMS_PLAIN,
                           {{NULL, PEND_TERM_DAMPING, 0, 0, 0, "N m s/rad", {"damping"}}}},
    [API_TERMS_STIFFNESS] = {"stiffness",
                             API_TERMS_PLAIN,
                             {{NULL, PEND_TERM_STIFFNESS, 0, 0, 0, "N m/rad", {"stiffness"}}}},
    [API_TERMS_REST] = {"rest",
                        API_TERMS_PLAIN,
                        {{NULL, PEND_TERM_REST, 0, 0, -INFINITY, "rad", {"rest"}}}},
    [API_TERMS_FRICTION] =
        {"friction",
         API_TERMS_RUBS,
         {{"torque", PEND_TERM_FRICTION, 0, 1, 0, "N m", {"friction_torque"}},
          {"speed", PEND_TERM_FRICTION_SPEED, 0, 1, MORE_THAN_0, "rad/s", {"friction_speed"}}}},
    [API_TERMS_TORQUE] = {"torque",
                          API_TERMS_DRIVE,
                          {{"constant", PEND_TERM_TORQUE, 0, 0, -INFINITY, "N m", {"torque"}}}},
    [API_TERMS_DRAG] =
        {"drag",
         API_TERMS_OBJECT,
         {{"linear", PEND_TERM_DRAG, 0, 0, 0, "N s/m", {"drag"}},
          {"quadratic", PEND_TERM_DRAG_QUADRATIC, 0, 0, 0, "N s^2/m^2", {"drag_quadratic"}},
          {"speed", PEND_TERM_DRAG_SPEED, 0, 0, MORE_THAN_0, "m/s", {"drag_speed"}}}},
    [API_TERMS_STOP] = {"stop", API_TERMS_STOPS, {{.name = NULL}}},
};

const struct api_terms_row *api_terms_row(enum api_terms_field field) {
    assert(field >= 0 && field < API_TERMS_FIELDS);
    return &fields[field];
}

const char *api_terms_varied(enum pend_term_row row) {
    for (int f = 0; f < API_TERMS_FIELDS; f++)
        for (const struct api_terms_part *part = fields[f].part; part->unit; part++)
            for (int i = 0; i <= part->point; i++)
                if (part->row + (unsigned)i == row) return part->varied[i];
    assert(!"every term of an arm has a field");
    return NULL;
}

double api_terms_usual(enum pend_term_row row) {
    if (row == PEND_TERM_AT_X) return NAN;
    if (row == PEND_TERM_FRICTION_SPEED)
        return 1; /* any number above 0, for arms without
                   * friction */
    return row == PEND_TERM_DRAG_SPEED ? usual_drag_speed : 0;
}
