# SPDX-License-Identifier: BSD-3-Clause
# Files that nibabel writes here are read with the geometry, labels, names and colours that it has put there.
find_python 'nibabel' python3-nibabel
cat >make.py <<'PYTHON'
import os, nibabel, numpy
from nibabel import gifti
labels = numpy.zeros((6, 5, 4), numpy.int16)
labels[1:3, 1:4, 1:3] = 17
labels[3:5, 1:4, 1:3] = 53
affine = numpy.array([[0, 0, 2, -7.5], [-1, 0, 0, 4], [0, -1.5, 0, 9], [0, 0, 0, 1]])
table = '<CaretExtension><VolumeInformation Index="0"><LabelTable>%s</LabelTable></VolumeInformation></CaretExtension>' % ''.join(
    '<Label Key="%d" Red="%g" Green="%g" Blue="0" Alpha="1"><![CDATA[%s]]></Label>' % row
    for row in ((17, 1, .5, 'Left-Hippocampus'), (53, 0, 1, 'Right-Hippocampus')))
for name, kind in (('one.nii.gz', nibabel.Nifti1Image), ('two.nii', nibabel.Nifti2Image)):
    image = kind(labels, affine)
    image.header.extensions.append(nibabel.nifti1.Nifti1Extension(0, table.encode()))
    nibabel.save(image, name)
plain = nibabel.Nifti1Image(labels, affine)
nibabel.save(plain, 'plain.nii')
big = nibabel.Nifti1Image(labels, affine, nibabel.Nifti1Header(endianness='>'))
big.header.extensions.append(nibabel.nifti1.Nifti1Extension(30, table.encode()))
nibabel.save(big, 'big.nii')
for name, kind in (('int16.mgz', numpy.int16), ('uint8.mgh', numpy.uint8), ('int32.mgz', numpy.int32), ('float.mgz', numpy.float32)):
    nibabel.save(nibabel.MGHImage(labels.astype(kind), affine), name)
for folder in 'masks', 'shifted':
    os.mkdir(folder)
    for value, name in ((17, 'hippocampus_left'), (53, 'hippocampus_right')):
        nibabel.save(nibabel.Nifti1Image((labels == value).astype(numpy.uint8), affine), folder + '/' + name + '.nii.gz')
nibabel.save(nibabel.Nifti1Image((labels > 0).astype(numpy.uint8), affine), 'masks/brain.nii.gz')
os.mkdir('pairs')
for value, name in ((17, 'hippocampus_left'), (53, 'hippocampus_right')):
    nibabel.save(nibabel.Nifti1Pair((labels == value).astype(numpy.uint8), affine), 'pairs/' + name + '.hdr')
# The boxes of tissues in a grid: the first, a turned one beside it, and one before both.
os.mkdir('cropped')
def crop(name, values, low, turn=False):
    a = affine.copy()
    a[:3, 3] += affine[:3, :3] @ low
    if turn:
        values = values.transpose(2, 1, 0)[:, ::-1]
        a = numpy.stack([a[:, 2], -a[:, 1], a[:, 0], a[:, 3] + a[:, 1] * (values.shape[1] - 1)], 1)
    nibabel.save(nibabel.Nifti1Image(numpy.ascontiguousarray(values).astype(numpy.uint8), a), 'cropped/' + name + '.nii.gz')
