# SPDX-License-Identifier: BSD-3-Clause
# Stores that zarr-python writes here (Zarr 2), and stores of Zarr 3 whose chunks numcodecs packs, are read with
# the labels, geometry, names and colours that were put there. Debian's zarr-python does not know the final
# Zarr 3, so that its metadata and shards are written here by its specification.
find_python 'zarr, numcodecs' python3-zarr
cat >make.py <<'PYTHON'
import itertools, json, os, struct, numpy, zarr, numcodecs
labels = numpy.zeros((7, 50, 60), numpy.uint16) # z, y, x
labels[2:5, 10:40, 10:30] = 17
labels[2:5, 10:40, 31:50] = 530
spacing = [1.25, .5, .5]
image_label = {'version': '0.4', 'colors': [{'label-value': 17, 'rgba': [255, 128, 0, 255]}, {'label-value': 530, 'rgba': [0, 255, 0, 255]}],
               'properties': [{'label-value': 17, 'name': 'nucleus'}, {'label-value': 530, 'name': 'cell \x1b[31m wall'}]}

def multiscales(axes='zyx', unit='micrometer', levels=2):
    spatial = [dict(name=a, type='space', unit=unit) if a in 'xyz' else dict(name=a, type=dict(t='time', c='channel')[a]) for a in axes]
    def scale(level):
        return [dict(zip('zyx', spacing)).get(a, 1) * (2 ** level if a in 'xy' else 1) for a in axes]
    return [dict(version='0.4', axes=spatial, datasets=[
        dict(path=str(l), coordinateTransformations=[dict(type='scale', scale=scale(l)), dict(type='translation', translation=[0.0] * len(axes))])
        for l in range(levels)])]

def ome(path, data=labels, axes='zyx', unit='micrometer', **options):
    group = zarr.open_group(path, mode='w')
    image = group.create_group('labels/cells')
    group['labels'].attrs['labels'] = ['cells']
    image.attrs['multiscales'] = multiscales(axes, unit)
    image.attrs['image-label'] = image_label
    for level in range(2):
        step = 2 ** level
        shape = data[..., ::step, ::step]
        image.create_dataset(str(level), data=shape, chunks=options.get('chunks', (1,) * (data.ndim - 3) + (3, 16, 25)),
                             compressor=options.get('compressor'), order=options.get('order', 'C'), dimension_separator='/')
    group.create_dataset('0', data=shape, chunks=shape.shape) # the picture that the labels belong to
    group.attrs['multiscales'] = multiscales(axes, unit, 1)

for name in 'lz4', 'lz4hc', 'zlib', 'zstd', 'blosclz':
    ome('blosc_%s.zarr' % name, compressor=numcodecs.Blosc(cname=name, shuffle=1))
for name, codec in dict(zstd=numcodecs.Zstd(), lz4=numcodecs.LZ4(), gzip=numcodecs.GZip(), zlib=numcodecs.Zlib(), raw=None).items():
    ome('%s.zarr' % name, compressor=codec)
ome('fortran.zarr', compressor=numcodecs.Zlib(), order='F')
ome('one_chunk.zarr', compressor=numcodecs.Zlib(), chunks=labels.shape)
ome('tczyx.zarr', labels[None, None], 'tczyx', compressor=numcodecs.Zstd())
halves = numpy.stack([labels, numpy.where(labels == 17, 0, labels), labels])[:, None]
ome('times.zarr', halves, 'tczyx')
ome('times_together.zarr', halves, 'tczyx', chunks=(2, 1, 3, 16, 25), compressor=numcodecs.Zstd(), order='F')
ome('channels.zarr', halves.swapaxes(0, 1), 'tczyx')
ome('no_unit.zarr', unit=None)
for kind in '<i4', '>u2', '>i8', '<u8', '<f4', '>f8':
    ome('type_%s%s.zarr' % ('big' if kind[0] == '>' else 'little', kind[1:]), labels.astype(kind), compressor=numcodecs.Zlib())
