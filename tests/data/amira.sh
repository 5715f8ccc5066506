# SPDX-License-Identifier: BSD-3-Clause
# Label fields of AmiraMesh, written here as Amira, Avizo and other programs write them, are read with the labels, names,
# colours and geometry put there; what is damaged is refused.
find_python zlib 'python3'
cat >make.py <<'PYTHON'
import array, struct, zlib
NX, NY, NZ = 12, 7, 5
voxels = [1 if x < 5 else 2 if y < 4 else 300 if x > 9 else 0 for z in range(NZ) for y in range(NY) for x in range(NX)]
small = [min(v, 3) for v in voxels]

def rle(data): # runs of at most 127 bytes, and bytes that stand for themselves
    out, i = b'', 0
    while i < len(data):
        n = 1
        while n < 127 and data[i + n:i + n + 1] == data[i:i + 1]:
            n += 1
        if n > 1:
            out += bytes([n]) + data[i:i + 1]
            i += n
            continue
        j = i
        while j < len(data) and j - i < 127 and data[j:j + 1] != data[j + 1:j + 2]:
            j += 1
        j = max(j, i + 1)
        out += bytes([0x80 | (j - i)]) + data[i:j]
        i = j
    return out

MATERIALS = '''    Materials {
        Exterior {
            Id %d
        }
        Cell_Wall {
            Color 0.64 0 0.8,
            Id %d
        }
        "nucleus \x1b[31mleft" {
            Transparency 0.5,
            Color 0 1 0.5 0,
            Id %d
        }
        Third {
            Id %d
        }
    }
'''
def write(path, data, kind='byte', first='# AmiraMesh BINARY-LITTLE-ENDIAN 2.1', packing='', ids=(1, 2, 3, 4),
          parameters='', box='BoundingBox 10 21 0 3 -2 2', equals='', lattice='define Lattice %d %d %d' % (NX, NY, NZ),
          more='', field=None, units=''):
    header = '%s\n\n\n%s\n\nParameters {\n%s%s    Content "%dx%dx%d %s, uniform coordinates",\n    %s,\n    CoordType "uniform"%s\n}\n\n' % (
        first, lattice, MATERIALS % ids if ids else '', units, NX, NY, NZ, kind, box, parameters)
    header += field or 'Lattice { %s Labels } %s@1%s\n' % (kind, equals, packing)
    header += more + '\n# Data section follows\n@1\n'
    open(path, 'wb').write(header.encode() + data + b'\n')

plain = bytes(small)
packed = rle(plain)
write('plain.am', plain)
write('rle.am', packed, packing='(HxByteRLE,%d)' % len(packed))
write('zip.am', zlib.compress(plain), packing='(HxZip,%d)' % len(zlib.compress(plain)))
write('ids.labels', plain, ids=(0, 1, 2, 3)) # numbers as other programs write them
write('avizo.am', plain, first='# Avizo BINARY-LITTLE-ENDIAN 2.1', equals='= ')
write('second.am', plain, more='Lattice { byte Probability } @2(HxByteRLE,99)\n')
write('ascii.am', ' '.join(map(str, small)).encode(), first='# AmiraMesh 3D ASCII 2.0')
write('wide.am', struct.pack('<%dH' % len(voxels), *voxels), 'ushort', ids=None)
write('wide_zip.am', zlib.compress(struct.pack('<%dH' % len(voxels), *voxels)), 'ushort', packing='(HxZip,9999)', ids=None)
wide = rle(struct.pack('<%dH' % len(voxels), *voxels))
write('wide_rle.am', wide, 'ushort', packing='(HxByteRLE,%d)' % len(wide), ids=None)
write('wide_big.am', struct.pack('>%dH' % len(voxels), *voxels), 'ushort', first='# AmiraMesh 3D BINARY 2.0', ids=None)
write('int_big.am', struct.pack('>%di' % len(voxels), *voxels), 'int', first='# AmiraMesh BINARY 2.0', ids=None)
write('um.am', plain, units='    Units {\n        Coordinates "\xb5m"\n    }\n')
write('moved.am', plain, parameters=',\n    TransformationMatrix 0 1 0 0 -1 0 0 0 0 0 1 0 100 0 0 1')
for name, data, first, packing in (('plain', voxels, 'BINARY-LITTLE-ENDIAN', ''), ('big', voxels, 'BINARY', ''), ('rle', wide, 'BINARY-LITTLE-ENDIAN', '(HxByteRLE,%d)' % len(wide))):
    data = data if name == 'rle' else struct.pack(('>' if name == 'big' else '<') + '%dH' % len(voxels), *data)
    write('drawn_%s.am' % name, data, 'ushort', first='# AmiraMesh %s 2.1' % first, packing=packing, ids=None, box='BoundingBox 0 11 0 3 0 4')
