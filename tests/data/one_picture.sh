# SPDX-License-Identifier: BSD-3-Clause
# The same object, written by each program that is here in each format and in several orders and directions of its axes,
# gives one picture, but for pixels at edges: that of a NRRD file in RAS. Formats that do not say where left is have their
# axes as right, front, head.
find_python 'numpy, nibabel' python3-nibabel
cat >make.py <<'PYTHON'
import itertools, os, numpy, nibabel
x, y, z = numpy.mgrid[:40, :34, :28].astype(float)
labels = numpy.zeros(x.shape, numpy.uint8)
labels[((x - 19) / 16) ** 2 + ((y - 16) / 13) ** 2 + ((z - 13) / 11) ** 2 < 1] = 1
labels[(x > 22) & (y > 18) & (z > 9) & (labels == 1)] = 2
labels[4:12, 14:20, 19:26] = 3
spacing = numpy.array([1, 1.25, 1.5])
ras = numpy.diag([*spacing, 1])
ras[:3, 3] = -20.02, -21.02, -20.02 # so that no middle is half a tenth of a mm, which is written
def nrrd(name, axes):
    rows = ' '.join('(%s)' % ','.join('%.9g' % v for v in axes[:3, i]) for i in range(3))
    head = 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: %d %d %d\nspace: right-anterior-superior\nspace directions: %s\n' \
        'space origin: (%s)\nencoding: raw\n\n' % (*labels.shape, rows, ','.join('%.9g' % v for v in axes[:3, 3]))
    open(name, 'wb').write(head.encode() + labels.tobytes(order='F'))
nrrd('ras.nrrd', ras)
image = nibabel.Nifti1Image(labels, ras)
count = 0
for order in itertools.permutations(range(3)):
    for flips in itertools.product((1, -1), repeat=3):
        count += 1
        if count % 5: # ten of them, of every permutation one at least
            continue
        turned = image.as_reoriented([[a, f] for a, f in zip(order, flips)])
        data, to_ras = numpy.asarray(turned.dataobj), turned.affine
        nibabel.save(nibabel.Nifti1Image(data, to_ras), 'one_%d.nii.gz' % count)
        nibabel.save(nibabel.MGHImage(data.astype(numpy.int32), to_ras), 'mgh_%d.mgz' % count)
        only_q = nibabel.Nifti2Image(data, to_ras)
        only_q.set_sform(None, 0)
        only_q.set_qform(to_ras, 1)
        nibabel.save(only_q, 'two_%d.nii' % count)
nibabel.save(nibabel.Nifti1Pair(labels, ras), 'pair.img')
os.mkdir('masks')
for value in 1, 2, 3:
    nibabel.save(nibabel.Nifti1Image((labels == value).astype(numpy.uint8), ras), 'masks/%d.nii.gz' % value)
numpy.ascontiguousarray(labels.T).tofile('xyz.raw')
zyx = numpy.ascontiguousarray(labels.T)
def tiff():
    import tifffile
    tifffile.imwrite('tiff.ome.tif', zyx, metadata=dict(axes='ZYX', PhysicalSizeX=1000, PhysicalSizeY=1250, PhysicalSizeZ=1500))
def zarr():
    import zarr
    group = zarr.open_group('store.zarr', mode='w')
    group.create_dataset('0', data=zyx, chunks=(10, 20, 15), dimension_separator='/')
    group.attrs['image-label'] = {'version': '0.4'}
    group.attrs['multiscales'] = [dict(version='0.4', axes=[dict(name=a, type='space', unit='millimeter') for a in 'zyx'],
        datasets=[dict(path='0', coordinateTransformations=[dict(type='scale', scale=[1.5, 1.25, 1])])])]
def hdf5():
    import h5py
    with h5py.File('file.h5', 'w') as f:
        f.create_dataset('labels', data=zyx, chunks=(7, 20, 40), compression='gzip').attrs['element_size_um'] = 1500, 1250, 1000
for write in tiff, zarr, hdf5:
    try:
        write()
    except ImportError as missing:
        print(missing)