crop('hippocampus_left', (labels == 17)[1:3, 1:4, 1:3], (1, 1, 1))
crop('hippocampus_right', (labels == 53)[2:6, :5, :], (2, 0, 0), True)
crop('zero', labels[:1, :1, :1] == 0, (-2, 0, -1))
# Soft masks: shares of one, and levels up to 255.
os.mkdir('soft')
share = numpy.array([0, .2, .5, .7, 1, .4])[:, None, None] * numpy.ones((6, 5, 4))
nibabel.save(nibabel.Nifti1Image(share.astype(numpy.float32), affine), 'soft/tract.nii.gz')
nibabel.save(nibabel.Nifti1Image((share[::-1] * 250 * (numpy.arange(4) == 0)).astype(numpy.uint8), affine), 'soft/lobe.nii.gz')
# A mask for each tissue along the fourth axis, without a time between them.
nibabel.save(nibabel.Nifti1Image(numpy.stack([labels == v for v in (0, 17, 53)], -1).astype(numpy.uint8), affine), 'onehot.nii.gz')
affine[0, 3] += 1
nibabel.save(nibabel.Nifti1Image((labels > 0).astype(numpy.uint8), affine), 'shifted/z.nii.gz')
affine[0, 3] -= 1
names = gifti.GiftiLabelTable()
for key, name, color in ((0, '???', (1, 1, 1, 0)), (17, 'Left-Hippocampus', (1, .5, 0, 1)), (53, 'Right-Hippocampus', (0, 1, 0, 1))):
    label = gifti.GiftiLabel(key, *color)
    label.label = name
    names.labels.append(label)
array = gifti.GiftiDataArray(numpy.zeros(3, numpy.int32), 'NIFTI_INTENT_LABEL')
nibabel.save(gifti.GiftiImage(darrays=[array], labeltable=names), 'names.label.gii')
# A ball with a smaller one in it, on a plain grid and on one whose slices are shifted against each other, as CT with a
# tilted gantry stores them.
for name, tilt in (('straight', 0), ('tilted', numpy.tan(numpy.radians(20)))):
    affine = numpy.array([[1, 0, 0, -24], [0, 1, 1.5 * tilt, -33 - tilt * 24], [0, 0, 1.5, -24], [0, 0, 0, 1]])
    i = numpy.stack(numpy.meshgrid(*[numpy.arange(n) for n in (49, 67, 33)], indexing='ij'), -1)
    mm = i @ affine[:3, :3].T + affine[:3, 3]
    ball = (mm ** 2).sum(-1) < 400
    nibabel.save(nibabel.Nifti1Image((1 * ball + (((mm - (8, 0, 5)) ** 2).sum(-1) < 36)).astype(numpy.uint8), affine), name + '.nii')
PYTHON
"$python" make.py || fail "nibabel cannot write the files"

# read_file FILE [OPTION...]: its labels and geometry are those of make.py.
read_file() {
    "$SEGCAST" info "$@" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e '[.labels[1:][] | [.value, .name, .color]] == [[17, "Left-Hippocampus", [255, 128, 0]], [53, "Right-Hippocampus", [0, 255, 0]]]' \
        info.json >/dev/null || fail "$1: labels $(jq -c '[.labels[] | [.value, .name, .color]]' info.json)"
    jq -e '.axes == "PIR" and (.labels[1].voxels == 12)' info.json >/dev/null || fail "$1: axes $(jq -c .axes info.json)"
}
"$SEGCAST" info one.nii.gz >stdout.txt 2>stderr.txt || fail "one.nii.gz cannot be read"
if grep -q 'built without Expat' stderr.txt; then
    skip "segcast was built without Expat"
fi
read_file one.nii.gz
read_file two.nii
read_file big.nii
read_file plain.nii --labels names.label.gii
matrix=$(jq -c .to_ras_mm info.json)
for file in int16.mgz uint8.mgh int32.mgz float.mgz; do
    read_file "$file" --labels names.label.gii
    [ "$(jq -c .to_ras_mm info.json)" = "$matrix" ] || fail "$file: geometry $(jq -c .to_ras_mm info.json), expected $matrix"
done

# A directory of masks in pairs of files.
"$SEGCAST" info pairs --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "pairs cannot be read"; }
jq -e '[.labels[1:][] | [.name, .voxels]] == [["hippocampus_left", 12], ["hippocampus_right", 12]]' info.json >/dev/null ||
    fail "pairs: $(jq -c '[.labels[] | [.name, .voxels]]' info.json)"

