# SPDX-License-Identifier: BSD-3-Clause
# DICOM segmentations that pydicom writes here are read with the labels, geometry, names and colours that it has put
# there, in all transfer syntaxes; what cannot be shown is refused with one message.
find_python 'pydicom, numpy' python3-pydicom
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
        "$SEGCAST" still "$volume.$ending" --sheet slices -o "$volume.$ending.png" --overwrite -q 2>stderr.txt ||
            { cat stderr.txt >&2; fail "$volume.$ending cannot be drawn"; }
    done
    cmp "$volume.dcm.png" "$volume.nrrd.png" || fail "the picture of $volume.dcm is not that of $volume.nrrd"
done
"$SEGCAST" orbit tilted.dcm -o film.mp4 --size 64x48 --set animation.frames=2 -q >stdout.txt 2>stderr.txt ||
    { cat stderr.txt >&2; fail "no film of a segmentation"; }
expect 65 'tilted.dcm: is a DICOM segmentation, expected a grey volume' "$SEGCAST" orbit tilted.nrrd --set image.path=tilted.dcm -o image.mp4
one_error

# Where the file names the images that it was made of, the slices that were left out are there again: as many as there are
# images before and behind, whatever their order; where the frames do not say which is theirs, or the images are in no
# order, one at each end; none where all are there, or the images are those of several series.
cat >images.py <<'PYTHON'
from dicom_files import *
labels = np.concatenate([LABELS, LABELS[:1]]) # eight slices, in the second to sixth of which there is something
used = frames_of(labels)
count = len(labels)
def several(data):
    name_images(data, used, range(count))
    data.ReferencedSeriesSequence.append(data.ReferencedSeriesSequence[0])
def twice(data):
    name_images(data, used, range(count))
    images = data.ReferencedSeriesSequence[0].ReferencedInstanceSequence
    images[0] = images[1]
for name, change in dict(rising=lambda data: name_images(data, used, range(count)),
                         falling=lambda data: name_images(data, used, range(count - 1, -1, -1)),
                         mixed=lambda data: name_images(data, used, [3, 1, 4, 7, 5, 0, 2, 6]),
                         unsaid=lambda data: name_images(data, used, range(count), by_frame=False),
                         whole=lambda data: name_images(data, used, [0, 0, 1, 2, 3, 4, 4, 4]),
                         several=several, twice=twice).items():
    write(f'images_{name}.dcm', used, SEGMENTS, change=change)
one = [f for f in used if f[1] == 3]
write('images_one.dcm', one, SEGMENTS, change=lambda data: name_images(data, one, range(count)))
write('images_map.dcm', slices_of(labels), SEGMENTS, kind='LABELMAP',
      change=lambda data: name_images(data, slices_of(labels), range(count)))
write_nrrd('images_rising.nrrd', labels, before=1, behind=2)
PYTHON
"$python" images.py 2>python.txt || { cat python.txt >&2; fail "pydicom cannot write files that name images"; }
for file in rising:8:30 falling:8:30 map:8:30 mixed:7:30 unsaid:7:30 one:3:32.5 whole:5:31.25 several:5:31.25 twice:5:31.25; do
    IFS=: read -r name slices first_mm <<<"$file"
    expect 0 '' "$SEGCAST" info "images_$name.dcm" --json
    jq -e ".size[2] == $slices and .to_ras_mm[2][3] == $first_mm and .to_ras_mm[2][2] == 1.25" stdout.txt >/dev/null ||
        fail "images_$name.dcm: $(jq -c '[.size, .to_ras_mm]' stdout.txt)"
done
"$SEGCAST" still images_rising.dcm --sheet slices -o rising.dcm.png -q 2>stderr.txt || { cat stderr.txt >&2; fail "images_rising.dcm cannot be drawn"; }
"$SEGCAST" still images_rising.nrrd --sheet slices -o rising.nrrd.png -q
cmp rising.dcm.png rising.nrrd.png || fail "a segmentation without its empty slices is another picture than with them"

