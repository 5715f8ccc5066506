# SPDX-License-Identifier: BSD-3-Clause
# Which frame still draws, and what its sheet shows.
small_job job.yaml
mv job.yaml short.yaml
sed 's/frames: 7/frames: 61/' short.yaml >job.yaml # 61 frames at 30 per second: 2.0333 s

still() { # still FILE [OPTION]...: draw with as many rays as a picture on a sheet has
    local file=$1
    shift
    "$SEGCAST" still job.yaml -q --overwrite -o "$file" "$@" >/dev/null
}
same() { # same OPTION VALUE FRAME: the option chooses this frame
    sampled || return 0
    still chosen.png "$1" "$2"
    still frame.png --frame "$3"
    "$IMAGE_DIFFERENCE" chosen.png frame.png || fail "$1 $2 is not frame $3"
}
same --time 0 0
same --time 1 30
same --time 0:01.03 31 # as the sheet writes the time of frame 31, 1.0333 s
same --time 0:00:02 60
same --time 1s 30
same --time "500 ms" 15
same --time 0s 0
same --time 2.0333 60 # the last frame, which is shown till then
same --time 0% 0
same --time 50% 30
same --time 100% 60
still frame.png --frame 60
still none.png
"$IMAGE_DIFFERENCE" none.png frame.png >/dev/null && fail 'two frames look the same: nothing is tested'
still frame.png --frame 0
"$IMAGE_DIFFERENCE" none.png frame.png || fail 'without an option it is not frame 0'

# A picture on the sheet has the pixels of a still of the same size. One of 96 x 72 pixels stands in the
# middle of a cell of 160 pixels, behind a gap of 12; below it are 24 pixels for its caption.
"$SEGCAST" still job.yaml --sheet 4 -q -o sheet.png >/dev/null
at=0
for frame in 0 20 40 60; do
    still frame.png --frame $frame
    "$IMAGE_DIFFERENCE" sheet.png frame.png 0 0 $((44 + at % 2 * 172)) $((12 + at / 2 * 108)) ||
        fail "frame $frame is not on the sheet"
    at=$((at + 1))
done
"$SEGCAST" still job.yaml --frames 0,20,40,60 -q -o listed.png >/dev/null
cmp sheet.png listed.png || fail '--frames and --count give other sheets of the same frames'

# No more pictures than frames, and each once.
"$SEGCAST" still short.yaml --sheet 12 -q -o few.png >/dev/null
"$SEGCAST" still short.yaml --frames 0-6 -q -o all.png >/dev/null
cmp few.png all.png || fail 'a sheet of a film of seven frames does not show each once'
# Large pictures become small ones of the same shape, of about 320 x 180 pixels.
expect 0 '12 of 61 frames, 180 x 320 pixels' "$SEGCAST" still job.yaml --sheet 12 --set output.size=vertical -o tall.png
expect 0 '12 of 61 frames, 7680 x 16 pixels' "$SEGCAST" still job.yaml --sheet 12 --set output.size=16384x16 -o flat.png
expect 0 '1 of 61 frames' "$SEGCAST" still job.yaml --sheet 1 --set render.quality=draft -o one.png
expect 0 '61 of 61 frames' "$SEGCAST" still job.yaml --sheet 1000 -o many.png
expect 0 '' "$SEGCAST" still job.yaml --sheet 12 --set animation.slices=through -o views.png

# A film of shots names the font of their text once, and again where a shot has another.
cat >shots.yaml <<'EOF'
volume: phantom:32x24x32
output: {size: [96, 72]}
animation: {frames: 2}
shots:
  - card: One
  - card: Two
  - overlays: {caption: Three}
EOF
expect 0 '' "$SEGCAST" check shots.yaml
[ "$(grep -c 'text is drawn in the font' stderr.txt)" = 1 ] || fail "a film of three shots: $(cat stderr.txt)"
expect 0 '' "$SEGCAST" check shots.yaml --set 'shots.2.overlays.font=DejaVu Sans Mono'
[ "$(grep -c 'text is drawn in the font' stderr.txt)" = 2 ] || fail "a film of two fonts: $(cat stderr.txt)"

