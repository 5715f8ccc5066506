# SPDX-License-Identifier: BSD-3-Clause
# Small volumes and tables, kept here, that other programs have written, as make.mjs or make.sh beside them tells: Zarr 3 by
# zarrita, Neuroglancer's format by the encoders of Neuroglancer itself, label tables by Connectome Workbench. They are
# read with their labels, names, colours and spacing; volumes give the same picture as the same voxels in NRRD.
kept=$SOURCE/tests/data
# same_as FOLDER VOLUME SIZE LABELS: labels are [value, voxels, name] of each but the background.
same_as() {
    local volume=$kept/$1/$2
    "$SEGCAST" info "$volume" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1/$2 cannot be read"; }
    jq -e --argjson size "$3" --argjson labels "$4" '.size == $size and [.labels[1:][] | [.value, .voxels, .name]] == $labels and
        (.spacing_mm | map(. * 1e9 | round)) == [500000, 500000, 1250000]' info.json >/dev/null ||
        fail "$1/$2: $(jq -c '[.size, .spacing_mm, [.labels[1:][] | [.value, .voxels, .name]]]' info.json)"
    for file in "$volume" "$kept/$1/labels.nrrd"; do
        rm -f "$(basename "$file").png"
        "$SEGCAST" still "$file" --sheet slices -o "$(basename "$file").png" -q --set 'tissues={"*": {color: teal}, 17: {color: orange}}' \
            >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "$file cannot be drawn"; }
    done
    cmp "$2.png" labels.nrrd.png || fail "the picture of $1/$2 is not that of the same voxels in NRRD"
}
if "$SEGCAST" --version | grep '^volumes .*zstd' | grep -q blosc; then
    for store in plain big_turned_zstd blosc_lz4; do
        same_as zarrita $store.zarr '[16, 12, 5]' '[[17, 120, "nucleus"], [530, 126, "cell wall"]]'
        jq -e '[.labels[1:][].color] == [[255, 128, 0], [0, 255, 0]]' info.json >/dev/null || fail "$store: $(jq -c '[.labels[].color]' info.json)"
    done
else
    echo "Zarr 3 was not tried: segcast was built without zstd or blosc"
fi
same_as neuroglancer words_32 '[20, 14, 9]' '[[3, 168, "soma"], [17, 350, "nucleus"], [530, 396, "cell wall"]]'
same_as neuroglancer words_64 '[20, 14, 9]' '[[3, 168, "soma"], [17, 350, "nucleus"], [4294967826, 396, "cell wall"]]'
# Where the volume lies in its space.
jq -e '[.to_ras_mm[][3]] | map(. * 1e9 | round) == [50250000, -9750000, 625000]' info.json >/dev/null || fail "offset: $(jq -c .to_ras_mm info.json)"

# The table in the header of a NIfTI file, and the list of labels that the same program makes of it.
table='[[17, "Left-Hippocampus", [220, 216, 20]], [53, "Right Hippocampus & more", [10, 20, 230]]]'
"$SEGCAST" info "$kept/workbench/labels.nii.gz" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "workbench/labels.nii.gz cannot be read"; }
if ! grep -q 'built without Expat' stderr.txt; then
    jq -e --argjson table "$table" '[.labels[1:][] | [.value, .name, .color]] == $table and (.labels[2].opacity * 255 | round) == 128' info.json >/dev/null ||
        fail "the table in the header: $(jq -c '[.labels[] | [.value, .name, .color, .opacity]]' info.json)"
fi
"$SEGCAST" convert "$kept/workbench/table.txt" -o table.json >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "workbench/table.txt cannot be read"; }
grep -q 'read as a Connectome Workbench label table' stderr.txt || { cat stderr.txt >&2; fail "the list is not recognised"; }
"$SEGCAST" convert "$kept/workbench/table.txt" -o - --to bids -q >bids.tsv 2>stderr.txt || { cat stderr.txt >&2; fail "the list cannot be converted"; }
printf 'index\tname\tcolor\n17\tLeft-Hippocampus\t#dcd814\n53\tRight Hippocampus & more\t#0a14e6\n' | diff - bids.tsv || fail "the list has other labels"