PYTHON
"$python" make.py >missing.txt 2>python.txt || { cat python.txt >&2; fail "the volumes cannot be written"; }
cat missing.txt
least=30 # volumes that are compared
if [ -n "$ITK_FILES" ]; then
    "$ITK_FILES" xyz.raw 40 34 28 1 1.25 1.5 -20.02 -21.02 -20.02 itk.nrrd itk_packed_turned.nhdr itk_packed.mha \
        itk_meta_turned.mhd itk_packed_turned.nii.gz itk.nii itk_turned.img itk.h5 itk_packed_turned.h5 >python.txt 2>&1 ||
        { cat python.txt >&2; fail "ITK cannot write the volumes"; }
    least=36 # two of its files are HDF5, which segcast may be built without
else
    echo "ITK is not installed (Debian: libinsighttoolkit5-dev): its volumes are not compared"
fi
# Teem's own program; a pair of NIfTI whose voxels are named is in the list below.
if command -v teem-unu >/dev/null; then
    teem-unu save -f nrrd -e hex -i ras.nrrd -o unu_hex.nhdr
    teem-unu save -f nrrd -e bz2 -i ras.nrrd -o unu_bz2.nrrd
    teem-unu permute -p 2 0 1 -i ras.nrrd | teem-unu flip -a 1 -o unu_turned.nrrd
    teem-unu flip -a 0 -i ras.nrrd | teem-unu convert -t ushort | teem-unu save -f nrrd -e raw -en big -o unu_flipped.nrrd
    least=$((least + 4))
else
    echo "Teem's unu is not installed (Debian: teem-apps): its volumes are not compared"
fi
printf 'value,name,color,opacity\n1,a,#c86450,0.6\n2,b,#5078c8,1\n3,c,#50c864,1\n' >table.csv
"$SEGCAST" still ras.nrrd --sheet slices --labels table.csv -o ras.png --size 320x240 --smooth 1 -q >/dev/null
sed 's/^space origin.*/space origin: (0,0,0)/' ras.nrrd >zero.nrrd
sed '/^space: /d; /^space origin/d; s/^space directions.*/spacings: 1 1.25 1.5/' ras.nrrd >plain.nrrd
for name in zero plain; do
    "$SEGCAST" still $name.nrrd --sheet slices --labels table.csv -o $name.png --size 320x240 --smooth 1 -q >/dev/null 2>&1
done
pictures=0
for volume in one_*.nii.gz two_*.nii mgh_*.mgz pair.hdr pair.img unu*.n* masks tiff.ome.tif store.zarr file.h5 xyz.raw itk*.nrrd itk*.nhdr itk*.mha \
    itk*.mhd itk*.nii itk*.nii.gz itk*.hdr itk*.h5; do
    [ -e "$volume" ] || continue
    options=()
    [ "$volume" != xyz.raw ] || options=(--header 'uint8 40x34x28 1x1.25x1.5 mm RAS')
    case $volume in # some do not say where left is, or where the origin is, so that other letters and positions are written
    tiff* | store* | file*) reference=plain.png ;;
    xyz.raw) reference=zero.png ;;
    *) reference=ras.png ;;
    esac
    if ! "$SEGCAST" still "$volume" --sheet slices "${options[@]}" --labels table.csv -o one.png --overwrite --size 320x240 --smooth 1 \
        -q >/dev/null 2>stderr.txt; then
        grep -q 'built without' stderr.txt && continue
        cat stderr.txt >&2
        fail "$volume cannot be drawn"
    fi
    "$IMAGE_DIFFERENCE" $reference one.png 80 0.5 >difference.txt || fail "$volume gives another picture: $(cat difference.txt)"
    pictures=$((pictures + 1))
done
[ $pictures -ge $least ] || fail "only $pictures volumes were compared"
# The comparison would see a volume that is mirrored.
sed 's/^space: .*/space: left-anterior-superior/' ras.nrrd >mirrored.nrrd
"$SEGCAST" still mirrored.nrrd --sheet slices --labels table.csv -o mirrored.png --size 320x240 --smooth 1 -q >/dev/null
! "$IMAGE_DIFFERENCE" ras.png mirrored.png 80 0.5 >/dev/null || fail "a mirrored object gives the same picture"
