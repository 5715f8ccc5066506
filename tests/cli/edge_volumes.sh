# SPDX-License-Identifier: BSD-3-Clause
# Volumes of one voxel's thickness, of background only, and the like: segcast draws them, warns where
# that helps, and exits with 0.
nrrd() { # nrrd NAME SIZES COUNT BYTE: write NAME.nrrd, whose COUNT voxels all hold BYTE
    {
        printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: %s\nspace: right-anterior-superior\n' "$2"
        printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n'
        head -c "$3" /dev/zero | tr '\0' "$4"
    } >"$1.nrrd"
}
nrrd flat '40 30 1' 1200 '\1'
nrrd rod '1 50 1' 50 '\1'
nrrd point '1 1 1' 1 '\1'
nrrd nothing '20 20 20' 8000 '\0'

for name in flat rod point; do
    for surface in smooth voxel; do
        for smooth in 0 1.25; do
            printf 'volume: %s.nrrd\noutput: {size: [64, 48]}\nrender: {surface: %s, smooth: %s}\n' \
                "$name" "$surface" "$smooth" >job.yaml
            printf 'animation: {camera: {orbit: {angle: 30, elevation: 40}}}\n' >>job.yaml
            "$SEGCAST" still job.yaml -o "$name.png" --overwrite >/dev/null 2>log.txt || fail "$name $surface: $(cat log.txt)"
            "$SEGCAST" still job.yaml -o plain.png --overwrite --set render.skip=none -q >/dev/null
            "$IMAGE_DIFFERENCE" "$name.png" plain.png 0 0 || fail "$name $surface: skip methods give different pictures"
            "$SEGCAST" still job.yaml -o blank.png --overwrite -q --set 'tissues."*".opacity=0' >/dev/null
            "$IMAGE_DIFFERENCE" "$name.png" blank.png 0 0 2>/dev/null >&2 && fail "$name $surface: nothing is drawn"
        done
    done
    "$SEGCAST" still "$name.nrrd" --sheet slices -o views.png --overwrite --size 200x160 -q >/dev/null || fail "views of $name"
done

"$SEGCAST" still nothing.nrrd --sheet slices -o nothing.png --size 64x64 >/dev/null 2>log.txt || fail "views of a volume of background only: $(cat log.txt)"
grep -q 'holds background only' log.txt || fail "no warning that a volume holds background only: $(cat log.txt)"

printf 'volume: flat.nrrd\noutput: {size: [64, 48], video: none}\nanimation:\n  frames: 3\n  clip: [{normal: superior, at: 50 mm}]\n' >gone.yaml
"$SEGCAST" render gone.yaml -o gone >/dev/null 2>log.txt || fail "clip planes that remove everything: $(cat log.txt)"
grep -q 'removes everything in 3 frames' log.txt || fail "no warning that clip planes remove everything: $(cat log.txt)"
grep -q 'clip plane 1, at 50.0 mm along its normal (0.000, 0.000, 1.000), removes everything: what is shown lies from -0.5 to 0.5 mm' log.txt ||
    fail "not said where the plane should be: $(cat log.txt)"
"$SEGCAST" check gone.yaml >/dev/null 2>check.txt
diff <(grep -v ': ok' check.txt | grep warning) <(grep warning log.txt) || fail "check and render warn differently"
grep -c '"frame"' gone/manifest.jsonl | grep -qx 3 || fail "the manifest does not name 3 frames"

printf 'volume: flat.nrrd\ntissues: {"*": {interior_opacity: 0.1}}\n' >inside.yaml
"$SEGCAST" still inside.yaml -o x.png --set output.size=[32,32] >/dev/null 2>log.txt
grep -q 'interior_opacity is not used' log.txt || fail "no warning that interior_opacity is not used: $(cat log.txt)"

# Slices go through the point that is asked for, and info measures hidden tissues, too.
"$SEGCAST" convert phantom:59x41x61 -o heart.nrrd -q >/dev/null
"$SEGCAST" still heart.nrrd --sheet slices -o middle.png --size 200x160 -q >/dev/null
"$SEGCAST" still heart.nrrd --sheet slices -o aside.png --size 200x160 --point 10,-20,30 -q >/dev/null
"$SEGCAST" still heart.nrrd --sheet slices -o other.png --size 200x160 --point -10,20,0 -q >/dev/null
for picture in middle other; do
    "$IMAGE_DIFFERENCE" $picture.png aside.png 0 0 2>/dev/null >&2 && fail "--point does not change the picture"
done
printf '8 10 20 30 1 0 0 "left ventricle"\n' >hidden.txt
"$SEGCAST" info heart.nrrd --labels hidden.txt --labels-format itksnap --json 2>/dev/null |
    jq -e '.labels[] | select(.value == 8) | (.visible | not) and .voxels > 0 and .thickness_mm > 0
        and .surface_mm2 > 0' >/dev/null || fail "info does not measure a hidden tissue"

"$SEGCAST" still flat.nrrd --sheet slices --point 1,2 -o x.png >/dev/null 2>log.txt && fail "a point of two coordinates was accepted"
grep -q 'expected \[R, A, S\] in millimetres' log.txt || fail "a point of two coordinates: unexpected message: $(cat log.txt)"

# Small lengths are printed in small units; numbers in JSON are exact.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 20 20\nspace: right-anterior-superior\n'
    printf 'space directions: (0.000004,0,0) (0,0.000004,0) (0,0,0.00004)\nspace origin: (-0.00000000001,0,0)\nencoding: raw\n\n'
    head -c 4000 /dev/zero | tr '\0' '\1'; head -c 4000 /dev/zero
} >tiny.nrrd
"$SEGCAST" info tiny.nrrd >info.txt 2>log.txt || fail "info of a tiny volume: $(cat log.txt)"
grep -q 'voxels of 4 x 4 x 40 nm' info.txt || fail "spacing: $(cat info.txt)"
grep -q 'thick. nm' info.txt && ! grep -qE -- '-0\.0+( |$)' info.txt || fail "units: $(cat info.txt)"
"$SEGCAST" info tiny.nrrd --json 2>/dev/null |
    jq -e '.spacing_mm[0] == 0.000004 and (.labels[1].thickness_mm > 0)' >/dev/null || fail "JSON of a tiny volume"
"$SEGCAST" still tiny.nrrd --sheet slices --size 200x160 -o tiny.png -q >/dev/null || fail "views of a tiny volume"
