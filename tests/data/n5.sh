# SPDX-License-Identifier: BSD-3-Clause
# Datasets of N5 that zarr-python writes here, and some written by the specification of N5, as its Java library has
# them (blocks cut at the ends of the array, blocks of lz4-java), are read with the labels and geometry put there.
find_python 'zarr.n5, numcodecs' python3-zarr
cat >make.py <<'PYTHON'
import itertools, json, os, struct, numpy, zarr, zarr.n5, numcodecs
labels = numpy.zeros((7, 50, 60), numpy.uint16) # z, y, x
labels[2:5, 10:40, 10:30] = 17
labels[2:5, 10:40, 31:50] = 530

# By zarr-python, which stores whole blocks, also at the ends.
for name, codec in dict(zstd=numcodecs.Zstd(), gzip=numcodecs.GZip(), zlib=numcodecs.Zlib(), raw=None, lz4=numcodecs.LZ4(),
                        blosc=numcodecs.Blosc(cname='lz4', shuffle=1), bz2=numcodecs.BZ2()).items():
    root = zarr.group(zarr.n5.N5Store('python_%s.n5' % name))
    root.create_dataset('labels', data=labels, chunks=(2, 16, 25), compressor=codec)

# By the specification.
def lz4_java(data, mark=b'LZ4Block'):
    out = b''
    for i in range(0, len(data), 1000):
        part = data[i:i + 1000]
        packed = numcodecs.LZ4().encode(part)[4:]
        how = 0x20 if len(packed) < len(part) else 0x10
        packed = packed if how == 0x20 else part
        out += mark + bytes([how | 4]) + struct.pack('<III', len(packed), len(part), 0) + packed
    return out + mark + bytes([0x14]) + struct.pack('<III', 0, 0, 0)

packers = dict(raw=bytes, gzip=numcodecs.GZip().encode, zstd=numcodecs.Zstd().encode, lz4=lz4_java,
               blosc=numcodecs.Blosc(cname='zstd', shuffle=2).encode)