zarr.save_array('array.zarr', labels, chunks=(4, 20, 20))
sparse = zarr.open('sparse.zarr', mode='w', shape=labels.shape, chunks=(3, 16, 25), dtype='u2', fill_value=9, write_empty_chunks=False)
sparse[0:3, 0:16, 0:25] = 17
ome('several.zarr')
group = zarr.open_group('several.zarr', mode='a')
group['labels'].attrs['labels'] = ['cells', 'nu\x1b[31mclei']
zarr.open_group('groups.zarr', mode='w').create_group('a')
# An image whose group of labels is empty, and two images of bioformats2raw.
image = zarr.open_group('empty_labels.zarr', mode='w')
image.create_dataset('0', data=labels, chunks=labels.shape)
image.attrs['multiscales'] = multiscales(levels=1)
image.create_group('labels').attrs['labels'] = []
two = zarr.open_group('two_images.zarr', mode='w')
two.attrs['bioformats2raw.layout'] = 3
for name in '0', '1':
    two.create_group(name)
zarr.save_array('lzma.zarr', labels, compressor=numcodecs.LZMA())
zarr.save_array('filter.zarr', labels, filters=[numcodecs.Delta('u2')])

# Zarr 3.
crc_table = []
for i in range(256):
    for _ in range(8):
        i = i >> 1 ^ (0x82f63b78 if i & 1 else 0)
    crc_table.append(i)
def crc32c(data):
    crc = 0xffffffff
    for byte in data:
        crc = crc_table[(crc ^ byte) & 255] ^ crc >> 8
    return struct.pack('<I', crc ^ 0xffffffff)

def pack(chunk, codecs):
    for codec in codecs:
        name, config = codec['name'], codec.get('configuration', {})
        if name == 'transpose':
            chunk = chunk.transpose(config['order'])
        elif name == 'bytes':
            chunk = chunk.astype(chunk.dtype.newbyteorder('>' if config['endian'] == 'big' else '<')).tobytes('C')
        elif name == 'sharding_indexed':
            chunk = shard(chunk, config)
        elif name == 'crc32c':
            chunk += crc32c(chunk)
        else:
            chunk = dict(zstd=numcodecs.Zstd(), gzip=numcodecs.GZip(), blosc=numcodecs.Blosc(cname='zstd', shuffle=1))[name].encode(chunk)
    return bytes(chunk)

