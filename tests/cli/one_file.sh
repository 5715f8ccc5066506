# SPDX-License-Identifier: BSD-3-Clause
# Commands that write one file replace none that is there, unless --overwrite is given; none that is an
# input, by whatever name, not even then; and nothing but files. All of this is said before any work.
"$SEGCAST" convert phantom:24x20x26 -o heart.nrrd -q >/dev/null
small_job job.yaml
sed -i 's/^volume.*/volume: heart.nrrd/' job.yaml
mkdir links folder
ln -s ../heart.nrrd links/heart.segc
ln -s ../heart.nrrd links/heart.png
ln -s ../heart.nrrd links/heart.mp4
ln heart.nrrd hard.segc
ln heart.nrrd hard.png
ln heart.nrrd hard.mp4
cp heart.nrrd x.segc
before=$(sha256sum heart.nrrd x.segc)
kept() { # kept: the volumes are what they were, and no temporary file is left
    [ "$(sha256sum heart.nrrd x.segc)" = "$before" ] || fail "a file of the user was changed: $*"
    [ -z "$(find . -name '.*')" ] || [ "$(find . -name '.*')" = . ] || fail "left behind: $(find . -name '.*')"
}

# An output that is an input.
for option in "" --overwrite; do
    expect 73 'x.segc: is an input' "$SEGCAST" convert x.segc -o x.segc $option; one_error
    expect 73 'is an input' "$SEGCAST" convert x.segc -o "$PWD/folder/../x.segc" $option
    expect 73 'is an input' "$SEGCAST" convert job.yaml -o links/heart.segc $option; one_error
    expect 73 'is an input' "$SEGCAST" convert heart.nrrd -o hard.segc $option
    expect 73 'is an input' "$SEGCAST" still job.yaml -o links/heart.png $option
    expect 73 'is an input' "$SEGCAST" still job.yaml -o hard.png $option; one_error
    expect 73 'is an input' "$SEGCAST" still job.yaml --sheet 12 -o hard.png $option; one_error
    expect 73 'is an input' "$SEGCAST" still heart.nrrd --sheet slices -o hard.png $option
    expect 73 'is an input' "$SEGCAST" orbit heart.nrrd -o hard.mp4 --frames 2 $option; one_error
    expect 73 'is an input' "$SEGCAST" orbit heart.nrrd -o links/heart.mp4 --frames 2 $option
    kept "$option"
done
printf '1 a 1 2 3 255\n' >table.png
expect 73 'table.png: is an input' "$SEGCAST" still job.yaml --set labels=table.png -o table.png --overwrite
[ "$(cat table.png)" = '1 a 1 2 3 255' ] || fail "the label table was changed"

{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nspace: right-anterior-superior\n'
    printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\ndata file: voxels.segc\n'
} >detached.nhdr
head -c 512 /dev/zero | tr '\0' '\1' >voxels.segc
cp voxels.segc voxels.copy
expect 73 'voxels.segc: is an input' "$SEGCAST" convert detached.nhdr -o voxels.segc --overwrite; one_error
cmp voxels.segc voxels.copy || fail "the voxels of a detached header were replaced"

# Of a volume in several files each is an input: of a list or a pattern in a header, also with encodings that are not
# streamed, of a directory of masks, of a Zarr store, of a volume of Neuroglancer, of Analyze; and the table beside it.
for i in 1 2 3 4 5 6 7 8; do head -c 64 /dev/zero | tr '\0' '\1' >s$i.segc; done
head -c 512 /dev/zero | tr '\0' '\1' | od -An -v -tu1 >numbers.segc
grep -v 'data file' detached.nhdr >fields.txt
{ cat fields.txt; echo 'data file: LIST'; printf 's%d.segc\n' 1 2 3 4 5 6 7 8; } >list.nhdr
{ cat fields.txt; echo 'data file: s%d.segc 1 8 1'; } >pattern.nhdr
{ sed 's/raw/ascii/' fields.txt; echo 'data file: numbers.segc'; } >ascii.nhdr
sums=$(sha256sum s?.segc numbers.segc)
for volume in list.nhdr pattern.nhdr; do
    for i in 1 2 8; do
        expect 73 "s$i.segc: is an input" "$SEGCAST" convert $volume -o s$i.segc --overwrite; one_error
    done
    expect 73 's5.segc: is an input' "$SEGCAST" convert job.yaml --set volume=$volume -o "$PWD/folder/../s5.segc" --overwrite
    expect 0 '' "$SEGCAST" convert $volume -q -o several.segc
    rm several.segc
