#include "api/op/orbits/orbits_told.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const ends[PEND_ORBITS_ENDS] = {
    [PEND_ORBITS_REACHED] = "reached", [PEND_ORBITS_POINTS] = "points",
    [PEND_ORBITS_LOST] = "lost",       [PEND_ORBITS_MEETS] = "meets",
    [PEND_ORBITS_WILD] = "wild",       [PEND_ORBITS_BACK] = "back",
    [PEND_ORBITS_NONE] = "none",       [PEND_ORBITS_MISSING] = "missing",
    [PEND_ORBITS_APART] = "apart",     [PEND_ORBITS_CLOSED] = "closed"};

const char *api_orbits_end(enum pend_orbits_end end) {
    assert(end < PEND_ORBITS_ENDS);
    return ends[end];
}

static void told_apart(const struct pend_orbits *search, char text[API_WARNING_TEXT]) {
    static const char *const whys[PEND_ORBITS_KINDS] = {
        [PEND_ORBITS_FOLD] =
            "a fold: the branch itself turns back there, and no other branch begins",
        [PEND_ORBITS_TORUS] = "one from which motions on a torus begin, which are not periodic",
        [PEND_ORBITS_BRANCH] = "one whose other orbits were not found",
        [PEND_ORBITS_SYMMETRY] = "one whose other orbits were not found",
        [PEND_ORBITS_DOUBLING] = "one whose orbits take more than 8 periods or were not found"};
    snprintf(text, API_WARNING_TEXT, "cannot switch branches at this bifurcation: it is %s",
             whys[pend_orbits_orbit(search).kind]);
}

/* writes why the branch came back to the parameter value where it started */
static void told_back(const struct pend_orbits *search, char text[API_WARNING_TEXT]) {
    static const char *const others[PEND_ORBITS_KINDS] = {
        [PEND_ORBITS_BRANCH] = "orbits of another branch",
        [PEND_ORBITS_SYMMETRY] = "orbits that are their own mirror images",
        [PEND_ORBITS_DOUBLING] = "orbits of half the period"};
    enum pend_orbits_kind kind = pend_orbits_turned(search);
    if (kind < PEND_ORBITS_KINDS)
        snprintf(text, API_WARNING_TEXT,
                 "the branch turns back where it meets %s. Those continue: follow them with the "
                 "field switch.",
                 others[kind]);
    else
        snprintf(text, API_WARNING_TEXT,
                 "the branch turns back and returns to the parameter value where it started: it "
                 "does not reach the requested end");
}

static void told_twins(const struct pend_orbits *search, char text[API_WARNING_TEXT]) {
    int twin[2], against, likes = pend_orbits_twins(search, twin, &against);
    size_t used = strlen(text);
    if (!likes) return;
    snprintf(text + used, API_WARNING_TEXT - used,
             against ? ". The equal branches at arms %d and %d swing against each other and the "
                       "others hang still; any two of the %d equal branches can"
                     : ". The frequency occurs more than once: there are also orbits in which the "
                       "equal branches at arms %d and %d, or any two of the %d, swing against each "
                       "other and the others hang still",
             twin[0] + 1, twin[1] + 1, likes);
}

void api_orbits_sentence(const struct pend_orbit_problem *p, const struct pend_orbits *search,
                         long orbits, char text[API_WARNING_TEXT]) {
    const char *where = orbits ? "beyond the last orbit" : "on the way there";
    int left = pend_orbits_left(search);
    switch (pend_orbits_end(search)) {
    case PEND_ORBITS_REACHED:
        snprintf(text, API_WARNING_TEXT, "the orbits reach the requested end");
        told_twins(search, text);
        return;
    case PEND_ORBITS_POINTS:
        snprintf(text, API_WARNING_TEXT,
                 "the branch continues, but was followed only for %d steps. More points or longer "
                 "steps go further.",
                 p->points);
        return;
    case PEND_ORBITS_LOST:
        snprintf(text, API_WARNING_TEXT,
                 "%s no orbit was found, with any step: the branch ends there or turns too "
                 "sharply. Is there an orbit nearby that never returns?",
                 where);
        return;
    case PEND_ORBITS_MEETS:
        snprintf(text, API_WARNING_TEXT,
                 "%s are orbits with 1/%d of this period. They belong to another branch.", where,
                 pend_orbits_part(search));
        return;
    case PEND_ORBITS_WILD:
        snprintf(text, API_WARNING_TEXT,
                 "%s errors grow so much in a period that double precision cannot decide whether "
                 "an orbit closes.",
                 where);
        return;
    case PEND_ORBITS_BACK:
        told_back(search, text);
        return;
    case PEND_ORBITS_CLOSED:
        snprintf(text, API_WARNING_TEXT,
                 "the branch is closed: it returns to its first orbit and does not reach the "
                 "requested end");
        return;
    case PEND_ORBITS_MISSING:
        snprintf(text, API_WARNING_TEXT, "branch %d has no bifurcation number %d to switch at",
                 1 + left, abs(p->leave[left]));
        return;
    case PEND_ORBITS_APART:
        told_apart(search, text);
        return;
    case PEND_ORBITS_NONE:
    case PEND_ORBITS_ENDS:
        break;
    }
    snprintf(text, API_WARNING_TEXT,
             p->driven ? "no orbit was found near this start. Let the motion settle first, start "
                         "elsewhere, or try more periods."
                       : "no orbit of this mode was found, even for small swings: another mode may "
                         "have the same or three times the frequency.");
}
