# SPDX-License-Identifier: BSD-3-Clause
# What has key frames is, in each frame, as if it were constant with the value that it has there: nothing is
# kept from another frame, or made once for all of them.
cat >job.yaml <<'EOF'
volume: phantom:37x26x38
output: {size: [96, 72], video: none}
tissues: {"*": {opacity: 0.6}}
animation:
  frames: 5
  camera: {orbit: {turns: 0, elevation: 10}}
EOF

frame() { # frame DIR FRAME: print the hash of a frame
    hashes "$1" | sed -n "s/^$2 //p"
}
more=() # options of both
# as_constant NAME KEY KEY_FRAMES {FRAME VALUE}...: with the key frames, the key is as if it were VALUE in FRAME
as_constant() {
    local name=$1 key=$2 n=0
    "$SEGCAST" render job.yaml -o "$name" -q "${more[@]}" --set "$key=$3" >/dev/null
    shift 3
    [ "$(hashes "$name" | cut -d' ' -f2 | sort -u | wc -l)" -gt 1 ] || fail "$name: $key does not change the picture"
    while [ $# -gt 0 ]; do
        n=$((n + 1))
        "$SEGCAST" render job.yaml -o "$name-$n" -q "${more[@]}" --frames "$1" --set "$key=$2" >/dev/null
        [ "$(frame "$name" "$1")" = "$(frame "$name-$n" "$1")" ] || fail "$name: frame $1 is not as with $key=$2"
        shift 2
    done
}

# Light: frame 2 is in the middle, where each strength is the mean of both.
strengths() { # strengths VALUE: a map with this value for each
    printf '{ambient: %s, key: %s, head: %s, occlusion: %s, edges: %s, depth_cue: %s}' "$1" "$1" "$1" "$1" "$1" "$1"
}
as_constant shadows light.shadows '{0%: false, 4f: 1}' 0 0 2 0.5 4 true
as_constant light light "$(strengths '{0%: 0, 4f: 0.5}')" \
    0 "$(strengths 0)" 2 "$(strengths 0.25)" 4 "$(strengths 0.5)"

# Background: what fades into it, lies beside it or is written on it follows. Halfway from white to black is level 137,
# whose tone is a half.
shades='{0%: white, 100%: black, ease: smooth}'
background() { # background NAME [OPTION]...
    local name=$1
    shift
    more=(--set light.depth_cue=0.4 --set 'overlays={time: top-left, legend: bottom-right}' "$@")
    as_constant "$name" render.background "$shades" 2 '[137, 137, 137]' 4 black
}
background plain
background views --set animation.slices=through
background divided --set 'compare={with: [phantom:36x26x38], divider: 50%}' --set overlays.legend=none
background apart --set 'animation.verbs=[{explode: aorta, by: 20 mm, during: [0%, 0%]}]'
background faded --set 'shots=[{fade_out: 100 ms}, {card: End, animation: {frames: 2}}]'

# Colours of tissues, and their squares in the legend. Two shots that differ in nothing else have one renderer.
colors() { # colors NAME [OPTION]...
    local name=$1
    shift
    more=(--set 'overlays={legend: bottom-right}' --set render.background=gray "$@")
    as_constant "$name" 'tissues."*".color' '{0f: white, 2f: navy, 4f: red}' 2 navy 4 red
}
colors painted
colors slices --set animation.slices=through
colors parts --set 'animation.verbs=[{explode: aorta, by: 20 mm, during: [0%, 0%]}]'
more=(--set render.background=gray --set 'shots=[{}, {tissues: {aorta: {color: red}}}]')
as_constant shots 'tissues."*".color' '{0%: white, 50%: navy, 100%: red}' 2 navy 7 navy

# Opacities are as if verbs changed the greatest of them. A tissue that is not there at a key frame is as one that has
# faded away.
as_verb() { # as_verb NAME KEY KEY_FRAMES VERB [OPTION]...: the key frames do what the verb does, in all frames
    "$SEGCAST" render job.yaml -o "$1" -q "${@:5}" --set "$2=$3" >/dev/null
    "$SEGCAST" render job.yaml -o "$1-verb" -q "${@:5}" --set "animation.verbs=[$4]" >/dev/null
    [ "$(hashes "$1" | cut -d' ' -f2 | sort -u | wc -l)" -gt 1 ] || fail "$1: $2 does not change the picture"
    hashes "$1" >keys.txt
    hashes "$1-verb" >verb.txt
    diff verb.txt keys.txt || fail "$1: $2=$3 is not as the verb $4"
}
opacities() { # opacities NAME [OPTION]...
    as_verb "$1" tissues.aorta.opacity '{0f: 1, 2f: {value: 0.5, ease: out}, 4f: 0.25}' \
        '{fade: aorta, to: 0.5, during: [0f, 2f], ease: out}, {fade: aorta, to: 25%, during: [2f, 4f]}' \
        --set tissues.aorta.opacity=1 "${@:2}"
}
opacities opaque --set overlays.legend=bottom-right
opacities voxels --set render.surface=voxel
opacities sliced --set animation.slices=through
opacities moved --set tissues.aorta.offset='[0, 10, 0]'
as_verb fade 'tissues."*".opacity' '{25%: 0.6, 75%: 0, ease: smooth}' \
    '{fade: "*", to: 0, during: [25%, 75%], ease: smooth}'
as_verb fade-local 'tissues."*".opacity' '{25%: 0.6, 75%: 0.3}' \
    '{fade: "*", to: 0.3, during: [25%, 75%]}' --set render.surface=voxel --set 'tissues."*".interior_opacity=auto'
as_verb comes 'tissues."*myocardium".visible' '{0%: false, 50%: true}' \
    '{appear: "*myocardium", during: [50%, 50%]}' --set overlays.legend=bottom-right
as_verb goes 'tissues.aorta.visible' '{50%: true, 75%: false}' \
    '{fade: aorta, to: 0, during: [75%, 75%]}' --set light.shadows=0.5
as_verb offset 'tissues.aorta.offset' '{25%: [0, 0, 0], 75%: [0, 0, 24], ease: smooth}' \
    '{explode: aorta, axis: superior, by: 24 mm, during: [25%, 75%], ease: smooth}' \
    --set 'animation.clip=[{normal: left, at: 30%}]'
as_verb placed 'tissues.aorta.offset' '[0, 12, 0]' \
    '{explode: aorta, axis: anterior, by: 12 mm, during: [0%, 0%]}' --set animation.camera.orbit.turns=0.1

# What planes spare, in steps.
more=()
as_constant spared animation.clip '[{normal: left, except: {1f: [aorta], 2f: [], 3f: ["*ventricle"]}}]' \
    0 '[{normal: left, except: [aorta]}]' 1 '[{normal: left, except: [aorta]}]' \
    2 '[{normal: left}]' 4 '[{normal: left, except: ["*ventricle"]}]'

# The share of an image on cut faces and slices.
more=(--set image.path=phantom:37x26x38 --set 'animation.clip=[{normal: posterior}]')
as_constant image-caps image.caps '{0%: 0, 100%: 1}' 0 0 2 0.5 4 1
more=(--set image.path=phantom:37x26x38)
as_constant image-backdrop image.backdrop '{0%: 0, 100%: 0.4}' 0 0 2 0.2 4 0.4
more=(--set image.path=phantom:37x26x38 --set 'animation.slices=[0, 0, 0]')
as_constant image-slices image.slices '{0%: 0, 100%: 1}' 0 0 2 0.5 4 1

# The window of an image, on cut faces, slices and behind the tissues. It opens from where nothing is seen behind them.
windows='{0%: [900, 100], 100%: [100, 300]}'
more=(--set image.path=phantom:37x26x38 --set image.caps=1 --set 'animation.clip=[{normal: posterior}]')
as_constant window-caps image.window "$windows" 0 '[900, 100]' 2 '[500, 200]' 4 '[100, 300]'
more=(--set image.path=phantom:37x26x38 --set image.backdrop=0.4)
as_constant window-backdrop image.window "$windows" 0 '[900, 100]' 2 '[500, 200]' 4 '[100, 300]'
more=(--set image.path=phantom:37x26x38 --set 'animation.slices=[0, 0, 0]')
as_constant window-slices image.window "$windows" 0 '[900, 100]' 4 '[100, 300]'

# Planes, and the point of the slices.
more=()
as_constant place animation.clip '[{normal: left, at: {0%: 20%, 50%: 5 mm, 100%: 70%}}]' \
    0 '[{normal: left, at: 20%}]' 2 '[{normal: left, at: 5 mm}]' 4 '[{normal: left, at: 70%}]'
as_constant normal animation.clip '[{normal: {2f: left, 4f: head, ease: smooth}}]' \
    0 '[{normal: left}]' 4 '[{normal: head}]'
as_constant point animation.slices '{0%: [0, 0, 0], 100%: [10, -5, 20]}' 2 '[5, -2.5, 10]'

# A camera without an orbit.
more=()
as_constant fixed animation.camera.fixed '{position_mm: {0%: [0, 400, 0], 100%: [100, 380, 0]},
    target_mm: {0%: [0, 0, 0], 100%: [0, 0, 10]}, up: {0%: head, 4f: left}}' \
    2 '{position_mm: [50, 390, 0], target_mm: [0, 0, 5], up: [-1, 0, 1]}' 4 '{position_mm: [100, 380, 0], target_mm: [0, 0, 10], up: left}'