# Masks of the boxes around tissues: the same voxels at the same places, whatever their axes.
expect 0 '3 of 3 masks have a part of the grid; together they have 8 x 5 x 5 voxels' "$SEGCAST" info cropped
while read -r label box; do
    "$SEGCAST" info cropped --set "volume={box: $box}" --json -q >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "cropped, box $box"; }
    jq -e --arg tissue "$label" '[.labels[] | select(.voxels == 12).name] == [$tissue]' info.json >/dev/null ||
        fail "cropped, box $box: $(jq -c '[.labels[] | [.name, .voxels]]' info.json)"
done <<'TABLE'
hippocampus_left [[3, 5], [1, 4], [2, 4]]
hippocampus_right [[5, 7], [1, 4], [2, 4]]
TABLE
"$SEGCAST" info cropped --json -q | jq -e '.to_ras_mm | map(.[3]) == [-9.5, 6, 9]' >/dev/null || fail "cropped: $("$SEGCAST" info cropped --json -q | jq -c .to_ras_mm)"

# Soft masks count from a stated share of the largest value on; without one they are refused, with advice.
expect 65 'soft/(tract|lobe).nii.gz: .* --set volume.threshold=50%' "$SEGCAST" info soft --threads 1; one_error
while read -r share lobe tract; do
    "$SEGCAST" info soft --set volume.threshold="$share" --json -q >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "soft masks, $share"; }
    jq -e --argjson lobe "$lobe" --argjson tract "$tract" '[.labels[1:][] | [.name, .voxels]] == [["lobe", $lobe], ["tract", $tract]]' info.json >/dev/null ||
        fail "soft masks from $share on: $(jq -c '[.labels[1:][] | [.name, .voxels]]' info.json), expected $lobe and $tract"
done <<'TABLE'
50% 15 50
0% 25 80
100% 5 20
TABLE
expect 0 'onehot.nii.gz: holds 3 volumes, with 0 and 1 alone and no time between them; if each is a tissue' "$SEGCAST" info onehot.nii.gz
expect 65 'threshold is for a directory of soft masks, and .*plain.nii is none' "$SEGCAST" info plain.nii --set volume.threshold=50%; one_error

# What segcast writes as GIFTI, nibabel reads.
"$SEGCAST" convert names.label.gii -o own.label.gii -q >/dev/null || fail "no GIFTI was written"
"$python" -c '
import nibabel
table = nibabel.load("own.label.gii").labeltable
assert [(l.key, l.label, tuple(round(c, 2) for c in l.rgba)) for l in table.labels] == \
    [(17, "Left-Hippocampus", (1, .5, 0, 1)), (53, "Right-Hippocampus", (0, 1, 0, 1))], [(l.key, l.label, l.rgba) for l in table.labels]
' || fail "nibabel does not read the label table that segcast has written"

# A directory of masks, as TotalSegmentator writes it, becomes a film without any further word; the brain
# covers both hippocampi, which are smaller.
"$SEGCAST" info masks --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "the masks cannot be read"; }
jq -e '[.labels[1:][] | [.value, .name, .voxels]] == [[2, "hippocampus_left", 12], [3, "hippocampus_right", 12]]' info.json >/dev/null ||
    fail "masks: $(jq -c '[.labels[] | [.value, .name, .voxels]]' info.json)"
[ "$(jq -c .to_ras_mm info.json)" = "$matrix" ] || fail "masks: geometry $(jq -c .to_ras_mm info.json), expected $matrix"
grep -q '24 voxels belong to several masks; each is shown as the smallest of them (overlap: smaller), most often as "hippocampus_left" and not "brain" (12)' stderr.txt ||
    { cat stderr.txt >&2; fail "the overlap of the masks is not told"; }
