#include "api/op/equations/equations_real.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/equations/equations_cart.h"
#include "api/op/terms_write.h"

/* ---- numbers */

/* a number of the caller's arm i */
static double real_number(const struct api_equations *e, enum pend_term_row row, int i) {
    return pend_terms_get(e->loads.terms, e->loads.value, row, e->place[i]);
}

/* The masses: those of the tips, then rods, then bodies; and scratch for lists. */
struct real_masses {
    int count;
    double *on, *x, *y, *mass; /* the arm, from 1; where on it, m; kg */
    double *spare;             /* as many numbers as harmonics or arms, whatever is more */
    double *inertia;           /* n: of rods and bodies about their centers */
};

static void real_add(struct real_masses *masses, int arm, double mass, double x, double y) {
    int at = masses->count++;
    masses->on[at] = arm + 1, masses->x[at] = x, masses->y[at] = y, masses->mass[at] = mass;
}

/* the masses, in one block that ends with free(masses->on) */
static enum pend_status real_masses(const struct api_equations *e, struct real_masses *masses) {
    size_t n = (size_t)e->n, more = (size_t)e->loads.terms->harmonics;
    double *at = malloc((13 * n + n + more) * sizeof *at);
    if (!at) return PEND_NO_MEMORY;
    *masses =
        (struct real_masses){0, at, at + 3 * n, at + 6 * n, at + 9 * n, at + 13 * n, at + 12 * n};
    for (int i = 0; i < e->n; i++) real_add(masses, i, e->mass[i], e->length[i], 0);
    for (int i = 0; i < e->n; i++) {
        double rod = real_number(e, PEND_TERM_ROD, i), l = e->length[i];
        masses->inertia[i] = rod * l * l / 12 + real_number(e, PEND_TERM_INERTIA, i);
        if (rod > 0) real_add(masses, i, rod, l / 2, 0);
    }
    for (int i = 0; i < e->n; i++) {
        double body = real_number(e, PEND_TERM_BODY, i);
        if (body > 0)
            real_add(masses, i, body, real_number(e, PEND_TERM_CENTER_X, i),
                     real_number(e, PEND_TERM_CENTER_Y, i));
    }
    assert(masses->count >= e->n && masses->count <= 3 * e->n);
    return PEND_OK;
}

/* where the caller's arm i hangs on the one that carries it, and whether that is its tip */
static int real_hangs(const struct api_equations *e, int i, double *x, double *y) {
    int p = e->parent[i], hung = e->loads.terms->hung[e->place[i]];
    *x = p < 0 ? 0 : hung ? real_number(e, PEND_TERM_AT_X, i) : e->length[p];
    *y = p < 0 || !hung ? 0 : real_number(e, PEND_TERM_AT_Y, i);
    return p >= 0 && !hung;
}

/* ---- lists of a program */

/* name = x + i y */
static enum pend_status real_places(const struct code_language *language, const char *name,
                                    const char *comment, int n, const double x[], const double y[],
                                    struct api_buffer *out) {
    int python = language == &api_code_in_python;
    PEND_TRY(api_buffer_format(out, python ? "%s = np.array(" : "%s = ", name));
    PEND_TRY(api_code_numbers(language, n, x, out));
    PEND_TRY(api_buffer_text(out, python ? ") + 1j * np.array(" : " + 1i*"));
    PEND_TRY(api_code_numbers(language, n, y, out));
    return api_buffer_format(out, python ? ")  # %s\n" : ";  %% %s\n", comment);
}

/* the bodies: where every mass is, and where arms hang */
static enum pend_status real_list_bodies(const struct code_language *language,
                                         const struct api_equations *e,
                                         const struct real_masses *masses, struct api_buffer *out) {
    double *x = masses->spare;
    PEND_TRY(api_code_list(language, "on",
                           "the arm of every mass: of tips, then of rods and bodies", masses->count,
                           masses->on, out));
    PEND_TRY(real_places(language, "place", "where on it: along the arm, and across it",
                         masses->count, masses->x, masses->y, out));
    PEND_TRY(api_code_list(language, "mass", "all masses", masses->count, masses->mass, out));
    PEND_TRY(api_code_list(language, "J", "inertias of rods and bodies about their centers", e->n,
                           masses->inertia, out));
    double *y = malloc(3 * (size_t)e->n * sizeof *y), *hangs = y + 2 * e->n;
    if (!y) return PEND_NO_MEMORY;
    for (int i = 0; i < e->n; i++) hangs[i] = real_hangs(e, i, &x[i], &y[i]);
    enum pend_status status = real_places(
        language, "at", "where each arm hangs on the one that carries it", e->n, x, y, out);
    if (status == PEND_OK)
        status = api_code_list(language, "tip", "1 = that is its tip", e->n, hangs, out);
    free(y);
    return status;
}

