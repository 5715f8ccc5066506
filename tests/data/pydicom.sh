# SPDX-License-Identifier: BSD-3-Clause
# DICOM segmentations that pydicom writes here are read with the labels, geometry, names and colours that it has put
# there, in all transfer syntaxes; what cannot be shown is refused with one message.
for python in /usr/bin/python3 python3 none; do
    "$python" -c 'import pydicom, numpy' 2>/dev/null && break
done
[ "$python" != none ] || skip "pydicom is not installed for Python (Debian: python3-pydicom)"
cp "$SOURCE/tests/support/dicom_files.py" .
cat >make.py <<'PYTHON'
from dicom_files import *
for name, syntax in SYNTAXES.items():
    if name != 'rle': # which DICOM does not have for single bits
        write(f'binary_{name}.dcm', frames_of(LABELS), SEGMENTS, syntax=syntax)
    write(f'shares_{name}.dcm', [(s, z, np.where(a, 100, 99).astype(np.uint8)) for s, z, a in frames_of(LABELS)], SEGMENTS,
          kind='FRACTIONAL', syntax=syntax)
    for bits in 8, 16:
        write(f'map{bits}_{name}.dcm', slices_of(LABELS.astype(f'uint{bits}')), SEGMENTS, kind='LABELMAP', syntax=syntax)
tilted = (.8, .6, 0, -.48, .64, .6)
for name, labels in ('tilted', LABELS), ('hole', np.where((np.arange(7) == 3)[:, None, None], 0, LABELS).astype(np.uint8)):
    write(f'{name}.dcm', frames_of(labels), SEGMENTS, orientation=tilted)
    write_nrrd(f'{name}.nrrd', labels, orientation=tilted)
write('wide.dcm', [(300 * s, z, a) for s, z, a in frames_of(np.minimum(LABELS, 2))], [(300 * s[0], *s[1:]) for s in SEGMENTS[:2]])
write('latin.dcm', frames_of(LABELS), SEGMENTS, characters='ISO_IR 100')
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "pydicom cannot write the files"; }
"$SEGCAST" info binary_explicit.dcm >stdout.txt 2>stderr.txt || {
    grep -q 'built without DCMTK' stderr.txt && skip "segcast was built without DCMTK"
    cat stderr.txt >&2
    fail "binary_explicit.dcm cannot be read"
}

# read_file FILE [LABELS]: its voxels, places, names and colours are those of dicom_files.py; nothing tells of the patient.
read_file() {
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    ! grep -qiE 'warning|secret' stderr.txt info.json || { cat stderr.txt >&2; fail "$1: this is printed"; }
    jq -e ".size == [19, 23, 5] and [.labels[1:][] | [.value, .voxels]] == ${2:-[[1, 336], [2, 384], [200, 1]]}" info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.size, [.labels[] | [.value, .voxels]]]' info.json)"
    jq -e '.to_ras_mm == [[-0.5, 0, 0, 10], [0, -0.75, 0, -20], [0, 0, 1.25, 31.25]]' info.json >/dev/null ||
        fail "$1: geometry $(jq -c .to_ras_mm info.json)"
    jq -e '[.labels[1:3][] | [.name, .color]] == [["Myocardium é", [200, 120, 60]], [" [31mred", [255, 0, 0]]]' info.json >/dev/null ||
        fail "$1: names and colours $(jq -c '[.labels[] | [.name, .color]]' info.json)"
}
# However the file is written; frames stand in a random order, and slices without any tissue are left out, but for those
# between others. A label that says nothing is replaced by what its code means.
for file in binary_*.dcm shares_*.dcm map*.dcm latin.dcm; do
    read_file "$file"
    jq -e '.labels[3].name == "Kidney, Right"' info.json >/dev/null || fail "$file: name $(jq .labels[3].name info.json)"
    [[ $file != shares* ]] || grep -q 'holds fractions of the type PROBABILITY; .* from half of the largest on' stderr.txt ||
        { cat stderr.txt >&2; fail "$file: nothing is said of its fractions"; }
done
read_file wide.dcm '[[300, 336], [600, 385]]'

# It becomes the same picture as the same voxels in another format, also tilted and with a slice that nothing is in.
for volume in tilted hole; do
    for ending in dcm nrrd; do
        "$SEGCAST" views "$volume.$ending" -o "$volume.$ending.png" --overwrite -q 2>stderr.txt ||
            { cat stderr.txt >&2; fail "$volume.$ending cannot be drawn"; }
    done
    cmp "$volume.dcm.png" "$volume.nrrd.png" || fail "the picture of $volume.dcm is not that of $volume.nrrd"
done
"$SEGCAST" orbit tilted.dcm -o film.mp4 --size 64x48 --set animation.frames=2 -q >stdout.txt 2>stderr.txt ||
    { cat stderr.txt >&2; fail "no film of a segmentation"; }
