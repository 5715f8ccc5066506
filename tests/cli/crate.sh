# SPDX-License-Identifier: BSD-3-Clause
# Every directory of a job says where its film comes from: ro-crate-metadata.json, which names nobody but the author.
find_python json python3
check_crate() { "$python" "$SOURCE/tests/cli/crate.py" "$1" >&2 || fail "$1 is no valid crate (above)"; }
entities() { jq -r "[.\"@graph\"[] | select($2)] | length" "$1/ro-crate-metadata.json"; }
actions='."@type" == "CreateAction"'

# A whole job. Names of files, hosts and users stay out; the film's own words come in.
mkdir doe_jane
"$SEGCAST" convert phantom:40x40x40 -o doe_jane/doe_scan.nrrd -q >/dev/null
printf 'volume: doe_scan.nrrd\noutput: {size: [64, 48], fps: 4, video: "a film.mp4", title: A heart, author: "A. Author; CC-BY-4.0"}
animation: {frames: 8}\nrender: {quality: draft}\n' >doe_jane/doe_job.yaml
mpi 2 "$SEGCAST" render doe_jane/doe_job.yaml -o doe_jane/whole -q --threads 1 --set output.frames=png \
    --set overlays.caption=doe >/dev/null
check_crate doe_jane/whole
crate=doe_jane/whole/ro-crate-metadata.json
! grep -niE "doe|$PWD|$(hostname)|\"[^\"]*(^|[^a-z])$(id -un)([^a-z]|$)" "$crate" >&2 || fail "$crate names too much (above)"
sha256=$(sha256sum doe_jane/doe_scan.nrrd | cut -d' ' -f1)
[ "$(entities doe_jane/whole ".sha256 == \"$sha256\" and .contentSize == \"$(stat -c %s doe_jane/doe_scan.nrrd)\"")" = 1 ] ||
    fail "the volume is not among the inputs with its SHA-256 and size"
