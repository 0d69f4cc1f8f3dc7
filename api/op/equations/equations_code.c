#include "api/op/equations/equations_code.h"

#include "api/number/number.h"

enum { CODE_LINE = 10 }; /* numbers of a line */

/* the syntax in which a language writes lists and S */
struct code_language {
    const char *comma, *wrap;    /* between the numbers of a list, and where a line ends */
    const char *list, *list_end; /* around a list that a name is given to */
    const char *end, *comment;   /* of a statement */
    const char *open, *entry, *row, *close; /* around and in S, row by row */
    const char *climb;                      /* S from the arms that carry the arms, p */
};

const struct code_language api_code_in_matlab = {
    .comma = "; ",
    .wrap = " ...\n     ",
    .list = "",
    .list_end = ";",
    .end = ";",
    .comment = "%",
    .open = "S = [",
    .entry = " ",
    .row = "\n     ",
    .close = "];  % row k: the arms on the way from the pivot to tip k\n",
    .climb = ";  % the arm that carries each, 0 = the pivot\n"
             "S = zeros(n);  % row k: the arms on the way from the pivot to tip k\n"
             "for k = 1:n\n"
             "    j = k;\n"
             "    while j > 0\n"
             "        S(k, j) = 1;\n"
             "        j = p(j);\n"
             "    end\n"
             "end\n"};

const struct code_language api_code_in_python = {
    .comma = ", ",
    .wrap = "\n    ",
    .list = "np.array(",
    .list_end = ", dtype=float)",
    .end = "",
    .comment = "#",
    .open = "S = np.array([[",
    .entry = ", ",
    .row = "],\n              [",
    .close = "]], dtype=float)  # row k: the arms on the way from the pivot to tip k\n",
    .climb = "  # the arm that carries each, from 1; 0 = the pivot\n"
             "S = np.zeros((n, n))  # row k: the arms on the way from the pivot to tip k\n"
             "for k in range(n):\n"
             "    j = k\n"
             "    while j >= 0:\n"
             "        S[k, j] = 1\n"
             "        j = p[j] - 1\n"};

static const struct code_language code_json = {.comma = ",", .wrap = ""};

enum pend_status api_code_number(double number, struct api_buffer *out) {
    PEND_TRY(api_buffer_room(out, API_NUMBER_BYTES));
    out->bytes = (size_t)(api_number_write(out->data + out->bytes, number) - out->data);
    return PEND_OK;
}

enum pend_status api_code_numbers(const struct code_language *language, int n,
                                  const double number[], struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "["));
    for (int i = 0; i < n; i++) {
        if (i) PEND_TRY(api_buffer_text(out, language->comma));
        if (i && i % CODE_LINE == 0) PEND_TRY(api_buffer_text(out, language->wrap));
        PEND_TRY(api_code_number(number[i], out));
    }
    return api_buffer_text(out, "]");
}

/* the arms that carry the arms, from 1; 0 is the pivot */
static enum pend_status code_parents(const struct code_language *language,
                                     const struct api_equations *equations,
                                     struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "["));
    for (int i = 0; i < equations->n; i++) {
        if (i) PEND_TRY(api_buffer_text(out, language->comma));
        if (i && i % CODE_LINE == 0) PEND_TRY(api_buffer_text(out, language->wrap));
        PEND_TRY(api_buffer_format(out, "%d", equations->parent[i] + 1));
    }
    return api_buffer_text(out, "]");
}

/* S row by row, as in the paper */
static enum pend_status code_rows(const struct code_language *language,
                                  const struct api_equations *equations, struct api_buffer *out) {
    int n = equations->n;
    for (int i = 0; i < n; i++) {
        PEND_TRY(api_buffer_text(out, i ? language->row : language->open));
        for (int j = 0; j < n; j++)
            PEND_TRY(api_buffer_format(out, "%s%d", j ? language->entry : "",
                                       api_equations_carries(equations, j, i)));
    }
    return api_buffer_text(out, language->close);
}