/* a list of a number for each harmonic of torques, or of the pivot; the name and its comment */
struct real_list {
    const char *name, *comment;
};
enum { REAL_PARTS = 4, REAL_WHERE = 3 };
static const struct real_list real_harmonics[][REAL_PARTS] = {
    {{"A", "of the drives, N m"},
     {"omega", "rad/s"},
     {"phase", NULL},
     {"driven", "the arm of each"}},
    {{"A0", "of the pivot: amplitudes, m"},
     {"omega0", "rad/s"},
     {"phase0", NULL},
     {"up", "1 = upwards, 0 = to the right"}},
    {{"A0", "of the force on the cart, N"}, {"omega0", "rad/s"}, {"phase0", NULL}}};

/* the caller's number, from 1, of the arm that a harmonic drives; of the pivot 1 = upwards */
static double real_driven(const struct api_equations *e, int drives) {
    if (drives < 0) return drives == PEND_DRIVE_PIVOT_Y;
    int k = 0;
    while (k < e->n - 1 && e->place[k] != drives) k++;
    return k + 1;
}

/* drives: API_HAVE_DRIVES, API_HAVE_PIVOT or API_HAVE_CART */
static enum pend_status real_list_harmonics(const struct code_language *language,
                                            const struct api_equations *e, unsigned drives,
                                            double list[], struct api_buffer *out) {
    const struct pend_terms *terms = e->loads.terms;
    int table = drives == API_HAVE_DRIVES ? 0 : drives == API_HAVE_PIVOT ? 1 : 2;
    for (int part = 0; part < REAL_PARTS && real_harmonics[table][part].name; part++) {
        int count = 0;
        for (int i = 0; i < terms->harmonics; i++) {
            const struct pend_harmonic *h = &terms->harmonic[i];
            if (api_pieces_drives(e, h) != drives) continue;
            list[count++] =
                part < REAL_WHERE ? e->loads.value[h->at + part] : real_driven(e, h->drives);
        }
        const struct real_list *row = &real_harmonics[table][part];
        PEND_TRY(api_code_list(language, row->name, row->comment, count, list, out));
    }
    return PEND_OK;
}

/* the harmonics of the pivot and its acceleration */
static enum pend_status real_list_pivot(const struct code_language *language,
                                        const struct api_equations *e, double list[],
                                        struct api_buffer *out) {
    int x = e->loads.terms->one[PEND_TERM_PIVOT_ACCELERATION_X];
    PEND_TRY(real_list_harmonics(language, e, API_HAVE_PIVOT, list, out));
    double both[2] = {x < 0 ? 0 : e->loads.value[x], x < 0 ? 0 : e->loads.value[x + 1]};
    return api_code_list(language, "a0", "the pivot's acceleration, to the right and up", 2, both,
                         out);
}

static enum pend_status real_list_mist(const struct code_language *language,
                                       const struct api_equations *e, struct api_buffer *out) {
    int at = e->loads.terms->one[PEND_TERM_DRAG_PER_MASS];
    PEND_TRY(api_buffer_text(out, "gamma = "));
    PEND_TRY(api_code_number(e->loads.value[at], out));
    return api_buffer_text(out, language == &api_code_in_python ? "\n" : ";\n");
}

/* the numbers an arm of the joints and of the air */
static enum pend_status real_list_rows(const struct code_language *language,
                                       const struct api_equations *e, double list[],
                                       struct api_buffer *out) {
    const struct api_equations_term *term;
    for (int t = 0; (term = api_equations_term(t)); t++) {
        if (!term->name || !api_equations_has_term(e, term)) continue;
        for (int i = 0; i < e->n; i++) list[i] = real_number(e, term->row, i);
        PEND_TRY(api_code_list(language, term->name, term->comment, e->n, list, out));
    }
    return PEND_OK;
}

