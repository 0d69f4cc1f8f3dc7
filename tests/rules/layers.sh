#!/bin/bash
# Checks the architecture: who may include whom, one file per outside library, the order of folders and files, no globals.
# usage: layers.sh BUILD     (build/release, for the symbols)
# Leaves to others: layout (layout.sh), documents (docs.sh).
# Invariant: a new outside library or header first needs a row here.
set -u
build=$1
passed=0 failed=0

# what each room's files may include of the project
declare -A may=([core]='^core/' [api]='^(api|core)/' [server]='^(server|api)/|^core/base/status[.]h$'
    [api/clients]='^api/')
# system headers that core and api may use: none that knows threads, files, sockets or time
pure='^(assert|complex|errno|float|limits|math|stdalign|stdarg|stdbool|stddef|stdint|stdio|stdlib|string|strings|tgmath|[ei]mmintrin|arm_neon)[.]h$|^(cassert|cmath|cstddef|cstdint|cstdio|cstdlib|cstring|limits|system_error)$'
# an outside library's headers, and the files that are its door
doors=(
    '^gsl/|^gsl_ ^core/(integrate/methods/method_gsl|fit/fit|fit/fit_pieces|fit/fit_told|fit/fit_verdict|orbits/orbit_algebra|modes/damped)[.]c$'
    '^sys/mman[.]h$ ^(core/modes/hugepage|server/sandbox/sandbox_seccomp)[.]c$' # advice about huge pages; rights of memory
    '^cjson/ ^api/(json/json_(scan|in)|clients/browser/missing)[.]c$'
    '^curl/ ^api/clients/cli/remote[.]c$'
    '^libdeflate[.]h$ ^(api/encode/encode_npz|api/call/zip|server/protocol/coding_gzip)[.]c$'
    '^nettle/ ^api/call/digest[.]c$'
    '^png[.]h$ ^api/encode/encode_png[.]c$'
    '^dragonbox/ ^api/number/number_write[.]cpp$'
    '^fast_float/ ^api/number/number_read[.]cpp$'
    '^microhttpd[.]h$ ^server/http/(http[.]c|(connection|response)[.][ch])$'
    '^isa-l/ ^server/protocol/coding_gzip[.]c$'
    '^zstd[.]h$ ^server/protocol/coding_zstd[.]c$'
    '^sqlite3[.]h$ ^server/store/store_sqlite([.]c|_disk[.][ch])$'
    '^libpq-fe[.]h$ ^server/store/store_postgres(_line[.]h|[.]c)$'
    '^seccomp[.]h$ ^server/sandbox/sandbox_seccomp[.]c$'
    '^linux/(landlock|capability)[.]h$ ^server/sandbox/(sandbox_landlock|privileges)[.]c$'
    '^(pthread|threads)[.]h$ ^server/'
)

verdict() { # name, complaints
    if [ -z "$2" ]; then passed=$((passed + 1)); return; fi
    failed=$((failed + 1))
    printf '%s\n' "$2" | sed 's/^/  /'
    printf 'FAIL %s\n' "$1"
}

# the clients ask from outside: they are no part of the room that they lie in
files() { find "$1" \( -name '*.[ch]' -o -name '*.cpp' \) | if [ "$1" = api ]; then grep -v '^api/clients/'; else cat; fi | sort; }

# every include of the three rooms: file, header, and the line's quote or angle
includes=$(grep -E '^ *# *include' $(files core) $(files api) $(files server) $(files api/clients) /dev/null |
    sed -nE 's/^([^:]+): *# *include *(["<])([^">]+)[">].*/\1 \3 \2/p')

room_includes() {
    awk -v room="^$1/" -v may="${may[$1]}" '$3 == "\"" && $1 ~ room && $2 !~ may { print $1 " may not include " $2 }' <<<"$includes"
}

door() { # header pattern, file pattern
    awk -v header="$1" -v file="$2" '$3 == "<" && $2 ~ header && $1 !~ file { print $1 " is no door to " $2 }' <<<"$includes"
}

pure_headers() {
    local all=$pure row
    for row in "${doors[@]}"; do [[ $row = *pthread* ]] || all+="|${row%% *}"; done
    awk -v all="$all" '$3 == "<" && $1 ~ /^(core|api)\// && $1 !~ /^api\/clients\// && $2 !~ all { print $1 " may not use " $2 }' <<<"$includes"
}