def pieces(shape, chunk):
    return itertools.product(*(range(-(-n // c)) for n, c in zip(shape, chunk)))

def shard(data, config):
    body, index = b'', b''
    first = config.get('index_location') == 'start'
    count = numpy.prod([n // c for n, c in zip(data.shape, config['chunk_shape'])])
    start = int(count) * 16 + 4 if first else 0
    for at in pieces(data.shape, config['chunk_shape']):
        part = data[tuple(slice(a * c, a * c + c) for a, c in zip(at, config['chunk_shape']))]
        if not part.any():
            index += b'\xff' * 16
            continue
        packed = pack(part, config['codecs'])
        index += struct.pack('<QQ', start + len(body), len(packed))
        body += packed
    index += crc32c(index)
    return index + body if first else body + index

LITTLE, BIG = (dict(name='bytes', configuration=dict(endian=e)) for e in ('little', 'big'))
CRC = dict(name='crc32c')
def sharding(inner, *codecs, **more):
    return dict(name='sharding_indexed', configuration=dict(chunk_shape=inner, codecs=list(codecs), index_codecs=[LITTLE, CRC], **more))

def array3(path, data, chunk, *codecs, keys=dict(name='default', configuration=dict(separator='/')), names=None):
    os.makedirs(path)
    meta = dict(zarr_format=3, node_type='array', shape=data.shape, data_type=str(data.dtype), fill_value=0, attributes={},
                chunk_grid=dict(name='regular', configuration=dict(chunk_shape=chunk)), chunk_key_encoding=keys, codecs=codecs)
    if names:
        meta['dimension_names'] = names
    json.dump(meta, open(path + '/zarr.json', 'w'))
    for at in pieces(data.shape, chunk):
        whole = numpy.zeros(chunk, data.dtype)
        part = data[tuple(slice(a * c, a * c + c) for a, c in zip(at, chunk))]
        whole[tuple(slice(0, n) for n in part.shape)] = part
        if not whole.any():
            continue
        separator = keys.get('configuration', {}).get('separator', '/' if keys['name'] == 'default' else '.')
        name = separator.join((['c'] if keys['name'] == 'default' else []) + [str(a) for a in at])
        os.makedirs(os.path.dirname(path + '/' + name), exist_ok=True)
        open(path + '/' + name, 'wb').write(pack(whole, codecs))

def group3(path, **attributes):
    os.makedirs(path, exist_ok=True)
    json.dump(dict(zarr_format=3, node_type='group', attributes=attributes), open(path + '/zarr.json', 'w'))

def ome3(path, chunk, *codecs, **options):
    group3(path, ome=dict(version='0.5', multiscales=multiscales(levels=1)))
    group3(path + '/labels', ome=dict(version='0.5', labels=['cells']))
    group3(path + '/labels/cells', ome={'version': '0.5', 'multiscales': multiscales(levels=1), 'image-label': image_label})
    array3(path + '/labels/cells/0', labels, chunk, *codecs, **options)

zstd, gzip, blosc = (dict(name=n, configuration={}) for n in ('zstd', 'gzip', 'blosc'))
order = dict(name='transpose', configuration=dict(order=[2, 0, 1]))
ome3('v3_zstd.zarr', [3, 16, 25], LITTLE, zstd)
ome3('v3_big_gzip_crc.zarr', [3, 16, 25], BIG, gzip, CRC)
ome3('v3_crc_blosc.zarr', [3, 16, 25], LITTLE, CRC, blosc)
ome3('v3_transpose.zarr', [3, 16, 25], order, LITTLE, blosc)
ome3('v3_twice.zarr', [3, 16, 25], order, order, LITTLE)
ome3('v3_keys.zarr', [3, 16, 25], LITTLE, keys=dict(name='v2'))
ome3('v3_dots.zarr', [3, 16, 25], LITTLE, keys=dict(name='default', configuration=dict(separator='.')))
ome3('v3_shards.zarr', [4, 32, 32], sharding([2, 16, 16], LITTLE, zstd))
ome3('v3_shards_first.zarr', [8, 64, 64], sharding([2, 16, 32], order, LITTLE, blosc, CRC, index_location='start'))
ome3('v3_shards_raw.zarr', [4, 64, 16], sharding([1, 64, 16], BIG))
array3('v3_xyz.zarr', numpy.ascontiguousarray(labels.transpose(2, 1, 0)), [16, 25, 3], LITTLE, names=['x', 'y', 'z'])
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "zarr cannot write the stores"; }

# read_store PATH: its labels and geometry are those of make.py.
read_store() {
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e '[.labels[1:][] | [.value, .voxels]] == [[17, 1800], [530, 1710]] and .size == [60, 50, 7]' info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.size, [.labels[] | [.value, .voxels]]]' info.json)"
}
"$SEGCAST" info blosc_lz4.zarr >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "blosc_lz4.zarr cannot be read"; }
for store in blosc_*.zarr zstd.zarr lz4.zarr gzip.zarr zlib.zarr raw.zarr fortran.zarr one_chunk.zarr tczyx.zarr type_*.zarr v3_[!x]*.zarr; do
    read_store "$store"
    jq -e '[.to_ras_mm[0][0], .to_ras_mm[1][1], .to_ras_mm[2][2]] | (map(. * 1e9 | round) == [500000, 500000, 1250000])' info.json >/dev/null ||
        fail "$store: geometry $(jq -c .to_ras_mm info.json)"
    jq -e '[.labels[1:][] | [.name, .color]] == [["nucleus", [255, 128, 0]], ["cell  [31m wall", [0, 255, 0]]]' info.json >/dev/null ||
        fail "$store: $(jq -c '[.labels[] | [.name, .color]]' info.json)"
done
# The same by the path of the group of labels, of the label image and of the array; a level by its path.
for path in v3_zstd.zarr/labels zstd.zarr/labels/cells zstd.zarr/labels/cells/0 v3_shards.zarr/labels/cells/0/; do
    read_store "$path"
    jq -e '.labels[1].name == "nucleus" and .to_ras_mm[2][2] == 0.00125' info.json >/dev/null || fail "$path: $(jq -c . info.json)"
done
(cd zstd.zarr/labels/cells/0 && "$SEGCAST" info . --json) >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "the current directory cannot be read"; }
jq -e '.labels[1].name == "nucleus"' info.json >/dev/null || fail "the group above the current directory is not read"
"$SEGCAST" info zstd.zarr/labels/cells/1 --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "the second level cannot be read"; }
jq -e '.size == [30, 25, 7] and .to_ras_mm[0][0] == 0.001 and .labels[2].name == "cell  [31m wall"' info.json >/dev/null || fail "the second level: $(jq -c . info.json)"
"$SEGCAST" info empty_labels.zarr --json -q >info.json || fail "an image whose list of labels is empty"
jq -e '.size == [60, 50, 7] and (.labels | length == 3)' info.json >/dev/null || fail "empty_labels.zarr: $(jq -c . info.json)"
expect 65 'two_images.zarr: holds several images of bioformats2raw; give the path of one, such as .*two_images.zarr/0' "$SEGCAST" info two_images.zarr
for store in array.zarr v3_xyz.zarr; do
    read_store "$store"
    grep -q "$store: nothing gives the spacing of its voxels (\"multiscales\" of OME-Zarr does); taken as 1 mm" stderr.txt ||
        { cat stderr.txt >&2; fail "$store: nothing is said of its spacing"; }
done
"$SEGCAST" info sparse.zarr --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "sparse.zarr cannot be read"; }
jq -e '[.labels[1:][] | [.value, .voxels]] == [[9, 19800], [17, 1200]]' info.json >/dev/null || fail "sparse.zarr: $(jq -c .labels info.json)"
grep -q 'sparse.zarr: 35 of 36 chunks are not there; they count as full of the fill value' stderr.txt || { cat stderr.txt >&2; fail "chunks that are not there are not told"; }
"$SEGCAST" info no_unit.zarr >stdout.txt 2>stderr.txt || fail "no_unit.zarr cannot be read"
grep -q 'its axes have no known unit of length ("unit", such as "micrometer"); taken as mm' stderr.txt || { cat stderr.txt >&2; fail "the missing unit is not told"; }

