#!/bin/bash
# Installs the library: its archive, its headers for C and C++, and what pkg-config says of them.
# usage: library.sh BUILD DESTDIR PREFIX LIBDIR HEADER...
# Leaves to others: the server and its unit (Makefile). Invariant: an installed header includes only installed ones, by
# their place beside it, and is reached as <pendulum/NAME.h>; C++ links to it as C.
set -eu
build=$1 destdir=$2 prefix=$3 libdir=$4
shift 4
version=$(sed -nE 's/^#define PEND_VERSION "(.*)"$/\1/p' core/base/status.h)
include=$destdir$prefix/include/pendulum
rm -rf "$include"
install -d "$include" "$destdir$libdir/pkgconfig"
install -m 644 "$build/libpendulum.a" "$destdir$libdir/libpendulum.a"
for name in "$@"; do
    # the declarations stand behind the last include
    awk '
        { sub(/^#include "core\/[a-z\/]+\//, "#include \""); line[NR] = $0 }
        /^#include|^#pragma once/ { begin = NR }
        END {
            for (i = 1; i <= NR; i++) {
                print line[i]
                if (i == begin) print "\n#ifdef __cplusplus\nextern \"C\" {\n#endif"
            }
            print "\n#ifdef __cplusplus\n}\n#endif"
        }' "core/$name.h" > "$include/${name##*/}.h"
    chmod 644 "$include/${name##*/}.h"
done
cat > "$destdir$libdir/pkgconfig/pendulum.pc" <<END
prefix=$prefix
includedir=\${prefix}/include
libdir=$libdir

Name: pendulum
Description: Planar pendulum trees: motion, forces, modes, ensembles
Version: $version
Requires: gsl
Libs: -L\${libdir} -lpendulum -lm
Cflags: -I\${includedir}
END
chmod 644 "$destdir$libdir/pkgconfig/pendulum.pc"
