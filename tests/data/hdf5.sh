# SPDX-License-Identifier: BSD-3-Clause
# Volumes in HDF5, written by h5py: datasets of all types of integers and storage are read with the labels and geometry
# that were put there; what is damaged, or crashes the library, is refused with one message.
"$SEGCAST" --version | grep -q '^volumes .*HDF5' || skip "segcast was built without libhdf5"
find_python 'h5py, numpy' python3-h5py
cat >make.py <<'PYTHON'
import h5py, numpy
shape = 7, 50, 60 # z, y, x
labels = numpy.zeros(shape, numpy.int64)
labels[2:5, 10:40, 10:30] = 17
labels[2:5, 10:40, 31:50] = 100
labels[5:7, 45:50, 55:60] = 3
um = 1250., 500., 500.

def volume(name, data=labels, path='labels', **options):
    with h5py.File(name + '.h5', 'w', userblock_size=options.pop('block', 0)) as f:
        attributes = options.pop('attributes', dict(element_size_um=um))
        d = f.create_dataset(path, data=data, **options)
        for key, value in attributes.items():
            d.attrs[key] = value

for kind in 'u1', 'i1', '<u2', '>u2', '<i4', '>u4', '<u8', '>i8', '<f4', '>f8':
    volume('type_' + kind.replace('<', 'l').replace('>', 'b'), labels.astype(kind))
import os
os.mkdir('masks')
for name, value in ('left', 17), ('right', 100):
    volume('masks/' + name, (labels == value).astype('u1'))
odd = h5py.h5t.STD_I32BE.copy() # 3 bytes
odd.set_precision(24)
odd.set_size(3)
with h5py.File('odd.h5', 'w') as f:
    space = h5py.h5s.create_simple(shape)
    d = h5py.Dataset(h5py.h5d.create(f.id, b'labels', odd, space))
    d.id.write(h5py.h5s.ALL, h5py.h5s.ALL, labels.astype('i4'))
    d.attrs['element_size_um'] = um
volume('chunks', labels.astype('u2'), chunks=(3, 16, 16))
volume('gzip', labels.astype('u2'), chunks=(2, 20, 7), compression='gzip', shuffle=True, fletcher32=True)
volume('tall', labels.astype('u1'), chunks=(7, 5, 60), compression='gzip')
volume('scaled', labels.astype('i4'), chunks=True, scaleoffset=0)
if h5py.h5z.filter_avail(h5py.h5z.FILTER_SZIP):
    volume('szip', labels.astype('u2'), chunks=(2, 20, 8), compression='szip')
volume('first', labels[None], attributes=dict(element_size_um=um))
volume('last', labels[None, :, :, :, None])
volume('block', block=1024)
volume('with:colon', labels)
volume('deep', path='a/b/labels')
volume('plain', attributes={})
header = ('NRRD0004\ntype: int64\ndimension: 3\nsizes: 60 50 7\nspace: 3D-right-handed\nendian: little\n'
          'space directions: (0.5,0,0) (0,0.5,0) (0,0,1.25)\nspace origin: (0,0,0)\nencoding: raw\n\n').encode()
open('same.nrrd', 'wb').write(header + labels.astype('<i8').tobytes())

with h5py.File('many.h5', 'w') as f:
    f['labels'] = labels
    f['mask'] = labels > 0
    f['other/labels'] = labels
    f['other/values'] = labels / 10.
    f['table'] = numpy.arange(10)
    f['soft'] = h5py.SoftLink('/other/labels')
    f['group'] = h5py.SoftLink('/other')
    f['loop'] = h5py.SoftLink('/loop')
    f['nowhere'] = h5py.SoftLink('/none')
    f['escape \x1b[31m'] = labels
    f['out'] = h5py.ExternalLink('gzip.h5', '/labels')
    f['through'] = h5py.SoftLink('/out')
    f['flat'] = labels[0]
    f['four'] = numpy.zeros((2, 3, 4, 5), 'u1')
    f['text'] = 'a text'
    f['negative'] = labels - 5
    f['record'] = numpy.zeros((3, 3, 3), [('a', 'i4'), ('b', 'f4')])
    f.create_dataset('empty', (0, 3, 3), 'u1', maxshape=(None, 3, 3), chunks=(1, 3, 3))
    f.create_dataset('huge', (40000, 40000, 40000), 'u1', chunks=(64, 64, 64))
    f.create_dataset('large', (4000, 4000, 4000), 'u1', chunks=(64, 64, 64))
    f.create_dataset('elsewhere', (7, 50, 60), 'u1', external=[('same.nrrd', 0, 21000)])
    layout = h5py.VirtualLayout(shape, 'i8')
    layout[...] = h5py.VirtualSource('plain.h5', 'labels', shape)
    f.create_virtual_dataset('virtual', layout)
    for name in 'fractions', 'spacing':
        f[name] = labels
    f['fractions'][3, 20, 20] = 17
    f['values'] = labels + .5
    f['spacing'].attrs['element_size_um'] = [0., 1, 1]
