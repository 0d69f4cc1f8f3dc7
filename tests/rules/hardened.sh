#!/bin/bash
# Checks with readelf that the programs and their object files follow OpenSSF's guide for hardened C.
# usage: hardened.sh BUILD     (build/release)
# Leaves to others: the flags, and the files that are exempt from some (Makefile, HARD); the sandbox
# (tests/wire/test_sandbox.c).
# Invariant: a program built without these flags fails every check, so no check can pass by seeing nothing.
set -u
build=$1
daemon=$build/pendulumd
passed=0 failed=0
export LC_ALL=C

verdict() { # name, complaints
    if [ -z "$2" ]; then passed=$((passed + 1)); return; fi
    failed=$((failed + 1))
    head -n 20 <<<"$2" | sed 's/^/  /'
    printf 'FAIL %s\n' "$1"
}

# what a linked program has, one line each; one that ends with `no` is a lack
table() {
    local dynamic segments symbols
    dynamic=$(readelf -dW "$1") segments=$(readelf -lW "$1") symbols=$(readelf --dyn-syms -W "$1")
    row 'position independent (PIE)' 'PIE' "$dynamic"
    row 'symbols bound at the start (now)' 'BIND_NOW' "$dynamic"
    row 'relocations read-only (relro)' 'GNU_RELRO' "$segments"
    row 'stack not executable' 'GNU_STACK .* RW +0x' "$segments"
    row 'stack protector' '__stack_chk_fail' "$symbols"
    row 'checked C library (FORTIFY)' '__[a-z]+_chk@' "$symbols"
    none 'no code that is rewritten' 'TEXTREL' "$dynamic"
    none 'no place of libraries of its own' 'R(UN)?PATH' "$dynamic"
    none 'no segment to write and run' 'LOAD .* RWE ' "$segments"
}
row() { if grep -qE -- "$2" <<<"$3"; then printf '%-36s yes\n' "$1"; else printf '%-36s no\n' "$1"; fi; }
none() { if grep -qE -- "$2" <<<"$3"; then printf '%-36s no\n' "$1"; else printf '%-36s yes\n' "$1"; fi; }

# objects whose sources are still there
objects() {
    local object source
    find "$build"/{core,api,server} -name '*.o' | while read -r object; do
        source=${object#"$build/"} source=${source%.o}
        for source in "$source.c" "$source.cpp" "$build/$source.c" "${source%.*}.c"; do
            [ -e "$source" ] && echo "$object" && break
        done
    done
}

# a note that the processor may check branches and returns; the linked daemon has it on x86-64, where its entry is its own
branches() {
    local want
    case $(readelf -h "$daemon" | sed -n 's/ *Machine: *//p') in
        *X86-64) want='IBT, SHSTK' ;;
        AArch64) want='BTI, PAC' ;;
        *) return ;;
    esac
    { objects; [ "$want" = "BTI, PAC" ] || echo "$daemon"; } | xargs readelf -n build/web/assets.o | awk -v want="$want" '
        function tell() { if (file != "" && !good) print file " has no note of " want }
        /^File: / { tell(); file = $2; good = 0 }
        /Properties:/ && index($0, want) { good = 1 }
        END { tell() }'
}

# gcc notes the flags that it was given; core has what its loops can bear (CORE_SPARED)
flags() {
    local all='-fPI -fstack-protector-strong -fstack-clash-protection -fno-delete-null-pointer-checks'
    objects | xargs readelf -wi --dwarf-depth=1 | awk -v all="$all" -v build="$build/" '
        function need(flag) { if (index($0, flag) == 0) print file " is compiled without " flag }
        /^File: / { file = $2 }
        /DW_AT_producer/ && / GNU C/ {
            seen++
            count = split(all, flag, " ")
            for (i = 1; i <= count; i++) need(flag[i])
            if (index(file, build "core/") == 1) next
            need("-fno-strict-overflow"); need("-fno-strict-aliasing")
            if ($0 !~ /GNU C[+0-9]* 1[23][.]/) need("-ftrivial-auto-var-init=zero")
        }
        END { if (!seen) print "no flags are noted" }'
}

# a program built without: each row of its table is a lack, but for what no linker does by itself
noticed() {
    local sample=$build/hardened.sample said
    printf 'int main(int n, char **all) { char text[64]; __builtin_strcpy(text, all[n - 1]); return text[0]; }\n' > "$sample.c"
    gcc -U_FORTIFY_SOURCE -fno-stack-protector -fno-pie -no-pie -Wl,-z,norelro -Wl,-z,lazy -Wl,-z,execstack -Wl,-rpath,/tmp \
        -o "$sample" "$sample.c" 2>/dev/null || { echo 'it does not build'; return; }
    said=$(table "$sample")
    rm -f "$sample" "$sample.c"
    [ "$(grep -c ' no$' <<<"$said")" = 7 ] || { echo 'of a program without, this was told:'; echo "$said"; }
}

table "$daemon"
verdict 'the daemon is hardened' "$(table "$daemon" | grep ' no$')"
verdict 'the command line is hardened' "$(table "$build/pendulum" | grep ' no$')"
verdict 'every object is ready for checked branches and returns' "$(branches)"
[ "$(readelf -wi --dwarf-depth=1 "$build/server/main.o" | grep -c 'GNU C')" = 0 ] || verdict 'every object has the flags' "$(flags)"
verdict 'a program without is noticed' "$(noticed)"
printf '%d passed, %d failed\n' $passed $failed
[ $failed = 0 ]
