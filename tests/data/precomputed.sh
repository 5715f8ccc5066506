# SPDX-License-Identifier: BSD-3-Clause
# Volumes of Neuroglancer's precomputed format, written here by its specification: raw and compressed_segmentation,
# packed by gzip or not, with and without shards, are read with the labels, geometry and names that were put there,
# and what is damaged is refused.
find_python 'numpy' python3-numpy
cat >make.py <<'PYTHON'
import gzip, itertools, json, os, struct, numpy
shape = 60, 50, 7
labels = numpy.zeros(shape, numpy.uint64) # x, y, z
labels[10:30, 10:40, 2:5] = 17
labels[31:50, 10:40, 2:5] = 530
labels[55:60, 45:50, 5:7] = (1 << 40) + 3
offset = -20, 0, 100
nm = 500, 500, 1250

def blocks(chunk, block): # compressed_segmentation, one channel
    words = 2 if chunk.dtype == numpy.uint64 else 1
    grid = [-(-n // b) for n, b in zip(chunk.shape, block)]
    header, body = [], []
    for z, y, x in itertools.product(*(range(n) for n in reversed(grid))):
        part = numpy.zeros(block, chunk.dtype, 'F')
        cut = chunk[x * block[0]:(x + 1) * block[0], y * block[1]:(y + 1) * block[1], z * block[2]:(z + 1) * block[2]]
        part[...] = cut.flat[0]
        part[:cut.shape[0], :cut.shape[1], :cut.shape[2]] = cut
        table, places = numpy.unique(part.ravel('F'), return_inverse=True)
        bits = 0 if len(table) == 1 else next(b for b in (1, 2, 4, 8, 16, 32) if 1 << b >= len(table))
        start = 2 * numpy.prod(grid) + len(body)
        if bits:
            per_word = 32 // bits
            places = numpy.concatenate([places, numpy.zeros(-len(places) % per_word, int)]).reshape(-1, per_word)
            body += [int(sum(int(p) << bits * i for i, p in enumerate(row))) for row in places]
        header += [2 * int(numpy.prod(grid)) + len(body) | bits << 24, int(start)]
        for label in table:
            body += [int(label) & 0xffffffff, int(label) >> 32][:words]
    data = [1] + header + body
    return struct.pack('<%dI' % len(data), *data)

def murmur(key): # the low half of MurmurHash3_x86_128
    def rotate(v, n): return (v << n | v >> 32 - n) & 0xffffffff
    def mix(h):
        for shift, factor in (16, 0x85ebca6b), (13, 0xc2b2ae35):
            h = (h ^ h >> shift) * factor & 0xffffffff
        return h ^ h >> 16
    k1, k2 = key & 0xffffffff, key >> 32
    h = [rotate(k1 * 0x239b961b & 0xffffffff, 15) * 0xab0e9789 & 0xffffffff, rotate(k2 * 0xab0e9789 & 0xffffffff, 16) * 0x38b34ae5 & 0xffffffff, 0, 0]
    h = [v ^ 8 for v in h]
    def spread(h):
        first = sum(h) & 0xffffffff
        return [first] + [v + first & 0xffffffff for v in h[1:]]
    h = spread([mix(v) for v in spread(h)])
    return h[0] | h[1] << 32

def morton(at, grid):
    number = bit = 0
    for i in range(32):
        for k in range(3):
            if grid[k] - 1 >> i:
                number |= (at[k] >> i & 1) << bit
                bit += 1
    return number

def shards(path, chunks, sharding):
    bits, files = sharding['minishard_bits'], {}
    for number, data in sorted(chunks.items()):
        key = number >> sharding['preshift_bits']
        key = murmur(key) if sharding['hash'] != 'identity' else key
        shard, mini = key >> bits & (1 << sharding['shard_bits']) - 1, key & (1 << bits) - 1
        files.setdefault(shard, {}).setdefault(mini, []).append((number, data))
    for shard, minis in files.items():
        body, index = b'', [(0, 0)] * (1 << bits)
        for mini, entries in minis.items():
            rows, last, end = [[], [], []], 0, 0
            for number, data in entries:
                packed = gzip.compress(data, mtime=0) if sharding.get('data_encoding') == 'gzip' else data
                for row, value in zip(rows, (number - last, len(body) - end, len(packed))):
                    row.append(value)
                last, end = number, len(body) + len(packed)
                body += packed
            packed = struct.pack('<%dQ' % (3 * len(entries)), *(v for row in rows for v in row))
            packed = gzip.compress(packed, mtime=0) if sharding.get('minishard_index_encoding') == 'gzip' else packed
            index[mini] = len(body), len(body) + len(packed)
            body += packed
        with open('%s/%0*x.shard' % (path, -(-sharding['shard_bits'] // 4), shard), 'wb') as f:
            f.write(b''.join(struct.pack('<QQ', *i) for i in index) + body)

def volume(path, data=labels, chunk=(16, 25, 3), encoding='raw', block=(8, 8, 2), pack='', sharding=None, levels=2, names=True, empty=False):
    scales = []
    for level in range(levels):
        step, key = 1 << level, '%d_%d_%d' % (500 << level, 500 << level, 1250)
        part = data[::step, ::step]
        begin = offset[0] // step, offset[1] // step, offset[2]
        os.makedirs(path + '/' + key)
        scale = dict(key=key, size=part.shape, resolution=[nm[0] * step, nm[1] * step, nm[2]], voxel_offset=begin, chunk_sizes=[chunk], encoding=encoding)
        if encoding != 'raw':
            scale['compressed_segmentation_block_size'] = block
        if sharding:
            scale['sharding'] = dict({'@type': 'neuroglancer_uint64_sharded_v1'}, **sharding)
        scales.append(scale)
        grid, chunks = [-(-n // c) for n, c in zip(part.shape, chunk)], {}
        for at in itertools.product(*map(range, grid)):
            low = [a * c for a, c in zip(at, chunk)]
            high = [min(l + c, n) for l, c, n in zip(low, chunk, part.shape)]
            piece = part[low[0]:high[0], low[1]:high[1], low[2]:high[2]]
            if not piece.any() and not empty:
                continue
            bytes_ = piece.astype(piece.dtype.newbyteorder('<')).tobytes('F') if encoding == 'raw' else blocks(piece, block)
            if sharding:
                chunks[morton(at, grid)] = bytes_
                continue
            name = '_'.join('%d-%d' % (l + b, h + b) for l, h, b in zip(low, high, begin))
            with open('%s/%s/%s%s' % (path, key, name, '.gz' if pack == '.gz' else ''), 'wb') as f:
                f.write(gzip.compress(bytes_, mtime=0) if pack else bytes_)
        if sharding:
            shards('%s/%s' % (path, key), chunks, sharding)
    info = {'@type': 'neuroglancer_multiscale_volume', 'type': 'segmentation', 'data_type': str(data.dtype), 'num_channels': 1, 'scales': scales}
    if names:
        info['segment_properties'] = 'names'
        os.makedirs(path + '/names')
        json.dump({'@type': 'neuroglancer_segment_properties', 'inline': dict(ids=['17', '530', str((1 << 40) + 3)], properties=[
            dict(id='label', type='label', values=['nucleus', 'cell \x1b[31m wall', 'far'])])}, open(path + '/names/info', 'w'))
    json.dump(info, open(path + '/info', 'w'))

small = numpy.where(labels > 1000, 3, labels)
blocky = dict(encoding='compressed_segmentation')
volume('raw')
volume('whole', chunk=(128, 128, 128), empty=True)
volume('gz', pack='.gz')
volume('gz_unnamed', pack='served')
volume('blocks', **blocky)
volume('blocks_gz', pack='.gz', block=(5, 7, 3), **blocky)
volume('noise', encoding='compressed_segmentation', chunk=(64, 64, 64),
       data=labels + (numpy.random.RandomState(1).randint(0, 300, shape).astype(numpy.uint64) + 1000) * (labels == 0))
for name, options in dict(plain=dict(preshift_bits=1, hash='identity', minishard_bits=2, shard_bits=1),
                          hashed=dict(preshift_bits=2, hash='murmurhash3_x86_128', minishard_bits=3, shard_bits=5, minishard_index_encoding='gzip', data_encoding='gzip'),
                          single=dict(preshift_bits=0, hash='identity', minishard_bits=0, shard_bits=0, minishard_index_encoding='raw', data_encoding='gzip')).items():
    volume('shards_' + name, sharding=options)
    volume('shards_blocks_' + name, sharding=options, chunk=(8, 8, 2), **blocky)
for type_ in 'uint16', 'uint32', 'float32':
    volume('type_' + type_, small.astype(type_))
volume('small_blocks', small.astype('uint32'), **blocky)
volume('unnamed', names=False)
header = ('NRRD0004\ntype: int64\ndimension: 3\nsizes: 60 50 7\nspace: 3D-right-handed\nendian: little\n'
          'space directions: (0.0005,0,0) (0,0.0005,0) (0,0,0.00125)\nspace origin: (-0.00975,0.00025,0.125625)\n' +
          ''.join('Segment%d_LabelValue:=%d\nSegment%d_Name:=%s\n' % (i, v, i, n) for i, (v, n) in enumerate([(17, 'nucleus'), (530, 'cell  [31m wall'), ((1 << 40) + 3, 'far')])) +
          'encoding: raw\n\n').encode()
open('same.nrrd', 'wb').write(header + labels.astype('<i8').tobytes('F'))
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "the volumes cannot be written"; }

# read_volume PATH [LAST]: its size, geometry and labels are those of make.py.
read_volume() {
    "$SEGCAST" info "$1" --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1 cannot be read"; }
    jq -e --argjson last "${2:-1099511627779}" '[.labels[1:][] | [.value, .voxels]] | sort == ([[17, 1800], [530, 1710], [$last, 50]] | sort)' info.json >/dev/null ||
        fail "$1: labels $(jq -c '[.labels[] | [.value, .voxels]]' info.json)"
    jq -e '.size == [60, 50, 7] and ([.to_ras_mm[][] | . * 1e9 | round][:12] == [500000, 0, 0, -9750000, 0, 500000, 0, 250000, 0, 0, 1250000, 125625000])' info.json >/dev/null ||
        fail "$1: geometry $(jq -c '[.size, .to_ras_mm]' info.json)"
}
for path in raw whole gz gz_unnamed blocks blocks_gz shards_*; do
    read_volume "$path"
    jq -e '[.labels[1:][].name] == ["nucleus", "cell  [31m wall", "far"]' info.json >/dev/null || fail "$path: names $(jq -c '[.labels[].name]' info.json)"
done
for path in type_* small_blocks; do read_volume "$path" 3; done
read_volume unnamed
"$SEGCAST" info noise --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "noise cannot be read"; }
jq -e '(.labels | length) == 304 and ([.labels[] | select(.value == 17).voxels] == [1800])' info.json >/dev/null || fail "noise: $(jq -c '.labels[:4]' info.json)"

# A level, a part, and pictures: as of the same voxels in NRRD, whatever the threads.
"$SEGCAST" info blocks --set volume.level=1 --json >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "the second scale cannot be read"; }
jq -e '.size == [30, 25, 7] and ([.to_ras_mm[0][0, 3] | . * 1e6 | round] == [1000, -9500])' info.json >/dev/null || fail "the second scale: $(jq -c '[.size, .to_ras_mm]' info.json)"
tell='[.size, [.labels[1:][] | [.value, .voxels]]]'
for box in '[[10, 31], [0, 50], [0, 7]]' '[[13, 14], [17, 33], [2, 3]]' '[[25, 60], [16, 50], [3, 7]]'; do
    wanted=$("$SEGCAST" info same.nrrd --set "volume={box: $box}" --json 2>/dev/null | jq -c "$tell")
    for path in raw blocks_gz shards_blocks_hashed; do
        found=$("$SEGCAST" info "$path" --set "volume={box: $box}" --threads 3 --json 2>/dev/null | jq -c "$tell")
        [ "$found" = "$wanted" ] || fail "$path, $box: $found, expected $wanted"
    done
done
for volume in same.nrrd gz shards_blocks_hashed; do
    for threads in 1 3; do
        "$SEGCAST" still "$volume" --sheet slices -o "$volume.$threads.png" --threads "$threads" -q 2>stderr.txt || { cat stderr.txt >&2; fail "$volume cannot be drawn"; }
        cmp same.nrrd.1.png "$volume.$threads.png" || fail "the picture of $volume with $threads threads is not that of NRRD"
    done
done

# What cannot be read is refused, with one message that names file or key and what was found.
changes="scale = glob.glob('500_*')[0]
first = lambda: sorted(f for f in glob.glob(scale + '/*') if os.path.getsize(f))[0]
def info(**keys):
    data = json.load(open('info')); data.update(keys); json.dump(data, open('info', 'w'))
def scales(**keys):
    data = json.load(open('info')); data['scales'][0].update(keys); json.dump(data, open('info', 'w'))
def sharding(**keys):
    data = json.load(open('info')); data['scales'][0]['sharding'].update(keys); json.dump(data, open('info', 'w'))
def patch(f, at, data):
    with open(f, 'r+b') as s: s.seek(at); s.write(data)"
change raw cut "os.truncate(first(), 100)"
change raw long "os.truncate(first(), 1 << 30)"
change gz gz_cut "os.truncate(first(), 50)"
change gz gz_bomb "import gzip; open(first(), 'wb').write(gzip.compress(bytes(100000)))"
change raw br "os.rename(first(), first() + '.br')"
change raw link "f = first(); os.rename(f, 'outside'); os.symlink('../outside', f)"
change raw scale_link "os.rename(scale, 'outside'); os.symlink('outside', scale)"
change raw no_scale "import shutil; shutil.rmtree(scale)"
change blocks blocks_cut "os.truncate(first(), 8)"
change blocks blocks_word "patch(first(), 0, struct.pack('<I', 2))"
change blocks blocks_bits "patch(first(), 7, b'\x03')"
change blocks blocks_table "patch(first(), 4, b'\xff\xff\xff')"
change blocks blocks_values "patch(first(), 4, struct.pack('<II', 1 << 24, 1 << 31))"
change blocks blocks_size "scales(compressed_segmentation_block_size=[0, 8, 8])"
change blocks blocks_type "info(data_type='uint16')"
change shards_plain shard_cut "os.truncate(first(), 10)"
change shards_plain shard_beyond "f = first(); d = open(f, 'rb').read(); patch(f, 0, struct.pack('<QQ', 1 << 40, (1 << 40) + 24) * 4)"
change shards_plain shard_long "f = first(); patch(f, 0, struct.pack('<QQ', 0, 1 << 50) * 4)"
change shards_plain shard_backwards "f = first(); patch(f, 0, struct.pack('<QQ', 99, 3) * 4)"
change shards_plain shard_overlap "f = first(); n = (os.path.getsize(f) - 64) // 24 * 24; patch(f, 0, struct.pack('<QQ', 0, n) * 4)"
change shards_hashed shard_gzip "[patch(f, 0, struct.pack('<QQ', 0, 48) * 8) for f in glob.glob(scale + '/*')]"
change shards_plain shard_type "sharding(**{'@type': 'other'})"
change shards_plain shard_hash "sharding(hash='md5')"
change shards_plain shard_bits "sharding(minishard_bits=40)"
change raw jpeg "scales(encoding='jpeg')"
change raw negative "scales(size=[-60, 50, 7])"
change raw huge "scales(size=[7000, 5000, 2000])"
change raw huge_chunks "scales(chunk_sizes=[[100000, 100000, 10]], size=[100000, 100000, 10])"
change raw many_chunks "scales(chunk_sizes=[[1, 1, 1]], size=[1024, 1024, 2])"
change raw parent "scales(key='../raw/500_500_1250')"
change raw names_parent "info(segment_properties='/etc')"
change raw mesh "info(**{'@type': 'neuroglancer_legacy_mesh'})"
change raw channels "info(num_channels=3)"
change raw type_ "info(data_type='complex')"
change raw resolution "scales(resolution=[1, 0, 1])"
change raw no_scales "info(scales=[])"
change raw no_json "open('info', 'w').write('{\n')"
change raw escape "scales(encoding='\x1b[31m')"
refused <<'TABLE'
65 cut cut/500_500_1250/-.*: has 100 bytes of values, expected 9600
65 long long/500_500_1250/-.*: has 1073741824 bytes, more than a chunk of 9600 bytes can take
65 gz_cut .*\.gz: gzip: ends too early
65 gz_bomb .*\.gz: gzip: unpacks to more bytes than are expected
65 br .*\.br: is packed in a way that is not read, expected chunks as they are, or packed by gzip
65 link 500_500_1250/-.*: is no regular file; links in the directory of a volume are not followed
65 scale_link scale_link/500_500_1250: is no directory, but .*/info: "key" of a scale names it; expected a directory, no link
66 no_scale no_scale/500_500_1250: is not there, but .*/info: "key" of a scale names it
65 blocks_cut compressed_segmentation: has fewer bytes than its blocks need
65 blocks_word compressed_segmentation: has another first word than 1
65 blocks_bits compressed_segmentation: has a block whose bits for each voxel are not 0, 1, 2, 4, 8, 16 or 32
65 blocks_table compressed_segmentation: has a voxel whose label lies behind its end
65 blocks_values compressed_segmentation: has a block whose values lie behind its end
65 blocks_size "compressed_segmentation_block_size" is not as expected: three numbers of voxels
65 blocks_type "data_type" is not as expected: uint32 or uint64, which compressed_segmentation holds
65 shard_cut 0.shard: is shorter than the index of a shard
65 shard_beyond 0.shard: the index of a minishard leads behind the end of the file
65 shard_long 0.shard: has a minishard whose index is longer than 48 MiB
65 shard_backwards 0.shard: the index of the shard is damaged
65 shard_overlap 0.shard: the indices of its minishards have more bytes than it has
65 shard_gzip shard: the index of a minishard is damaged .gzip.
65 shard_type "@type" of "sharding" is not as expected
65 shard_hash "hash" of "sharding" is not as expected
65 shard_bits "minishard_bits" of "sharding" is not as expected
65 jpeg its "encoding" is "jpeg", which is not read; expected "raw" or "compressed_segmentation"
65 negative "size" is not as expected: three numbers of voxels, from 1 to 2147483647
71 huge 7000 x 5000 x 2000 voxels take about .* GiB of memory, more than the limit .* --max-memory
65 huge_chunks has chunks of up to 800000000000 bytes, expected at most
65 many_chunks what is to be read lies in 2097152 chunks of 1 x 1 x 1 voxels, expected at most 1048576; choose a part
65 parent "key" of a scale names "../raw/500_500_1250": outside the header's directory
65 names_parent "segment_properties" is "/etc": an absolute path
65 mesh is of type "neuroglancer_legacy_mesh", expected "neuroglancer_multiscale_volume": meshes
65 channels "num_channels" is not as expected: 1
65 type_ "data_type" is not as expected: uint8
65 resolution "resolution" is not as expected: three lengths of voxels in nm, above 0
65 no_scales "scales" is not as expected: a list of at least one scale
65 no_json info:2: is no JSON
65 escape its "encoding" is ".*31m", which is not read
TABLE
"$SEGCAST" info many_chunks --set 'volume={box: [[0, 8], [0, 8], [0, 2]]}' >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "a part of many chunks cannot be read"; }
expect 65 'has no resolution level 2, expected one of 2: 0 ."500_500_1250" of .60, 50, 7.., 1 ."1000_1000_1250" of .30, 25, 7..; 0 is the finest' \
    "$SEGCAST" info raw --set volume.level=2
"$SEGCAST" info raw >stdout.txt 2>stderr.txt || fail "raw cannot be read"
grep -q 'raw/500_500_1250: 7 of 24 chunks are not there; they count as background' stderr.txt || { cat stderr.txt >&2; fail "chunks that are not there are not told"; }
"$SEGCAST" info whole >stdout.txt 2>stderr.txt || fail "whole cannot be read"
! grep -q 'not there' stderr.txt || { cat stderr.txt >&2; fail "of a whole volume chunks are said to be missing"; }
expect 66 'raw/500_500_1250: is a directory of chunks; give the directory above it, which holds "info"' "$SEGCAST" info raw/500_500_1250
cp -r raw lost && rm -r lost/names
"$SEGCAST" info lost >stdout.txt 2>stderr.txt || { cat stderr.txt >&2; fail "without its names a volume is not read"; }
grep -q 'lost/names/info: is not there, but .*/info names it; labels have no names from it' stderr.txt || { cat stderr.txt >&2; fail "lost names are not told"; }