# Of a volume, without a job, still draws what orbit does; a directory that a job has made is told from one of masks.
"$SEGCAST" convert phantom:59x41x61 -o heart.nrrd -q >/dev/null
printf 'volume: heart.nrrd\nlook: studio\noutput: {size: [96, 72]}\nanimation: {camera: {orbit: {elevation: 30}}}\n' >volume.yaml
"$SEGCAST" still volume.yaml --time 25% -o job.png -q >/dev/null
expect 0 '' "$SEGCAST" still heart.nrrd --size 96x72 --view 0,30 --time 25% -o volume.png
"$IMAGE_DIFFERENCE" job.png volume.png || fail 'the picture of a volume is not that of a job'
# If no frame is asked for, it is framed for itself, as views are, and not for the whole turn.
"$SEGCAST" still volume.yaml --view 0,30 -o job.png --overwrite -q >/dev/null
expect 0 '' "$SEGCAST" still heart.nrrd --size 96x72 --view 0,30 -o alone.png
"$IMAGE_DIFFERENCE" job.png alone.png || fail 'the only picture of a volume is not framed for itself'
expect 0 '' "$SEGCAST" still heart.nrrd --size 96x72 --view 0,30 --frame 0 -o first.png
"$SEGCAST" still volume.yaml -o job.png --overwrite -q >/dev/null
"$IMAGE_DIFFERENCE" job.png first.png || fail 'frame 0 of a volume is not that of its turn'
"$IMAGE_DIFFERENCE" alone.png first.png >/dev/null 2>&1 && fail 'a picture alone and one of a turn are framed alike'
# The camera stands where a word says, whatever people call the place; a turn begins there.
for view in 'left 90 0' 'dorsal 180 0' 'cranial 0 90' '-y 180 0' 'x -90 0' 'Caudal 0 -90' '-30,12.5 -30 12.5'; do
    read -r word start elevation <<<"$view"
    "$SEGCAST" still heart.nrrd --size 96x72 --view "$word" -o word.png --overwrite -q >/dev/null
    "$SEGCAST" still volume.yaml --view "$start,$elevation" -o job.png --overwrite -q >/dev/null
    "$IMAGE_DIFFERENCE" job.png word.png || fail "the picture from $word is another"
done
# The sheet of views holds what each of their options draws, of a volume as of a job, whatever its camera is.
"$SEGCAST" still heart.nrrd --size 96x72 --sheet views -o views.png --overwrite -q >/dev/null
cat >still.yaml <<'EOF'
volume: heart.nrrd
look: studio
output: {size: [96, 72]}
animation: {camera: {fixed: {position_mm: [0, 400, 0], target_mm: [0, 0, 0]}}}
shots: [{animation: {frames: 2}}]
EOF
"$SEGCAST" still still.yaml --sheet views -o job.png --overwrite -q >/dev/null
"$IMAGE_DIFFERENCE" job.png views.png || fail 'the views of a job are not those of its volume'
at=0
for view in anterior posterior left right superior inferior 45,20 135,20 -135,20 -45,20; do
    "$SEGCAST" still heart.nrrd --size 96x72 --view "$view" -o word.png --overwrite -q >/dev/null
    "$IMAGE_DIFFERENCE" views.png word.png 0 0 $((44 + at % 5 * 172)) $((12 + at / 5 * 108)) || fail "$view is not on the sheet of views"
    at=$((at + 1))
done
# That of looks, likewise; the job's own keys go before its look, in each shot, and what is resolved says all of it.
"$SEGCAST" still heart.nrrd --size 96x72 --sheet looks -o looks.png --overwrite -q >/dev/null
at=0
for look in plain studio cinematic atlas xray; do
    "$SEGCAST" still heart.nrrd --size 96x72 --look "$look" -o word.png --overwrite -q >/dev/null
    "$IMAGE_DIFFERENCE" looks.png word.png 0 0 $((44 + at % 3 * 172)) $((12 + at / 3 * 108)) || fail "$look is not on the sheet of looks"
    at=$((at + 1))
