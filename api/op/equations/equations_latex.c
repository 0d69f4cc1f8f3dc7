#include "api/op/equations/equations_latex.h"

#include "api/number/number.h"

enum {
    LATEX_LISTED = 20,  /* arms up to which matrices and lists are written whole */
    LATEX_MATRIX = 10,  /* columns that pmatrix has in amsmath */
    LATEX_SHORT = 2,    /* arms up to which a row of (aaa) is one line */
    LATEX_LEFT_OUT = 10 /* entries at the beginning of a longer list */
};

/* --- pieces --- */

enum pend_status api_latex_number(double number, struct api_buffer *out) {
    PEND_TRY(api_buffer_room(out, API_NUMBER_BYTES));
    char *at = out->data + out->bytes, *end = api_number_write(at, number), *exponent = at;
    while (exponent < end && *exponent != 'e') exponent++;
    int power = 0, negative = exponent + 1 < end && exponent[1] == '-';
    for (char *digit = exponent + 1 + negative; digit < end; digit++)
        power = 10 * power + (*digit - '0');
    out->bytes = (size_t)(exponent - out->data);
    return exponent < end ? api_buffer_format(out, "\\cdot10^{%s%d}", negative ? "-" : "", power)
                          : PEND_OK;
}

/* (m_{2}+m_{3}): the masses that an arm carries, its own included */
static enum pend_status latex_masses(const struct api_equations *equations, int arm,
                                     struct api_buffer *out) {
    int count = 0;
    for (int k = 0; k < equations->n; k++) count += api_equations_carries(equations, arm, k);
    if (count > 1) PEND_TRY(api_buffer_text(out, "("));
    for (int k = 0, written = 0; k < equations->n; k++) {
        if (!api_equations_carries(equations, arm, k)) continue;
        PEND_TRY(api_buffer_format(out, "%sm_{%d}", written++ ? "+" : "", k + 1));
    }
    return count > 1 ? api_buffer_text(out, ")") : PEND_OK;
}

/* the deeper of two arms of which one carries the other, -1 if neither does: S^T diag(m) S is 0
 * there */
static int latex_deeper(const struct api_equations *equations, int i, int j) {
    if (api_equations_carries(equations, i, j)) return j;
    return api_equations_carries(equations, j, i) ? i : -1;
}

/* (m_{2}+m_{3})\,\ell_{1}\ell_{2}, the size of an entry of M */
static enum pend_status latex_size(const struct api_equations *equations, int i, int j,
                                   struct api_buffer *out) {
    PEND_TRY(latex_masses(equations, latex_deeper(equations, i, j), out));
    if (i == j) return api_buffer_format(out, "\\ell_{%d}^{2}", i + 1);
    return api_buffer_format(out, "\\ell_{%d}\\ell_{%d}", (i < j ? i : j) + 1, (i < j ? j : i) + 1);
}

/* an entry of a matrix that is written out */
typedef enum pend_status latex_entry_fn(const struct api_equations *equations, int i, int j,
                                        struct api_buffer *out);

static enum pend_status latex_matrix(const struct api_equations *equations, latex_entry_fn *entry,
                                     const char *align, struct api_buffer *out) {
    int n = equations->n, plain = n <= LATEX_MATRIX;
    PEND_TRY(api_buffer_text(out, plain ? "\\begin{pmatrix}" : "\\left(\\begin{array}{"));
    for (int j = 0; j < n && !plain; j++) PEND_TRY(api_buffer_text(out, align));
    if (!plain) PEND_TRY(api_buffer_text(out, "}"));
    for (int i = 0; i < n; i++) {
        if (i) PEND_TRY(api_buffer_text(out, "\\\\"));
        for (int j = 0; j < n; j++) {
            if (j) PEND_TRY(api_buffer_text(out, "&"));
            PEND_TRY(entry(equations, i, j, out));
        }
    }
    return api_buffer_text(out, plain ? "\\end{pmatrix}" : "\\end{array}\\right)");
}

/* an item of a list */
typedef enum pend_status latex_item_fn(const struct api_equations *equations, int i,
                                       struct api_buffer *out);

/* (a,b,c), or (a,\ldots,c) if there are many */
static enum pend_status latex_list(const struct api_equations *equations, latex_item_fn *item,
                                   struct api_buffer *out) {
    int n = equations->n;
    PEND_TRY(api_buffer_text(out, "("));
    for (int i = 0; i < n; i++) {
        if (i) PEND_TRY(api_buffer_text(out, ",\\,"));
        if (n > LATEX_LISTED && i == LATEX_LEFT_OUT) {
            PEND_TRY(api_buffer_text(out, "\\ldots,\\,"));
            i = n - 1;
        }
        PEND_TRY(item(equations, i, out));
    }
    return api_buffer_text(out, ")");
}

/* --- parameters --- */