# A file of dcmqi that comes with pydicom; somebody has cut it to the pixels of its first frame, of three.
cat >real.py <<'PYTHON'
import pydicom, pydicom.data
for name in 'liver_1frame', 'liver_expb_1frame':
    data = pydicom.dcmread(pydicom.data.get_testdata_file(name + '.dcm', download=False))
    data.NumberOfFrames, data.PixelData, data['PixelData'].VR = 3, 3 * data.PixelData, 'OB'
    data.save_as(name + '.dcm')
PYTHON
if "$python" -W ignore real.py 2>python.txt; then
    for file in liver_1frame liver_expb_1frame; do
        expect 0 '' "$SEGCAST" info "$file.dcm" --json
        jq -e '.size == [512, 512, 3] and [.labels[1] | .name, .voxels, .color] == ["Liver", 108699, [217, 130, 101]]' stdout.txt >/dev/null ||
            fail "$file.dcm: $(jq -c '[.size, .labels[1]]' stdout.txt)"
    done
fi

# A voxel of several segments goes to the smaller one, or the last one, and it is told how many there are.
cat >overlap.py <<'PYTHON'
from dicom_files import *
write('overlap.dcm', [(n, z, LABELS[z] > 0 if n == 2 else LABELS[z] == 1) for n in (1, 2) for z in range(1, 6)], SEGMENTS)
PYTHON
"$python" overlap.py 2>python.txt || { cat python.txt >&2; fail "pydicom cannot write overlap.dcm"; }
told='overlap.dcm: 336 voxels belong to several segments; each is shown as the'
expect 0 "$told smallest of them .* \"Myocardium é\" and not \" \[31mred\" \(336\)" "$SEGCAST" info overlap.dcm --json
jq -e '[.labels[1:][] | [.value, .voxels]] == [[1, 336], [2, 385]]' stdout.txt >/dev/null || fail "smaller wins: $(jq -c '[.labels[].voxels]' stdout.txt)"
expect 0 "$told last of them" "$SEGCAST" info overlap.dcm --json --overlap order
jq -e '[.labels[1:][] | [.value, .voxels]] == [[2, 721]]' stdout.txt >/dev/null || fail "the last wins: $(jq -c '[.labels[].voxels]' stdout.txt)"
"$SEGCAST" info overlap.dcm --json --set 'volume.keep=[2]' >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "keep"; }
! grep -q 'belong to several' stderr.txt || fail "an overlap with a segment that is left out is told"
jq -e '[.labels[1:][] | [.value, .voxels]] == [[2, 721]]' stdout.txt >/dev/null || fail "a segment that is left out takes voxels of one that is kept"

# The segmentation in a directory is found by its content, beside the slices of its image.
mkdir one several image
cp binary_explicit.dcm one/IM00001
mkfifo one/pipe
cp binary_explicit.dcm several/a
cp overlap.dcm several/b
cat >image.py <<'PYTHON'
from dicom_files import *
data = pydicom.dcmread('binary_explicit.dcm')
data.file_meta.MediaStorageSOPClassUID = data.SOPClassUID = '1.2.840.10008.5.1.4.1.1.2'
for name in 'image/1', 'image/2', 'one/slice':
    data.save_as(name)
PYTHON
"$python" image.py 2>python.txt || { cat python.txt >&2; fail "pydicom cannot write an image"; }
read_file one
grep -q 'one: of 2 DICOM files, .*one/IM00001 is a segmentation, and read' stderr.txt || { cat stderr.txt >&2; fail "nothing is said of the file in the directory"; }
expect 66 'several: holds 2 DICOM segmentations, expected one; .* such as .*several/a or .*several/b' "$SEGCAST" info several
one_error
expect 66 'image: is a directory of DICOM files, none of them a segmentation' "$SEGCAST" info image
one_error
expect 65 'image/1: is DICOM, a slice of a CT image, not a segmentation; .*dcm2niix' "$SEGCAST" info image/1
one_error

# What is missing, damaged, or does not agree is refused, with one message.
cat >bad.py <<'PYTHON'
from dicom_files import *
def spoil(name, change, **options):
    write(name + '.dcm', frames_of(LABELS), SEGMENTS, change=change, **options)
def delete(data, *names):
    for name in names[:-1]:
        data = getattr(data, name)[0]
    delattr(data, names[-1])
