# SPDX-License-Identifier: BSD-3-Clause
# Pictures without a background: PNG files with alpha, whose hashes hold it, are verified and drawn again.
small_job job.yaml
sed -i 's/, video: none//' job.yaml
printf 'render: {background: none}\n' >>job.yaml
kind_of() { od -An -tu1 -j25 -N1 "$1" | tr -d ' '; } # kind_of FILE.png: 2: RGB, 6: RGB with alpha
"$SEGCAST" render job.yaml -o out -q --set output.video=none --set output.frames=png >/dev/null
[ "$(kind_of out/frames/000004.png)" = 6 ] || fail 'a frame without a background has no alpha'
expect 0 '' "$SEGCAST" verify out
"$SEGCAST" still job.yaml --frame 4 -o still.png -q >/dev/null
"$IMAGE_DIFFERENCE" still.png out/frames/000004.png || fail 'a still differs from the frame of the same number'
"$SEGCAST" still job.yaml --frame 4 --set render.background=white -o white.png -q >/dev/null
[ "$(kind_of white.png)" = 2 ] || fail 'a picture with a background has alpha'
grep -q '^ *background: none$' out/job.yaml || fail "the resolved job: $(grep background out/job.yaml)"

# A frame that has lost its alpha is not the frame that the manifest names.
cp -r out copy
cp white.png copy/frames/000004.png
expect 65 '000004.png: is missing, damaged, or not the picture' "$SEGCAST" verify copy
expect 0 '' "$SEGCAST" render job.yaml -o copy --set output.video=none --set output.frames=png --resume
cmp out/frames/000004.png copy/frames/000004.png || fail 'a frame that was drawn again is another one'

# Slices with lines and letters, which lie over what is transparent, and a sheet, which is opaque.
"$SEGCAST" still job.yaml --set animation.slices=through -o views.png -q >/dev/null
[ "$(kind_of views.png)" = 6 ] || fail 'the views have no alpha'
"$SEGCAST" still job.yaml --sheet 4 -o sheet.png -q >/dev/null
[ "$(kind_of sheet.png)" = 2 ] || fail 'a sheet has alpha'
"$SEGCAST" still phantom:59x41x61 --sheet slices --size 96x72 --set render.background=none -o slices.png -q >/dev/null
[ "$(kind_of slices.png)" = 6 ] || fail 'segcast still --sheet slices has no alpha'
# The job is planned with the memory of four bytes for a pixel.
expect 0 '' "$SEGCAST" plan job.yaml --json --set output.video=film.mov

# A transparent film is refused where there is no alpha; cli.exports makes those that there are.
expect 65 'H.264, which has no transparency' "$SEGCAST" check job.yaml; one_error