done
printf 'volume: heart.nrrd\noutput: {size: [96, 72]}\nlook: xray\nrender: {background: "#203040"}\ntissues: {"*": {opacity: 1}}\n' >look.yaml
printf 'volume: heart.nrrd\noutput: {size: [96, 72]}\nlight: {method: flat, edges: 1}\nrender: {background: "#203040"}\ntissues: {"*": {opacity: 1}}\n' >bare.yaml
printf 'volume: heart.nrrd\noutput: {size: [96, 72]}\nlook: atlas\nshots: [{look: xray, render: {background: "#203040"}, tissues: {"*": {opacity: 1}}}]\n' >shot.yaml
for job in look bare shot; do "$SEGCAST" still $job.yaml -o $job.png --overwrite -q >/dev/null; done
"$IMAGE_DIFFERENCE" bare.png look.png || fail "a look goes before the keys of a job"
"$IMAGE_DIFFERENCE" bare.png shot.png || fail "a shot has something of the look of the film beside its own"
expect 64 'unknown look "rainbow"; expected one of: plain, studio, cinematic, atlas, xray' "$SEGCAST" still heart.nrrd --look rainbow -o word.png
# Names are not needed for a look.
{ printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 6 6\nencoding: raw\nspacings: 1 1 1\n\n' && head -c 216 /dev/zero | tr '\0' '\3'; } >nameless.nrrd
"$SEGCAST" still nameless.nrrd --size 96x72 --sheet looks -o nameless.png -q >/dev/null || fail 'tissues without names have no looks'
# A tissue of a volume fills the picture as the verb frame lets it, and what lies before it does not hide it.
"$SEGCAST" still volume.yaml --set animation.camera.orbit.turns=0 --view 0,30 --set 'animation.verbs=[{frame: aorta, during: [0%, 0%]}]' \
    --set tissues.*.opacity=0.04 --set tissues.aorta.opacity=1 -o job.png --overwrite -q >/dev/null
expect 0 '' "$SEGCAST" still heart.nrrd --size 96x72 --view 0,30 --tissue aorta -o framed.png
"$IMAGE_DIFFERENCE" job.png framed.png || fail '--tissue does not frame the tissue'
"$IMAGE_DIFFERENCE" alone.png framed.png >/dev/null 2>&1 && fail '--tissue frames all tissues'
expect 0 '' "$SEGCAST" still heart.nrrd --size 96x72 --view 0,30 --tissue 'left v*' --set tissues.aorta.visible=false -o framed.png --overwrite
expect 0 '' "$SEGCAST" still heart.nrrd --size 96x72 --tissue '*' -o framed.png --overwrite
expect 64 'view is .superiour., expected anterior, .*did you mean .superior.' "$SEGCAST" still heart.nrrd --view superiour -o no.png; one_error
expect 64 'view 0,400: .*from -360 to 360' "$SEGCAST" still heart.nrrd --view 0,400 -o no.png; one_error
"$SEGCAST" render short.yaml -o made -q >/dev/null
expect 64 'is the directory that a job has made: .segcast still made/job.yaml. takes that job' "$SEGCAST" still made; one_error
expect 64 'is the directory that a job has made' "$SEGCAST" convert made -o made.segc; one_error

# A body twice as high as wide is better shown in a picture that is higher than wide: said by all who draw it, where it is so.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 10 8 20\nspace: right-anterior-superior\n'
    printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n'
    head -c 1600 /dev/zero | tr '\0' '\1'
} >tall.nrrd
printf 'volume: tall.nrrd\noutput: {size: [64, 48]}\nanimation: {frames: 2}\n' >tall.yaml
note='what is visible is 2.1 times as high as wide: with --size vertical'
expect 0 "$note" "$SEGCAST" still tall.nrrd --size 64x48 -o tall.png --overwrite
expect 0 "$note" "$SEGCAST" orbit tall.nrrd --size 64x48 --frames 2 -o tall.mp4
expect 0 "$note" "$SEGCAST" check tall.yaml
for more in '--size 48x64' '--view top' '--sheet slices' '--sheet views'; do
    # shellcheck disable=SC2086  # options with their values
    "$SEGCAST" still tall.nrrd --size 64x48 $more -o tall.png --overwrite >/dev/null 2>stderr.txt
    grep -q 'times as high as wide' stderr.txt && fail "$more: $(cat stderr.txt)"
done

# A line one voxel wide is hardly seen where a pixel is wider, which is said; where it fills the picture, it is not.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 40 40 40\nspace: right-anterior-superior\n'
    printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n'
    awk 'BEGIN { for (i = 0; i < 64000; i++) { y = int(i / 40) % 40; printf i % 40 == 20 && y == 30 ? 2 : y < 20 } }' |
        tr 012 '\0\1\2'
} >thin.nrrd
expect 0 '1 tissue is thinner than a pixel, which is 2.* mm wide, and hardly seen, such as "" .label 2.: ' \
    "$SEGCAST" still thin.nrrd --size 32x24 -o thin.png
"$SEGCAST" still thin.nrrd --size 640x480 -o thin.png --overwrite >/dev/null 2>stderr.txt
grep -q 'thinner than a pixel' stderr.txt && fail "a line that is wider than a pixel: $(cat stderr.txt)"

# The phantom by its name is a volume, too.
"$SEGCAST" still phantom:24x18x24 --size 64x48 -q -o phantom.png >/dev/null || fail 'no picture of the phantom by its name'