own_header_first() {
    local file
    for file in $(files core) $(files api) $(files server) $(files api/clients); do
        [[ $file = *.h ]] || [ ! -f "${file%.*}.h" ] || echo "$file ${file%.*}.h"
    done | awk 'NR == FNR { own[$1] = $2; next } ($1 in own) && !seen[$1]++ && $2 != own[$1] { print $1 " does not include its own header first" }' - <(echo "$includes")
}

# what a README lists in order, the first cells of its table: folders end with a slash; X stands for X.h and X.c, or X.h
# where the header has a place of its own
listed() {
    awk '/^\| (file|folder) \|/ { inside = 1 } !/^\|/ { inside = 0 } inside' "$1/README.md" 2>/dev/null |
        sed -nE 's/^\| *(`[^|]*)\|.*/\1/p' | grep -oE '`[^`]+`' | tr -d '`' | awk '!seen[$0]++'
}

# a room's README lists its folders and the files at its top, and the README of a folder the files of that: in the order
# in which they may include each other
file_order() {
    local -A place=() of=() # a file's place; what of its room a file includes
    local room=$1 number=0 stem other file folder
    while read -r file other; do of[$file]+=" $other"; done < <(awk -v room="$room/" '$3 == "\"" && index($2, room) == 1 { print $1, $2 }' <<<"$includes")
    for stem in $(listed "$room"); do
        if [[ $stem = */ ]]; then
            folder=$room/${stem%/}
            [ -d "$folder" ] || { echo "$room/README.md lists a folder that is not there: $stem"; continue; }
            place[$folder/]=1
            [ -f "$folder/README.md" ] || { echo "$folder has no README.md"; continue; }
            for other in $(listed "$folder"); do place[$folder/$other]=$((++number)); done
        else
            place[$room/$stem]=$((++number))
        fi
    done
    [ $number -gt 0 ] || { echo "$room/README.md lists no files"; return; }
    for stem in "${!place[@]}"; do
        [[ $stem = */ ]] || compgen -G "$stem.*" > /dev/null || [ -f "$stem" ] || echo "a README lists $stem, which is not there"
    done
    for file in $(files "$room"); do
        folder=${file%/*}
        [ "$folder" = "$room" ] || [ -n "${place[$folder/]-}" ] || { echo "$room/README.md does not list $folder/"; continue; }
        stem=$file
        [[ $stem = *.h && -n "${place[$stem]-}" ]] || stem=${stem%.*}
        [ -n "${place[$stem]-}" ] || { echo "$folder/README.md does not list ${stem##*/}"; continue; }
        for other in ${of[$file]-}; do
            [ -n "${place[$other]-}" ] || other=${other%.h}
            [ -z "${place[$other]-}" ] || [ "${place[$other]}" -le "${place[$stem]}" ] || echo "$file includes $other, which is listed below it"
        done
    done | sort -u
}

# the page's READMEs list its scripts and styles, and nothing that is not there
page_files() {
    local readme folder name file
    for readme in $(find server/web -name README.md -not -path '*/node_modules/*'); do
        folder=${readme%/README.md}
        for name in $(listed "$folder"); do
            compgen -G "$folder/${name%/}*" >/dev/null || echo "$readme lists $name, which is not there"
        done
        for file in "$folder"/*.js "$folder"/*.css; do
            name=${file##*/}
            [ ! -e "$file" ] || listed "$folder" | grep -qxF -e "$name" -e "${name%.js}" || echo "$readme does not list $name"
        done
    done
    find server/web -name '*.js' -not -path '*/node_modules/*' -not -path '*/text/*/*' -printf '%h\n' | sort -u |
        while read -r folder; do [ -f "$folder/README.md" ] || [ "${folder##*/}" = text ] || echo "$folder has no README.md"; done
}

# data that can change; constants with addresses in them (.data.rel.ro) cannot
globals() {
    objdump -t "$build/libpendulum.a" | awk '/file format/ { file = $1 }
        $0 ~ / (O|  ) +(\.data|\.bss|\.tdata|\.tbss|\*COM\*)/ && $0 !~ /\.data\.rel\.ro/ && $(NF-1) !~ /^0+$/ { print file " holds the variable " $NF }'
}

effects() {
    nm -u "$build/libpendulum.a" | awk '{ print $2 }' | sort -u |
        grep -E '^(f?open|fopen64|fread|fwrite|f?printf|puts|putchar|perror|time|clock|clock_gettime|gettimeofday|nanosleep|rand|random|getenv|socket|read|write|pthread_.*|malloc_trim|exit|abort|__fprintf_chk|__printf_chk)$' |
        grep -vE '^(abort)$' | sed 's/^/core uses /'
}