def place(i, offset):
    def change(data):
        position = data.PerFrameFunctionalGroupsSequence[i].PlanePositionSequence[0]
        position.ImagePositionPatient = [float(a) + b for a, b in zip(position.ImagePositionPatient, offset)]
    return change
def first(data, name, value):
    setattr(data.PerFrameFunctionalGroupsSequence[0].SegmentIdentificationSequence[0], name, value)
def shared(data, group, name, value):
    setattr(getattr(data.SharedFunctionalGroupsSequence[0], group)[0], name, value)
def twice(data):
    data.PerFrameFunctionalGroupsSequence[1] = data.PerFrameFunctionalGroupsSequence[0]
def deep(data):
    for _ in range(40):
        outer = Dataset()
        outer.SegmentSequence = Sequence([data])
        data = outer
    return data
def nest(data):
    data.SharedFunctionalGroupsSequence.append(deep(Dataset()))
def turn(data):
    plane = Dataset()
    plane.ImageOrientationPatient = [0, 1, 0, 0, 0, 1]
    data.PerFrameFunctionalGroupsSequence[2].PlaneOrientationSequence = Sequence([plane])
spoil('more_frames', lambda d: setattr(d, 'NumberOfFrames', 999))
spoil('fewer_frames', lambda d: setattr(d, 'NumberOfFrames', 3))
spoil('no_frames', lambda d: setattr(d, 'NumberOfFrames', 0))
spoil('huge', lambda d: (setattr(d, 'Rows', 65535), setattr(d, 'Columns', 65535)))
spoil('no_rows', lambda d: delete(d, 'Rows'))
spoil('no_pixels', lambda d: delete(d, 'PixelData'))
spoil('no_segments', lambda d: delete(d, 'SegmentSequence'))
spoil('no_spacing', lambda d: delete(d, 'SharedFunctionalGroupsSequence', 'PixelMeasuresSequence'))
spoil('no_orientation', lambda d: delete(d, 'SharedFunctionalGroupsSequence', 'PlaneOrientationSequence'))
spoil('no_position', lambda d: delete(d, 'PerFrameFunctionalGroupsSequence', 'PlanePositionSequence'))
spoil('no_segment', lambda d: delete(d, 'PerFrameFunctionalGroupsSequence', 'SegmentIdentificationSequence'))
spoil('other_segment', lambda d: first(d, 'ReferencedSegmentNumber', 77))
spoil('same_numbers', lambda d: setattr(d.SegmentSequence[1], 'SegmentNumber', 1))
spoil('type', lambda d: setattr(d, 'SegmentationType', '\x1b[31mX'))
spoil('zero_spacing', lambda d: shared(d, 'PixelMeasuresSequence', 'PixelSpacing', [0, 1]))
spoil('long_direction', lambda d: shared(d, 'PlaneOrientationSequence', 'ImageOrientationPatient', [2, 0, 0, 0, 1, 0]))
spoil('parallel', lambda d: shared(d, 'PlaneOrientationSequence', 'ImageOrientationPatient', [1, 0, 0, 1, 0, 0]))
spoil('far', place(0, (0, 0, 1e7)))
spoil('irregular', place(0, (0, 0, .5)))
spoil('shifted', place(0, (3, 0, 0)))
spoil('nearly', place(0, (0, 0, .05)))
spoil('twice', twice)
spoil('turned', turn)
spoil('deep', nest)
spoil('tiled_sparse', lambda d: setattr(d, 'TotalPixelMatrixColumns', 460))
spoil('tiled_full', lambda d: (setattr(d, 'TotalPixelMatrixColumns', 460), delattr(d, 'PerFrameFunctionalGroupsSequence')))
spoil('wrong_distance', lambda d: shared(d, 'PixelMeasuresSequence', 'SpacingBetweenSlices', .9))
whole = open('binary_explicit.dcm', 'rb').read()
for name, length in ('cut_meta', 200), ('cut_early', 900), ('cut_late', len(whole) - 20):
    open(name + '.dcm', 'wb').write(whole[:length])
