#!/bin/bash
# Tests the result of `make install`: every header alone in C and in C++, a program built by pkg-config, and uninstalling.
# usage: install.sh BUILD
# Leaves to others: the library itself. Invariant: writes only into its own directory under build/.
set -u
cd "$(dirname "$0")/../.." || exit
build=$1 passed=0 failed=0
root=$(mktemp -d "$PWD/build/install XXXXXX") || exit
trap 'rm -rf "$root"' EXIT
say() { if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $1"; fi; }
# what was built is old: builds share the page's parts, and a program linked again is gone for a moment while other jobs run it
make="make --no-print-directory -o build -o $build/pendulumd -o $build/pendulum B=$build DESTDIR="
export PKG_CONFIG_PATH=$root/usr/lib/x/pkgconfig PKG_CONFIG_SYSROOT_DIR=

installed() { $make"$root" PREFIX=/usr LIBDIR=/usr/lib/x install > "$root.log" 2>&1 || { cat "$root.log"; return 1; }; }
say 'make install into a directory with a blank in its name' installed
sed -i "s|^prefix=.*|prefix=$PWD/build/installed|; s|^libdir=.*|libdir=\${prefix}/lib/x|" "$PKG_CONFIG_PATH/pendulum.pc"
ln -sfn "$root/usr" build/installed
flags=$(pkg-config --cflags pendulum) libs=$(pkg-config --libs pendulum)

for header in "$root"/usr/include/pendulum/*.h; do
    name=$(basename "$header")
    echo "#include <pendulum/$name>" > "$root/alone.c"
    say "<pendulum/$name> in C" gcc -std=c17 -Wall -Wextra -Werror -pedantic $flags -fsyntax-only "$root/alone.c"
    say "<pendulum/$name> in C++" g++ -std=c++17 -Wall -Wextra -Werror -x c++ $flags -fsyntax-only "$root/alone.c"
done

cat > "$root/program.c" <<'END'
#include <math.h>
#include <pendulum/run.h>
#include <stdio.h>

/* two arms from the horizontal: where they are after a second */
int main(void) {
    const double length[] = {1, 1}, mass[] = {1, 1}, phi[] = {0, 0}, rate[] = {0, 0};
    const int parent[] = {-1, 0};
    struct pend_tree *tree;
    struct pend_run *run;
    double t[2], angle[4];
    struct pend_samples samples = {};
    struct pend_problem problem = {};
    int done = 0;
    samples.cap = 2, samples.t = t, samples.phi = angle;
    if (pend_tree_new(&tree, 2, length, mass, parent, NULL) != PEND_OK) return 1;
    problem.tree = tree, problem.loads.gravity = 9.81, problem.phi = phi, problem.rate = rate;
    problem.times.count = 2, problem.times.span = 1, problem.times.divisor = 1;
    const struct pend_method *method = pend_method_at(0);
    problem.rtol = method->rtol_default;
    if (pend_run_new(&run, method, &problem, NULL) != PEND_OK) return 2;
    while (!done)
        if (pend_run_next(run, &samples, INFINITY, &done, NULL) != PEND_OK) return 3;
    printf("%.3f %.3f\n", angle[2], angle[3]);
    pend_run_free(&run);
    pend_tree_free(&tree);
    return 0;
}
END
program() { "$@" $flags -o "$root/program" "$root/program.c" -x none $libs && [ "$("$root/program")" = "$want" ]; }
# found by another program, with the fourth-order method of Runge and Kutta
want='-2.196 -2.605'
say 'a program in C' program gcc -std=gnu17 -Wall
say 'the same in C++' program g++ -std=c++17 -x c++

command_line() { echo '{"length":[1],"mass":[1],"parent":[0]}' | "$root/usr/bin/pendulum" run - --t 0,1 --local > "$root/answer" &&
    [ "$(wc -l < "$root/answer")" = 3 ] && [ -s "$root/usr/share/man/man1/pendulum.1" ] && bash -n "$root/usr/share/bash-completion/completions/pendulum"; }
say 'the command line, its man page and its completion' command_line

# what is beside it stays, whatever its name
mkdir -p "${root% *}"; touch "${root% *}/mine"
uninstalled() { $make"$root" PREFIX=/usr LIBDIR=/usr/lib/x uninstall > /dev/null && [ -e "${root% *}/mine" ] &&
    [ -z "$(find "$root/usr" -type f)" ]; }
say 'make uninstall takes away what was installed, and nothing else' uninstalled
rm -rf "${root% *}" "$root.log" build/installed
echo "$passed passed, $failed failed"
[ $failed = 0 ]