for name in 'gzip', 'lzf':
    data = labels.astype('u4')
    data[1, :, :] = numpy.random.RandomState(1).randint(0, 2, data[1].shape) * 17 # also literal bytes
    volume('noise_' + name, data, compression=name, shuffle=name == 'gzip', chunks=(3, 50, 16))

# Layouts of programs. ITK: LPS, a row of the directions for each axis, x first.
turn = numpy.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], float)
with h5py.File('itk.h5', 'w') as f:
    g = f.create_group('ITKImage/0')
    g['VoxelData'] = labels.astype('u2')
    g['Spacing'], g['Origin'], g['Directions'] = [.5, .5, 1.25], [1., 2, 3], turn
    g['Dimension'], g['VoxelType'] = numpy.array([60, 50, 7], 'u8'), 'USHORT'
    f['other'] = labels
def nrrd(name, columns, origin, data=labels):
    vectors = ' '.join('(%g,%g,%g)' % tuple(c) for c in columns)
    open(name, 'wb').write(('NRRD0004\ntype: int64\ndimension: 3\nsizes: %d %d %d\nspace: right-anterior-superior\nendian: little\nspace directions: %s\n'
                            'space origin: (%g,%g,%g)\nencoding: raw\n\n' % (data.shape[::-1] + (vectors,) + tuple(origin))).encode() + data.astype('<i8').tobytes())
lps = numpy.diag([-1, -1, 1])
nrrd('itk.nrrd', [lps @ (turn[i] * s) for i, s in enumerate((.5, .5, 1.25))], lps @ [1, 2, 3])

# MINC 2: x is the slowest axis here, y goes backwards, and the numbers are scaled.
data = labels.transpose(2, 0, 1) # x, z, y
with h5py.File('minc.mnc', 'w') as f:
    image = f.create_dataset('minc-2.0/image/0/image', data=(data + 10).astype('u2'), chunks=True, compression='gzip')
    image.attrs['dimorder'] = numpy.string_('xspace,zspace,yspace')
    image.attrs['valid_range'] = [0., 200]
    f['minc-2.0/image/0/image-min'], f['minc-2.0/image/0/image-max'] = numpy.full((60, 7), -10.), numpy.full((60, 7), 190.)
    f['minc-2.0/image/1/image'] = labels[::2, ::2, ::2]
    for name, start, step, cosines in ('x', -9, .5, [.8, .6, 0]), ('y', 5, -.5, [-.6, .8, 0]), ('z', 7, 1.25, None):
        d = f.create_dataset('minc-2.0/dimensions/%sspace' % name, data=0)
        d.attrs['start'], d.attrs['step'] = float(start), step
        if cosines:
            d.attrs['direction_cosines'] = cosines
x, y, z = numpy.array([.8, .6, 0]), numpy.array([-.6, .8, 0]), numpy.array([0, 0, 1])
nrrd('minc.nrrd', [y * -.5, z * 1.25, x * .5], x * -9 + y * 5 + z * 7, data)
with h5py.File('minc.mnc', 'r') as old:
    for name in 'minc_scales', 'minc_order':
        with h5py.File(name + '.mnc', 'w') as f:
            old.copy('minc-2.0', f)
            if name == 'minc_scales':
                f['minc-2.0/image/0/image-max'][30, 2] = 180
            else:
                f['minc-2.0/image/0/image'].attrs['dimorder'] = numpy.string_('xspace,zspace,\x1b[31m')

# ilastik: the axes by name. CREMI: nanometres.
tags = '{"axes": [%s]}' % ', '.join('{"key": "%s", "typeFlags": 2, "resolution": 0, "description": ""}' % c for c in 'tzyxc')
volume('ilastik', labels[None, :, :, :, None].astype('u4'), 'exported_data', attributes=dict(axistags=tags, element_size_um=um))
volume('xyz', labels.transpose(2, 1, 0), attributes=dict(element_size_um=um, axistags='{"axes": [{"key": "x"}, {"key": "y"}, {"key":\n"z"}]}'))
nrrd('xyz.nrrd', [(0, 0, 1.25), (0, .5, 0), (.5, 0, 0)], (0, 0, 0), labels.transpose(2, 1, 0))
volume('cremi', path='volumes/labels/neuron_ids', attributes=dict(resolution=[1250e3, 500e3, 500e3], offset=[40e6, 0, 1e6]))
nrrd('cremi.nrrd', [(.5, 0, 0), (0, .5, 0), (0, 0, 1.25)], (1, 0, 40))
open('text.h5', 'w').write('no HDF5\n')
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "the volumes cannot be written"; }

