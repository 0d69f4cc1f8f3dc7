#include "api/op/equations/equations_real_latex.h"

#include "api/op/equations/equations_latex.h"
#include "api/op/equations/equations_pieces.h"

enum { REAL_LISTED = 20, REAL_LEFT_OUT = 10 }; /* arms of a list that is written whole, and else */

static int real_cart(const struct api_equations *e) { return pend_terms_cart(e->loads.terms); }

/* torques are driven */
static int real_drives(const struct api_equations *e) {
    return (api_pieces_have(e) & API_HAVE_DRIVES) != 0;
}

/* the pivot moves */
static int real_moves(const struct api_equations *e) {
    return (api_pieces_have(e) & (API_HAVE_PIVOT | API_HAVE_CART)) != 0;
}

static int real_air(const struct api_equations *e) {
    return api_equations_has(e, PEND_TERM_DRAG) || api_equations_has(e, PEND_TERM_DRAG_QUADRATIC);
}

static int real_mist(const struct api_equations *e) {
    return e->loads.terms->one[PEND_TERM_DRAG_PER_MASS] >= 0;
}

static int real_joints(const struct api_equations *e) {
    return (api_pieces_have(e) & API_HAVE_JOINTS) != 0;
}

/* (a,\,b), or (a,\,\ldots,\,c) if there are many */
static enum pend_status real_list(const struct api_equations *e, enum pend_term_row row,
                                  struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "("));
    for (int i = 0; i < e->n; i++) {
        if (i) PEND_TRY(api_buffer_text(out, ",\\,"));
        if (e->n > REAL_LISTED && i == REAL_LEFT_OUT) {
            PEND_TRY(api_buffer_text(out, "\\ldots,\\,"));
            i = e->n - 1;
        }
        PEND_TRY(api_latex_number(pend_terms_get(e->loads.terms, e->loads.value, row, e->place[i]),
                                  out));
    }
    return api_buffer_text(out, ")");
}

static enum pend_status real_parameters(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_latex_at(0)->write(e, out));
    const struct api_equations_term *term;
    for (int t = 0; (term = api_equations_term(t)); t++) {
        if (!term->letter || !api_equations_has_term(e, term)) continue;
        PEND_TRY(api_buffer_format(out, ",\\qquad %s=", term->letter));
        PEND_TRY(real_list(e, term->row, out));
        PEND_TRY(api_buffer_format(out, "\\,\\mathrm{%s}", term->unit));
    }
    if (!real_mist(e)) return PEND_OK;
    PEND_TRY(api_buffer_text(out, ",\\qquad\\gamma="));
    PEND_TRY(api_latex_number(e->loads.value[e->loads.terms->one[PEND_TERM_DRAG_PER_MASS]], out));
    return api_buffer_text(out, "\\,\\mathrm{1/s}");
}

static enum pend_status real_path(const struct api_equations *e, struct api_buffer *out) {
    return api_latex_at(1)->write(e, out);
}

static enum pend_status real_force_map(const struct api_equations *e, struct api_buffer *out) {
    return api_latex_at(2)->write(e, out);
}

/* where arm i hangs on the one that carries it */
static enum pend_status real_hang(const struct api_equations *e, int i, struct api_buffer *out) {
    const struct pend_loads *loads = &e->loads;
    int k = e->place[i], p = e->parent[i];
    PEND_TRY(api_buffer_format(out, ",\\quad H_{%d,%d}=", i + 1, p + 1));
    if (!loads->terms->hung[k]) return api_buffer_format(out, "\\ell_{%d}", p + 1);
    double y = pend_terms_get(loads->terms, loads->value, PEND_TERM_AT_Y, k);
    PEND_TRY(api_latex_number(pend_terms_get(loads->terms, loads->value, PEND_TERM_AT_X, k), out));
    if (y == 0) return PEND_OK;
    if (y > 0) PEND_TRY(api_buffer_text(out, "+"));
    PEND_TRY(api_latex_number(y, out));
    return api_buffer_text(out, "\\,\\mathrm{i}");
}

static enum pend_status real_tips(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(out,
                               "z=%sZe^{\\mathrm{i}\\phi},\\qquad "
                               "Z=SH+\\operatorname{diag}(\\ell)",
                               real_moves(e) ? "z_{0}+" : ""));
    for (int i = 0; i < e->n && e->n <= REAL_LISTED; i++)
        if (e->parent[i] >= 0) PEND_TRY(real_hang(e, i, out));
    return PEND_OK;
}