# Of several times one is read, whether chunks hold one of them or more.
for store in times.zarr times_together.zarr; do
    for phase in 0:1800 1:null 2:1800; do
        "$SEGCAST" info "$store" --set volume.phase="${phase%:*}" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$store: phase ${phase%:*} cannot be read"; }
        jq -e --argjson voxels "${phase#*:}" '([.labels[] | select(.value == 17).voxels][0] == $voxels) and ([.labels[] | select(.value == 530).voxels] == [1710])' info.json >/dev/null ||
            fail "$store, phase $phase: $(jq -c '[.labels[] | [.value, .voxels]]' info.json)"
    done
    expect 65 'phase: 3, but .*zarr holds 3, expected 0 to 2' "$SEGCAST" info "$store" --set volume.phase=3
done

# A label image becomes a film without any further word; the picture does not depend on format, version or threads.
"$SEGCAST" orbit zstd.zarr -o film.mp4 --size 64x48 --set animation.frames=2 -q >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "no film of a label image"; }
[ -s film.mp4 ] || fail "no film of a label image was written"
cat >nrrd.py <<'PYTHON'
import sys, numpy, zarr
labels = zarr.open('zstd.zarr/labels/cells/0', mode='r')[:]
header = ('NRRD0004\ntype: uint16\ndimension: 3\nsizes: 60 50 7\nspacings: 0.0005 0.0005 0.00125\nendian: little\n'
          'Segment0_LabelValue:=17\nSegment0_Color:=1 0.50196078 0\nSegment0_Name:=nucleus\n'
          'Segment1_LabelValue:=530\nSegment1_Color:=0 1 0\nSegment1_Name:=cell  [31m wall\nencoding: raw\n\n').encode()
