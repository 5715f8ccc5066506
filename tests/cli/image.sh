# SPDX-License-Identifier: BSD-3-Clause
# A CT image is seen on cut faces and slices, the same by any ranks, tiles, skip methods and kernels; what it holds and
# the window belong to the identity of the job, its path does not.
small_job job.yaml
"$SEGCAST" convert phantom:50x36x52 --ct -o ct.nrrd -q >/dev/null
with=(--set image.path=ct.nrrd --set output.frames=png)

# A file and the built-in image are the same; so are pictures by any way to draw them.
expect 0 '50 x 36 x 52 grey values' "$SEGCAST" render job.yaml "${with[@]}" -o one
expect 0 '' "$SEGCAST" render job.yaml -o plain -q
expect 0 '' "$SEGCAST" render job.yaml --set image.path=phantom:50x36x52 -o built-in -q
[ "$(hashes one)" = "$(hashes built-in)" ] || fail "the written image shows other pictures than the built-in one"
[ "$(hashes one | tail -1)" != "$(hashes plain | tail -1)" ] || fail "the image is not seen"
for surface in smooth voxel; do
    for layout in picture views backdrop; do
        [ $surface-$layout = smooth-backdrop ] || sampled || continue # that one is compared again below
        set=("${with[@]}" --set render.surface=$surface --frames 2-6:2)
        case $layout in
        backdrop) set+=(--set image.backdrop=0.4 --set 'tissues={"*": {opacity: 0.3}}') ;;
        views) set+=(--set animation.slices=through) ;;
        esac
        "$SEGCAST" render job.yaml "${set[@]}" -o a-$surface-$layout -q --cpu c >/dev/null
        mpi 3 "$SEGCAST" render job.yaml "${set[@]}" -o b-$surface-$layout -q --set farm.partition=tiles --set farm.tile=13 \
            --set render.skip=none >/dev/null
        OMP_NUM_THREADS=2 mpi 2 "$SEGCAST" render job.yaml "${set[@]}" -o c-$surface-$layout -q --set farm.share=false \
            --set render.skip=octree >/dev/null
        for other in b c; do
            [ "$(hashes a-$surface-$layout)" = "$(hashes $other-$surface-$layout)" ] || fail "pictures differ: $surface, $layout, $other"
        done
    done
done

# A prepared volume, and a film whose shots show it or not.
"$SEGCAST" convert job.yaml -o heart.segc -q >/dev/null
expect 0 '' "$SEGCAST" render job.yaml "${with[@]}" --set volume=heart.segc -o prepared -q
[ "$(hashes prepared)" = "$(hashes one)" ] || fail "the pictures of a prepared file differ"
expect 0 '' "$SEGCAST" render job.yaml "${with[@]}" --set 'shots=[{}, {image: {caps: 0}}]' -o film -q
[ "$(hashes film | sed -n 7p | cut -d' ' -f2)" = "$(hashes one | sed -n 7p | cut -d' ' -f2)" ] || fail "the first shot differs"
[ "$(hashes film | sed -n 14p | cut -d' ' -f2)" = "$(hashes plain | sed -n 7p | cut -d' ' -f2)" ] || fail "the second shot shows the image"

[ "$(hashes a-smooth-backdrop | head -1)" != "$(hashes one | sed -n 3p)" ] || fail "the backdrop is not seen"
expect 0 '' "$SEGCAST" render job.yaml "${with[@]}" --set 'shots=[{}, {image: {backdrop: 0.3}}]' -o behind -q
expect 0 '' "$SEGCAST" render job.yaml "${with[@]}" --set image.backdrop=0.3 -o alone -q
[ "$(hashes behind | sed -n 7p | cut -d' ' -f2)" = "$(hashes one | sed -n 7p | cut -d' ' -f2)" ] || fail "the first shot shows a backdrop"
[ "$(hashes behind | sed -n 14p | cut -d' ' -f2)" = "$(hashes alone | sed -n 7p | cut -d' ' -f2)" ] || fail "the second shot shows no backdrop"

# The identity: under another path it is the same job, with another window or other values it is not.
mkdir elsewhere && cp ct.nrrd elsewhere/image.nrrd
expect 0 'nothing to do' "$SEGCAST" render job.yaml "${with[@]}" --set image.path=elsewhere/image.nrrd -o one --resume
expect 0 'nothing to do' "$SEGCAST" render one/job.yaml -o one --resume
expect 73 'other job|another job' "$SEGCAST" render job.yaml "${with[@]}" --set 'image.window=[100, 600]' -o one --resume -q
"$SEGCAST" convert phantom:50x36x53 --ct -o ct.nrrd --overwrite -q >/dev/null
expect 73 'other job|another job' "$SEGCAST" render job.yaml "${with[@]}" -o one --resume -q

# Options, and what must not be lost.
"$SEGCAST" convert phantom:59x41x61 -o heart.nrrd -q >/dev/null
expect 0 '' "$SEGCAST" still heart.nrrd --sheet slices --image ct.nrrd -o views.png -q --size 200x150
cp ct.nrrd ct.png # formats are told by content
expect 73 'ct.png: is an input of this command' "$SEGCAST" still heart.nrrd --sheet slices --image ct.png -o ct.png --overwrite -q