/* a mass r of arm k at p_r has the row (SH)_k + p_r of P */
static enum pend_status real_mass(const struct api_equations *e, struct api_buffer *out) {
    (void)e;
    return api_buffer_text(
        out, "M(\\phi)=\\operatorname{diag}\\bigl(e^{-\\mathrm{i}\\phi}\\bigr)P^{\\mathsf{H}}"
             "\\operatorname{diag}(m)P\\operatorname{diag}\\bigl(e^{\\mathrm{i}\\phi}\\bigr)"
             "+\\operatorname{diag}\\bigl(\\tfrac{1}{12}\\mu\\ell^{2}+I\\bigr),\\qquad "
             "P_{rj}=(SH)_{kj}+p_{r}\\delta_{kj},\\qquad h=P^{\\mathsf{H}}m,\\qquad "
             "p_{r}\\in\\{\\ell_{k},\\,\\tfrac{1}{2}\\ell_{k},\\,x_{k}+\\mathrm{i}y_{k}\\}");
}

static enum pend_status real_aaa(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(
        out,
        "\\operatorname{Re}M(\\phi)\\;\\ddot{\\phi}=\\operatorname{Im}M(\\phi)\\;\\dot{\\phi}^{2}-"
        "\\operatorname{Im}\\bigl[e^{-\\mathrm{i}\\phi}h\\,(%s\\mathrm{i}g)\\bigr]",
        real_moves(e) ? "\\ddot{z}_{0}+" : ""));
    if (real_joints(e)) PEND_TRY(api_buffer_text(out, "+B\\tau"));
    if (real_air(e))
        PEND_TRY(api_buffer_text(
            out, "+\\operatorname{Im}\\bigl[e^{-\\mathrm{i}\\phi}Z^{\\mathsf{H}}F\\bigr]"));
    if (!real_mist(e)) return PEND_OK;
    PEND_TRY(api_buffer_text(out, "-2\\gamma\\Bigl(\\operatorname{Re}M(\\phi)\\;\\dot{\\phi}"));
    if (real_moves(e))
        PEND_TRY(api_buffer_text(
            out, "+\\operatorname{Im}\\bigl[e^{-\\mathrm{i}\\phi}h\\,\\dot{z}_{0}\\bigr]"));
    return api_buffer_text(out, "\\Bigr)");
}

static enum pend_status real_bbb(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(
        out,
        "\\lambda_{k}=\\operatorname{Re}\\Bigl[e^{-\\mathrm{i}\\phi_{k}}\\Bigl(\\sum_{r}m_{r}"
        "\\bigl(\\ddot{z}_{r}+\\mathrm{i}g%s\\bigr)",
        real_mist(e) ? "+2\\gamma\\dot{z}_{r}" : ""));
    if (real_air(e)) PEND_TRY(api_buffer_text(out, "-\\sum_{j}F_{j}"));
    return api_buffer_format(out,
                             "\\Bigr)\\Bigr],\\qquad z_{r}=%s(Pe^{\\mathrm{i}\\phi})_{r},\\quad r%s"
                             "\\text{ at the tip of }k\\text{ and beyond}",
                             real_moves(e) ? "z_{0}+" : "", real_air(e) ? ",\\,j" : "");
}

/* + A \cos(\omega t + \varphi), with the signs of the numbers */
static enum pend_status real_harmonic(const struct api_equations *e, const struct pend_harmonic *h,
                                      const char *unit, struct api_buffer *out) {
    const double *value = e->loads.value + h->at;
    if (value[0] >= 0) PEND_TRY(api_buffer_text(out, "+"));
    PEND_TRY(api_latex_number(value[0], out));
    PEND_TRY(api_buffer_format(out, "%s\\cos(", unit));
    PEND_TRY(api_latex_number(value[1], out));
    PEND_TRY(api_buffer_text(out, "\\,t"));
    if (value[2] != 0) {
        if (value[2] > 0) PEND_TRY(api_buffer_text(out, "+"));
        PEND_TRY(api_latex_number(value[2], out));
    }
    return api_buffer_text(out, ")");
}

/* tau: what acts in the joints, and what drives them */
static enum pend_status real_torques(const struct api_equations *e, struct api_buffer *out) {
    const struct pend_terms *terms = e->loads.terms;
    int motor = api_equations_has(e, PEND_TERM_TORQUE) || real_drives(e);
    PEND_TRY(api_buffer_text(out, "\\tau&="));
    if (motor) PEND_TRY(api_buffer_text(out, "T"));
    const struct api_equations_term *term;
    for (int t = 0; (term = api_equations_term(t)); t++)
        if (term->latex && api_equations_has(e, term->row))
            PEND_TRY(api_buffer_text(out, term->latex));
    PEND_TRY(api_buffer_text(out, ",\\qquad q=B^{\\mathsf{T}}\\phi+\\tfrac{\\pi}{2}r,\\quad "
                                  "r_{k}=1\\text{ at the pivot, else }0"));
    for (int i = 0; i < e->n && motor && e->n <= REAL_LISTED; i++) {
        double constant = pend_terms_get(terms, e->loads.value, PEND_TERM_TORQUE, e->place[i]);
        PEND_TRY(api_buffer_format(out, "\\\\T_{%d}&=", i + 1));
        PEND_TRY(api_latex_number(constant, out));
        for (int j = 0; j < terms->harmonics; j++)
            if (terms->harmonic[j].drives == e->place[i])
                PEND_TRY(real_harmonic(e, &terms->harmonic[j], "", out));
    }
    return PEND_OK;
}