# All at once: a still is the frame of the film, whatever was drawn before it.
keyframes=("$SOURCE/jobs/keyframes.yaml" --set volume=phantom:37x26x38 --set 'output.size=[96, 54]' --set animation.frames=9)
"$SEGCAST" render "${keyframes[@]}" -o all -q --set output.video=none --set output.frames=png >/dev/null
[ "$(hashes all | cut -d' ' -f2 | sort -u | wc -l)" = 9 ] || fail 'frames repeat'
for k in 7 3; do
    "$SEGCAST" still "${keyframes[@]}" --frame $k -o still.png -q --overwrite >/dev/null
    "$IMAGE_DIFFERENCE" still.png all/frames/00000$k.png || fail "still --frame $k is not frame $k of the film"
done

# check lists them all by their frames, in each shot of a film; of very many the first hundred.
cat >list.yaml <<'EOF'
volume: phantom:29x21x31
tissues:
  left atrium: {opacity: {0.5s: 1, 80%: 0.25, ease: smooth}, visible: {45f: true}}
animation:
  frames: 61
  clip: [{normal: left, except: {0:01: [aorta, "*ventricle"], 2s: []}}]
EOF
lists() { # lists FILE [OPTION]...: check lists what stands in FILE
    "$SEGCAST" check list.yaml "${@:2}" 2>/dev/null | sed -n '/^key frames/,$ {/^ /s/  */ /gp}' >listed.txt
    diff "$1" listed.txt || fail "check ${*:2} lists other key frames"
}
cat >own.txt <<'EOF'
 tissues."left atrium".opacity 15 1
 48 0.25 smooth
 tissues."left atrium".visible 45 true
 animation.clip.0.except 30 [aorta, *ventricle]
 60 []
