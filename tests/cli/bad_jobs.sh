# SPDX-License-Identifier: BSD-3-Clause
# A job that cannot run is refused with one message and the documented exit code, and nothing is written.
small_job good.yaml
"$SEGCAST" check good.yaml | grep -q 'ok: 7 frames of 96 x 72' || fail "segcast check refuses a good job"
"$SEGCAST" plan good.yaml | grep -q 'core hours' || fail "segcast plan prints no core hours"
"$SEGCAST" plan good.yaml | grep -qE '^wall time +[0-9]+ s on 1 node' || fail "segcast plan prints no wall time"
"$SEGCAST" plan good.yaml --json | jq -e '.schema == "segcast-plan-1" and .draw_cpu_s_per_frame > 0 and
    .frames_measured > 0 and .prepare_wall_s >= 0 and .memory.prepared_bytes > 0' >/dev/null ||
    fail "segcast plan --json: $("$SEGCAST" plan good.yaml --json)"

refuse() { # refuse CODE PATTERN SED_SCRIPT: the job, changed by the sed script, is refused
    sed "$3" good.yaml >bad.yaml
    for command in render check; do
        expect "$1" "$2" "$SEGCAST" "$command" bad.yaml
        one_error
    done
    [ ! -e out ] || fail "a refused job wrote out/: $2"
}
refuse 65 'bad.yaml:2: unknown key "outptu"; did you mean "output"' 's/^output/outptu/'
refuse 65 'bad.yaml:4: tissue "aorat" matches no label.*did you mean "aorta"' 's/"\*"/"aorat"/'
refuse 65 'bad.yaml:10: tissue "coronary vein.*no label' 's/coronary arteries/coronary veins x/'
refuse 66 'none.nrrd: No such file' 's/^volume.*/volume: none.nrrd/'
refuse 66 'is a directory' 's|^volume.*|volume: /|'
refuse 64 'expected phantom or for example' 's/59x41x61/59x41/'
refuse 64 'expected 2 to 4096' 's/59x41x61/59x41x1/'
refuse 66 'no.ctbl: No such file' '1a labels: no.ctbl'
expect 64 'not within the animation' "$SEGCAST" render good.yaml --frames 0-7; one_error
expect 64 'not within the animation' "$SEGCAST" still good.yaml --frame 7; one_error
expect 64 'render.quality=best' "$SEGCAST" render good.yaml --set render.quality=best; one_error
: >file
expect 73 'file' "$SEGCAST" render good.yaml -o file/out; one_error
expect 73 'file' "$SEGCAST" render good.yaml -o file; one_error
if [ "$(id -u)" != 0 ]; then
    mkdir locked && chmod 555 locked
    expect 73 'Permission denied' "$SEGCAST" render good.yaml -o locked/out; one_error
fi

# A job in which nothing is visible, or whose clip planes remove everything, draws background.
expect 0 'no tissue is visible' "$SEGCAST" still good.yaml --set 'tissues.*.visible=false' -o w.png
expect 0 '' "$SEGCAST" still good.yaml --frame 6 --set animation.clip.0.at=200% \
    --set animation.clip.0.except=[] -o x.png
"$IMAGE_DIFFERENCE" w.png x.png || fail "clip planes that remove everything leave something visible"

# check reads the voxels once and keeps none; --fast reads the header only, and says so.
"$SEGCAST" convert phantom:59x41x61 -o whole.nrrd -q >/dev/null
head -c 3000 whole.nrrd >cut.nrrd
for file in whole cut; do
    sed "s/^volume.*/volume: $file.nrrd/" good.yaml >$file.yaml
    sed 's/"\*"/"7"/' $file.yaml >$file-number.yaml
    sed 's/"\*"/"aorat"/' $file.yaml >$file-name.yaml
done
"$SEGCAST" check whole.yaml | grep -q 'ok: .* 59 x 41 x 61 voxels' || fail "check of a file"
expect 65 'cut.nrrd: ends after' "$SEGCAST" check cut.yaml; one_error
expect 0 'it is not known whether the tissues' "$SEGCAST" check --fast cut.yaml
expect 0 'it is not known whether the tissues' "$SEGCAST" check --fast cut-number.yaml
expect 65 'tissue "aorat" matches no label.*did you mean "aorta"' "$SEGCAST" check --fast cut-name.yaml
sed /Segment/d cut.nrrd >bare.nrrd # no table
echo 'volume: bare.nrrd' >bare.yaml
for setting in 'overlays.names=[7]' 'animation.camera={focus: "7", aperture_mm: 2}'; do
    expect 0 'it is not known' "$SEGCAST" check --fast bare.yaml --set "$setting"
done
sed 's/"\*"/"77"/' whole.yaml >none.yaml
expect 65 'tissue "77" matches no label' "$SEGCAST" check none.yaml
