# SPDX-License-Identifier: BSD-3-Clause
# The verb fly: the film is the same for any number of ranks and threads, from a volume, a prepared file and with the tissue
# hidden; what has no way is refused, by check as by render. property.films draws frames alone and the resolved job.
small_job job.yaml
volume=$(sed -n 's/^volume: *//p' job.yaml)
fly='animation.verbs=[{fly: aorta, through: [[9, 4, 27], [-24, -43, 5]], during: [20%, 80%]}]'
OMP_NUM_THREADS=1 "$SEGCAST" render job.yaml -o one -q --set "$fly" >/dev/null
[ "$(hashes one | cut -d' ' -f2 | sort -u | wc -l)" -ge 5 ] || { hashes one; fail "the camera does not fly"; }
OMP_NUM_THREADS=2 mpi 2 "$SEGCAST" render job.yaml -o three -q --set "$fly" >/dev/null
[ "$(hashes one)" = "$(hashes three)" ] || fail "the pictures depend on ranks and threads"

# The way does not depend on what is shown: with the aorta hidden, it is found in the file.
"$SEGCAST" check job.yaml --set "$fly" 2>&1 >/dev/null | grep -o 'the centre line.*' >shown.txt || fail "check does not tell of the line"
for more in 'tissues={aorta: {visible: false}}' 'render.surface=voxel'; do
    rm -rf hidden
    "$SEGCAST" render job.yaml -o hidden --frames 4 --set "$fly" --set "$more" 2>&1 >/dev/null | grep -o 'the centre line.*' |
        diff shown.txt - >&2 || fail "the line is another with $more"
done
"$SEGCAST" convert job.yaml -o heart.segc -q >/dev/null
"$SEGCAST" check job.yaml --set "$fly" --set volume=heart.segc 2>&1 >/dev/null | grep -o 'the centre line.*' |
    diff shown.txt - >&2 || fail "the line is another in a prepared file of $volume"
# A prepared file that holds the tissue, which the job hides, makes the film of the volume.
"$SEGCAST" render job.yaml -o without -q --set "$fly" --set 'tissues={aorta: {visible: false}}' >/dev/null
"$SEGCAST" render job.yaml -o without2 -q --set "$fly" --set 'tissues={aorta: {visible: false}}' --set volume=heart.segc >/dev/null 2>&1
[ "$(hashes without)" = "$(hashes without2)" ] || fail "a prepared file makes another film where the tissue is hidden"

# A prepared file that lacks the tissue is refused; one with other slices than the volume's own makes the same film.
"$SEGCAST" convert job.yaml -o lacking.segc -q --set 'tissues={aorta: {visible: false}}' >/dev/null
expect 65 'lacking.segc: was prepared while "aorta" \(label 6\) was hidden' "$SEGCAST" check job.yaml --set "$fly" --set volume=lacking.segc \
    --set 'tissues={aorta: {visible: false}}'
expect 65 'lacking.segc: was prepared while "aorta" \(label 6\) was hidden' "$SEGCAST" convert lacking.segc --tissue aorta -o -; one_error
"$SEGCAST" convert phantom:59x41x20 -o thick.nrrd -q >/dev/null
"$SEGCAST" render job.yaml -o thick -q --frames 2-4 --set "$fly" --set volume=thick.nrrd >/dev/null
"$SEGCAST" convert job.yaml -o thick.segc -q --set volume=thick.nrrd >/dev/null
"$SEGCAST" render job.yaml -o prepared -q --frames 2-4 --set "$fly" --set volume=thick.segc >/dev/null
[ "$(hashes thick)" = "$(hashes prepared)" ] || fail "a prepared file of thick slices makes another film"
"$SEGCAST" check job.yaml --fast --set "$fly" -q >/dev/null

# A flight ends two radii before the end of the line where the wall is ahead, be that a point or not.
"$SEGCAST" convert "$volume" --tissue aorta -o line.csv -q >/dev/null
read -r begin middle end <<<"$(awk -F, 'NR > 1 && $1 + 0 == $1 { p[++n] = $1 "," $2 "," $3 } END { print p[1], p[int((n + 1) / 2)], p[n] }' line.csv)"
last() { # last FILE FLY
    "$SEGCAST" still job.yaml -q -o "$1" --time 100% --set animation.frames=400 --set "animation.verbs=[{fly: aorta$2}]" >/dev/null
}
last ends.png ''
last end.png ", through: [[$begin], [$end]]"
last middle.png ", through: [[$begin], [$middle]]"
"$IMAGE_DIFFERENCE" ends.png end.png 255 8 || fail "a flight to a point at the end does not end before the wall"
"$IMAGE_DIFFERENCE" ends.png middle.png 255 8 >/dev/null && fail "points do not say where the flight ends"

# Points alone.
"$SEGCAST" render job.yaml -o points -q --set 'animation.verbs=[{fly: [[13, 7, 42], [8, 2, 54], [-6, -12, 60]], fov: 60}]' >/dev/null
[ "$(hashes points | cut -d' ' -f2 | sort -u | wc -l)" = 7 ] || fail "the camera does not fly through points"

# From middle to middle of tissues that touch: the way goes on when the next tissue is visited.
middles='animation.verbs=[{fly: [left atrium, left ventricle, aorta], through: middles}]'
"$SEGCAST" render job.yaml -o middles -q --set "$middles" >/dev/null
"$SEGCAST" render job.yaml -o middle -q --frames 2 --set "$middles" >/dev/null
[ "$(hashes middle)" = "$(hashes middles | grep '^2 ')" ] || fail "a frame alone differs from that of the flight from middle to middle"

# Mistakes: one message with file and line.
mistake() { # mistake TEXT VERB
    printf 'volume: %s\noutput: {video: none}\nanimation:\n  frames: 3\n  verbs:\n    - {fly: %s}\n' "$volume" "$2" >bad.yaml
    for command in check render; do
        expect 65 "bad.yaml:6: $1" "$SEGCAST" $command bad.yaml; one_error
    done
}
mistake 'fly: it has no way; expected tissues' '[[1, 2, 3]]'
mistake 'points 1 and 2 are the same' '[[1, 2, 3], [1, 2, 3]]'
mistake 'point 2 .60.0, 0.0, 0.0. lies outside of "aorta"; the nearest place in it is' 'aorta, through: [[13, 7, 42], [60, 0, 0]]'
mistake 'there is no way within "aorta", "inferior vena cava" from point 1' '[aorta, inferior vena cava], through: [[13, 7, 42], [35, -17, -42]]'
mistake 'there is no way within "left ventricle", "right atrium" from point 1' '[left ventricle, right atrium], through: middles'
mistake 'fly: from middle to middle there have to be two tissues' 'aorta, through: middles'
