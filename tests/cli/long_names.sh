# SPDX-License-Identifier: BSD-3-Clause
# Paths of any length that the system accepts are used whole; longer ones are refused, and nothing is
# written anywhere else. Names that do not fit are refused with their limit, or shown with dots.
"$SEGCAST" convert phantom:24x20x26 -o heart.nrrd -q >/dev/null
small_job job.yaml
printf '1 a 10 20 30 255\n' >table.txt
part=$(printf 'd%.0s' $(seq 240))
deep=$part/$part/$part/$part/$part/$part # 1,445 characters
mkdir -p "$deep"
cp heart.nrrd table.txt "$deep"
sed -i 's|^volume.*|volume: heart.nrrd|' job.yaml
cp job.yaml "$deep"
shallow() { find . -maxdepth 5 -type f | sort; }
before=$(shallow)
unchanged() {
    rm -f stdout.txt stderr.txt
    [ "$(shallow)" = "$before" ] || fail "$1: files at another place: $(diff <(echo "$before") <(shallow))"
}
for format in png mp4 segc nrrd; do
    case $format in
    png) words="still job.yaml" ;;
    mp4) words="orbit heart.nrrd --frames 2 --size 64x48" ;;
    segc) words="convert heart.nrrd" ;;
    nrrd) words="convert phantom:20x20x20" ;;
    esac
    # shellcheck disable=SC2086 # a list of words
    expect 0 '' "$SEGCAST" $words -q -o "$deep/x.$format"
    [ -s "$deep/x.$format" ] || fail "$words: no file"
    # shellcheck disable=SC2086
    expect 73 'exists' "$SEGCAST" $words -q -o "$deep/x.$format"
    unchanged "$words"
done
expect 0 '' "$SEGCAST" still "$deep/heart.nrrd" --sheet slices --labels "$deep/table.txt" --size 64x48 -q -o "$deep/views.png"
expect 0 '' "$SEGCAST" still "$deep/job.yaml" -q -o "$deep/still.png" --set labels="$deep/table.txt"
expect 0 '' "$SEGCAST" info "$deep/heart.nrrd"
expect 0 '' "$SEGCAST" render "$deep/job.yaml" -q -o "$deep/run" --set output.video=f.mp4 --set output.frames=png
[ -s "$deep/run/f.mp4" ] && [ "$(ls "$deep/run/frames" | wc -l)" = 7 ] || fail "render: $(ls "$deep/run")"
expect 0 '' "$SEGCAST" render job.yaml -q --set "output.directory=$PWD/$deep/set" --set output.video=f.mp4
cmp "$deep/run/f.mp4" "$deep/set/f.mp4" || fail "the deep directories hold other videos"
expect 0 '' "$SEGCAST" verify "$deep/run"
expect 0 '' "$SEGCAST" render job.yaml -q -o "$deep/slices" --slice 0/1 --set output.video=f.mp4
expect 0 '' "$SEGCAST" join "$deep/slices"
expect 0 '' "$SEGCAST" verify "$deep/slices"
unchanged 'commands in a deep directory'

# Longer than the system accepts.
far=$deep/$deep/$deep
for words in "still job.yaml -o $far/x.png" "convert heart.nrrd -o $far/x.segc" "convert phantom -o $far/x.nrrd" \
    "orbit heart.nrrd -o $far/x.mp4" "render job.yaml -o $far/run" "info $far/heart.nrrd" "verify $far" \
    "still $far/job.yaml -o x.png" "still job.yaml --set volume=$far/heart.nrrd -o x.png" \
    "still job.yaml --set labels=$far/table.txt -o x.png" "render job.yaml --set output.directory=$far/run"; do
    code=0
    # shellcheck disable=SC2086
    "$SEGCAST" $words >stdout.txt 2>stderr.txt || code=$?
    case $code in 64 | 65 | 66 | 73) ;; *) fail "exit code $code of a path of ${#far} characters: ${words:0:20}..." ;; esac
    one_error
    unchanged "${words:0:20}"
done
expect 73 'the path of the directory has [0-9]+ bytes, expected at most 3700' "$SEGCAST" render job.yaml -o "$deep/$deep/$part/$part/$part/$part"

# Names of a job.
expect 64 'expected a name .* of at most 140 bytes' "$SEGCAST" render job.yaml -o named --set output.video="$(printf '%0150d' 0).mp4"
one_error
[ ! -e named ] || fail "a name of a video that is too long: a directory was made"
name=$(printf 'ü%.0s' $(seq 200))
long=x${name:0:127} # 255 bytes
printf '1 %s 10 20 30 255\n' "$long" >long.txt
expect 0 '' "$SEGCAST" check job.yaml --set labels=long.txt --set "tissues.\"$long\".opacity=0.5"
"$SEGCAST" info heart.nrrd --labels long.txt | grep -qF "$long" || fail "info cuts a name of 255 bytes"
printf 'volume: heart.nrrd\ntissues:\n  %sx: {opacity: 0.5}\n' "$long" >long.yaml
expect 65 'name has 256 bytes, expected less than 256' "$SEGCAST" check long.yaml
expect 64 'expected less than' "$SEGCAST" check job.yaml --set "output.title=$name"
expect 64 'each key has at most 255 characters' "$SEGCAST" check job.yaml --set "tissues.\"$name\".opacity=0.5"
expect 0 'names no key' env "SEGCAST_$(printf 'X%.0s' $(seq 300))=1" "$SEGCAST" check job.yaml

# The place of a mistake is the end of a long path, and whole characters.
printf 'volume: heart.nrrd\ntissues:\n  nowhere: {opacity: 0.5}\n' >"$deep/job.yaml"
expect 65 '^segcast: error: \.\.\..*/job.yaml:3: ' "$SEGCAST" check "$deep/job.yaml"
