#include "api/op/equations/equations_cart.h"

#include <assert.h>
#include <math.h>

enum pend_status api_cart_list(const struct code_language *language, const struct api_equations *e,
                               struct api_buffer *out) {
    const struct pend_terms *terms = e->loads.terms;
    const double *value = e->loads.value;
    int python = language == &api_code_in_python;
    assert(pend_terms_cart(terms));
    double rail = value[terms->one[PEND_TERM_RAIL]];
    const struct {
        const char *name;
        double number;
        const char *comment;
    } lines[] = {
        {"M0", e->tree->mass[0], "the cart's mass"},
        {"c0", pend_terms_get(terms, value, PEND_TERM_DAMPING, 0), "its damping, N s/m"},
        {"k0", pend_terms_get(terms, value, PEND_TERM_STIFFNESS, 0), "its spring, N/m"},
        {"F0", pend_terms_get(terms, value, PEND_TERM_TORQUE, 0), "the constant force on it, N"},
        {"x0", e->cart[0], "its start on the rail, m"},
        {"v0", e->cart[1], "and its speed, m/s"},
    };
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        PEND_TRY(api_buffer_format(out, "%s = ", lines[i].name));
        PEND_TRY(api_code_number(lines[i].number, out));
        PEND_TRY(api_buffer_format(out, python ? "  # %s\n" : ";  %% %s\n", lines[i].comment));
    }
    PEND_TRY(api_buffer_text(out, python ? "rail = np.exp(1j * " : "rail = exp(1i * "));
    PEND_TRY(api_code_number(rail, out));
    return api_buffer_text(out, python ? ")\n" : ");\n");
}

const struct api_piece api_cart_python[] = {
    {0, 0,
     "\n\ndef phidd(phi, w, t=0):\n"
     "    \"\"\"(aaa) accelerations; the last of phi, of w and of these are the cart's\"\"\"\n"
     "    phi, x, w, v = phi[:n], phi[n], w[:n], w[n]\n"
     "    back, inertia, weight = np.exp(-1j * phi), M(phi), M0 + mass.sum()\n"
     "    along = (back * h * rail).imag  # what a unit of the cart's asks of the arms\n"
     "    right = inertia.imag @ w**2 - (back * h * 1j * g).imag\n"
     "    push = F0 + A0 @ np.cos(omega0 * t + phase0) - c0 * v - k0 * x - weight * g * rail.imag\n"
     "    push += (w**2 * (back * h * rail).conj()).real.sum()\n"},
    {API_HAVE_JOINTS, 0, "    right += B @ torques(phi, w, t)\n"},
    {API_HAVE_AIR, 0,
     "    right += (back * (Z.conj().T @ air(phi, w, v))).imag\n"
     "    push += (air(phi, w, v) / rail).real.sum()\n"},
    {API_HAVE_MIST, 0,
     "    right -= 2 * gamma * (inertia.real @ w + along * v)\n"
     "    push -= 2 * gamma * (along @ w + weight * v)\n"},
    {0, 0,
     "    both = np.block([[inertia.real, along[:, None]], [along[None, :], "
     "np.array([[weight]])]])\n"
     "    return np.linalg.solve(both, np.append(right, push))\n"
     "\n\ndef lambda_(phi, w, a, t=0):\n"
     "    \"\"\"(bbb) compression forces in the arms at their tips; a is phidd(phi, w, t)\"\"\"\n"
     "    u, w, v = np.exp(1j * phi[:n]), w[:n], w[n]\n"
     "    zdd = P @ ((1j * a[:n] - w**2) * u) + a[n] * rail\n"},
    {API_HAVE_MIST, 0, "    zdd = zdd + 2 * gamma * (P @ (1j * w * u) + v * rail)\n"},
    {0, 0, "    force = W @ (mass * (zdd + 1j * g))\n"},
    {API_HAVE_AIR, 0, "    force = force - (T + np.eye(n)) @ air(phi[:n], w, v)\n"},
    {0, 0,
     "    return (u.conj() * force).real\n"
     "\n\ndef right(t, x):\n"
     "    return np.concatenate([x[n + 1:], phidd(x[:n + 1], x[n + 1:], t)])\n"
     "\n\nif __name__ == \"__main__\":\n"
     "    import matplotlib.pyplot as plt\n"
     "    from scipy.integrate import solve_ivp\n"
     "\n"
     "    t = np.linspace(0, 5, 501)\n"
     "    x = solve_ivp(right, (0, 5), np.concatenate([phi0, [x0], w0, [v0]]), \"DOP853\", t, "
     "rtol=1e-10, atol=1e-12).y\n"
     "    z = x[n] * rail + Z @ np.exp(1j * x[:n])\n"
     "    force = np.array([lambda_(c[:n + 1], c[n + 1:], phidd(c[:n + 1], c[n + 1:], at_), at_) "
     "for c, at_ in zip(x.T, t)])\n"
     "    _, (tips, forces) = plt.subplots(1, 2)\n"
     "    tips.plot(z.real.T, z.imag.T)\n"
     "    tips.set(title=\"the tips\", aspect=\"equal\")\n"
     "    forces.plot(t, force)\n"
     "    forces.set(title=\"compression forces\", xlabel=\"t\")\n"
     "    plt.show()\n"},
    {0, 0, NULL}};