# A directory of masks.
"$SEGCAST" info masks --json -q >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "masks in HDF5 cannot be read"; }
jq -e '[.labels[1:][] | [.name, .voxels]] == [["left", 1800], ["right", 1710]] and .size == [60, 50, 7]' info.json >/dev/null ||
    fail "masks in HDF5: $(jq -c '[.size, [.labels[] | [.name, .voxels]]]' info.json)"


# read_volume PATH [SPACING]: its size, geometry and labels are those of make.py; the spacing is that of the file, or 1.
read_volume() {
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e '[.labels[1:][] | [.value, .voxels]] == [[3, 50], [17, 1800], [100, 1710]]' info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.labels[] | [.value, .voxels]]' info.json)"
    jq -e --argjson spacing "${2:-[0.5, 0.5, 1.25]}" '.size == [60, 50, 7] and ([.to_ras_mm[0][0], .to_ras_mm[1][1], .to_ras_mm[2][2]] | map(. * 1e6 | round / 1e6)) == $spacing' info.json >/dev/null ||
        fail "$1: geometry $(jq -c '[.size, .to_ras_mm]' info.json)"
}
for path in type_* odd.h5 chunks.h5 gzip.h5 tall.h5 scaled.h5 block.h5 with:colon.h5 first.h5 last.h5; do read_volume "$path"; done
[ ! -e szip.h5 ] || read_volume szip.h5
read_volume plain.h5 '[1, 1, 1]'
grep -q 'plain.h5: nothing gives the spacing of its voxels (the attribute element_size_um does' stderr.txt || fail "no warning of the spacing"
read_volume deep.h5
grep -q 'deep.h5: its dataset /a/b/labels is read, the only one that may be a volume' stderr.txt || fail "nobody is told which dataset is read"
for path in :/a/b/labels :a/b/labels :/a/b :/a/b/; do read_volume "deep.h5$path"; done
for path in labels other soft group other/labels; do read_volume "many.h5:/$path" '[1, 1, 1]'; done
read_volume with:colon.h5:/labels
"$SEGCAST" info many.h5:/mask --json 2>stderr.txt | jq -e '[.labels[1:][] | [.value, .voxels]] == [[1, 3560]]' >/dev/null || fail "a mask of h5py's type bool: $(cat stderr.txt)"

# A part, and pictures: as of the same voxels in NRRD, whatever the threads; also of a job in another directory.
tell='[.size, .to_ras_mm, [.labels[1:][] | [.value, .voxels]]]'
for box in '[[10, 31], [0, 50], [0, 7]]' '[[13, 14], [17, 33], [2, 3]]' '[[25, 60], [16, 50], [3, 7]]'; do
    wanted=$("$SEGCAST" info same.nrrd --set "volume={box: $box}" --json 2>/dev/null | jq -c "$tell")
    for path in gzip tall type_bu2; do
        found=$("$SEGCAST" info "$path.h5:/labels" --set "volume={box: $box}" --json 2>/dev/null | jq -c "$tell")
        [ "$found" = "$wanted" ] || fail "$path, $box: $found, expected $wanted"
    done
done
small_job job.yaml
sed -i 's|^volume.*|volume: same.nrrd|; s|^  "\*".*|  17: {opacity: 0.5}|; s|except: .*|except: [3]}|' job.yaml
mkdir sub
sed 's|^volume.*|volume: ../gzip.h5:/labels|' job.yaml >sub/job.yaml
for job in job.yaml sub/job.yaml; do
    for threads in 1 3; do
        "$SEGCAST" still "$job" --frame 2 -o "${job%.yaml}.$threads.png" --threads "$threads" -q 2>stderr.txt || { cat stderr.txt >&2; fail "$job cannot be drawn"; }
        cmp job.1.png "${job%.yaml}.$threads.png" || fail "the picture of $job with $threads threads is not that of NRRD"
    done
done
mkdir elsewhere
"$SEGCAST" init gzip.h5:/labels -o elsewhere/gzip.yaml -q 2>stderr.txt || { cat stderr.txt >&2; fail "init"; }
grep -q "^volume: .*$PWD/gzip.h5:/labels" elsewhere/gzip.yaml || fail "init: $(grep ^volume elsewhere/gzip.yaml)"
expect 0 '' "$SEGCAST" check elsewhere/gzip.yaml
expect 64 'is a volume: `segcast orbit gzip.h5:/labels` makes a video' "$SEGCAST" render gzip.h5:/labels
expect 66 'volume=gone.h5:/labels: gone.h5:/labels: No such file' "$SEGCAST" check sub/job.yaml --set volume=gone.h5:/labels