EOF
lists own.txt
(echo ' shot 1' && cat own.txt && echo ' shot 2 (Long one)' && sed 's/^ 48 / 95.2 /' own.txt) >shots.txt
lists shots.txt --set 'shots=[{}, {name: "Long\n\none", animation: {frames: 4s}}, {card: End, animation: {frames: 30}}]'
# A shot's own key frames of a tissue stand for those of its film; the others of the film stay.
cat >mixed.txt <<'EOF'
 shot 1
 tissues."left atrium".opacity 6 0.5
 tissues."left atrium".visible 45 true
 animation.clip.0.except 30 [aorta, *ventricle]
 60 []
EOF
lists mixed.txt --set 'shots=[{tissues: {"left atrium": {color: red, opacity: {10%: 0.5}}}}]'
"$SEGCAST" check list.yaml --set 'shots=[{tissues: {"left atrium": {color: red}}}]' 2>&1 >/dev/null | grep error && fail 'check tells an error that a job has not'
many=$(seq -s, 0 59 | sed 's/[0-9]*/&f: 1/g')
"$SEGCAST" check list.yaml --set "light.key={$many}" --set "light.head={$many}" 2>/dev/null >many.txt
[ "$(grep -c '^  ' many.txt)" = 101 ] || fail 'not a hundred key frames are listed'
grep -q '^  and 25 more$' many.txt || fail 'it is not said how many key frames there are'

# Key frames of a film outside of its shots, in seconds and frames, are counted by each shot for itself, may lie behind the
# sixth second and the end of a card, and stay what they are in the job as resolved, which makes the same pictures.
printf 'name,a,b\naorta,1,2\nleft ventricle,3,1\n' >columns.csv
cat >film.yaml <<'EOF'
volume: phantom:29x21x31
output: {directory: whole, size: [96, 72], fps: 10, video: none, frames: png}
color_by: {values: columns.csv, column: {0s: a, 0:01: b}}
overlays: {color_bar: bottom-left}
image: {path: phantom, caps: {0s: 0.5, 0.6s: 0.2}}
light: {key: {0%: 0.5, 3f: 1}}
tissues: {"*": {opacity: 1}, aorta: {color: {0s: red, 0.5s: {value: blue, ease: smooth}, 700ms: lime}}}
shots:
  - {card: The heart, image: {caps: 0.3}, animation: {frames: 2}}
  - {animation: {frames: 12, camera: {orbit: {turns: 0}}}}
  - {animation: {frames: 23, camera: {orbit: {turns: 0}}}, tissues: {"*": {coat: 0.5}}}
EOF
expect 0 '' "$SEGCAST" render film.yaml -q
grep -q '0.5s: {value: \[0, 0, 255\], ease: smooth}' whole/job.yaml || fail 'times of the film are not kept in the job as resolved'
expect 0 '' "$SEGCAST" render whole/job.yaml -o resolved -q
[ "$(hashes whole)" = "$(hashes resolved)" ] || fail 'a film with key frames outside of its shots makes other pictures when resolved'
expect 0 'nothing to do' "$SEGCAST" render whole/job.yaml -o whole --resume
expect 0 '' "$SEGCAST" check film.yaml --set 'shots=[{animation: {frames: 9s}}]' \
    --set 'tissues.aorta.color={0s: red, 8s: blue}'
expect 64 'color: 8s is behind the end of the animation, which has 70 frames' "$SEGCAST" check film.yaml --set 'shots=[{animation: {frames: 7s}}]' \
    --set 'tissues.aorta.color={0s: red, 8s: blue}'
one_error
expect 64 'the key frame at 5f does not come after that at 0.6s' "$SEGCAST" check film.yaml \
    --set 'tissues.aorta.color={0.6s: red, 5f: blue}'
one_error
