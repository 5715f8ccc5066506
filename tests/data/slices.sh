# SPDX-License-Identifier: BSD-3-Clause
# A directory with a PNG picture for each slice is a volume: slices in the order of their numbers, pixels as labels.
find_python 'zlib' python3
cat >make.py <<'PYTHON'
import os, struct, zlib
nx, ny, nz = 21, 18, 12
def label(x, y, z): # another one in each slice, and none of them the same if an axis is turned
    return z + 3 if 3 <= x < 15 and 2 <= y < 9 + z // 2 else 0
def png(path, bits, kind, rows, palette=b''):
    chunk = lambda name, data: struct.pack('>I', len(data)) + name + data + struct.pack('>I', zlib.crc32(name + data))
    open(path, 'wb').write(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>2I5B', nx, len(rows), bits, kind, 0, 0, 0)) +
                           (chunk(b'PLTE', palette) if palette else b'') +
                           chunk(b'IDAT', zlib.compress(b''.join(b'\0' + row for row in rows))) + chunk(b'IEND', b''))
def rows(z, pack):
    return [pack([label(x, y, z) for x in range(nx)]) for y in range(ny)]
nibbles = lambda row: bytes(a << 4 | b for a, b in zip(row[::2], row[1::2] + [0]))
kinds = {'grey': (8, 0, bytes), 'wide': (16, 0, lambda row: struct.pack('>%dH' % nx, *[v * 300 for v in row])),
         'packed': (4, 3, nibbles), 'rgb': (8, 2, lambda row: bytes(v for v in row for _ in range(3))),
         'alpha': (8, 6, lambda row: bytes(w for v in row for w in (v, v, v, 255)))}
for name, (bits, kind, pack) in kinds.items():
    os.mkdir(name)
    for z in range(nz):
        png('%s/slice%d_a.png' % (name, 9 + z), bits, kind, rows(z, pack), bytes(range(48)) if kind == 3 else b'')
    open(name + '/notes.txt', 'w').write('24 slices')
    open(name + '/.hidden.png', 'w').write('')
for name, times, kind in ('grey', 1, 'uint8'), ('wide', 300, 'uint16'):
    open(name + '.nrrd', 'wb').write(('NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n' % (kind, nx, ny, nz)).encode() +
        b''.join(struct.pack('<H' if times > 1 else 'B', label(x, y, z) * times) for z in range(nz) for y in range(ny) for x in range(nx)))
for name in 'gap', 'sizes', 'color', 'cut', 'words', 'masks', 'types', 'jpeg':
    os.mkdir(name)
    for z in 0, 1, 2, 3, 5 if name == 'gap' else 4:
        png('%s/%03d.png' % (name, z), 8, 0, rows(z, bytes))
png('sizes/003.png', 8, 0, rows(0, bytes)[1:])
png('color/003.png', 8, 2, [bytes(range(3 * nx))] * ny)
png('types/003.png', 16, 0, rows(3, kinds['wide'][2]))
data = open('cut/003.png', 'rb').read()
open('cut/003.png', 'wb').write(data[:len(data) // 2])
os.rename('words/003.png', 'words/cover.png')
header, voxels = open('grey.nrrd', 'rb').read().split(b'\n\n', 1)
open('masks/liver.nrrd', 'wb').write(header + b'\n\n' + bytes(v > 0 for v in voxels))
PYTHON
"$python" make.py || fail "the slices cannot be made"
labels_of() { "$SEGCAST" info "$1" --json -q 2>stderr.txt | jq -c '[.size, (.labels | map([.value, .voxels]))]'; }
for name in grey wide packed rgb alpha; do
    same=grey
    [ $name != wide ] || same=wide
    labels_of $same.nrrd >want.json
    labels_of $name >got.json
    diff want.json got.json >&2 || { cat stderr.txt >&2; fail "$name: other voxels"; }
done
for volume in grey grey.nrrd; do
    "$SEGCAST" still "$volume" --sheet slices --size 300x200 -o "$volume.png" -q >/dev/null || fail "$volume cannot be drawn"
done
cmp grey.png grey.nrrd.png || fail "the slices are not in the order of their numbers"
"$SEGCAST" info packed --json -q 2>/dev/null | jq -e '.labels[1].color == [9, 10, 11]' >/dev/null || fail "the colours of the palette are not read"
expect 0 'grey: PNG does not give the spacing of its voxels; taken as 1 x 1 x 1 mm' "$SEGCAST" info grey
expect 0 'its voxels are said to measure 0.5 x 0.5 x 3 mm' "$SEGCAST" info grey --header '0.5x0.5x3 mm'
expect 73 'grey/slice9_a.png: is an input of this command' "$SEGCAST" still grey -o grey/slice9_a.png --overwrite
expect 0 'gap: between 003.png and 005.png slices seem to be missing' "$SEGCAST" info gap
expect 65 'sizes/003.png has 21 x 17 x 1 pixels of 1 bytes, but .*sizes/000.png 21 x 18 of 1; expected the slices of one volume' "$SEGCAST" info sizes; one_error
expect 65 'types/003.png has 21 x 18 x 1 pixels of 2 bytes, but .*types/000.png 21 x 18 of 1' "$SEGCAST" info types; one_error
expect 65 'color/003.png: is a colour picture, expected the number of a label in each pixel' "$SEGCAST" info color; one_error
expect 65 'cut/003.png: (is no PNG file, or is cut off|.*; the file is damaged: get it anew)' "$SEGCAST" info cut; one_error
expect 66 'words: is a directory; .*; this one holds 5 entries, the first "000.png": expected slices of one volume' "$SEGCAST" info words; one_error
"$SEGCAST" info masks --json -q 2>/dev/null | jq -e '.labels[1].name == "liver"' >/dev/null || fail "pictures beside a mask hide it"