def dataset(path, data, block=(25, 16, 2), packer='gzip', kind='uint16', **attributes): # block along x, y, z
    os.makedirs(path)
    xyz = data.transpose()
    json.dump(dict(attributes, dimensions=xyz.shape, blockSize=block, dataType=kind, compression=dict(type=packer)),
              open(path + '/attributes.json', 'w'))
    for at in itertools.product(*(range(-(-n // b)) for n, b in zip(xyz.shape, block))):
        part = xyz[tuple(slice(a * b, a * b + b) for a, b in zip(at, block))]
        if not part.any():
            continue # N5 has no block where all is 0
        os.makedirs(path + '/' + '/'.join(map(str, at[:-1])), exist_ok=True)
        head = struct.pack('>HH', 0, part.ndim) + struct.pack('>%dI' % part.ndim, *part.shape)
        values = part.astype(numpy.dtype(kind).newbyteorder('>')).tobytes('F')
        open(path + '/' + '/'.join(map(str, at)), 'wb').write(head + bytes(packers[packer](values)))

def group(path, **attributes):
    os.makedirs(path, exist_ok=True)
    json.dump(attributes, open(path + '/attributes.json', 'w'))

nm = dict(pixelResolution=dict(dimensions=[500, 500, 1250], unit='nm'))
for packer in packers:
    dataset('spec_%s.n5/ids' % packer, labels, packer=packer, **nm)
for kind in 'int32', 'uint64', 'int64', 'float32', 'float64':
    dataset('spec_%s.n5/ids' % kind, labels, kind=kind, **nm)
dataset('spec_four.n5/ids', labels[None], block=(25, 16, 2, 1), **nm)
dataset('spec_one_block.n5/ids', labels, block=(64, 64, 64), **nm)
# Levels, whose geometry stands in the levels, in the group, or in a transform for each.
half = labels[:, ::2, ::2]
group('levels.n5', n5='2.5.1', **nm)
dataset('levels.n5/cells/s0', labels, **nm)
dataset('levels.n5/cells/s1', half, downsamplingFactors=[2, 2, 1], **nm)
group('grouped/cells', scales=[[1, 1, 1], [2, 2, 1]], resolution=[500, 500, 1250], units=['nm', 'nm', 'nm'], offset=[1000, 0, 0])
dataset('grouped/cells/s0', labels)
dataset('grouped/cells/s1', half)
def transform(step, shift):
    return dict(transform=dict(axes=['z', 'y', 'x'], scale=[1250, step, step], translate=[0, shift, shift], units=['nm'] * 3))
dataset('transforms.n5/s0', labels, **transform(500, 0))
dataset('transforms.n5/s1', half, **transform(1000, 250))
group('paintera.n5/cells', painteraData=dict(type='label'), maxId=530)
dataset('paintera.n5/cells/data/s0', labels, resolution=[500, 500, 1250])
dataset('paintera.n5/cells/unique-labels/s0', labels)
dataset('multiset.n5/s0', labels, isLabelMultiset=True)
dataset('two.n5/a', labels)
dataset('two.n5/b', labels)
dataset('channels.n5/a', numpy.stack([labels, labels]), block=(25, 16, 2, 1))
dataset('xz.n5/a', labels)
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "the stores cannot be written"; }

# read_store PATH: its labels are those of make.py.
read_store() {
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e '[.labels[1:][] | [.value, .voxels]] == [[17, 1800], [530, 1710]] and .size == [60, 50, 7]' info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.size, [.labels[] | [.value, .voxels]]]' info.json)"
}
# placed PATH SPACING ORIGIN: it lies there, in nm along x, y and z.
placed() {
    jq -e --argjson spacing "$2" --argjson origin "$3" '.to_ras_mm as $m | ([range(3) as $i | $m[$i][$i] * 1e6 | round] == $spacing) and ([range(3) as $i | $m[$i][3] * 1e6 | round] == $origin)' info.json >/dev/null ||
        fail "$1: geometry $(jq -c .to_ras_mm info.json), expected spacing $2 and origin $3"
}
for store in zstd gzip zlib raw lz4 blosc; do
    read_store python_$store.n5
    grep -q "labels: nothing gives the spacing of its voxels (\"pixelResolution\" or \"resolution\" in attributes.json does); taken as 1 mm" stderr.txt ||
        { cat stderr.txt >&2; fail "python_$store: nothing is said of its spacing"; }
done
for store in spec_*.n5 spec_zstd.n5/ids/ levels.n5 levels.n5/cells/s0 transforms.n5 transforms.n5/s0; do
    read_store "$store"
    placed "$store" '[500, 500, 1250]' '[0, 0, 0]'
done
read_store grouped/cells/s0 # a group whose attributes stand above the level, by the path of the level
placed grouped/cells/s0 '[500, 500, 1250]' '[1000, 0, 0]'
read_store paintera.n5
placed paintera.n5 '[500000000, 500000000, 1250000000]' '[0, 0, 0]'
grep -q 'its axes have no known unit of length' stderr.txt || { cat stderr.txt >&2; fail "the missing unit is not told"; }
for level in levels.n5:0 transforms.n5:0 grouped/cells:1000; do
    "$SEGCAST" info "${level%:*}" --set volume.level=1 --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "level 1 of ${level%:*} cannot be read"; }
    jq -e '.size == [30, 25, 7]' info.json >/dev/null || fail "level 1 of ${level%:*}: $(jq -c .size info.json)"
    placed "${level%:*}" '[1000, 1000, 1250]' "[$((${level#*:} + 250)), 250, 0]"
done
"$SEGCAST" info grouped/cells/s1 --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "level 1 by its path"; }
placed grouped/cells/s1 '[1000, 1000, 1250]' '[1250, 250, 0]'
# A part of a dataset is that of the whole, and every voxel is in its place.
for box in '[[25, 50], [16, 32], [3, 6]]:160:608' '[[28, 33], [8, 12], [4, 7]]:4:4' '[[0, 11], [38, 50], [0, 3]]:2:null'; do
    IFS=: read -r voxels first second <<<"$box"
    "$SEGCAST" info spec_lz4.n5 --set "volume={box: $voxels}" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "no part can be read"; }
    jq -e --argjson first "$first" --argjson second "$second" '.labels | .[1].voxels == $first and .[2].voxels == $second' info.json >/dev/null ||
        fail "the labels of $box: $(jq -c .labels info.json)"
