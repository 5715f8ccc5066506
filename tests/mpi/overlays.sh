# SPDX-License-Identifier: BSD-3-Clause
# With overlays, too, each frame has the same hash for any number of ranks, partition, tile size, skip method
# and kernel; alone it is that of the film. Without fonts on any rank but the first the pictures stay the same,
# and a run does not go on with another font.
small_job job.yaml
"$SEGCAST" still job.yaml -o logo.png -q --set output.size=[80,60] --set render.background=none >/dev/null
overlays=(--set output.size=[200,160] --set overlays.time=top-right --set overlays.scale_bar=bottom-left --set overlays.logo=logo.png --set overlays.legend=top-left --set overlays.orientation=bottom-right --set overlays.names=all
    --set 'overlays.caption={0%: "The heart", 60%: two words}')
for setting in animation.slices=none animation.slices=through render.background=none; do
    OMP_NUM_THREADS=1 "$SEGCAST" render job.yaml -o "one-$setting" -q "${overlays[@]}" --set $setting >/dev/null
    "$SEGCAST" render job.yaml -o "bare-$setting" -q --set output.size=[200,160] --set $setting >/dev/null
    [ -z "$(comm -12 <(hashes "one-$setting" | sort) <(hashes "bare-$setting" | sort))" ] ||
        fail "$setting: pictures with overlays are as those without"
done
OMP_NUM_THREADS=2 mpi 2 "$SEGCAST" render job.yaml -o two -q "${overlays[@]}" --set animation.slices=through --set farm.partition=frames \
    --set farm.tile=59 --set render.skip=none >/dev/null
[ "$(hashes one-animation.slices=through)" = "$(hashes two)" ] || fail "the three views differ with 2 ranks"
mpi 3 "$SEGCAST" render job.yaml -o three -q "${overlays[@]}" --set render.background=none --set farm.partition=tiles --cpu c \
    --set farm.share=false >/dev/null
[ "$(hashes one-render.background=none)" = "$(hashes three)" ] || fail "the pictures without a background differ with 3 ranks"
"$SEGCAST" render job.yaml -o alone -q "${overlays[@]}" --frames 3 >/dev/null
[ "$(hashes alone)" = "$(hashes one-animation.slices=none | sed -n 4p)" ] || fail "a frame alone is not that of the film"

# A rank that finds no fonts.
mkdir none
printf '<?xml version="1.0"?><fontconfig><dir>%s/none</dir></fontconfig>\n' "$PWD" >none.conf
cat >rank.sh <<'SH'
#!/bin/sh
[ "${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-0}}" = 0 ] || export FONTCONFIG_FILE=$PWD/none.conf
exec "$@"
SH
chmod +x rank.sh
mpi 2 ./rank.sh "$SEGCAST" render job.yaml -o fontless -q "${overlays[@]}" --set farm.partition=tiles >/dev/null
[ "$(hashes fontless)" = "$(hashes one-animation.slices=none)" ] || fail "the pictures differ where a rank has no fonts"
FONTCONFIG_FILE=$PWD/none.conf expect 71 'fontconfig finds no font' "$SEGCAST" check job.yaml "${overlays[@]}"
FONTCONFIG_FILE=$PWD/none.conf expect 0 '' "$SEGCAST" check job.yaml

# Another logo under the same name, in the middle of a film.
expect 0 '' "$SEGCAST" render job.yaml -o logos -q "${overlays[@]}" --frames 0-2
mv logo.png first.png
"$SEGCAST" still job.yaml -o logo.png --frame 2 -q --set output.size=[80,60] >/dev/null
expect 73 'another job' "$SEGCAST" render job.yaml -o logos --resume -q "${overlays[@]}"
mv first.png logo.png

# The same family name, but another font file, in the middle of a film.
command -v fc-match >/dev/null || exit 0
overlays+=(--set overlays.font=sans-serif)
expect 0 '' "$SEGCAST" render job.yaml -o film -q "${overlays[@]}" --frames 0-2
mkdir other
cp "$(fc-match -f '%{file}' 'DejaVu Sans Mono:bold')" other
printf '<?xml version="1.0"?><fontconfig><dir>%s/other</dir></fontconfig>\n' "$PWD" >other.conf
FONTCONFIG_FILE=$PWD/other.conf expect 73 'another job' "$SEGCAST" render job.yaml -o film --resume -q "${overlays[@]}"
expect 0 '' "$SEGCAST" render job.yaml -o film --resume -q "${overlays[@]}"

# A picture that is too narrow for names says so, and does not call their tissues hidden.
printf 'volume: phantom:40x30x40\noutput: {size: [160, 120], video: none}\noverlays: {names: [aorta]}\nanimation: {frames: 2, slices: through}\n' >narrow.yaml
"$SEGCAST" render narrow.yaml -o narrow >narrow.txt 2>&1 || { cat narrow.txt >&2; fail "a narrow picture was not drawn"; }
grep -q 'a picture of 80 x 60 pixels has no room for names' narrow.txt || { cat narrow.txt >&2; fail "it is not told that there is no room for names"; }
! grep -q 'are hidden' narrow.txt || fail "tissues are called hidden that are too near to the edges"