# Of large numbers that differ little, the ends of the window are told apart.
cat >large.nhdr <<'NRRD'
NRRD0005
type: int32
dimension: 3
space: RAS
sizes: 8 8 4
space directions: (20,0,0) (0,20,0) (0,0,40)
space origin: (-70,-70,-60)
endian: little
encoding: raw
data file: large.raw
NRRD
for i in $(seq 0 255); do # 2000000000 and more
    # shellcheck disable=SC2059
    printf "$(printf '\\x%02x\\x94\\x35\\x77' "$i")"
done >large.raw
expect 0 'shown from 20000000[0-9]{2} \(black\) to 2000000[12][0-9]{2} \(white\)' "$SEGCAST" still heart.nrrd --sheet slices --image large.nhdr -o large.png --size 200x150

# Mistakes: each is one message.
cat >far.nhdr <<'NRRD'
NRRD0005
type: int16
dimension: 3
space: RAS
sizes: 4 4 4
space directions: (1,0,0) (0,1,0) (0,0,1)
space origin: (5000,0,0)
endian: little
encoding: raw
data file: far.raw
NRRD
head -c 128 /dev/zero >far.raw
for command in check render; do
    expect 65 'far.nhdr: the image lies nowhere in the volume: it reaches from \(4999.5, -0.5, -0.5\) to' "$SEGCAST" $command job.yaml --set image.path=far.nhdr
    one_error
done
sed 's/5000/0/; s/dimension: 3/dimension: 4/; s/sizes:/sizes: 3/; s/space directions:/space directions: none/; /^sizes/a kinds: RGB-color domain domain domain' far.nhdr >color.nhdr
expect 65 'color.nhdr: axis 0 .RGB-color. has 3 samples.*expected three spatial axes' "$SEGCAST" check job.yaml --set image.path=color.nhdr
one_error
sed 's/5000/0/; s/far.raw/short.raw/' far.nhdr >short.nhdr
head -c 100 /dev/zero >short.raw
expect 65 'short.nhdr: the header promises 128 bytes' "$SEGCAST" render job.yaml --set image.path=short.nhdr -o short -q
one_error
expect 64 'image.path is "phantom:1x9x9"' "$SEGCAST" check job.yaml --set image.path=phantom:1x9x9
one_error

# Beside a second volume: without an image of its own it shows that of the job, with one its own, in the window of the
# first, and moved with its volume. At 0 % of the width the divider leaves the picture to the second one.
"$SEGCAST" convert phantom:50x36x52 -o there.nrrd -q >/dev/null
# By multiples of 16 voxels, as the cells of borders lie at fixed places.
shift_mm=$(grep -a '^space directions' there.nrrd |
    awk -F '[ (),]+' '{ printf "%.17g %.17g %.17g", 160 * $3, -16 * $7, 32 * $11 }')
for file in there ct; do
    origin=$(grep -a '^space origin' $file.nrrd |
        awk -F '[ (),]+' -v by="$shift_mm" '{ split(by, mm, " "); printf "%.17g,%.17g,%.17g", $3 + mm[1], $4 + mm[2], $5 + mm[3] }')
    sed "s/^space origin: .*/space origin: ($origin)/" $file.nrrd >moved-$file.nrrd
    cmp -s $file.nrrd moved-$file.nrrd && fail "the geometry of $file.nrrd was not changed"
done
second() { # second FILE.png SUBJECT [OPTION]...: the second volume of a comparison, with frame 6 of the job
    local file=$1 subject=$2
    shift 2
    "$SEGCAST" still job.yaml --frame 6 --set compare.divider=0% --set "compare.with=[{name: b, $subject}]" -q \
        --set compare.align=center -o "$file" "$@" >/dev/null
}
second none.png 'volume: there.nrrd'
second shared.png 'volume: there.nrrd' --set image.path=ct.nrrd
second own.png 'volume: there.nrrd, image: ct.nrrd' --set image.path=phantom:40x30x40
second window.png 'volume: there.nrrd, image: ct.nrrd' --set image.path=ct.nrrd --set 'image.window=[-163, 30]'
second moved.png 'volume: moved-there.nrrd, image: moved-ct.nrrd' --set image.path=ct.nrrd
second without.png 'volume: there.nrrd, image: none' --set image.path=ct.nrrd
"$IMAGE_DIFFERENCE" none.png without.png || fail "image: none shows an image"
"$IMAGE_DIFFERENCE" none.png shared.png >/dev/null && fail "the image of the job is not seen in the second volume"
# Places half a metre away are rounded otherwise.
"$IMAGE_DIFFERENCE" shared.png moved.png 2 || fail "the image does not move with its volume"
"$IMAGE_DIFFERENCE" shared.png window.png >/dev/null && fail "the window is not that of the job"
"$IMAGE_DIFFERENCE" none.png own.png >/dev/null && fail "the image of the second volume is not seen"
expect 65 'moved-ct.nrrd: the image lies nowhere in the volume' "$SEGCAST" check job.yaml --set image.path=ct.nrrd \
    --set 'compare.with=[{volume: there.nrrd, image: moved-ct.nrrd}]'
both=(--set image.path=ct.nrrd --set 'compare.with=[{volume: there.nrrd, image: phantom:50x36x52}]' --set output.frames=png -q)
"$SEGCAST" render job.yaml "${both[@]}" -o both >/dev/null
mpi 2 "$SEGCAST" render job.yaml "${both[@]}" -o both-2 --set farm.partition=tiles >/dev/null
[ "$(hashes both)" = "$(hashes both-2)" ] || fail "a comparison with images differs with two ranks"
