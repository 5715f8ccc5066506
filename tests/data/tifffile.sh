# SPDX-License-Identifier: BSD-3-Clause
# Stacks that tifffile writes here are read with the labels, geometry and colours that it has put there.
find_python 'tifffile' python3-tifffile
cat >make.py <<'PYTHON'
import os, numpy, tifffile
labels = numpy.zeros((4, 50, 60), numpy.uint16) # z, y, x
labels[1:3, 10:40, 10:30] = 17
labels[1:3, 10:40, 31:50] = 530
palette = numpy.zeros((3, 65536), numpy.uint16)
palette[:, 17] = 65535, 32768, 0
palette[:, 530] = 0, 65535, 0
imagej = dict(imagej=True, resolution=(2, 2), metadata=dict(axes='ZYX', spacing=1.25, unit='um'))
tifffile.imwrite('imagej.tif', labels, **imagej)
tifffile.imwrite('big_end.tif', labels, byteorder='>', **imagej)
ome = dict(ome=True, metadata=dict(axes='ZYX', PhysicalSizeX=500, PhysicalSizeXUnit='nm', PhysicalSizeY=.5, PhysicalSizeZ=1.25))
for name, options in dict(strips=dict(rowsperstrip=7), tiles=dict(tile=(32, 16)), deflate=dict(compression='zlib', predictor=True),
                          bigtiff=dict(bigtiff=True), palette=dict(photometric='palette', colormap=palette)).items():
    tifffile.imwrite('ome_%s.ome.tif' % name, labels, **options, **ome)
for kind in 'int16', 'uint32', 'int32', 'float32', 'float64':
    tifffile.imwrite('ome_%s.tif' % kind, labels.astype(kind), **ome)
tifffile.imwrite('one_page.tif', labels[1])
tifffile.imwrite('plain.tif', labels, photometric='minisblack')
# Stacks whose axis nobody said: channels, or times, of one slice.
tifffile.imwrite('as_channels.tif', labels, imagej=True)
tifffile.imwrite('as_times.tif', labels, imagej=True, metadata=dict(axes='TYX'))
tifffile.imwrite('as_channels.ome.tif', labels, ome=True)
tifffile.imwrite('channels.tif', numpy.stack([labels, labels], 1), imagej=True, metadata=dict(axes='ZCYX'))
tifffile.imwrite('times.ome.tif', numpy.stack([labels, labels]), ome=True, metadata=dict(axes='TZYX'))
tifffile.imwrite('rgb.tif', numpy.zeros((50, 60, 3), numpy.uint8), photometric='rgb')
tifffile.imwrite('rgba\x1b[31m.tif', numpy.zeros((50, 60, 3), numpy.uint8), photometric='rgb')
tifffile.imwrite('fraction.tif', labels.astype('float32') / 2, **ome)
with tifffile.TiffWriter('sizes.tif') as out:
    out.write(labels[0])
    out.write(labels[0, :40])
with tifffile.TiffWriter('pyramid.tif') as out:
    out.write(labels[1], metadata=None)
    out.write(labels[1, ::2, ::2], metadata=None, subfiletype=1)
# An ImageJ file of more than 4 GiB has one page, and the pixels of all slices behind it.
data = open('imagej.tif', 'rb').read()
with tifffile.TiffFile('imagej.tif') as tiff:
    offset = tiff.pages[0].offset
    first = tiff.pages[0].dataoffsets[0]
count = int.from_bytes(data[offset:offset + 2], 'little')
end = offset + 2 + 12 * count
open('long_page.tif', 'wb').write(data[:end] + b'\0\0\0\0' + data[end + 4:])
open('long_page_cut.tif', 'wb').write((data[:end] + b'\0\0\0\0' + data[end + 4:])[:first + 20000])
whole = open('ome_deflate.ome.tif', 'rb').read()
open('cut.tif', 'wb').write(whole[:len(whole) // 2])
with tifffile.TiffFile('ome_deflate.ome.tif') as tiff:
    at = tiff.pages[1].dataoffsets[0]
open('damaged.tif', 'wb').write(whole[:at] + b'\xff' * 10 + whole[at + 10:])
next_page = int.from_bytes(data[end:end + 4], 'little')
again = bytearray(data) # the second page is followed by itself
n = int.from_bytes(data[next_page:next_page + 2], 'little')
at = next_page + 2 + 12 * n
again[at:at + 4] = next_page.to_bytes(4, 'little')
open('circle.tif', 'wb').write(bytes(again))
open('no_page.tif', 'wb').write(b'II*\0\0\0\0\0') # as one that is being written
os.mkdir('masks')
os.mkdir('slices')
for name, value in ('nucleus', 17), ('vacuole', 530):
    tifffile.imwrite('masks/%s.tif' % name, ((labels == value) * 255).astype(numpy.uint8), **imagej)
for z in range(4):
    tifffile.imwrite('slices/slice%d.tif' % (9 + z), labels[z])
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "tifffile cannot write the files"; }
"$SEGCAST" info one_page.tif >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "one_page.tif cannot be read"; }

# read_file FILE: its labels and geometry are those of make.py.
read_file() {
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e '[.labels[1:][] | [.value, .voxels]] == [[17, 1200], [530, 1140]] and .size == [60, 50, 4]' info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.size, [.labels[] | [.value, .voxels]]]' info.json)"
    jq -e '[.to_ras_mm[0][0], .to_ras_mm[1][1], .to_ras_mm[2][2]] | (map(. * 1e9 | round) == [500000, 500000, 1250000])' info.json >/dev/null ||
        fail "$1: geometry $(jq -c .to_ras_mm info.json)"
}
for file in imagej.tif big_end.tif long_page.tif ome_*.tif; do
    read_file "$file"
    ! grep -q 'spacing' stderr.txt || { cat stderr.txt >&2; fail "$file: a warning of its spacing"; }