static enum pend_status code_path(const struct code_language *language,
                                  const struct api_equations *equations, struct api_buffer *out) {
    if (equations->is_explicit) return code_rows(language, equations, out);
    PEND_TRY(api_buffer_text(out, "p = "));
    PEND_TRY(code_parents(language, equations, out));
    return api_buffer_text(out, language->climb);
}

/* name = [...], with a comment or NULL */
enum pend_status api_code_list(const struct code_language *language, const char *name,
                               const char *comment, int n, const double number[],
                               struct api_buffer *out) {
    PEND_TRY(api_buffer_format(out, "%s = %s", name, language->list));
    PEND_TRY(api_code_numbers(language, n, number, out));
    PEND_TRY(api_buffer_text(out, language->list_end));
    if (comment) PEND_TRY(api_buffer_format(out, "  %s %s", language->comment, comment));
    return api_buffer_text(out, "\n");
}

/* the parameters: the pendulum and its start */
enum pend_status api_code_givens(const struct code_language *language,
                                 const struct api_equations *equations, struct api_buffer *out) {
    int n = equations->n;
    PEND_TRY(api_code_list(language, "L", "lengths", n, equations->length, out));
    PEND_TRY(api_code_list(language, "m", "masses at the tips", n, equations->mass, out));
    PEND_TRY(api_buffer_text(out, "g = "));
    PEND_TRY(api_code_number(equations->loads.gravity, out));
    PEND_TRY(api_buffer_format(out, "%s\n", language->end));
    PEND_TRY(code_path(language, equations, out));
    PEND_TRY(api_code_list(language, "phi0", "the start", n, equations->phi, out));
    return api_code_list(language, "w0", NULL, n, equations->rate, out);
}

enum pend_status api_code_matlab(const struct api_equations *equations, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(
        out,
        "%% A planar pendulum of %d arm%s: G. Meinsma, Planar Pendulums in Complex "
        "Coordinates.\n"
        "%% Runs as it is in MATLAB and in Octave. Angles from the positive real axis, SI units.\n"
        "n = %d;\n",
        equations->n, equations->n > 1 ? "s" : "", equations->n));
    PEND_TRY(api_code_givens(&api_code_in_matlab, equations, out));
    return api_buffer_text(
        out,
        "\n"
        "mu = S.' * diag(m) * S;\n"
        "M = @(phi) diag(L .* exp(-1i*phi)) * mu * diag(L .* exp(1i*phi));\n"
        "% (aaa) angular accelerations\n"
        "phidd = @(phi, w) real(M(phi)) \\ (imag(M(phi))*w.^2 - g*cos(phi).*L.*(S.'*m));\n"
        "% (bbb) compression forces in the arms; a is phidd(phi, w)\n"
        "lambda = @(phi, w, a) g*sin(phi).*(S.'*m) - (imag(M(phi))*a + real(M(phi))*w.^2) ./ L;\n"
        "\n"
        "right = @(t, x) [x(n+1:2*n); phidd(x(1:n), x(n+1:2*n))];\n"
        "[t, x] = ode45(right, 0:.01:5, [phi0; w0], odeset('RelTol', 1e-8, 'AbsTol', 1e-10));\n"
        "z = S * (diag(L) * exp(1i*x(:, 1:n).'));\n"
        "force = zeros(numel(t), n);\n"
        "for k = 1:numel(t)\n"
        "    phi = x(k, 1:n).';\n"
        "    w = x(k, n+1:2*n).';\n"
        "    force(k, :) = lambda(phi, w, phidd(phi, w)).';\n"
        "end\n"
        "\n"
        "subplot(1, 2, 1); plot(real(z).', imag(z).'); axis equal; title('the tips');\n"
        "subplot(1, 2, 2); plot(t, force); xlabel('t'); title('compression forces');\n");
}