open('same.nrrd', 'wb').write(header + labels.astype('<u2').tobytes())
PYTHON
"$python" nrrd.py || fail "the same voxels cannot be written as NRRD"
for volume in same.nrrd zstd.zarr v3_shards_first.zarr; do
    for threads in 1 3; do
        "$SEGCAST" still "$volume" --sheet slices -o "$volume.$threads.png" --threads "$threads" -q 2>stderr.txt || { cat stderr.txt >&2; fail "$volume cannot be drawn"; }
        cmp same.nrrd.1.png "$volume.$threads.png" || fail "the picture of $volume with $threads threads is not that of NRRD"
    done
done

# A level by its number, and a part of a volume, are what zarr-python cuts out; of chunks outside of the part not even
# the files are looked at, and what holds the box only in part is read in part. Every box is also that of NRRD.
cat >part.py <<'PYTHON'
import sys, numpy, zarr
path, level, *box = sys.argv[1:]
labels = zarr.open('zstd.zarr/labels/cells/' + level, mode='r')[:]
x0, x1, y0, y1, z0, z1 = map(int, box) if box else (0, labels.shape[2], 0, labels.shape[1], 0, labels.shape[0])
step = .0005 * 2 ** int(level)
header = ('NRRD0004\ntype: uint16\ndimension: 3\nsizes: %d %d %d\nspace: right-anterior-superior\nspace directions: (%r,0,0) (0,%r,0) (0,0,0.00125)\n'
          'space origin: (%r,%r,%r)\nendian: little\nencoding: raw\n\n' % (x1 - x0, y1 - y0, z1 - z0, step, step, step * x0, step * y0, .00125 * z0)).encode()
open(path, 'wb').write(header + numpy.ascontiguousarray(labels[z0:z1, y0:y1, x0:x1]).astype('<u2').tobytes())
PYTHON
# found VOLUME [OPTION ...]: size, geometry and labels that `segcast info` finds, the geometry rounded
found() {
    "$SEGCAST" info "$1" "${@:2}" --json 2>stderr.txt >info.json || { cat stderr.txt >&2; fail "$* cannot be read"; }
    jq -c '[.size, [.to_ras_mm[][] | . * 1e9 | round], [.labels[1:][] | [.value, .voxels]]]' info.json
}
threads=1
while read -r level box; do
    threads=$((4 - threads))
    IFS=', ' read -ra corners <<<"${box//[\[\]]/}"
    "$python" part.py part.nrrd "$level" "${corners[@]}" || fail "no part of the store can be written"
    wanted=$(found part.nrrd)
    for store in zstd.zarr v3_shards_first.zarr fortran.zarr same.nrrd one_chunk.zarr; do
        { [ "$level" != 0 ] && [[ $store == v3* || $store == same* ]]; } && continue
        [ "$(found "$store" --set "volume={level: $level${box:+, box: $box}}" --threads $threads)" = "$wanted" ] ||
            fail "level $level, box $box of $store: $(jq -c . info.json), expected $wanted"
    done
done <<'TABLE'
1
0 [[10, 31], [0, 50], [0, 7]]
0 [[13, 14], [17, 33], [2, 3]]
0 [[0, 60], [9, 41], [1, 6]]
0 [[25, 50], [16, 32], [3, 6]]
1 [[3, 30], [4, 25], [1, 7]]
TABLE
cp -r zstd.zarr few.zarr
for file in few.zarr/labels/cells/0/*/*/*; do # only chunk (z 1, y 1, x 1) stays; the others would be refused
    [[ $file == */1/1/1 ]] || echo damaged >"$file"