# What cannot be read.
write('no_box.am', plain, box='Dummy 1')
write('stacked.am', plain, parameters=',\n    CoordType "stacked"')
write('cut.am', plain[:200])
write('rle_cut.am', packed[:20], packing='(HxByteRLE,20)')
write('rle_short.am', packed[:40], packing='(HxByteRLE,%d)' % len(packed))
write('rle_zero.am', b'\0' * len(packed), packing='(HxByteRLE,%d)' % len(packed))
write('rle_bomb.am', packed, packing='(HxByteRLE,%d)' % len(packed), lattice='define Lattice 2000 2000 2000')
write('zip_cut.am', zlib.compress(plain)[:20], packing='(HxZip,20)')
write('unknown.am', plain, packing='(HxJpeg,420)')
write('negative.am', plain, lattice='define Lattice 12 -7 5')
write('huge.am', plain, lattice='define Lattice 99999999999 7 5')
write('flat.am', plain, lattice='define Lattice 12 7')
write('vector.am', plain, 'float[3]')
write('ascii_word.am', b'1 2 x', first='# AmiraMesh 3D ASCII 2.0', lattice='define Lattice 3 1 1')
write('ascii_short.am', b'1 2 3', first='# AmiraMesh 3D ASCII 2.0', lattice='define Lattice 3 2 1')
write('graph.am', plain, lattice='define VERTEX 6\ndefine EDGE 2', field='VERTEX { float[3] VertexCoordinates } @1\n')
write('nan.am', plain, box='BoundingBox 0 nan 0 1 0 1')
open('no_data.am', 'w').write('# AmiraMesh BINARY-LITTLE-ENDIAN 2.1\ndefine Lattice 3 3 3\n' + 'Parameters {\n' * 100000)
open('surface.surf', 'w').write('# HyperSurface 0.1 BINARY\n')
# A NRRD of the same voxels.
open('wide.nrrd', 'wb').write(('NRRD0004\ntype: uint16\ndimension: 3\nsizes: %d %d %d\nspacings: 1 0.5 1\nendian: little\nencoding: raw\n\n' % (NX, NY, NZ)).encode()
                              + struct.pack('<%dH' % len(voxels), *voxels))
PYTHON
"$python" make.py || fail "the files cannot be written"

read_file() { # read_file FILE LABELS [CONDITION]: numbers and voxels of its labels, and what else holds of info --json
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e "([.labels[1:][] | [.value, .voxels]] == $2) and .size == [12, 7, 5]" info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.size, [.labels[] | [.value, .voxels]]]' info.json)"
    jq -e "${3:-true}" info.json >/dev/null || fail "$1: $3 does not hold: $(jq -c '[.to_ras_mm, .labels]' info.json)"
}
small='[[1, 175], [2, 140], [3, 30]]'
wide='[[1, 175], [2, 140], [300, 30]]'
named='[.labels[1:][] | .name] == ["Cell_Wall", "nucleus  [31mleft", "Third"] and .labels[1].color == [163, 0, 204] and .labels[2].color == [0, 255, 128]'
# The box lies at the centres of voxels: 12 of them from 10 to 21 are 1 apart.
placed='.to_ras_mm == [[1, 0, 0, 10], [0, 0.5, 0, 0], [0, 0, 1, -2]]'
for file in plain.am rle.am zip.am ids.labels avizo.am second.am ascii.am; do
    read_file $file "$small" "($named) and ($placed)"