static enum pend_status latex_item_length(const struct api_equations *equations, int i,
                                          struct api_buffer *out) {
    return api_latex_number(equations->length[i], out);
}

static enum pend_status latex_item_mass(const struct api_equations *equations, int i,
                                        struct api_buffer *out) {
    return api_latex_number(equations->mass[i], out);
}

static enum pend_status latex_item_parent(const struct api_equations *equations, int i,
                                          struct api_buffer *out) {
    return api_buffer_format(out, "%d", equations->parent[i] + 1);
}

static enum pend_status latex_parameters(const struct api_equations *equations,
                                         struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "\\ell="));
    PEND_TRY(latex_list(equations, latex_item_length, out));
    PEND_TRY(api_buffer_text(out, "\\,\\mathrm{m},\\qquad m="));
    PEND_TRY(latex_list(equations, latex_item_mass, out));
    PEND_TRY(api_buffer_text(out, "\\,\\mathrm{kg},\\qquad g="));
    PEND_TRY(api_latex_number(equations->loads.gravity, out));
    return api_buffer_text(out, "\\,\\mathrm{m/s^{2}}");
}

/* --- S and B --- */

static enum pend_status latex_entry_path(const struct api_equations *equations, int i, int j,
                                         struct api_buffer *out) {
    return api_buffer_text(out, api_equations_carries(equations, j, i) ? "1" : "0");
}

/* S = I + P S, where P has a 1 at (k, the arm that carries k) */
static enum pend_status latex_path(const struct api_equations *equations, struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "S="));
    if (equations->n <= LATEX_LISTED) return latex_matrix(equations, latex_entry_path, "c", out);
    PEND_TRY(api_buffer_text(out, "(I-P)^{-1},\\qquad P_{k,\\,p_{k}}=1,\\qquad p="));
    return latex_list(equations, latex_item_parent, out);
}

static enum pend_status latex_entry_force(const struct api_equations *equations, int i, int j,
                                          struct api_buffer *out) {
    return api_buffer_text(out, i == j ? "1" : equations->parent[j] == i ? "-1" : "0");
}

static enum pend_status latex_force_map(const struct api_equations *equations,
                                        struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "B=S^{-\\mathsf{T}}="));
    if (equations->n <= LATEX_LISTED) return latex_matrix(equations, latex_entry_force, "r", out);
    return api_buffer_text(out, "I-P^{\\mathsf{T}}");
}

/* --- z --- */

static enum pend_status latex_tips(const struct api_equations *equations, struct api_buffer *out) {
    if (!equations->is_explicit)
        return api_buffer_text(out, "z=S\\,\\bigl[\\ell\\,e^{\\mathrm{i}\\phi}\\bigr]");
    PEND_TRY(api_buffer_text(out, "\\begin{aligned}"));
    for (int k = 0; k < equations->n; k++) {
        PEND_TRY(api_buffer_format(out, "%sz_{%d}&=", k ? "\\\\" : "", k + 1));
        for (int j = 0, written = 0; j < equations->n; j++) {
            if (!api_equations_carries(equations, j, k)) continue;
            PEND_TRY(api_buffer_format(out, "%s\\ell_{%d}e^{\\mathrm{i}\\phi_{%d}}",
                                       written++ ? "+" : "", j + 1, j + 1));
        }
    }
    return api_buffer_text(out, "\\end{aligned}");
}

/* --- M --- */

static enum pend_status latex_entry_mass(const struct api_equations *equations, int i, int j,
                                         struct api_buffer *out) {
    if (latex_deeper(equations, i, j) < 0) return api_buffer_text(out, "0");
    PEND_TRY(latex_size(equations, i, j, out));
    if (i == j) return PEND_OK;
    return api_buffer_format(out, "e^{\\mathrm{i}(\\phi_{%d}-\\phi_{%d})}", j + 1, i + 1);
}

static enum pend_status latex_mass(const struct api_equations *equations, struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "M(\\phi)="));
    if (equations->is_explicit) return latex_matrix(equations, latex_entry_mass, "c", out);
    return api_buffer_text(
        out, "\\operatorname{diag}\\bigl(e^{-\\mathrm{i}\\phi}\\,\\ell\\bigr)\\,S^{\\mathsf{T}}"
             "\\operatorname{diag}(m)\\,S\\,"
             "\\operatorname{diag}\\bigl(\\ell\\,e^{\\mathrm{i}\\phi}\\bigr)");
}

/* --- (aaa) and (bbb) --- */

/* \cos(\phi_{2}-\phi_{1}) and the like */
static enum pend_status latex_turned(const char *function, int i, int j, struct api_buffer *out) {
    return api_buffer_format(out, "%s(\\phi_{%d}-\\phi_{%d})", function, j + 1, i + 1);
}

