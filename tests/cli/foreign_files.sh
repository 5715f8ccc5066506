# SPDX-License-Identifier: BSD-3-Clause
# Every command, in and with a folder full of strangers' files that bear the names of ours: nothing that
# segcast has not made changes, also not behind symbolic links. The list of commands is the program's own.
"$SEGCAST" convert phantom:24x20x26 -o heart.nrrd -q >/dev/null
small_job job.yaml
sed -i "s|^volume.*|volume: $PWD/heart.nrrd|; s|frames: 7|frames: 2|; s|video: none|video: film.mp4, frames: png|" job.yaml
"$SEGCAST" convert heart.nrrd -o heart.segc -q >/dev/null
printf 'set: {volume: %s, output: {size: 32x32}, threads: 1}\nleast: 1\nmost: 1\n' "$PWD/heart.nrrd" >study.yaml

calibration=$(basename "$(XDG_CACHE_HOME=$PWD/cache "$SEGCAST" plan --calibrate -q | tail -1)")
rm -r cache

strangers() { # strangers DIR [links]: a folder of files that are not ours; segments/ and frames/ may be links
    mkdir -p "$1" outside/segments outside/frames
    if [ "${2:-}" = links ]; then
        ln -s "$PWD/outside/segments" "$1/segments"
        ln -s "$PWD/outside/frames" "$1/frames"
        ln -s "$PWD/outside/film" "$1/film.mp4"
        ln -s "$PWD/outside/nowhere" "$1/stats.json"
    fi
    mkdir -p "$1/segments" "$1/frames" "$1/segcast"
    local name
    for name in segments/patient7.seg.nrrd segments/000000.seg segments/000000.host.1.part \
        segments/.000000.seg.tmp.host.1.0123456789abcdef frames/000000.png frames/000003.png frames/a.png \
        stats.json status.json frames.csv trace.json report.html job.yaml film.mp4 film.partial.mp4 video.mp4 manifest.jsonl.bak \
        manifest.0.jsonl.old .film.mp4.tmp.host.1 film.mp4.tmp notes.tmp still.png views.png orbit.mp4 \
        orbit.partial.mp4 prepared.segc phantom.nrrd heart.yaml measurements.jsonl cells.csv extrap.jsonl study.yaml \
        segcast/calibration.json segcast/notes.txt segcast/"$calibration"; do
        [ -e "$1/$name" ] || [ -L "$1/$name" ] || echo "mine: $name" >"$1/$name"
    done
}
snapshot() { # snapshot DIR...: a line for everything in the folders
    find "$@" \( -type f -exec sha256sum {} + \) -o \( -type l -printf '%p -> %l\n' \) | sort
}
unchanged() { # unchanged BEFORE DIR...: every line of BEFORE is still true
    local before=$1 lost
    shift
    lost=$(comm -23 <(echo "$before") <(snapshot "$@"))
    [ -z "$lost" ] || fail "changed by \"$ran\": $lost"
}
run() { # run COMMAND [ARGUMENT]...: any exit code of the contract is right, as long as the files stay
    local code=0
    ran="$*"
    # A desk ends by Ctrl-C. What its page saves, desk.desk tests.
    local by=()
    [ "$1" != desk ] || by=(timeout --preserve-status -s INT 3)
    "${by[@]}" "$SEGCAST" "$@" >"$top/stdout.txt" 2>"$top/stderr.txt" </dev/null || code=$?
    case $code in 0 | 64 | 65 | 66 | 73 | 75) ;; *) cat "$top/stderr.txt" >&2; fail "exit code $code: $ran" ;; esac
    codes="$codes $code"
}
top=$PWD job=$PWD/job.yaml heart=$PWD/heart.nrrd codes=