done
for file in wide.am wide_zip.am wide_rle.am wide_big.am int_big.am; do
    read_file $file "$wide" "$placed"
done
read_file um.am "$small" '.to_ras_mm[0][0] == 0.001 and .to_ras_mm[0][3] == 0.01'
read_file moved.am "$small" '.to_ras_mm == [[0, -0.5, 0, 100], [1, 0, 0, 10], [0, 0, 1, -2]]'
read_file no_box.am "$small" '.to_ras_mm[0] == [1, 0, 0, 0]'
grep -q 'no_box.am: does not give the spacing of its voxels along all axes (BoundingBox)' stderr.txt || { cat stderr.txt >&2; fail "the missing box is not told"; }
for volume in wide.nrrd drawn_plain.am drawn_big.am drawn_rle.am; do
    "$SEGCAST" still "$volume" --sheet slices --size 300x200 -o "$volume.png" -q >/dev/null 2>&1 || fail "$volume cannot be drawn"
    cmp wide.nrrd.png "$volume.png" || fail "the picture of $volume is not that of NRRD"
done
"$SEGCAST" info rle.am --set 'volume={box: [[4, 12], [2, 7], [1, 3]]}' --json -q >info.json || fail "no part can be read"
jq -e '[.labels[1:][] | .voxels] == [10, 28, 12]' info.json >/dev/null || fail "a part: $(jq -c .labels info.json)"
"$SEGCAST" init plain.am -o init.yaml -q >stdout.txt 2>stderr.txt || fail "no job can be written"
grep -q 'video: "plain.mp4"' init.yaml || fail "the video has not the name of the file: $(grep video: init.yaml)"
cp plain.am plain.png
expect 73 'plain.png: is an input of this command' "$SEGCAST" still plain.png -o plain.png --overwrite

while read -r code file pattern; do
    expect "$code" "$pattern" "$SEGCAST" info "$file"
    one_error
    ! grep -q $'\x1b' stderr.txt || fail "$file: an escape code is printed"
done <<'TABLE'
65 stacked.am its slices are not evenly spaced .CoordType., expected "uniform"
65 cut.am the header promises 420 voxels, more than the file can hold \(201 bytes\)
65 rle_cut.am its labels, packed by HxByteRLE, end or are damaged after [0-9]* of 420 bytes
65 rle_short.am its labels, packed by HxByteRLE, end or are damaged after
65 rle_zero.am its labels, packed by HxByteRLE, end or are damaged after 0 of 420 bytes
65 rle_bomb.am the header promises 8000000000 voxels, more than the file can hold \([0-9]* bytes, packed\)
65 zip_cut.am zip_cut.am: ends after [0-9]* bytes of voxels, expected 420
65 unknown.am packed in a way that is not known, expected HxByteRLE or HxZip
65 negative.am size -1 along axis 1, expected 1 to 2147483647
65 huge.am size -1 along axis 0, expected 1 to
65 flat.am is AmiraMesh without a lattice of labels as its first data
65 graph.am is AmiraMesh without a lattice of labels as its first data
65 vector.am has voxels of the type float\[3\], expected those of a label field
65 ascii_word.am voxel 2 of 3: is no number
65 ascii_short.am voxel 3 of 6: the file ends
65 no_data.am has no line "@1", behind which the voxels stand, in its first 1048576 bytes
65 surface.surf is a mesh, a surface without voxels
TABLE
expect 0 'nan.am: does not give the spacing of its voxels' "$SEGCAST" info nan.am