done
"$SEGCAST" still levels.n5 --size 64x48 -o levels.png -q || fail "a dataset of N5 cannot be drawn"
"$SEGCAST" init levels.n5/ -o init.yaml -q >stdout.txt 2>stderr.txt || fail "no job can be written for a store"
grep -q 'video: "levels.mp4"' init.yaml || fail "the video has not the name of the store: $(grep video: init.yaml)"

# What cannot be read is refused, with one message that names file or key and what was found.
changes="def meta(path, **keys):
    data = json.load(open(path)); data.update(keys); json.dump(data, open(path, 'w'))
def block(path, at, new):
    data = bytearray(open(path, 'rb').read()); data[at:at + len(new)] = new; open(path, 'wb').write(data)"
change spec_raw.n5 cut.n5 "os.truncate('ids/1/1/1', 100)"
change spec_raw.n5 no_head.n5 "os.truncate('ids/1/1/1', 10)"
change spec_raw.n5 mode.n5 "block('ids/1/1/1', 0, b'\0\1')"
change spec_raw.n5 rank.n5 "block('ids/1/1/1', 2, b'\0\2')"
change spec_raw.n5 large.n5 "block('ids/1/1/1', 4, b'\xff\xff\xff\xff')"
change spec_raw.n5 small.n5 "block('ids/1/1/1', 4, struct.pack('>I', 24))"
change spec_raw.n5 long.n5 "os.truncate('ids/1/1/1', 1 << 30)"
change spec_gzip.n5 damaged.n5 "block('ids/1/1/1', 30, b'\0' * 16)"
change spec_lz4.n5 lz4.n5 "block('ids/1/1/1', 16 + 13, struct.pack('<I', 1 << 31))"
change spec_lz4.n5 lz4_cut.n5 "os.truncate('ids/1/1/1', 60)"
change spec_raw.n5 link.n5 "os.rename('ids/1', '../outside'); os.symlink('../../outside', 'ids/1')"
change spec_raw.n5 attributes_link.n5 "os.rename('ids/attributes.json', 'x'); os.symlink('../x', 'ids/attributes.json')"
change spec_raw.n5 negative.n5 "meta('ids/attributes.json', dimensions=[60, -50, 7])"
change spec_raw.n5 huge.n5 "meta('ids/attributes.json', dimensions=[2000, 5000, 7000])"
change spec_raw.n5 huge_blocks.n5 "meta('ids/attributes.json', blockSize=[60000, 50000, 70000])"
change spec_raw.n5 many_blocks.n5 "meta('ids/attributes.json', blockSize=[1, 1, 1], dimensions=[1000, 1000, 100])"
change spec_raw.n5 many_axes.n5 "meta('ids/attributes.json', blockSize=[1] * 9, dimensions=[1] * 9)"
change spec_raw.n5 text.n5 "meta('ids/attributes.json', dataType='string')"
change spec_raw.n5 no_blocks.n5 "meta('ids/attributes.json', blockSize=None)"
change spec_raw.n5 resolution.n5 "meta('ids/attributes.json', pixelResolution=dict(dimensions=[1, 0, 1]))"
change spec_raw.n5 unset.n5 "meta('ids/attributes.json', pixelResolution='1 um')"
change transforms.n5 transform.n5 "meta('s0/attributes.json', transform=dict(axes=['x', 'y', 'z'], scale=[1, 2]))"
change grouped factors.n5 "meta('cells/attributes.json', scales=[[1, -1, 1]])"
change spec_raw.n5 no_json.n5 "open('ids/attributes.json', 'w').write('{\n')"
change xz.n5 packed.n5 "meta('a/attributes.json', compression=dict(type='x\x1bz'))"
change spec_raw.n5 deep.n5 "os.makedirs('/'.join(['ids'] + ['d'] * 12)); os.remove('ids/attributes.json'); import shutil; [shutil.rmtree('ids/' + d) for d in os.listdir('ids') if d != 'd']"
mkdir empty.n5
refused <<'TABLE'
65 cut.n5 cut.n5/ids/1/1/1: has 84 bytes of values, expected 1600
65 no_head.n5 no_head.n5/ids/1/1/1: does not begin as a block of N5 with 3 dimensions and one value for each voxel
65 mode.n5 ids/1/1/1: does not begin as a block of N5
65 rank.n5 ids/1/1/1: does not begin as a block of N5
65 large.n5 ids/1/1/1: has 4294967295 voxels along dimension 0, expected 25 to 25
65 small.n5 ids/1/1/1: has 24 voxels along dimension 0, expected 25 to 25
65 long.n5 ids/1/1/1: has 1073741824 bytes, more than a chunk of 1600 bytes can take
65 damaged.n5 ids/1/1/1: 
65 lz4.n5 ids/1/1/1: lz4: is damaged, or does not unpack to the size of a block
65 lz4_cut.n5 ids/1/1/1: lz4: is damaged
65 link.n5 ids/1/0/0: is no regular file; links in the directory of a volume are not followed
65 attributes_link.n5 attributes.json: .*links in the directory of a volume are not followed
65 negative.n5 ids/attributes.json: "dimensions" is \[60,-50,7\], expected a number from 1 to 2147483647
71 huge.n5 2000 x 5000 x 7000 voxels take about .* GiB of memory, more than the limit .* --max-memory
65 huge_blocks.n5 "blockSize" is \[60000,50000,70000\], expected chunks of at most 2\^30 values
65 many_blocks.n5 what is to be read lies in 100000000 chunks of 1 x 1 x 1 voxels, expected at most 1048576
65 many_axes.n5 "dimensions" is \[1,1,1,1,1,1,1,1,1\], expected the sizes of 2 to 8 dimensions
65 text.n5 "dataType" is "string", expected integers or floats
65 no_blocks.n5 "blockSize" is null, expected a number
65 resolution.n5 ids/attributes.json: "pixelResolution" is not as expected: a number above 0 for each axis
65 unset.n5 ids/attributes.json: "pixelResolution" is not as expected
65 transform.n5 s0/attributes.json: "transform" is not as expected
65 factors.n5 cells/s0/attributes.json: "scales" is not as expected: a number above 0 for each axis
65 no_json.n5 ids/attributes.json:2: is no JSON: 
65 packed.n5 stored by the codec "x\\x1bz", expected blosc, zstd, lz4, gzip, zlib or crc32c
65 python_bz2.n5 stored by the codec "bzip2", expected blosc
65 multiset.n5 s0: holds label multisets, .*paintera-convert to-scalar
65 two.n5 two.n5: is a group of N5 with 2 groups or datasets; give the path of one, such as .*two.n5/a
65 channels.n5 has 2 entries along dimension 0, expected one beside x, y, z and t; write one channel
65 empty.n5 empty.n5: is a group of N5 without a dataset
65 deep.n5 is a group of N5 without a dataset
TABLE
expect 65 'cells: has no resolution level 2, expected 0, the finest .s0., to 1' "$SEGCAST" info levels.n5 --set volume.level=2
expect 65 's0: is a dataset, and thus one resolution; expected level 0' "$SEGCAST" info levels.n5/cells/s0 --set volume.level=1
expect 71 'levels.n5/cells/s1 is a coarser level of the same image, and may fit' "$SEGCAST" info levels.n5 --max-memory 80K