done
expect 65 'few.zarr/labels/cells/0/0/0/0: zstd' "$SEGCAST" info few.zarr
"$SEGCAST" info few.zarr --set 'volume={box: [[25, 50], [16, 32], [3, 6]]}' --json >info.json 2>stderr.txt ||
    { cat stderr.txt >&2; fail "chunks outside of the box are read"; }
jq -e '.labels[1:] | map(.voxels) == [160, 608]' info.json >/dev/null || fail "the labels of one chunk: $(jq -c .labels info.json)"
# Tissues with a name of which the box has nothing are told; other chunks are not looked at.
printf 'value,name\n60000,far one\n' >far.csv
expect 0 'the box has no voxel of .* with a name: .*"far one".*; other chunks are not read' "$SEGCAST" info few.zarr \
    --set 'volume={box: [[25, 50], [16, 32], [3, 6]]}' --labels far.csv
expect 0 '' "$SEGCAST" info zstd.zarr --labels far.csv
! grep -q 'the box has' stderr.txt || fail "a box is told of without one: $(cat stderr.txt)"
# The same by two corners in mm: voxels 25 to 49, 16 to 31, 3 to 5.
mm='[[0.0245, 0.00799, 0.0064], [0.01249, 0.0155, 0.00370]]'
[ "$(found zstd.zarr --set "volume={box: $mm}")" = "$(found zstd.zarr --set 'volume={box: [[25, 50], [16, 32], [3, 6]]}')" ] ||
    fail "a box in mm: $(jq -c . info.json)"
expect 65 'has no resolution level 2, expected one of 2: 0 ."0" of .7, 50, 60.., 1 ."1" of .7, 25, 30..; 0 is the finest' \
    "$SEGCAST" info zstd.zarr --set volume.level=2
expect 65 'is an array, and thus one resolution; expected level 0' "$SEGCAST" info zstd.zarr/labels/cells/0 --set volume.level=1
expect 65 'level: .*same.nrrd has one resolution' "$SEGCAST" info same.nrrd --set volume.level=1
expect 65 'box: \[0, 31\] along x reaches beyond the volume of 30 x 25 x 7' "$SEGCAST" info zstd.zarr --set 'volume={level: 1, box: [[0, 31], [0, 2], [0, 2]]}'
expect 65 'box: the volume has no voxel in the box; it reaches from .-0.00025, -0.00025, -0.000625. to' \
    "$SEGCAST" info zstd.zarr --set 'volume={box: [[1, 1, 1], [2, 2, 2]]}'

# What cannot be read is refused, with one message that names file or key and what was found.
changes="def meta(path, **keys):
    data = json.load(open(path)); data.update(keys); json.dump(data, open(path, 'w'))"