"$SEGCAST" orbit masks/ -o film.mp4 --size 64x48 --set animation.frames=2 2>stderr.txt >stdout.txt || { cat stderr.txt >&2; fail "no film of the masks"; }
[ -s film.mp4 ] || fail "no film of the masks was written"
"$SEGCAST" init masks/ -o init.yaml --overlap order -q >stdout.txt || fail "no job can be written for the masks"
grep -q '^overlap: order' init.yaml || fail "init has left out the rule for overlaps"
grep -q 'video: "masks.mp4"' init.yaml || fail "the video has not the name of the directory: $(grep video: init.yaml)"
expect 65 'shifted/z.nii.gz has another voxel size or orientation than .*shifted/hippocampus_left.nii.gz, or voxels between its voxels; expected masks of one grid' \
    "$SEGCAST" info shifted
one_error

# A change of the masks is noticed by --resume.
printf 'volume: masks\noverlap: order\noutput: {directory: out, size: [64, 48], frames: png, video: none}\nanimation: {frames: 2}\n' >job.yaml
"$SEGCAST" render job.yaml -q || fail "the masks cannot be drawn"
"$SEGCAST" render job.yaml -q --resume || fail "the masks cannot be drawn again"
mv masks/brain.nii.gz masks/z.nii.gz # which is the last now, and covers the others
expect 73 'volume' "$SEGCAST" render job.yaml --resume

# Masks that are stored along other axes are turned: the volume is the same, and so is a part of it.
cat >turn.py <<'PYTHON'
import os, nibabel, numpy
affine = numpy.array([[0, 0, 2, -3], [-1.5, 0, 0, 4], [0, 1.2, 0, 5], [0, 0, 0, 1]])
label = numpy.random.default_rng(1).integers(0, 4, (5, 6, 7))
for folder in 'straight_masks', 'turned_masks':
    os.mkdir(folder)
for value, axes in ((1, None), (2, [[0, -1], [1, 1], [2, 1]]), (3, [[2, -1], [0, -1], [1, 1]])):
    image = nibabel.Nifti1Image((label == value).astype(numpy.uint8), affine)
    nibabel.save(image, 'straight_masks/%d.nii.gz' % value)
    nibabel.save(image.as_reoriented(numpy.array(axes)) if axes else image, 'turned_masks/%d.nii.gz' % value)
PYTHON
"$python" turn.py || fail "nibabel cannot turn masks"
for part in 'volume.overlap=smaller' 'volume.box=[[1, 4], [0, 5], [2, 6]]'; do
    for folder in straight turned; do
        "$SEGCAST" convert ${folder}_masks --set "${part/volume.overlap/overlap}" -o $folder.segc --overwrite >/dev/null 2>stderr.txt ||
            { cat stderr.txt >&2; fail "the $folder masks cannot be read"; }
    done
    grep -q 'turned_masks: 2 of 3 masks are stored along other axes than .*turned_masks/1.nii.gz, and turned to them' stderr.txt ||
        { cat stderr.txt >&2; fail "that masks are turned is not told"; }
    cmp straight.segc turned.segc || fail "turned masks give another volume ($part)"
done

# Sheared axes are used as they are: the same ball is seen. Light and form differ by less than the voxels do; with the
# shear left out, it would be an ellipsoid (RMS of the difference: 29).
for name in straight tilted; do
    printf 'volume: %s.nii\noutput: {size: 96x72}\ntissues: {"1": {opacity: 0.4}, "2": {opacity: 1}}\nanimation: {frames: 1, camera: {orbit: {axis: superior, angle: 60}}}\n' \
        $name >$name.yaml
    "$SEGCAST" still $name.yaml -o $name.png -q 2>stderr.txt || { cat stderr.txt >&2; fail "$name.nii cannot be drawn"; }
done
grep -q 'sheared, by up to 20.00 degrees; shown as stored' stderr.txt || "$SEGCAST" info tilted.nii 2>&1 | grep -q 'sheared, by up to 20.00 degrees' ||
    fail 'nothing is said of the shear'
"$IMAGE_DIFFERENCE" straight.png tilted.png 255 8 >difference.txt || fail "the sheared ball looks different: $(cat difference.txt)"