packed = open('binary_deflated.dcm', 'rb').read()
open('jpeg.dcm', 'wb').write(packed.replace(b'1.2.840.10008.1.2.1.99', b'1.2.840.10008.1.2.4.80'))
open('unknown.dcm', 'wb').write(packed.replace(b'1.2.840.10008.1.2.1.99', b'1.2.840.10008.1.2.9.99'))
open('cut_deflated.dcm', 'wb').write(packed[:len(packed) - 100])
at = whole.index(b'\x10\x00\x10\x00PN')
open('no_such_type.dcm', 'wb').write(whole[:at + 4] + b'\x1b[' + whole[at + 6:])
PYTHON
"$python" -W ignore bad.py 2>python.txt || { cat python.txt >&2; fail "pydicom cannot write the bad files"; }
while read -r file pattern; do
    expect 65 "$file.dcm: $pattern" "$SEGCAST" info "$file.dcm"
    one_error
    ! grep -qiE $'secret|\x1b' stderr.txt || fail "$file.dcm: the message tells what it should not"
done <<'TABLE'
more_frames promises 999 frames of 19 x 23 pixels, which take [0-9]+ bytes, but has [0-9]+; the file is cut short
fewer_frames promises 3 frames \(NumberOfFrames\), but describes 9
no_frames has 0 frames of 19 x 23 pixels
huge promises 9 frames of 65535 x 65535 pixels, which take [0-9]+ bytes, but has
no_rows has 9 frames of 19 x 0 pixels
no_pixels promises 9 frames of 19 x 23 pixels, which take [0-9]+ bytes, but has 0
no_segments names no segments \(SegmentSequence\)
no_spacing frame 1 has no spacing of pixels \(PixelSpacing, two numbers\), expected one for each frame or for all
no_orientation frame 1 has no orientation
no_position frame 1 has no position \(ImagePositionPatient, three numbers\)
no_segment frame 1 has no segment \(ReferencedSegmentNumber, from 1 to 65535\)
other_segment frame 1 shows segment 77, which is none of the 3 segments of the file
same_numbers two segments have the number 1
type is of the type ".*X" \(SegmentationType\) with 1 bits for each pixel, expected BINARY with 1
zero_spacing frame 1: PixelSpacing is 0 and 1 mm, expected more than 0
long_direction frame 1: ImageOrientationPatient has a direction of length 2, expected 1
parallel frame 1: the directions of ImageOrientationPatient are not at right angles
irregular frame [0-9]+ lies 0.[0-9]+ slices and [0-9.e-]+ pixels beside where slices at equal distances
shifted frame 1 lies [0-9.e-]+ slices and 6 pixels beside where
tiled_sparse is a segmentation of a slide, in tiles \(TILED_FULL or TILED_SPARSE\), which has one slice
tiled_full is a segmentation of a slide, in tiles
twice frames [0-9]+ and [0-9]+ show the same segment in one slice
turned frame 3 has another orientation than frame 1
deep attribute \(0062,0002\): sequences are nested deeper than 16 levels
far measures 1e\+07 mm from corner to corner
jpeg has the transfer syntax 1.2.840.10008.1.2.4.80 \(JPEG-LS\), expected one without compression, RLE or deflated; convert it, .*gdcmconv --raw
unknown has the transfer syntax 1.2.840.10008.1.2.9.99, which is not known, expected
cut_meta (the first group of its attributes cannot be read|does not name its transfer syntax)
cut_early byte [0-9]+ of its data set, attribute \([0-9a-f]{4},[0-9a-f]{4}\): .*damaged or cut short
cut_late byte [0-9]+ of its data set, attribute \(7fe0,0010\): promises more bytes than the file has
cut_deflated (byte [0-9]+ of its data set|its deflated data set cannot be unpacked)
no_such_type byte [0-9]+ of its data set, attribute \(0010,0010\): has no type that DICOM knows
TABLE
expect 0 'nearly.dcm: its slices do not lie at equal distances: frame [0-9]+ is off by 0.04 slices' "$SEGCAST" info nearly.dcm
expect 0 'wrong_distance.dcm: its slices lie 1.25 mm apart, not 0.9 mm as it says' "$SEGCAST" info wrong_distance.dcm
"$SEGCAST" --version | grep -q '^volumes .*DICOM SEG' || fail "segcast --version does not say that DICOM is read"