static enum pend_status real_lists(const struct code_language *language,
                                   const struct api_equations *e, struct api_buffer *out) {
    unsigned have = api_pieces_have(e);
    struct real_masses masses;
    PEND_TRY(real_masses(e, &masses));
    double *list = masses.spare;
    enum pend_status status = real_list_bodies(language, e, &masses, out);
    if (status == PEND_OK) status = real_list_rows(language, e, list, out);
    if (status == PEND_OK && have & API_HAVE_DRIVES)
        status = real_list_harmonics(language, e, API_HAVE_DRIVES, list, out);
    if (status == PEND_OK && have & API_HAVE_PIVOT)
        status = real_list_pivot(language, e, list, out);
    if (status == PEND_OK && have & API_HAVE_CART)
        status = real_list_harmonics(language, e, API_HAVE_CART, list, out);
    if (status == PEND_OK && have & API_HAVE_CART) status = api_cart_list(language, e, out);
    if (status == PEND_OK && have & API_HAVE_MIST) status = real_list_mist(language, e, out);
    free(masses.on);
    return status;
}

/* the torques of the joints' terms, which a program adds up */
static enum pend_status real_torques(const struct api_equations *e, int python,
                                     struct api_buffer *out) {
    const struct api_equations_term *term;
    for (int t = 0; (term = api_equations_term(t)); t++)
        if (term->python && api_equations_has(e, term->row))
            PEND_TRY(api_buffer_text(out, python ? term->python : term->matlab));
    return PEND_OK;
}

/* ---- Python */

static const struct api_piece real_python[] = {
    {0, 0,
     "on = on.astype(int) - 1\n"
     "B = np.linalg.inv(S).T  # a torque in a joint acts on its arm, and back on the one before\n"
     "C = S @ (at[:, None] * (np.eye(n) - B.T))  # the joints are at C exp(i phi)\n"
     "Z = C + np.diag(L)  # the tips\n"
     "P = C[on] + place[:, None] * np.eye(n)[on]  # the masses\n"
     "mu = P.conj().T @ (mass[:, None] * P)\n"
     "h = P.conj().T @ mass\n"
     "T = (tip[:, None] * (np.eye(n) - B.T)).T @ S.T  # row k: the arms that the tip of k carries\n"
     "W = T[:, on] + np.eye(n, len(mass))  # row k: the masses that it does\n"},
    {API_HAVE_DRIVES, 0, "D = (np.arange(1, n + 1)[:, None] == driven).astype(float)\n"},
    {API_HAVE_PIVOT, 0, "A0 = A0 * 1j**up\na0 = a0 @ [1, 1j]\n"},
    {0, 0,
     "\n\ndef M(phi):\n"
     "    u = np.exp(1j * phi)\n"
     "    return u.conj()[:, None] * mu * u + np.diag(J)\n"},
    {API_HAVE_PIVOT, 0,
     "\n\ndef pivot(t):\n"
     "    \"\"\"velocity and acceleration of the pivot\"\"\"\n"
     "    angle = omega0 * t + phase0\n"
     "    return a0 * t - A0 @ (omega0 * np.sin(angle)), a0 - A0 @ (omega0**2 * np.cos(angle))\n"},
    {API_HAVE_JOINTS, 0,
     "\n\ndef torques(phi, w, t):\n"
     "    \"\"\"of the joints on their arms\"\"\"\n"
     "    tau = np.zeros(n)\n"},
    {API_HAVE_JOINTS, 0, "    r = B.T @ w  # the joints' speeds\n"},
    {API_HAVE_ANGLES, 0,
     "    q = B.T @ phi + (S.sum(1) == 1) * np.pi / 2  # their angles; of the first arm theta\n"},
    {0, 0, NULL}};

/* behind the torques of the joints' terms */
static const struct api_piece real_python_loads[] = {
    {API_HAVE_DRIVES, 0, "    tau += D @ (A * np.cos(omega * t + phase))\n"},
    {API_HAVE_JOINTS, 0, "    return tau\n"},
    {API_HAVE_AIR, 0, "\n\ndef air(phi, w, "},
    {API_HAVE_AIR, API_HAVE_CART, "t"},
    {API_HAVE_AIR | API_HAVE_CART, 0, "speed"},
    {API_HAVE_AIR, 0,
     "):\n"
     "    \"\"\"the air's forces on the tips\"\"\"\n"
     "    v = Z @ (1j * w * np.exp(1j * phi))\n"},
    {API_HAVE_AIR | API_HAVE_CART, 0, "    v = v + speed * rail\n"},
    {API_HAVE_AIR | API_HAVE_PIVOT, 0, "    v = v + pivot(t)[0]\n"},
    {API_HAVE_AIR, 0, "    return -(b + d * np.sqrt(abs(v)**2 + e**2)) * v\n"},
    {0, 0, NULL}};