[ "$(entities doe_jane/whole '."@id" == "https://spdx.org/licenses/CC-BY-4.0"')" = 1 ] || fail "the licence is not there"
[ "$(entities doe_jane/whole '."@type" == "Person" and .name == "A. Author"')" = 1 ] || fail "the author is not there"
[ "$(entities doe_jane/whole "$actions and (.description | contains(\"segcast render --output DIR --quiet --threads 1 \"))
    and (.description | contains(\" 2 ranks, 1 threads\"))")" = 1 ] || fail "command line or machine are not there"
version=$("$SEGCAST" --version | sed -n 's/^segcast //p') commit=$("$SEGCAST" --version | sed -n 's/^commit *//p')
[ "$(entities doe_jane/whole ".\"@type\" == \"SoftwareApplication\" and .softwareVersion == \"$version\" and
    (.description | endswith(\"$commit\"))")" = 1 ] || fail "version and commit are not there"

# verify proves it.
"$SEGCAST" verify doe_jane/whole | grep -q ', ro-crate-metadata.json,' || fail "verify does not name the crate"
sed -i 's/A. Author/B. Author/' "$crate"
expect 65 'whole/ro-crate-metadata.json: is missing, or is not the file of' "$SEGCAST" verify doe_jane/whole; one_error

# Runs that go on, slices, and join: an action for each run, and the same directory gives the same bytes.
small_job plain.yaml
"$SEGCAST" render plain.yaml -o resumed -q --frames 0-3 >/dev/null
[ "$(entities resumed "$actions")" = 1 ] || fail "a slice that is done has no action"
"$SEGCAST" render plain.yaml -o resumed -q --resume >/dev/null
check_crate resumed
[ "$(entities resumed "$actions")" = 2 ] || fail "a run that went on is not there"
"$SEGCAST" render plain.yaml -o resumed -q --resume >/dev/null # there is nothing to do, and nothing changes
"$SEGCAST" verify resumed >/dev/null
for slice in 0-2 3-6; do
    "$SEGCAST" render plain.yaml -o sliced -q --frames $slice >/dev/null &
    slices+=($!)
done
for slice in "${slices[@]}"; do
    wait "$slice" || fail "a slice failed"
done
"$SEGCAST" join sliced >/dev/null
"$SEGCAST" verify sliced >/dev/null
check_crate sliced
[ "$(entities sliced "$actions")" = 2 ] || fail "a slice is not there"
mv sliced/ro-crate-metadata.json before.json
sed -i '/"file":/,$d' sliced/manifest.jsonl # as after an accident before the records were proven
"$SEGCAST" join sliced >/dev/null
cmp before.json sliced/ro-crate-metadata.json || fail "join made another crate of the same directory"
"$SEGCAST" verify sliced | grep -q ro-crate-metadata.json || fail "join does not prove the crate"

# A killed run: its crate says that the run has not ended, also when another one has completed the job.
small_job slow.yaml
"$SEGCAST" render slow.yaml -o killed -q --set output.size=640x480 --set render.quality=still >/dev/null 2>&1 &
wait_until '[ "$(frames killed)" -gt 0 ]'
kill -KILL $! && wait $! || :
expect 75 "" "$SEGCAST" status killed
jq -e '."@graph"[] | select(."@type" == "CreateAction") | has("endTime") | not' killed/ro-crate-metadata.json >/dev/null ||
    fail "a run that was killed has ended"
"$SEGCAST" render slow.yaml -o killed -q --set output.size=640x480 --set render.quality=still --resume >/dev/null
check_crate killed
[ "$(entities killed "$actions and .actionStatus.\"@id\" == \"http://schema.org/ActiveActionStatus\"")" = 1 ] ||
    fail "a run that was killed is not there"

# A crate of somebody else's stays.
mkdir foreign
echo '{"somebody": "else"}' >foreign/ro-crate-metadata.json
cp foreign/ro-crate-metadata.json theirs.json
for option in '' --resume --overwrite; do
    # shellcheck disable=SC2086
    expect 73 'foreign/ro-crate-metadata.json: is a file that was not made by segcast' "$SEGCAST" render plain.yaml -o foreign -q $option
    one_error
done
cmp foreign/ro-crate-metadata.json theirs.json && [ "$(ls foreign)" = ro-crate-metadata.json ] || fail "something was changed"

# The licence may be an address, or words, or not stated at all.
for author in 'A; https://example.org/terms' 'A; For teaching only' ''; do
    "$SEGCAST" render plain.yaml -o licence -q --overwrite --set output.author="$author" >/dev/null
    check_crate licence
    jq -c '."@graph"[] | select(."@id" == "./").license' licence/ro-crate-metadata.json
done >licences.txt
diff licences.txt - >&2 <<'TEXT' || fail "the licences differ (above)"
{"@id":"https://example.org/terms"}
"For teaching only"
"No licence is stated. Ask the author before it is used."
TEXT

# Inputs of several files have the SHA-256 of the list that sha256sum prints; a prepared file has its own.
mkdir masks store.zarr
printf 'volume: none\noutput: {size: [64, 48], video: none}\nanimation: {frames: 1}\nrender: {quality: draft}\n' >any.yaml
"$SEGCAST" convert phantom:40x40x40 -o scan.segc -q >/dev/null
"$python" - <<'PY'
import json
values = bytes(x // 8 % 3 for z in range(32) for y in range(32) for x in range(32))
header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 32 32 32\nencoding: raw\n"
open("scan.raw", "wb").write(values)
open("scan.nhdr", "w").write(header + "data file: scan.raw\n\n")
for label, name in enumerate(["left", "right"], 1):
    open(f"masks/{name}.nrrd", "wb").write((header + "\n").encode() + bytes(v == label for v in values))
open("store.zarr/.zarray", "w").write(json.dumps({"zarr_format": 2, "shape": [32, 32, 32], "chunks": [32, 32, 32], "dtype": "|u1",
                                                  "compressor": None, "fill_value": 0, "filters": None, "order": "C"}))
open("store.zarr/0.0.0", "wb").write(values)
PY
list_of() { (cd "$1" && find . -type f | LC_ALL=C sort | xargs -d '\n' sha256sum | sha256sum | cut -d' ' -f1); }
has_input() { # has_input VOLUME TYPE SHA-256: the crate of its film says so of the label volume
    local found
    "$SEGCAST" render any.yaml -o inputs -q --overwrite --set volume="$1" >/dev/null 2>&1 || fail "$1 is not drawn"
    check_crate inputs
    found=$(jq -r '."@graph"[] | select(.name // "" | startswith("label volume")) | "\(."@type") \(.sha256)"' inputs/ro-crate-metadata.json)
    [ "$found" = "$2 $3" ] || fail "the crate says of $1: $found, expected $2 $3"
}
has_input masks Dataset "$(list_of masks)"
has_input store.zarr Dataset "$(list_of store.zarr)"
has_input scan.nhdr Dataset "$(sha256sum ./scan.nhdr ./scan.raw | sha256sum | cut -d' ' -f1)"
has_input scan.segc File "$(sha256sum scan.segc | cut -d' ' -f1)"
has_input phantom:40x40x40 CreativeWork null
truncate -s 1M store.zarr/another-level # more than is read of the store
has_input store.zarr CreativeWork null

# The directory of a study has its crate, too.
printf 'title: A study\nset: {volume: doe_jane/doe_scan.nrrd, output: {size: 64x64}, animation: {frames: 2}}
sweep: {render.skip: [none, leap]}\nleast: 1\nmost: 1\n' >study.yaml
"$SEGCAST" study study.yaml -o study -q >/dev/null
check_crate study
[ "$(entities study ".sha256 == \"$sha256\"")" = 1 ] || fail "the volume of a study is not among its inputs"
[ "$(entities study "$actions and .name == \"2 measurements made\" and has(\"endTime\")
    and (.description | contains(\"segcast study --output DIR --quiet STUDY.yaml\"))")" = 1 ] || fail "the run of a study is not there"
! grep -niE "doe|$PWD|$(hostname)" study/ro-crate-metadata.json >&2 || fail "the crate of a study names too much (above)"
"$SEGCAST" verify study | grep -q ro-crate-metadata.json || fail "verify does not name the crate of a study"
sed -i 's/A study/Your study/' study/ro-crate-metadata.json
expect 65 'study/ro-crate-metadata.json: is not what segcast' "$SEGCAST" verify study; one_error
"$SEGCAST" study study.yaml -o study -q --resume >/dev/null
"$SEGCAST" verify study >/dev/null
expect 73 'ro-crate-metadata.json: is in the way' "$SEGCAST" study study.yaml -o foreign -q; one_error
