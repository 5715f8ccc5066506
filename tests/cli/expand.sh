# SPDX-License-Identifier: BSD-3-Clause
# check --expand prints verbs as key frames, and all frames are the same bits. Verbs that key frames cannot say, stay.
small=(--set volume=phantom:64x48x65 --set output.size=96x72 --set animation.frames=23 --set output.video=none)
expand() { # expand NAME OPTIONS...: expand the job of a verb to NAME.yaml, and compare the frames of both
    local name=$1 job=$SOURCE/jobs/verbs/$1.yaml
    shift
    rm -rf verbs tracks
    "$SEGCAST" check "$job" -q --expand "${small[@]}" "$@" >"$name.yaml" || fail "check $job --expand: exit code $?"
    "$SEGCAST" render "$job" -q -o verbs "${small[@]}" "$@" >/dev/null
    "$SEGCAST" render "$name.yaml" -q -o tracks >/dev/null
    [ "$(hashes verbs)" = "$(hashes tracks)" ] || fail "$name.yaml: frames are others than with verbs"
}
for verb in orbit fade appear pulse; do
    expand $verb
    grep -q "verbs: \[\]" $verb.yaml || fail "$verb.yaml: verbs are left: $(grep -A3 verbs: $verb.yaml)"
done
expand orbit --set animation.camera.orbit.turns=0.3 --set animation.camera.orbit.angle=12
grep -q -- "- {orbit: " orbit.yaml || fail "orbit.yaml: a sum of four angles would be rounded otherwise"
expand pulse --set animation.verbs.0.ease=in # the way back is none of the eases
expand zoom
for verb in pulse zoom; do
    grep -q -- "- {$verb: " $verb.yaml || fail "$verb.yaml: the verb is gone"
done