# Layouts of programs: size, geometry and labels as in NRRD.
read_volume ilastik.h5
for pair in itk.h5:itk minc.mnc:minc xyz.h5:xyz cremi.h5:cremi noise_lzf.h5:noise_gzip.h5; do
    other=${pair#*:}
    [ "${other%.h5}" != "$other" ] || other=$other.nrrd
    for volume in "${pair%%:*}" "$other"; do
        "$SEGCAST" info "$volume" --json >"$volume.json" 2>stderr.txt || { cat stderr.txt >&2; fail "$volume cannot be read"; }
        jq -c '[.size, ([.to_ras_mm[][] | . * 1e6 | round + 0]), [.labels[] | [.value, .voxels, .boundary_voxels]]]' "$volume.json" >"$volume.txt"
    done
    cmp "${pair%%:*}.txt" "$other.txt" || fail "$pair: $(cat "${pair%%:*}.txt" "$other.txt")"
done
"$SEGCAST" info itk.h5 2>&1 | grep -q 'left and front' && fail "itk.h5: its orientation is not known"
expect 0 'itk.h5:/other: nothing gives the spacing' "$SEGCAST" info itk.h5:/other

# What cannot be read is refused, with one message that names dataset and reason.
truncate -s 3000 gzip.h5
mkfifo pipe.h5
while read -r code volume pattern; do
    expect "$code" "$volume: $pattern" "$SEGCAST" info "$volume"
    one_error
    ! grep -q $'\x1b' stderr.txt || fail "$volume: an escape code is printed"
done <<'TABLE'
66 many.h5 holds 12 volumes: /elsewhere, /empty, /escape .x1b.31m, .*, [.][.][.]; say behind the file which one is wanted: FILE:/elsewhere
66 many.h5:/none holds no /none; `segcast info FILE` names what it holds
65 many.h5:/nowhere /nowhere is a link to what is not there, to itself or to another file
65 many.h5:/loop /loop is a link to what is not there
65 many.h5:/through /through is a link to what is not there, to itself or to another file
65 many.h5:/out /out leads to another file .an external link., which is not read
65 many.h5:/out/labels /out/labels leads to another file
65 many.h5:/flat the dataset /flat holds 50 x 60 .integers of 8 bytes., expected integers along z, y and x
65 many.h5:/four the dataset /four holds 2 x 3 x 4 x 5
65 many.h5:/text the dataset /text holds no array .texts of 8 bytes.
65 many.h5:/record the dataset /record holds 3 x 3 x 3 .records of 8 bytes.
65 many.h5:/empty size 0 along axis 2, expected 1 to 2147483647
65 many.h5:/huge 40000 x 40000 x 40000 voxels are more than 1 TiB
71 many.h5:/large 4000 x 4000 x 4000 voxels take about 238 GiB of memory
65 many.h5:/elsewhere the dataset /elsewhere has its voxels in other files .external storage., which are not read
65 many.h5:/virtual the dataset /virtual has its voxels in other files .a virtual dataset., which are not read
65 many.h5:/values voxel .0, 0, 0. holds 0.5, a fraction
65 many.h5:/spacing its voxels measure 0 to 0.001 mm
66 text.h5:/labels its file is no HDF5, in which volumes have paths
66 gone.h5:/labels No such file or directory
66 pipe.h5:/labels No such file or directory
65 gzip.h5 cannot be opened as HDF5: .*; the file is damaged or cut short
65 minc.mnc:/minc-2.0/image/1/image /minc-2.0/image/1/image is a coarser copy .MINC.
65 minc_scales.mnc slice [0-9]* has another scale than slice 0 .MINC, image-max.
65 minc_order.mnc its dimension 2 is ".x1b.31m" .MINC, dimorder., expected xspace, yspace or zspace
TABLE
"$python" -c 'import h5py, subprocess, sys
with h5py.File("plain.h5", "r+"):
    sys.exit(subprocess.run(sys.argv[1:]).returncode)' "$SEGCAST" info plain.h5 >stdout.txt 2>stderr.txt || code=$?
grep -q 'plain.h5: another program has it open for writing; run again' stderr.txt || fail "a file that is written: $(cat stderr.txt)"
expect 65 'level: .*/many.h5:/labels has one resolution' "$SEGCAST" info many.h5:/labels --set volume.level=1