/* the cart's place, and what moves it */
static enum pend_status real_rail(const struct api_equations *e, struct api_buffer *out) {
    const struct pend_terms *terms = e->loads.terms;
    const double *value = e->loads.value;
    static const struct {
        enum pend_term_row row;
        const char *sign, *of;
    } numbers[] = {{PEND_TERM_DAMPING, "-", "\\,\\dot{x}"},
                   {PEND_TERM_STIFFNESS, "-", "\\,x"},
                   {PEND_TERM_TORQUE, "+", ""}};
    PEND_TRY(api_buffer_text(out, "z_{0}&=\\rho\\,x,\\qquad\\rho=e^{"));
    PEND_TRY(api_latex_number(value[terms->one[PEND_TERM_RAIL]], out));
    PEND_TRY(api_buffer_text(out, "\\,\\mathrm{i}}\\\\"));
    PEND_TRY(api_latex_number(e->tree->mass[0], out));
    PEND_TRY(api_buffer_format(
        out,
        "\\,\\bigl(\\ddot{x}+g\\operatorname{Im}\\rho%s\\bigr)&=-\\operatorname{Re}\\Bigl[\\bar{"
        "\\rho}"
        "\\Bigl(\\sum_{r}m_{r}\\bigl(\\ddot{z}_{r}+\\mathrm{i}g%s\\bigr)%s\\Bigr)\\Bigr]",
        real_mist(e) ? "+2\\gamma\\dot{x}" : "", real_mist(e) ? "+2\\gamma\\dot{z}_{r}" : "",
        real_air(e) ? "-\\sum_{j}F_{j}" : ""));
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        double number = pend_terms_get(terms, value, numbers[i].row, 0);
        if (number == 0) continue;
        // a force may point either way
        if (i < 2 || number > 0) PEND_TRY(api_buffer_text(out, numbers[i].sign));
        PEND_TRY(api_latex_number(number, out));
        PEND_TRY(api_buffer_text(out, numbers[i].of));
    }
    for (int j = 0; j < terms->harmonics; j++)
        if (api_pieces_drives(e, &terms->harmonic[j]) == API_HAVE_CART)
            PEND_TRY(real_harmonic(e, &terms->harmonic[j], "", out));
    return PEND_OK;
}

static enum pend_status real_pivot(const struct api_equations *e, struct api_buffer *out) {
    const struct pend_terms *terms = e->loads.terms;
    int at = terms->one[PEND_TERM_PIVOT_ACCELERATION_X];
    double x = at < 0 ? 0 : e->loads.value[at], y = at < 0 ? 0 : e->loads.value[at + 1];
    PEND_TRY(api_buffer_text(out, "z_{0}&=\\tfrac{1}{2}t^{2}("));
    PEND_TRY(api_latex_number(x, out));
    PEND_TRY(api_buffer_text(out, y < 0 ? "" : "+"));
    PEND_TRY(api_latex_number(y, out));
    PEND_TRY(api_buffer_text(out, "\\,\\mathrm{i})"));
    for (int j = 0; j < terms->harmonics && terms->harmonic[j].drives < 0; j++)
        PEND_TRY(real_harmonic(
            e, &terms->harmonic[j],
            terms->harmonic[j].drives == PEND_DRIVE_PIVOT_Y ? "\\,\\mathrm{i}" : "", out));
    return PEND_OK;
}

static enum pend_status real_loads(const struct api_equations *e, struct api_buffer *out) {
    int lines = 0;
    PEND_TRY(api_buffer_text(out, "\\begin{aligned}"));
    if (real_joints(e)) {
        PEND_TRY(real_torques(e, out));
        lines++;
    }
    if (real_air(e))
        PEND_TRY(api_buffer_format(out,
                                   "%sF&=-\\bigl(b+d\\sqrt{|\\dot{z}|^{2}+e^{2}}\\bigr)\\,\\dot{z}",
                                   lines++ ? "\\\\" : ""));
    if (real_moves(e)) {
        PEND_TRY(api_buffer_text(out, lines++ ? "\\\\" : ""));
        PEND_TRY(real_cart(e) ? real_rail(e, out) : real_pivot(e, out));
    }
    if (!lines) PEND_TRY(api_buffer_text(out, "\\tau&=0"));
    return api_buffer_text(out, "\\end{aligned}");
}

static const struct api_latex real_table[] = {
    {"parameters", real_parameters},
    {"S", real_path},
    {"B", real_force_map},
    {"z", real_tips},
    {"M", real_mass},
    {"aaa", real_aaa},
    {"bbb", real_bbb},
    {"loads", real_loads},
};

const struct api_latex *api_real_latex_at(int i) {
    return i >= 0 && i < (int)(sizeof real_table / sizeof *real_table) ? &real_table[i] : NULL;
}