array=labels/cells/0
change zstd.zarr cut.zarr "f='$array/1/1/1'; os.truncate(f, os.path.getsize(f) // 2)"
change blosc_lz4.zarr blosc_cut.zarr "f='$array/1/1/1'; os.truncate(f, os.path.getsize(f) - 1)"
change gzip.zarr wrong_codec.zarr "meta('$array/.zarray', compressor=dict(id='zstd', level=1))"
change raw.zarr raw_cut.zarr "os.truncate('$array/0/0/0', 100)"
change raw.zarr raw_long.zarr "os.truncate('$array/0/0/0', 1 << 30)"
change zlib.zarr small_chunks.zarr "meta('$array/.zarray', chunks=[1, 16, 25])"
change zstd.zarr negative.zarr "meta('$array/.zarray', shape=[7, -50, 60])"
change zstd.zarr huge.zarr "meta('$array/.zarray', shape=[7000, 5000, 2000])"
change zstd.zarr huge_chunks.zarr "meta('$array/.zarray', chunks=[70000, 50000, 60000])"
change zstd.zarr many_chunks.zarr "meta('$array/.zarray', chunks=[1, 1, 1], shape=[100, 1000, 1000])"
change zstd.zarr loop.zarr "os.remove('$array/1/1/1'); os.symlink('1', '$array/1/1/1')"
change zstd.zarr link.zarr "os.rename('$array/1', 'outside'); os.symlink('../../../outside', '$array/1')"
change zstd.zarr label_link.zarr "os.rename('labels/cells', 'outside'); os.symlink('../outside', 'labels/cells')"
change zstd.zarr parent.zarr "meta('labels/.zattrs', labels=['../../zstd.zarr/labels/cells'])"
change zstd.zarr absolute.zarr "meta('labels/.zattrs', labels=['/etc'])"
change zstd.zarr gone.zarr "meta('labels/.zattrs', labels=['no\x1bne'])"
change zstd.zarr no_level.zarr "import shutil; shutil.rmtree('$array')"
change zstd.zarr no_meta.zarr "os.remove('$array/.zarray')"
change zstd.zarr no_json.zarr "open('$array/.zarray', 'w').write('{\n')"
change zstd.zarr axes.zarr "m = json.load(open('labels/cells/.zattrs')); m['multiscales'][0]['axes'].pop(); [t[t['type']].pop() for d in m['multiscales'][0]['datasets'] for t in d['coordinateTransformations']]; json.dump(m, open('labels/cells/.zattrs', 'w'))"
change zstd.zarr fill.zarr "meta('$array/.zarray', fill_value=70000)"
change zstd.zarr fill_negative.zarr "meta('$array/.zarray', fill_value=-1)"
change type_littlei4.zarr fill_real.zarr "meta('$array/.zarray', fill_value=3e9)"
change v3_shards.zarr shard_index.zarr "f='$array/c/0/0/0'; d=bytearray(open(f,'rb').read()); d[-20]^=1; open(f,'wb').write(d)"
change v3_shards_raw.zarr shard_beyond.zarr "m=json.load(open('$array/zarr.json')); m['codecs'][0]['configuration']['index_codecs'].pop(); json.dump(m, open('$array/zarr.json','w'))
f='$array/c/0/0/1'; d=open(f,'rb').read()[:-68]; open(f,'wb').write(d + struct.pack('<QQ', 1 << 40, 99) * 4)"
change v3_shards.zarr shard_cut.zarr "os.truncate('$array/c/0/0/0', 50)"
change v3_shards.zarr shard_shape.zarr "m=json.load(open('$array/zarr.json')); m['codecs'][0]['configuration']['chunk_shape']=[3,16,16]; json.dump(m, open('$array/zarr.json','w'))"
change v3_big_gzip_crc.zarr crc.zarr "f='$array/c/0/0/0'; d=bytearray(open(f,'rb').read()); d[-1]^=1; open(f,'wb').write(d)"
change zstd.zarr mirrored.zarr "m = json.load(open('labels/cells/.zattrs')); m['multiscales'][0]['datasets'][0]['coordinateTransformations'][0]['scale'][-2] *= -1; json.dump(m, open('labels/cells/.zattrs', 'w'))"
change zstd.zarr headless.zarr "os.remove('.zgroup')"
change zstd.zarr headless "os.remove('.zgroup')"
refused <<'TABLE'
65 cut.zarr cut.zarr/labels/cells/0/1/1/1: zstd: .
65 blosc_cut.zarr blosc_cut.zarr/labels/cells/0/1/1/1: blosc: is damaged or cut short
65 wrong_codec.zarr wrong_codec.zarr/labels/cells/0/0/0/0: zstd: 
65 raw_cut.zarr raw_cut.zarr/labels/cells/0/0/0/0: has 100 bytes of values, expected 2400
65 raw_long.zarr 0/0/0: has 1073741824 bytes, more than a chunk of 2400 bytes can take
65 small_chunks.zarr 0/0/0/0: gzip: unpacks to more bytes than are expected
65 negative.zarr \.zarray: "shape" is \[7,-50,60\], expected a number from 1 to 2147483647
71 huge.zarr 2000 x 5000 x 7000 voxels take about .* GiB of memory, more than the limit .* --max-memory
65 huge_chunks.zarr \.zarray: "chunks" is \[70000,50000,60000\], expected chunks of at most 2\^30 values
65 many_chunks.zarr what is to be read lies in 100000000 chunks of 1 x 1 x 1 voxels, expected at most 1048576
65 loop.zarr 0/1/1/1: is no regular file; links in the directory of a volume are not followed
65 link.zarr 0/1/0/0: is no regular file; links in the directory of a volume are not followed
65 label_link.zarr labels/cells: is no directory, but .*labels/.z[a-z]* names it; expected a directory, no link
65 parent.zarr \.z[a-z]* names ".*zstd.zarr/labels/cells": outside the header's directory
65 absolute.zarr \.z[a-z]* names "/etc": an absolute path
65 gone.zarr \.z[a-z]* names "no\\x1bne": not a name of a file
66 no_level.zarr labels/cells/0: is not there, but .*labels/cells/.z[a-z]* names it
66 no_meta.zarr labels/cells/0: holds neither zarr.json nor .zarray nor .zgroup
65 no_json.zarr \.zarray:2: is no JSON: 
65 mirrored.zarr labels/cells/\.zattrs: the "scale" of axis "y" is -[0-9.]*, expected the distance of voxels
66 headless.zarr headless.zarr: is a directory of Zarr, but its metadata are missing: there is neither zarr.json nor .zgroup
66 headless headless: is a directory of Zarr, but its metadata are missing
65 axes.zarr has 3 dimensions, but its group names 2 axes
65 fill.zarr \.zarray: "fill_value" is 70000, expected a number within the range of the array's type
65 fill_negative.zarr \.zarray: "fill_value" is -1, expected a number within
65 fill_real.zarr \.zarray: "fill_value" is 3000000000.0, expected a number within
65 shard_index.zarr c/0/0/0: the check sum of the index of the shard is wrong
65 shard_beyond.zarr c/0/0/1: the index of the shard leads behind the end of the file
65 shard_cut.zarr c/0/0/0: is shorter than the index of a shard
65 shard_shape.zarr zarr.json: "chunk_shape" is \[3,16,16\], expected divisors of the shape of a shard
65 crc.zarr c/0/0/0: its check sum \(crc32c\) is wrong
65 several.zarr holds 2 label images: cells, nu\\x1b\[31mclei; give the path of one, such as .*several.zarr/labels/cells
65 groups.zarr is a group of Zarr without images
65 lzma.zarr stored by the codec "lzma", expected blosc, zstd, lz4, gzip, zlib or crc32c
65 filter.zarr "filters" is .*delta.*expected null: write it anew without filters
65 channels.zarr has 3 entries along dimension 1 \(c\), expected one beside x, y, z and t; write one channel
TABLE
expect 71 'more than the limit' "$SEGCAST" info raw.zarr --max-memory 1K
# Where a level does not fit, the next is named, which does.
expect 71 'raw.zarr/labels/cells/1 is a coarser level of the same image, and may fit' "$SEGCAST" info raw.zarr --max-memory 80K
"$SEGCAST" info raw.zarr/labels/cells/1 --max-memory 80K >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "the coarser level does not fit"; }
"$SEGCAST" init zstd.zarr/ -o init.yaml -q >stdout.txt 2>stderr.txt || fail "no job can be written for a store"
grep -q 'video: "zstd.mp4"' init.yaml || fail "the video has not the name of the store: $(grep video: init.yaml)"
"$SEGCAST" convert zstd.zarr -o - --to csv >table.csv 2>stderr.txt || { cat stderr.txt >&2; fail "no table of a store"; }
grep -q '^17,nucleus,255,128,0' table.csv || fail "the table of a store is $(cat table.csv)"