done
expect 73 'numbers.segc: is an input' "$SEGCAST" convert ascii.nhdr -o numbers.segc --overwrite
mkdir masks
cp heart.nrrd masks/b.nrrd
cp heart.nrrd masks/a.nrrd
expect 73 'masks/b.nrrd: is an input' "$SEGCAST" convert masks -o masks/b.nrrd --to freesurfer --overwrite; one_error
[ "$(sha256sum s?.segc numbers.segc)" = "$sums" ] && cmp masks/b.nrrd heart.nrrd || fail "a file of a volume was replaced"
rm -r masks s?.segc numbers.segc
mkdir -p store.zarr/0
echo '{"zarr_format": 2}' >store.zarr/.zgroup
echo '{"multiscales": [{"axes": [{"name": "z"}, {"name": "y"}, {"name": "x"}], "datasets": [{"path": "0"}]}]}' >store.zarr/.zattrs
echo '{"zarr_format": 2, "shape": [8, 8, 8], "chunks": [8, 8, 8], "dtype": "|u1", "compressor": null, "fill_value": 0,
    "order": "C", "filters": null, "dimension_separator": "."}' >store.zarr/0/.zarray
cp voxels.copy store.zarr/0/0.0.0
mkdir -p precomputed/s
echo '{"data_type": "uint8", "num_channels": 1, "scales": [{"key": "s", "size": [8, 8, 8], "encoding": "raw",
    "chunk_sizes": [[8, 8, 8]], "resolution": [1, 1, 1]}]}' >precomputed/info
cp voxels.copy precomputed/s/0-8_0-8_0-8
cp store.zarr/.zattrs zattrs
for volume in store.zarr precomputed; do
    expect 0 '' "$SEGCAST" convert $volume -q -o several.segc
    rm several.segc
    cp voxels.copy $volume/mine.segc
    expect 73 'mine.segc: is an input' "$SEGCAST" convert $volume -o $volume/mine.segc --overwrite; one_error
    cmp voxels.copy $volume/mine.segc || fail "a file in $volume was replaced"
done
expect 73 'is an input' "$SEGCAST" convert store.zarr -o store.zarr/.zattrs --to bids --overwrite
cmp zattrs store.zarr/.zattrs || fail "the attributes of a Zarr store were replaced"
rm -r store.zarr precomputed zattrs
mkdir bids
echo '{}' >bids/dataset_description.json
{ cat fields.txt; echo 'data file: voxels.segc'; } >bids/x_dseg.nii # formats are told by content
cp voxels.copy bids/voxels.segc
printf 'index\tname\n1\ta\n' >bids/x_dseg.tsv
cp bids/x_dseg.tsv table.tsv
expect 73 'x_dseg.tsv: is an input' "$SEGCAST" convert bids/x_dseg.nii --tissue a -o bids/x_dseg.tsv --overwrite; one_error
cmp bids/x_dseg.tsv table.tsv || fail "the table beside a volume was replaced"
expect 65 'has no label table in its header' "$SEGCAST" convert bids/x_dseg.nii -o bids/x_dseg.tsv --overwrite # reads it not
rm -r bids table.tsv

# What a job or a shot reads beside the volume: a logo, a table of values, an image.
"$SEGCAST" convert phantom:24x20x26 --ct -o ct.nrrd -q >/dev/null
"$SEGCAST" still job.yaml -o logo.png -q >/dev/null
mv ct.nrrd ct.png # formats are told by content
printf 'name,mm\naorta,3\n' >values.png
more=('overlays: {logo: logo.png}' 'color_by: {values: values.png}' 'image: {path: ct.png}')
sums=$(sha256sum logo.png values.png ct.png)
for keys in "${more[@]}"; do
    file=$(grep -o '[a-z]*[.]png' <<<"$keys")
    { cat job.yaml; echo "$keys"; } >more.yaml
    { cat job.yaml; echo "shots: [{name: a}, {name: b, $keys}]"; } >shots.yaml
    for name in more shots; do
        [[ $name != shots || $keys != image* ]] || continue # of the whole film
        expect 73 "$file: is an input" "$SEGCAST" still $name.yaml -o "$file" --overwrite; one_error
        expect 73 "$file: is an input" "$SEGCAST" still $name.yaml --sheet 12 -o "$PWD/folder/../$file" --overwrite
    done
done
[ "$(sha256sum logo.png values.png ct.png)" = "$sums" ] || fail "a file that a job reads was replaced"
rm logo.png values.png ct.png more.yaml shots.yaml