# the objects of a room whose sources are still there: X.o of X.c or X.cc, X.avx2.o of X.c
objects() {
    local object source
    find "$build/$1" -name '*.o' -not -path '*/api/clients/*' | while read -r object; do
        source=${object#"$build/"} source=${source%.o}
        for source in "$source.c" "$source.cc" "${source%.*}.c"; do
            [ -e "$source" ] && echo "$object" && break
        done
    done
}

prefixes() { # room, symbol pattern
    # C++ names (_Z) have namespaces: those of the room and of its outside libraries
    objects "$1" | xargs nm -g --defined-only | awk 'NF == 3 { print $3 }' | sort -u | grep -vE "$2|^_Z" | sed "s|^|$1 defines |"
}

for room in core api server; do
    verdict "$room includes only what it may" "$(room_includes $room)"
    verdict "$room's folders and files include only those above them in its READMEs" "$(file_order $room)"
done
verdict "the page's READMEs list its files" "$(page_files)"
verdict 'a client includes only itself and api' "$(room_includes api/clients)"
verdict 'no room includes a client' "$(awk '$1 !~ /^api\/clients\// && $2 ~ /^api\/clients\// { print $1 " includes " $2 }' <<<"$includes")"
for row in "${doors[@]}"; do
    read -r header file <<<"$row"
    verdict "only the door to $header includes it" "$(door "$header" "$file")"
done
verdict 'core and api use no thread, file, socket or clock' "$(pure_headers)"
# core compiles wherever there is a C17 compiler and the GNU Scientific Library
linux_headers() {
    local file
    for file in $(files core); do
        awk '/^ *# *ifdef __linux__/ { inside = 1 } /^ *# *endif/ { inside = 0 }
            /^ *# *include *<(sys|linux|asm|unistd|fcntl)/ && !inside { print FILENAME " includes " $NF " on any system" }' "$file"
    done
}
verdict 'core includes a header of Linux on Linux alone' "$(linux_headers)"
verdict 'a file includes its own header first' "$(own_header_first)"
verdict 'core has no variable of its own' "$(globals)"
verdict 'core has no effects' "$(effects)"
verdict 'core names begin with pend_' "$(prefixes core '^pend_')"
verdict 'api names begin with api_' "$(prefixes api '^api_')"
# recv: recv_hook reads what libmicrohttpd receives
verdict 'server names begin with srv_' "$(prefixes server '^(srv_|main$|recv$)')"

# the rule notices what it is for: a copy of the sources with a fault of each kind
noticed() {
    local top=$PWD copy=$build/layers.sample said line
    rm -rf "$copy"
    mkdir -p "$copy"
    find core api server \( -name '*.[ch]' -o -name '*.cpp' -o -name 'README.md' \) -not -path '*/node_modules/*' -exec cp --parents -t "$copy" {} +
    sed -i '1i #include "core/integrate/run/run.h"' "$copy/core/tree/tree.h"
    sed -i '1i #include "api/json/json_out.h"' "$copy/api/base/text.h"
    sed -i '1i #include "server/work/queue.h"' "$copy/core/base/rng.h"
    sed -i '1i #include <sqlite3.h>' "$copy/server/work/queue.c"
    sed -i '1i #include <sys/mman.h>' "$copy/core/modes/hugepage.c"
    touch "$copy/server/store/unlisted.c"
    mkdir "$copy/api/unlisted"
    touch "$copy/api/unlisted/new.c" "$copy/server/web/class/new.js"
    said=$(cd "$copy" && LAYERS_SAMPLE=1 "$top/tests/rules/layers.sh" "$top/$build")
    for line in 'core/tree/tree.h includes core/integrate/run/run, which is listed below it' \
        'api/base/text.h includes api/json/json_out, which is listed below it' \
        'core/base/rng.h may not include server/work/queue.h' 'core/modes/hugepage.c includes <sys/mman.h> on any system' 'server/work/queue.c is no door to sqlite3.h' \
        'server/web/class/README.md does not list new.js' 'server/store/README.md does not list unlisted' 'api/README.md does not list api/unlisted/'; do
        grep -qF "  $line" <<<"$said" || echo "not noticed: $line"
    done
    rm -rf "$copy"
}
[ -n "${LAYERS_SAMPLE-}" ] || verdict 'faults of each kind in a copy of the sources are noticed' "$(noticed)"

printf '%d passed, %d failed\n' $passed $failed
[ $failed = 0 ]