# ways COMMAND: the command with everything that may write, one way a line, run in the folder of strangers
ways() {
    local more
    case $1 in
    render) for more in "" --overwrite --resume "--slice 0/2" "--frames 0"; do
        echo "render $job -o . $more"
        echo "render $job -o ../strangers/sub $more"
        echo "render job.yaml $more"
    done ;;
    check) echo "$1 $job"; echo "$1 job.yaml" ;;
    plan) echo "$1 $job"; echo "$1 job.yaml"; echo "$1 --calibrate" ;; # XDG_CACHE_HOME is this folder
    still) echo "still $job"; echo "still $job -o new.png --overwrite"; echo "still $job -o frames/a.png"; echo "still $job -o ."
        echo "still $job --sheet 12"; echo "still $job --sheet 12 -o new.png --overwrite"; echo "still $job --sheet 12 -o frames/a.png"
        echo "still $heart --sheet slices --size 64x48 -o frames/000000.png" ;;
    orbit) echo "orbit $heart --frames 2 --size 64x48"; echo "orbit $heart --frames 2 --size 64x48 -o new.mp4 --overwrite"
        echo "orbit $heart --frames 2 --size 64x48 -o film.mp4" ;;
    info) echo "info $heart --json" ;;
    desk) echo "desk $job" ;;
    init) echo "init $heart"; echo "init $heart -o job.yaml" ;;
    convert) echo "convert $heart -o job.yaml --to bids"; echo "convert $heart -o new.tsv --overwrite"
        echo "convert $heart --tissue aorta -o job.yaml"; echo "convert $heart --tissue aorta -o new.csv --overwrite"
        echo "convert $heart -o prepared.segc"; echo "convert $job -o prepared.segc"; echo "convert $heart -o new.segc --overwrite"
        echo "convert phantom:20x20x20 -o phantom.nrrd"; echo "convert phantom:20x20x20 -o segments/patient7.seg.nrrd"
        echo "convert phantom:20x20x20 --beating 3 -o sub/heart.nrrd" ;;
    join | verify | status) echo "$1 ."; echo "$1 sub" ;;
    report) echo "report ."; echo "report sub"; echo "report . sub"; echo "report . sub -o job.yaml"
        echo "report . sub -o new.html --overwrite" ;;
    study) for more in "" --overwrite --resume; do
        echo "study ../study.yaml -o . $more"
        echo "study ../study.yaml -o sub $more"
    done ;;
    help) echo "help --man"; echo "help render"; echo "help keys --schema"; echo "help keys --markdown"; echo --version ;;
    *) fail "the command $1 is new: say here how it may write" ;;
    esac
}
commands=$("$SEGCAST" --help | sed -nE 's/^([a-z]+)? {2,}([a-z]+) +[][A-Z].*/\2/p' | sort -u)
[ "$(wc -w <<<"$commands")" -gt 12 ] || fail "the list of commands: $commands"
kinds='plain links'
case $BUILD in */asan) kinds=links ;; esac # where most files are plain, too
for kind in $kinds; do
    rm -rf strangers outside
    strangers strangers $kind
    strangers strangers/sub $kind
    before=$(snapshot "$top/strangers" "$top/outside")
    cd strangers
    for command in $commands; do
        ways "$command" >"$top/ways.txt" # not $(...), in which a failure would end the subshell alone
        [ -s "$top/ways.txt" ] || fail "the command $command has no way to write"
        while read -ra words; do
            XDG_CACHE_HOME=$PWD run "${words[@]}"
            unchanged "$before" "$top/strangers" "$top/outside"
        done <"$top/ways.txt"
    done
    cd "$top"
    [ ! -e outside/nowhere ] || fail "a file was made behind a dangling link"
done
[[ $codes == *73* && $codes == *' 0'* ]] || fail "exit codes: $codes"

# Strangers' files beside ours: theirs stay, whatever becomes of ours. Where they stand in folders that are
# ours alone, they are in the way.
mkdir -p run
echo mine >outside/file
"$SEGCAST" render "$job" -o run -q >/dev/null
ln -s "$PWD/outside" run/link
beside() { # beside NAME...: render, verify and join with these files there
    local name
    mkdir -p run/segments
    for name in "$@"; do
        echo mine >"run/$name"
    done
    for more in --resume --overwrite "--overwrite --set render.quality=draft"; do
        # shellcheck disable=SC2086 # a list of words
        run render "$job" -o run -q $more
        run verify run
        run join run
        for name in "$@"; do
            [ "$(cat "run/$name")" = mine ] || fail "run/$name changed: $more"
        done
        [ -L run/link ] && [ "$(cat outside/file)" = mine ] || fail "what a link leads to changed: $more"
    done
}
codes=
beside notes.txt stats.json.bak .hidden.tmp x.tmp film.mp4.bak manifest.jsonl.old
[ "$codes" = ' 0 0 0 0 0 0 0 0 0' ] || fail "files beside a run are in the way: $codes"
beside segments/patient7.seg.nrrd segments/000001-notes.seg frames/a.png frames/notes.txt

# The job that was given is no output: what was written into job.yaml of a run, and the run begun anew from it, stays.
mkdir given
small_job given.yaml
"$SEGCAST" render given.yaml -o given -q --frames 0-2 >/dev/null
cp given/job.yaml given/resolved.yaml
echo '# turned the other way' >>given/job.yaml
cp given/job.yaml edited.yaml
(cd given && expect 73 'job.yaml: is the job that was given, and --overwrite would replace it' "$SEGCAST" render job.yaml -o . --overwrite)
cmp given/job.yaml edited.yaml || fail "--overwrite has replaced the job that was given"
(cd given && "$SEGCAST" render job.yaml -o . --resume -q >/dev/null)
cmp given/job.yaml edited.yaml || fail "--resume has replaced the job that was given"
mv given/resolved.yaml given/job.yaml
(cd given && "$SEGCAST" render job.yaml -o . --overwrite -q >/dev/null) || fail "a job as it was resolved cannot be rendered anew"