done
read_file ome_palette.ome.tif
jq -e '[.labels[1:][].color] == [[255, 128, 0], [0, 255, 0]]' info.json >/dev/null ||
    fail "the colours of the palette are $(jq -c '[.labels[].color]' info.json)"

# A directory of masks, and one of slices.
"$SEGCAST" info masks --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "masks cannot be read"; }
jq -e '[.labels[1:][] | [.name, .voxels]] == [["nucleus", 1200], ["vacuole", 1140]] and .to_ras_mm[2][2] == 0.00125' info.json >/dev/null ||
    fail "masks: $(jq -c '[.to_ras_mm, [.labels[] | [.name, .voxels]]]' info.json)"
"$SEGCAST" info slices --json -q 2>/dev/null | jq -e '.size == [60, 50, 4] and ([.labels[1:][] | [.value, .voxels]] == [[17, 1200], [530, 1140]])' >/dev/null ||
    fail "slices: $("$SEGCAST" info slices 2>&1)"

# Without spacing, a voxel has 1 mm, which is said; smaller copies of a page are left out.
for file in plain.tif one_page.tif pyramid.tif; do
    "$SEGCAST" info "$file" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$file cannot be read"; }
    grep -q "$file: does not give the spacing of its voxels along all axes .*; taken as 1 x 1 x 1 mm" stderr.txt ||
        { cat stderr.txt >&2; fail "$file: nothing is said of its spacing"; }
    jq -e '.labels[1].value == 17 and .to_ras_mm[2][2] == 1' info.json >/dev/null || fail "$file: $(jq -c . info.json)"
done
jq -e '.size == [60, 50, 1]' info.json >/dev/null || fail "pyramid.tif: size $(jq -c .size info.json)"

# A stack becomes the same film as the same voxels in another format.
cat >nrrd.py <<'PYTHON'
import numpy, tifffile
labels = tifffile.imread('imagej.tif')
header = ('NRRD0004\ntype: uint16\ndimension: 3\nsizes: 60 50 4\nspacings: 0.0005 0.0005 0.00125\n'
          'endian: little\nencoding: raw\n\n').encode()
open('same.nrrd', 'wb').write(header + labels.astype('<u2').tobytes())
PYTHON
"$python" nrrd.py || fail "the same voxels cannot be written as NRRD"
for volume in imagej.tif same.nrrd; do
    "$SEGCAST" still "$volume" --sheet slices -o "$volume.png" --overwrite -q 2>stderr.txt || { cat stderr.txt >&2; fail "$volume cannot be drawn"; }
done
cmp imagej.tif.png same.nrrd.png || fail "the picture of TIFF is not that of NRRD"
"$SEGCAST" orbit imagej.tif -o film.mp4 --size 64x48 --set animation.frames=2 -q >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "no film of a stack"; }

# A stack that is said to be channels or times of one slice is read as slices, with a warning.
"$SEGCAST" info imagej.tif --json -q 2>/dev/null | jq -c '[.size, (.labels | map([.value, .voxels]))]' >want.json
for volume in as_channels.tif as_times.tif as_channels.ome.tif; do
    expect 0 "$volume: has one slice of 4 (channels|times) \((ImageJ|OME-XML)\); they are taken as slices" "$SEGCAST" info "$volume"
    "$SEGCAST" info "$volume" --json -q 2>/dev/null | jq -c '[.size, (.labels | map([.value, .voxels]))]' | cmp want.json - ||
        fail "$volume: other slices"
done

# Slices as pictures, and an empty directory: it is told what is there, and what to do.
mkdir pictures empty
touch pictures/slice{0..3}.jpg
expect 66 'pictures: is a directory; .*; this one holds 4 entries, the first "slice0.jpg": JPEG changes labels' "$SEGCAST" info pictures; one_error
expect 66 'empty: is a directory; .*; this one is empty' "$SEGCAST" info empty; one_error

# What cannot be shown is refused, with one message.
while read -r file pattern; do
    expect 65 "$file: $pattern" "$SEGCAST" info "$file"
    one_error
done <<'TABLE'
channels.tif has 2 channels and 1 times \(ImageJ\), expected one of each; .*Image > Duplicate
times.ome.tif has 1 channels and 2 times \(OME-XML\), expected one of each
rgb.tif has 3 values for each pixel, a colour picture; expected one, the number of a label
fraction.tif voxel \(10, 10, 1\) holds 8.5, a fraction; expected whole label numbers
sizes.tif page 1 has 60 x 40 pixels of 16 bits, page 0 60 x 50 of 16; expected the slices of one volume
cut.tif (page|cannot|the page)
damaged.tif page 1, strip 0: .
long_page_cut.tif the header promises .* bytes, more than the file can hold
circle.tif the page behind page 1 is one before it, so that the pages have no end
no_page.tif cannot be read as TIFF: has no page, as if it was never finished
TABLE
expect 65 'rgba\\x1b\[31m.tif: has 3 values' "$SEGCAST" info rgba*.tif
"$SEGCAST" init ome_palette.ome.tif -o init.yaml -q >stdout.txt 2>stderr.txt || fail "no job can be written for a stack"
grep -q 'video: "ome_palette.mp4"' init.yaml || fail "the video has not the name of the stack: $(grep video: init.yaml)"
cp ome_palette.ome.tif palette # which only its content tells
for file in ome_palette.ome.tif palette; do
    "$SEGCAST" convert "$file" -o - --to csv >table.csv 2>stderr.txt || { cat stderr.txt >&2; fail "no table of a stack"; }
    grep -q '^530,.*,0,255,0' table.csv || fail "the table of a stack is $(grep -n '^530' table.csv)"
done
