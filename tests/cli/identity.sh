# SPDX-License-Identifier: BSD-3-Clause
# Everything that determines the pictures belongs to the identity of a job, also what follows from the names
# in a label table while the job file stays the same.
"$SEGCAST" convert phantom:59x41x61 -o p.nrrd -q >/dev/null
table() { # table NAME_OF_6 NAME_OF_8
    printf '6 %s 200 40 40 255\n8 %s 200 40 40 255\n' "$1" "$2"
}
job() { # job EXTRA_LINES: with a label table of two tissues
    cat >job.yaml <<YAML
volume: p.nrrd
labels: names.ctbl
labels_format: slicer
output: {directory: out, size: [64, 48], video: none, frames: png}
animation: {frames: 3, camera: {orbit: {turns: 1}}, $2}
tissues: {"*": {opacity: 1}, $1}
YAML
}
changed_by_names() { # changed_by_names TISSUES ANIMATION
    job "$1" "$2"
    rm -rf out
    table aorta ventricle >names.ctbl
    expect 0 '' "$SEGCAST" render job.yaml -q
    expect 0 'nothing to do' "$SEGCAST" render job.yaml --resume
    table ventricle aorta >names.ctbl
    expect 73 'other job|another job' "$SEGCAST" render job.yaml --resume -q
    one_error
}
changed_by_names 'aorta: {specular: 2}' 'clip: []'
changed_by_names 'aorta: {coat: 0.2}' 'clip: []'
changed_by_names 'aorta: {roughness: 0.3}' 'clip: []'
changed_by_names 'aorta: {opacity: 1}' 'clip: [{normal: posterior, at: 50%, except: [aorta]}]'
changed_by_names 'aorta: {visible: true}' 'verbs: [{fade: aorta, to: 30%}]'
changed_by_names 'aorta: {visible: true}' 'verbs: [{frame: aorta}]'

# How a job is run does not belong to its identity.
table aorta ventricle >names.ctbl
job 'aorta: {specular: 2}' 'clip: []'
rm -rf out
expect 0 '' "$SEGCAST" render job.yaml -q
expect 0 'nothing to do' "$SEGCAST" render job.yaml --resume --set farm.tile=16 --set render.skip=none --set render.cpu=c

# A tissue's name may hold what YAML uses as marks: the job as resolved is read by join and verify.
table 'a"b\c' ventricle >names.ctbl
job "'a\"b\\c': {opacity: 0.5}" "clip: [{normal: left, at: 50%, except: ['a\"b\\c']}]"
rm -rf out
expect 0 '' "$SEGCAST" render job.yaml -q
expect 0 '' "$SEGCAST" verify out
expect 0 '' "$SEGCAST" render out/job.yaml -o again -q
[ "$(hashes out)" = "$(hashes again)" ] || fail "the job as resolved makes other pictures"

# The resolved job is the same job to the last bit, also where its numbers have been computed: unit vectors, a plane
# through a point, thirds.
cat >oblique.yaml <<'YAML'
volume: phantom:24x18x24
output: {size: [48, 32], fps: 7, video: none}
tissues: {aorta: {opacity: 0.3333333333333333}}
animation:
  frames: 4
  camera: {orbit: {axis: [0.6, -0.5, 0.4], turns: 0.784, target_mm: [1.00000000000003, 2, 0.1]}}
  clip: [{normal: [1, 2, 3], at: [1, 2, -4]}]
  slices: 33.3333333333333%
  verbs:
    - {frame: interventricular septum, during: [33.3333333333333%, 240 ms]}
    - {explode: aorta, axis: [1, 1, 1]}
YAML
"$SEGCAST" render oblique.yaml -o oblique -q >/dev/null
cp oblique/job.yaml resolved.yaml
"$SEGCAST" render resolved.yaml -o resolved -q >/dev/null
[ "$(job_hash oblique)" = "$(job_hash resolved)" ] || fail "the resolved job is another one"
cmp oblique/job.yaml resolved/job.yaml || fail "the resolved job is written in another way when it is resolved again"