# An output that exists.
write() { # write FILE [OPTION]...: let the command that makes such a file write it
    local file=$1
    shift
    case $file in
    still.png) "$SEGCAST" still job.yaml -q -o "$file" "$@" ;;
    sheet.png) "$SEGCAST" still job.yaml --sheet 12 -q -o "$file" "$@" ;;
    views.png) "$SEGCAST" still heart.nrrd --sheet slices --size 64x48 -q -o "$file" "$@" ;;
    *.mp4 | *.webm | *.mkv | *.mov | *.webp | *.gif) "$SEGCAST" orbit heart.nrrd --frames 2 --size 64x48 -q -o "$file" "$@" ;;
    *.segc) "$SEGCAST" convert heart.nrrd -q -o "$file" "$@" ;;
    *.nrrd) "$SEGCAST" convert phantom:20x20x20 -q -o "$file" "$@" ;;
    esac
}
for file in still.png sheet.png views.png turn.mp4 turn.mkv turn.webm turn.mov turn.webp turn.gif whole.segc p.nrrd; do
    sampled || continue
    expect 0 '' write "$file"
    [ "$(basename "$(cat stdout.txt)")" = "$file" ] || fail "$file: printed $(cat stdout.txt)"
    mv "$file" made
    echo mine >"$file"
    expect 73 "$file: exists.*--overwrite" write "$file"; one_error
    [ "$(cat "$file")" = mine ] || fail "$file: was replaced without --overwrite"
    expect 0 '' write "$file" --overwrite
    cmp "$file" made || fail "$file: --overwrite gives other bytes"
    rm "$file"
    mkdir "$file"
    expect 73 'is a directory' write "$file" --overwrite; one_error
    rmdir "$file"
    echo mine >target
    ln -s target "$file"
    for option in "" --overwrite; do
        expect 73 'is a symbolic link' write "$file" $option; one_error
    done
    [ "$(cat target)" = mine ] && [ -L "$file" ] || fail "$file: a symbolic link was replaced or followed"
    rm "$file" && ln -s nowhere "$file"
    expect 73 'is a symbolic link' write "$file"
    [ ! -e nowhere ] && [ -L "$file" ] || fail "$file: a dangling link was followed"
    rm "$file" && mkfifo "$file"
    expect 73 'no regular file' write "$file" --overwrite
    [ -p "$file" ] || fail "$file: a named pipe was replaced"
    rm "$file"
done
expect 73 'nowhere/x.png: cannot be created' "$SEGCAST" still job.yaml -o nowhere/x.png; one_error
expect 64 '--output is empty' "$SEGCAST" still job.yaml -o ''; one_error
kept

# Each command writes one format, and does not write it under the name of another.
expect 64 'a.jpg: a picture in the format PNG is written, expected a name ending in .png' \
    "$SEGCAST" still job.yaml -o a.jpg; one_error
expect 64 'expected a name ending in .png' "$SEGCAST" still job.yaml --sheet 12 -o a.webp; one_error
expect 64 'expected a name ending in .png' "$SEGCAST" still heart.nrrd --sheet slices -o a.tiff
expect 64 'only the phantom is written as NRRD' "$SEGCAST" convert heart.nrrd -o a.nrrd
expect 64 'expected a name ending in .nrrd' "$SEGCAST" convert phantom --ct -o a.nii.gz; one_error
expect 64 'its ending does not tell what to write' "$SEGCAST" convert phantom -o a.nii.gz; one_error
expect 0 '' "$SEGCAST" still job.yaml -o A.PNG
kept

# An orbit that is stopped names what it has; an older part of that name stays.
cat >stop.sh <<'SH'
"$SEGCAST" orbit phantom:59x41x61 --frames 2000 --size 320x240 --fps 2 -o slow.mp4 2>said.txt &
id=$!
for _ in $(seq 100); do
    find . -name '.slow.mp4.tmp.*' -size +2k | grep -q . && break
    sleep 0.1
done
kill -USR1 $id
wait $id
SH
echo mine >slow.partial.mp4
expect 75 '' bash stop.sh
[ "$(cat slow.partial.mp4)" = mine ] || fail "a file slow.partial.mp4 was replaced"
[ -s slow.partial-2.mp4 ] && grep -q 'slow.partial-2.mp4: holds the frames so far' said.txt ||
    fail "the partial video: $(ls) $(cat said.txt)"
rm said.txt
kept

# Names that a library takes for an address, or that leave no room for a temporary name, are names.
expect 0 '' "$SEGCAST" orbit heart.nrrd --frames 2 --size 64x48 -q -o http:turn.mp4
[ -s http:turn.mp4 ] || fail "http:turn.mp4 was not written"
long=$(printf 'ü%.0s' $(seq 120)).png
expect 0 '' "$SEGCAST" still job.yaml -q -o "$long"
[ -s "$long" ] || fail "a name of ${#long} characters was not written"
kept
