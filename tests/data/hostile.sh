# SPDX-License-Identifier: BSD-3-Clause
# Files that were made to do harm are accepted or refused as EXPECT.tsv says: at once, in little memory,
# with one message, and without one escape code of theirs reaching the terminal.
[ -d "$DATA/hostile" ] || skip "there is no $DATA/hostile (SC_TEST_DATA)"

# What a header promises is not allocated: 2 GiB of addresses suffice (sanitizers need more for themselves).
grep -q '^SC_SANITIZE:STRING=.' "$BUILD/CMakeCache.txt" || ulimit -v $((2 * 1024 * 1024))

no_escapes() { # no_escapes FILE...: no control character but the end of a line, and no sequence of C1
    if LC_ALL=C grep -nP '[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]' "$@"; then
        fail "$name: a control character of the file reaches the terminal"
    fi
}

attempt() { # attempt COMMAND...: run it; sets code
    code=0
    timeout 60 "$SEGCAST" "$@" >stdout.txt 2>stderr.txt </dev/null || code=$?
    case $code in 0 | 64 | 65 | 66) ;; *)
        cat stderr.txt; fail "$name: segcast $1: exit code $code, expected 0, 64, 65 or 66" ;;
    esac
    [ $code = 0 ] || one_error
    no_escapes stdout.txt stderr.txt
}

count=0
while IFS=$'\t' read -r name expected; do
    [ "$name" = file ] && continue
    count=$((count + 1))
    path=$DATA/hostile/$name
    case $name in
    *.yaml)
        sed "s|^volume: \([a-z0-9]*\.mha\)|volume: $DATA/hostile/\1|" "$path" >job.yaml
        attempt check job.yaml
        case $expected in *"verify is 0"* | *"verify: both 0"*)
            rm -rf out
            attempt render job.yaml -o out -q
            case $expected in *refuses*) ;; *) [ $code = 0 ] || fail "$name: render gives $code" ;; esac
            if [ $code = 0 ]; then
                attempt verify out
                [ $code = 0 ] || fail "$name: what was rendered is not verified"
            fi ;;
        esac
        continue ;;
    esac
    attempt info "$path"
    case $code:$expected in
    0:accept* | 6?:refuse* | 0:*"accept or refuse"* | 6?:*"accept or refuse"* | 0:*"or draw"*) ;;
    *) cat stderr.txt; fail "$name: exit code $code, expected: $expected" ;;
    esac
    [ $code = 0 ] || continue
    # every label is in the object, each with a name that is UTF-8
    labels=$("$SEGCAST" info "$path" --json 2>/dev/null | jq '.labels | length')
    told=$(awk '$1 == "labels" {print $2 + 1}' stdout.txt)
    [ "$labels" = "$told" ] || fail "$name: info --json has $labels labels, info $told"
    case $expected in *"all 5 labels"*) [ "$labels" = 5 ] || fail "$name: $labels labels, expected 5" ;; esac
done <"$DATA/hostile/EXPECT.tsv"
[ "$count" -ge 17 ] || fail "EXPECT.tsv names only $count files, expected at least 17"

# The same for names in a label table and for keys of a job, and for names of files.
name="a table"
printf '1 \x1b[31mred\x07 1 2 3 255\n2 c1\xc2\x9b31m 1 2 3 255\n3 \xff\x9b 1 2 3 255\nx\x1b]0;t\x07\n' >t.ctbl
attempt info "$DATA/hostile/fmt_n.nrrd" --labels t.ctbl
[ $code = 0 ] || fail "a table with control characters in its names is refused"
name="a job"
printf 'volume: phantom:40x32x40\n"\\e[31mkey\\x9b": {}\n' >key.yaml
attempt check key.yaml
[ $code = 65 ] || fail "a job with an unknown key gives $code, expected 65"
name="a file"
cp "$DATA/hostile/fmt_n.nrrd" $'\e[31mred.nrrd'
attempt info $'\e[31mred.nrrd'
attempt info $'\e[31mnone.nrrd'
[ $code = 66 ] || fail "a missing file gives $code, expected 66"