enum pend_status api_code_python(const struct api_equations *equations, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(out,
                               "\"\"\"A planar pendulum of %d arm%s: G. Meinsma, Planar Pendulums "
                               "in Complex Coordinates.\n"
                               "\n"
                               "Angles from the positive real axis, SI units. The functions need "
                               "NumPy; the main program SciPy "
                               "and Matplotlib.\n"
                               "\"\"\"\n"
                               "import numpy as np\n"
                               "\n"
                               "n = %d\n",
                               equations->n, equations->n > 1 ? "s" : "", equations->n));
    PEND_TRY(api_code_givens(&api_code_in_python, equations, out));
    return api_buffer_text(
        out, "mu = S.T @ (m[:, None] * S)\n"
             "\n"
             "\n"
             "def M(phi):\n"
             "    return (L * np.exp(-1j * phi))[:, None] * mu * (L * np.exp(1j * phi))\n"
             "\n"
             "\n"
             "def phidd(phi, w):\n"
             "    \"\"\"(aaa) angular accelerations\"\"\"\n"
             "    mass = M(phi)\n"
             "    return np.linalg.solve(mass.real, mass.imag @ w**2 - g * np.cos(phi) * L * (S.T "
             "@ m))\n"
             "\n"
             "\n"
             "def lambda_(phi, w, a):\n"
             "    \"\"\"(bbb) compression forces in the arms; a is phidd(phi, w)\"\"\"\n"
             "    mass = M(phi)\n"
             "    return g * np.sin(phi) * (S.T @ m) - (mass.imag @ a + mass.real @ w**2) / L\n"
             "\n"
             "\n"
             "def right(t, x):\n"
             "    return np.concatenate([x[n:], phidd(x[:n], x[n:])])\n"
             "\n"
             "\n"
             "if __name__ == \"__main__\":\n"
             "    import matplotlib.pyplot as plt\n"
             "    from scipy.integrate import solve_ivp\n"
             "\n"
             "    t = np.linspace(0, 5, 501)\n"
             "    x = solve_ivp(right, (0, 5), np.concatenate([phi0, w0]), \"DOP853\", t, "
             "rtol=1e-10, atol=1e-12).y\n"
             "    z = S @ (L[:, None] * np.exp(1j * x[:n]))\n"
             "    force = np.array([lambda_(c[:n], c[n:], phidd(c[:n], c[n:])) for c in x.T])\n"
             "    _, (tips, forces) = plt.subplots(1, 2)\n"
             "    tips.plot(z.real.T, z.imag.T)\n"
             "    tips.set(title=\"the tips\", aspect=\"equal\")\n"
             "    forces.plot(t, force)\n"
             "    forces.set(title=\"compression forces\", xlabel=\"t\")\n"
             "    plt.show()\n");
}

enum pend_status api_code_curl(const struct api_equations *equations, struct api_buffer *out) {
    int n = equations->n;
    PEND_TRY(api_buffer_text(
        out, "curl -s http://127.0.0.1:8080/v1/trajectories -H 'Content-Type: application/json' "
             "-d '{\"pendulum\":{\"length\":"));
    PEND_TRY(api_code_numbers(&code_json, n, equations->length, out));
    PEND_TRY(api_buffer_text(out, ",\"mass\":"));
    PEND_TRY(api_code_numbers(&code_json, n, equations->mass, out));
    PEND_TRY(api_buffer_text(out, ",\"parent\":"));
    PEND_TRY(code_parents(&code_json, equations, out));
    PEND_TRY(api_buffer_text(out, ",\"gravity\":"));
    PEND_TRY(api_code_number(equations->loads.gravity, out));
    PEND_TRY(api_buffer_text(out, "},\"initial\":{\"phi\":"));
    PEND_TRY(api_code_numbers(&code_json, n, equations->phi, out));
    PEND_TRY(api_buffer_text(out, ",\"phid\":"));
    PEND_TRY(api_code_numbers(&code_json, n, equations->rate, out));
    return api_buffer_text(out, "},\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}}'");
}