static const struct api_piece real_python_run[] = {
    {0, 0,
     "\n\ndef phidd(phi, w, t=0):\n"
     "    \"\"\"(aaa) angular accelerations\"\"\"\n"
     "    back, inertia = np.exp(-1j * phi), M(phi)\n"
     "    right = inertia.imag @ w**2 - (back * h * 1j * g).imag\n"},
    {API_HAVE_PIVOT, 0, "    right -= (back * h * pivot(t)[1]).imag\n"},
    {API_HAVE_JOINTS, 0, "    right += B @ torques(phi, w, t)\n"},
    {API_HAVE_AIR, 0, "    right += (back * (Z.conj().T @ air(phi, w, t))).imag\n"},
    {API_HAVE_MIST, 0, "    right -= 2 * gamma * inertia.real @ w\n"},
    {API_HAVE_MIST | API_HAVE_PIVOT, 0, "    right -= 2 * gamma * (back * h * pivot(t)[0]).imag\n"},
    {0, 0,
     "    return np.linalg.solve(inertia.real, right)\n"
     "\n\ndef lambda_(phi, w, a, t=0):\n"
     "    \"\"\"(bbb) compression forces in the arms at their tips; a is phidd(phi, w, t)\"\"\"\n"
     "    u = np.exp(1j * phi)\n"
     "    zdd = P @ ((1j * a - w**2) * u)\n"},
    {API_HAVE_PIVOT, 0, "    zdd = zdd + pivot(t)[1]\n"},
    {API_HAVE_MIST, 0, "    zdd = zdd + 2 * gamma * P @ (1j * w * u)\n"},
    {API_HAVE_MIST | API_HAVE_PIVOT, 0, "    zdd = zdd + 2 * gamma * pivot(t)[0]\n"},
    {0, 0, "    force = W @ (mass * (zdd + 1j * g))\n"},
    {API_HAVE_AIR, 0, "    force = force - (T + np.eye(n)) @ air(phi, w, t)\n"},
    {0, 0,
     "    return (u.conj() * force).real\n"
     "\n\ndef right(t, x):\n"
     "    return np.concatenate([x[n:], phidd(x[:n], x[n:], t)])\n"
     "\n\nif __name__ == \"__main__\":\n"
     "    import matplotlib.pyplot as plt\n"
     "    from scipy.integrate import solve_ivp\n"
     "\n"
     "    t = np.linspace(0, 5, 501)\n"
     "    x = solve_ivp(right, (0, 5), np.concatenate([phi0, w0]), \"DOP853\", t, rtol=1e-10, "
     "atol=1e-12).y\n"
     "    z = Z @ np.exp(1j * x[:n])  # from the pivot\n"
     "    force = np.array([lambda_(c[:n], c[n:], phidd(c[:n], c[n:], at_), at_) for c, at_ in "
     "zip(x.T, t)])\n"
     "    _, (tips, forces) = plt.subplots(1, 2)\n"
     "    tips.plot(z.real.T, z.imag.T)\n"
     "    tips.set(title=\"the tips\", aspect=\"equal\")\n"
     "    forces.plot(t, force)\n"
     "    forces.set(title=\"compression forces\", xlabel=\"t\")\n"
     "    plt.show()\n"},
    {0, 0, NULL}};

enum pend_status api_real_python(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(
        out,
        "\"\"\"A real pendulum of %d arm%s, after G. Meinsma, Planar Pendulums in Complex "
        "Coordinates.\n"
        "\n"
        "Angles from the positive real axis, SI units. The functions need NumPy; the main program "
        "SciPy and Matplotlib.\n"
        "\"\"\"\n"
        "import numpy as np\n"
        "\n"
        "n = %d\n",
        e->n, e->n > 1 ? "s" : "", e->n));
    PEND_TRY(api_code_givens(&api_code_in_python, e, out));
    PEND_TRY(real_lists(&api_code_in_python, e, out));
    unsigned have = api_pieces_have(e);
    PEND_TRY(api_pieces_say(have, real_python, out));
    PEND_TRY(real_torques(e, 1, out));
    PEND_TRY(api_pieces_say(have, real_python_loads, out));
    return api_pieces_say(have, have & API_HAVE_CART ? api_cart_python : real_python_run, out);
}