const struct api_piece api_cart_matlab[] = {
    {0, 0,
     "weight = M0 + sum(mass);\n"
     "along = @(phi) imag(conj(u(phi)) .* h * rail);  % what a unit of x'' asks of the arms\n"
     "pull = @(t) F0 + A0(:).' * cos(omega0(:)*t + phase0(:));\n"
     "% the right sides of the arms, and of the cart at x with the speed v\n"
     "arms = @(phi, w, v, t) imag(M(phi))*w.^2 - imag(conj(u(phi)) .* h * 1i*g)"},
    {API_HAVE_JOINTS, 0, " ...\n    + B * tau(phi, w, t)"},
    {API_HAVE_AIR, 0, " ...\n    + imag(conj(u(phi)) .* (Z' * air(phi, w, v)))"},
    {API_HAVE_MIST, 0, " ...\n    - 2*gamma * (real(M(phi)) * w + along(phi) * v)"},
    {0, 0,
     ";\n"
     "push = @(phi, w, x, v, t) pull(t) - c0*v - k0*x - weight*g*imag(rail) ...\n"
     "    + real(conj(rail) * (h' * (w.^2 .* u(phi))))"},
    {API_HAVE_AIR, 0, " ...\n    + real(conj(rail) * sum(air(phi, w, v)))"},
    {API_HAVE_MIST, 0, " ...\n    - 2*gamma * (along(phi).' * w + weight * v)"},
    {0, 0,
     ";\n"
     "both = @(phi, w, x, v, t) [real(M(phi)) along(phi); along(phi).' weight] ...\n"
     "    \\ [arms(phi, w, v, t); push(phi, w, x, v, t)];\n"
     "% (aaa) accelerations; the last of phi, of w and of these are the cart's\n"
     "phidd = @(phi, w, t) both(phi(1:n), w(1:n), phi(n+1), w(n+1), t);\n"
     "% (bbb) compression forces in the arms at their tips; a is phidd(phi, w, t)\n"
     "tips = @(phi, w, v, a) real(conj(u(phi)) .* (W * (mass .* (P * ((1i*a(1:n) - w.^2) .* "
     "u(phi)) ...\n    + rail*a(n+1)"},
    {API_HAVE_MIST, 0, " + 2*gamma * (P * (1i*w .* u(phi)) + rail*v)"},
    {0, 0, " + 1i*g))"},
    {API_HAVE_AIR, 0, " ...\n    - (T + I) * air(phi, w, v)"},
    {0, 0,
     "));\n"
     "lambda = @(phi, w, a, t) tips(phi(1:n), w(1:n), w(n+1), a);\n"
     "\n"
     "right = @(t, x) [x(n+2:2*n+2); phidd(x(1:n+1), x(n+2:2*n+2), t)];\n"
     "[t, x] = ode45(right, 0:.01:5, [phi0; x0; w0; v0], odeset('RelTol', 1e-8, 'AbsTol', "
     "1e-10));\n"
     "z = rail * x(:, n+1).' + Z * exp(1i*x(:, 1:n).');\n"
     "force = zeros(numel(t), n);\n"
     "for j = 1:numel(t)\n"
     "    phi = x(j, 1:n+1).';\n"
     "    w = x(j, n+2:2*n+2).';\n"
     "    force(j, :) = lambda(phi, w, phidd(phi, w, t(j)), t(j)).';\n"
     "end\n"
     "\n"
     "subplot(1, 2, 1); plot(real(z).', imag(z).'); axis equal; title('the tips');\n"
     "subplot(1, 2, 2); plot(t, force); xlabel('t'); title('compression forces');\n"},
    {0, 0, NULL}};