/* row i of Re M phi'' = Im M phi'^2 - g cos(phi) l (S^T m), on two lines if it is long */
static enum pend_status latex_aaa_row(const struct api_equations *equations, int i,
                                      struct api_buffer *out) {
    for (int j = 0, written = 0; j < equations->n; j++) {
        if (latex_deeper(equations, i, j) < 0) continue;
        if (written++) PEND_TRY(api_buffer_text(out, "+"));
        PEND_TRY(latex_size(equations, i, j, out));
        if (i != j) PEND_TRY(latex_turned("\\cos", i, j, out));
        PEND_TRY(api_buffer_format(out, "\\ddot{\\phi}_{%d}", j + 1));
    }
    PEND_TRY(api_buffer_text(out, equations->n > LATEX_SHORT ? "\\\\&\\qquad{}=" : "="));
    for (int j = 0, written = 0; j < equations->n; j++) {
        if (i == j || latex_deeper(equations, i, j) < 0) continue;
        if (written++) PEND_TRY(api_buffer_text(out, "+"));
        PEND_TRY(latex_size(equations, i, j, out));
        PEND_TRY(latex_turned("\\sin", i, j, out));
        PEND_TRY(api_buffer_format(out, "\\dot{\\phi}_{%d}^{2}", j + 1));
    }
    PEND_TRY(api_buffer_text(out, "-g"));
    PEND_TRY(latex_masses(equations, i, out));
    return api_buffer_format(out, "\\ell_{%d}\\cos\\phi_{%d}", i + 1, i + 1);
}

static enum pend_status latex_aaa(const struct api_equations *equations, struct api_buffer *out) {
    if (!equations->is_explicit)
        return api_buffer_text(
            out, "\\ddot{\\phi}=\\bigl(\\operatorname{Re}M(\\phi)\\bigr)^{-1}\\Bigl["
                 "\\operatorname{Im}M(\\phi)\\;\\dot{\\phi}^{2}-g\\cos(\\phi)\\,\\ell\\,"
                 "(S^{\\mathsf{T}}m)\\Bigr]");
    PEND_TRY(api_buffer_text(out, "\\begin{aligned}"));
    for (int i = 0; i < equations->n; i++) {
        PEND_TRY(api_buffer_text(out, i ? "\\\\[1ex]&" : "&"));
        PEND_TRY(latex_aaa_row(equations, i, out));
    }
    return api_buffer_text(out, "\\end{aligned}");
}

/* one term of (bbb): an entry of M over l_i, times phi'' and phi'^2 */
static enum pend_status latex_bbb_term(const struct api_equations *equations, int i, int j,
                                       struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "-"));
    PEND_TRY(latex_masses(equations, latex_deeper(equations, i, j), out));
    PEND_TRY(api_buffer_format(out, "\\ell_{%d}", j + 1));
    if (i == j) return api_buffer_format(out, "\\dot{\\phi}_{%d}^{2}", i + 1);
    PEND_TRY(api_buffer_text(out, "\\bigl["));
    PEND_TRY(latex_turned("\\sin", i, j, out));
    PEND_TRY(api_buffer_format(out, "\\ddot{\\phi}_{%d}+", j + 1));
    PEND_TRY(latex_turned("\\cos", i, j, out));
    return api_buffer_format(out, "\\dot{\\phi}_{%d}^{2}\\bigr]", j + 1);
}

static enum pend_status latex_bbb(const struct api_equations *equations, struct api_buffer *out) {
    if (!equations->is_explicit)
        return api_buffer_text(out, "\\lambda=g\\sin(\\phi)\\,(S^{\\mathsf{T}}m)-\\ell^{-1}\\Bigl["
                                    "\\operatorname{Im}M(\\phi)\\;\\ddot{\\phi}+"
                                    "\\operatorname{Re}M(\\phi)\\;\\dot{\\phi}^{2}\\Bigr]");
    PEND_TRY(api_buffer_text(out, "\\begin{aligned}"));
    for (int i = 0; i < equations->n; i++) {
        PEND_TRY(api_buffer_format(out, "%s\\lambda_{%d}&=g", i ? "\\\\" : "", i + 1));
        PEND_TRY(latex_masses(equations, i, out));
        PEND_TRY(api_buffer_format(out, "\\sin\\phi_{%d}", i + 1));
        for (int j = 0; j < equations->n; j++)
            if (latex_deeper(equations, i, j) >= 0) PEND_TRY(latex_bbb_term(equations, i, j, out));
    }
    return api_buffer_text(out, "\\end{aligned}");
}

static const struct api_latex latex_table[] = {
    {"parameters", latex_parameters},
    {"S", latex_path},
    {"B", latex_force_map},
    {"z", latex_tips},
    {"M", latex_mass},
    {"aaa", latex_aaa},
    {"bbb", latex_bbb},
};

const struct api_latex *api_latex_at(int i) {
    return i >= 0 && i < (int)(sizeof latex_table / sizeof *latex_table) ? &latex_table[i] : NULL;
}