/* ---- MATLAB and Octave */

static const struct api_piece real_matlab[] = {
    {0, 0,
     "\n"
     "I = eye(n);\n"
     "B = inv(S).';  % a torque in a joint acts on its arm, and back on the one before\n"
     "C = S * (diag(at) * (I - B.'));  % the joints are at C exp(i phi)\n"
     "Z = C + diag(L);  % the tips\n"
     "P = C(on, :) + diag(place) * I(on, :);  % the masses\n"
     "mu = P' * diag(mass) * P;\n"
     "h = P' * mass;\n"
     "T = (diag(tip) * (I - B.')).' * S.';  % row k: the arms that the tip of k carries\n"
     "W = T(:, on) + eye(n, numel(mass));  % row k: the masses that it does\n"},
    {API_HAVE_DRIVES, 0, "D = double((1:n).' == driven.');\n"},
    {API_HAVE_PIVOT, 0,
     "A0 = (A0(:) .* 1i.^up(:)).';\n"
     "omega0 = omega0(:);\n"
     "phase0 = phase0(:);\n"
     "a0 = [1 1i] * a0;\n"},
    {0, 0,
     "u = @(phi) exp(1i*phi);\n"
     "M = @(phi) diag(conj(u(phi))) * mu * diag(u(phi)) + diag(J);\n"},
    {API_HAVE_PIVOT, 0,
     "% velocity and acceleration of the pivot\n"
     "z0d = @(t) a0*t - A0 * (omega0 .* sin(omega0*t + phase0));\n"
     "z0dd = @(t) a0 - A0 * (omega0.^2 .* cos(omega0*t + phase0));\n"},
    {API_HAVE_ANGLES, 0,
     "% the joints' angles; of the first arm theta\n"
     "q = @(phi) B.'*phi + (sum(S, 2) == 1) * pi/2;\n"},
    {API_HAVE_JOINTS, 0,
     "r = @(w) B.'*w;  % the joints' speeds\n"
     "% torques of the joints on their arms\n"
     "tau = @(phi, w, t) zeros(n, 1)"},
    {0, 0, NULL}};

/* behind the torques of the joints' terms */
static const struct api_piece real_matlab_loads[] = {
    {API_HAVE_DRIVES, 0, " ...\n    + D * (A .* cos(omega*t + phase))"},
    {API_HAVE_JOINTS, 0, ";\n"},
    {API_HAVE_AIR, API_HAVE_PIVOT | API_HAVE_CART, "v = @(phi, w, t) Z * (1i*w .* u(phi));\n"},
    {API_HAVE_AIR | API_HAVE_CART, 0, "v = @(phi, w, speed) rail*speed + Z * (1i*w .* u(phi));\n"},
    {API_HAVE_AIR | API_HAVE_PIVOT, 0, "v = @(phi, w, t) z0d(t) + Z * (1i*w .* u(phi));\n"},
    {API_HAVE_AIR, 0,
     "drag = @(v) -(b + d .* sqrt(abs(v).^2 + e.^2)) .* v;\n"
     "% the air's forces on the tips\n"},
    {API_HAVE_AIR, API_HAVE_CART, "air = @(phi, w, t) drag(v(phi, w, t));\n"},
    {API_HAVE_AIR | API_HAVE_CART, 0, "air = @(phi, w, speed) drag(v(phi, w, speed));\n"},
    {0, 0, NULL}};

static const struct api_piece real_matlab_run[] = {
    {0, 0,
     "% (aaa) angular accelerations\n"
     "phidd = @(phi, w, t) real(M(phi)) \\ (imag(M(phi))*w.^2 - imag(conj(u(phi)) .* h * 1i*g)"},
    {API_HAVE_PIVOT, 0, " ...\n    - imag(conj(u(phi)) .* h * z0dd(t))"},
    {API_HAVE_JOINTS, 0, " ...\n    + B * tau(phi, w, t)"},
    {API_HAVE_AIR, 0, " ...\n    + imag(conj(u(phi)) .* (Z' * air(phi, w, t)))"},
    {API_HAVE_MIST, 0, " ...\n    - 2*gamma * real(M(phi)) * w"},
    {API_HAVE_MIST | API_HAVE_PIVOT, 0, " ...\n    - 2*gamma * imag(conj(u(phi)) .* h * z0d(t))"},
    {0, 0,
     ");\n"
     "% (bbb) compression forces in the arms at their tips; a is phidd(phi, w, t)\n"
     "lambda = @(phi, w, a, t) real(conj(u(phi)) .* (W * (mass .* (P * ((1i*a - w.^2) .* u(phi))"},
    {API_HAVE_PIVOT, 0, " + z0dd(t)"},
    {API_HAVE_MIST, 0, " ...\n    + 2*gamma * P * (1i*w .* u(phi))"},
    {API_HAVE_MIST | API_HAVE_PIVOT, 0, " + 2*gamma * z0d(t)"},
    {0, 0, " + 1i*g))"},
    {API_HAVE_AIR, 0, " ...\n    - (T + I) * air(phi, w, t)"},
    {0, 0,
     "));\n"
     "\n"
     "right = @(t, x) [x(n+1:2*n); phidd(x(1:n), x(n+1:2*n), t)];\n"
     "[t, x] = ode45(right, 0:.01:5, [phi0; w0], odeset('RelTol', 1e-8, 'AbsTol', 1e-10));\n"
     "z = Z * exp(1i*x(:, 1:n).');  % from the pivot\n"
     "force = zeros(numel(t), n);\n"
     "for j = 1:numel(t)\n"
     "    phi = x(j, 1:n).';\n"
     "    w = x(j, n+1:2*n).';\n"
     "    force(j, :) = lambda(phi, w, phidd(phi, w, t(j)), t(j)).';\n"
     "end\n"
     "\n"
     "subplot(1, 2, 1); plot(real(z).', imag(z).'); axis equal; title('the tips');\n"
     "subplot(1, 2, 2); plot(t, force); xlabel('t'); title('compression forces');\n"},
    {0, 0, NULL}};

enum pend_status api_real_matlab(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_buffer_format(
        out,
        "%% A real pendulum of %d arm%s, after G. Meinsma, Planar Pendulums in Complex "
        "Coordinates.\n"
        "%% Runs as it is in MATLAB and in Octave. Angles from the positive real axis, SI units.\n"
        "n = %d;\n",
        e->n, e->n > 1 ? "s" : "", e->n));
    PEND_TRY(api_code_givens(&api_code_in_matlab, e, out));
    PEND_TRY(real_lists(&api_code_in_matlab, e, out));
    unsigned have = api_pieces_have(e);
    PEND_TRY(api_pieces_say(have, real_matlab, out));
    PEND_TRY(real_torques(e, 0, out));
    PEND_TRY(api_pieces_say(have, real_matlab_loads, out));
    return api_pieces_say(have, have & API_HAVE_CART ? api_cart_matlab : real_matlab_run, out);
}

/* ---- a line for a shell */

enum pend_status api_real_curl(const struct api_equations *e, struct api_buffer *out) {
    PEND_TRY(api_buffer_text(
        out, "curl -s http://127.0.0.1:8080/v1/trajectories -H 'Content-Type: application/json' "
             "-d '{\"pendulum\":{"));
    PEND_TRY(api_out_number(out, "gravity", e->loads.gravity, 0));
    PEND_TRY(api_terms_write_whole(e->tree, &e->loads, out));
    PEND_TRY(api_out_open(out, "arms", '['));
    for (int i = 0; i < e->n; i++) {
        PEND_TRY(api_buffer_format(out, "%s{\"name\":\"%d\"", i ? "," : "", i + 1));
        if (e->parent[i] >= 0)
            PEND_TRY(api_buffer_format(out, ",\"parent\":\"%d\"", e->parent[i] + 1));
        PEND_TRY(api_out_number(out, "length", e->length[i], 0));
        PEND_TRY(api_out_number(out, "mass", e->mass[i], 0));
        PEND_TRY(api_terms_write_arm(&e->loads, e->place[i], out));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    PEND_TRY(api_buffer_text(out, "]},\"initial\":{"));
    PEND_TRY(api_out_numbers(out, "phi", e->n, e->phi, 0));
    PEND_TRY(api_out_numbers(out, "phid", e->n, e->rate, 0));
    if (api_pieces_have(e) & API_HAVE_CART) {
        PEND_TRY(api_out_open(out, "cart", '{'));
        PEND_TRY(api_out_number(out, "x", e->cart[0], 0));
        PEND_TRY(api_out_number(out, "v", e->cart[1], 0));
        PEND_TRY(api_buffer_text(out, "}"));
    }
    return api_buffer_text(out, "},\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}}'");
}
