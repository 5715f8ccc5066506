# SPDX-License-Identifier: BSD-3-Clause
# Volumes in HDF5 that are damaged, and a program segcast-hdf5 that crashes, hangs or sends nonsense: segcast ends with
# one message, and no process is left.
"$SEGCAST" --version | grep -q '^volumes .*HDF5' || skip "segcast was built without libhdf5"
find_python 'h5py, numpy' python3-h5py
cat >make.py <<'PYTHON'
import h5py, numpy
labels = numpy.zeros((5, 6, 7), 'u2')
labels[1:4, 2:5, 1:6] = 3
for name, version in ('old', 'earliest'), ('new', 'latest'):
    with h5py.File('small_%s.h5' % name, 'w', libver=version) as f:
        d = f.create_dataset('a/labels', data=labels, chunks=(2, 6, 4), compression='gzip', shuffle=True)
        d.attrs['element_size_um'] = 2., 1, 1
        f['link'] = h5py.SoftLink('/a/labels')
with h5py.File('deep.h5', 'w', libver='latest') as f: # looking at all of it took two minutes
    group = f
    for _ in range(3000):
        group = group.create_group('g')
    group.create_dataset('labels', data=labels)
with h5py.File('large.h5', 'w') as f: # all of it is the fill value
    f.create_dataset('large', (2000, 2000, 2000), 'u1', chunks=(64, 64, 64))
    d = f.create_dataset('bomb', (64, 64, 64), 'u1', chunks=(64, 64, 64), compression='gzip')
    import zlib
    d.id.write_direct_chunk((0, 0, 0), zlib.compress(bytes(400 << 20)))
PYTHON
"$python" make.py 2>python.txt || { cat python.txt >&2; fail "the volumes cannot be written"; }

expect 66 'deep.h5: holds no dataset of integers along three axes in / that can be found without a long search' \
    timeout 30 "$SEGCAST" info deep.h5

# A program that crashes, hangs or sends nonsense: one message, and no process is left.
mkdir bin
cp "$SEGCAST" bin/segcast
cat >bin/segcast-hdf5 <<'SH'
#!/bin/sh
echo $$ >pid.txt
. ./does.sh
SH
chmod +x bin/segcast-hdf5
while read -r code does pattern; do
    echo "${does//_/ }" >does.sh
    expect "$code" "segcast: error: .*small_old.h5: .*$pattern" bin/segcast info small_old.h5
    one_error
    ! kill -0 "$(cat pid.txt)" 2>/dev/null || fail "${does//_/ }: the process is left"
done <<'TABLE'
65 kill_-SEGV_$$ the HDF5 library crashed .signal 11. while it read the file; the file is damaged
65 kill_-ABRT_$$ the HDF5 library crashed .signal 6.
65 kill_-KILL_$$ was ended .signal 9. by a limit of CPU time or memory
65 ulimit_-t_1;while_:;do_:;done was ended .signal [0-9]*. by a limit of CPU time
65 exit_1 the HDF5 library ended too early
71 exit_127 ended with exit code 127 before it began
65 echo_text the HDF5 library ended too early
65 yes has answered with what is none
65 exec_yes_>/dev/stdout has answered with what is none
65 exec_>&-;exec_sleep_1000 the HDF5 library ended too early
TABLE
chmod -x bin/segcast-hdf5
expect 71 'the program that reads HDF5, .*segcast-hdf5, cannot be started: ' bin/segcast info small_old.h5
one_error

# Two files that crash libhdf5 1.10.8 (a byte or a few changed): a newer library may refuse or even read them.
for path in "$SOURCE"/tests/data/hdf5-crash-*.h5; do
    code=0
    "$SEGCAST" info "$path" >stdout.txt 2>stderr.txt || code=$?
    case $code in
    0) ;;
    65 | 66) one_error ;;
    *) cat stderr.txt >&2; fail "$path: exit code $code" ;;
    esac
done

# A chunk that unpacks to more than it may: with room for it, the library takes what the chunk has; else it is refused.
case $BUILD in
*san*) echo "the sanitizers leave no limit of memory" ;;
*)
    expect 65 'large.h5:/bomb: slices 0 to 63 .of the axis z. cannot be read: .*; the file is damaged' "$SEGCAST" info large.h5:/bomb --max-memory 64M
    one_error
    ;;
esac

# Ctrl-C and the death of segcast: the program goes with it. The dataset has 8 GB.
for signal in INT TERM KILL; do
    "$SEGCAST" info large.h5:/large --max-memory 40G >stdout.txt 2>stderr.txt &
    id=$!
    for _ in $(seq 600); do
        child=$(pgrep -P $id -f '/large [0-9]' || true)
        [ -z "$child" ] || break
        sleep 0.02
    done
    [ -n "$child" ] || { cat stderr.txt >&2; fail "the program was not started"; }
    sleep 0.2
    kill -$signal $id
    code=0
    wait $id || code=$?
    case $signal in KILL) wanted=137 ;; *) wanted=75 ;; esac
    [ "$code" = $wanted ] || { cat stderr.txt >&2; fail "$signal: exit code $code, expected $wanted"; }
    for _ in $(seq 100); do kill -0 "$child" 2>/dev/null || break; sleep 0.02; done
    ! kill -0 "$child" 2>/dev/null || fail "$signal: the program goes on without segcast"
done

# Files with a byte changed, or cut off: read, or refused by one message; never another end, and no process is left.
changes=0 refused=0 crashed=0
try() { # try FILE WHAT
    local code=0
    timeout 100 "$SEGCAST" info "$1" >stdout.txt 2>stderr.txt || code=$?
    case $code in
    0) ;;
    65 | 66) one_error ;;
    *) cat stderr.txt >&2; fail "$2: exit code $code" ;;
    esac
    ! grep -q $'\x1b' stderr.txt || fail "$2: an escape code is printed"
    changes=$((changes + 1))
    [ $code = 0 ] || refused=$((refused + 1))
    ! grep -q 'crashed (signal\|was ended (signal' stderr.txt || crashed=$((crashed + 1))
}
many=60
case $BUILD in */asan) many=20 ;; esac # every start takes ten times as long there
for name in old new; do
    bytes=$(stat -c %s small_$name.h5)
    for i in $(seq $many); do
        at=$((i * 7919 % bytes)) value=$((i * 31 % 255 + 1))
        cp small_$name.h5 changed.h5
        printf "\\x$(printf %x $value)" | dd of=changed.h5 bs=1 seek=$at conv=notrunc status=none
        try changed.h5 "small_$name.h5, byte $at = $value"
    done
    for i in $(seq 20); do
        head -c $((bytes * i / 21)) small_$name.h5 >changed.h5
        try changed.h5 "small_$name.h5, $((bytes * i / 21)) bytes"
    done
done
echo "$changes damaged files: $refused refused, $crashed of them because the library crashed"
[ "$changes" = $((2 * many + 40)) ] && [ "$refused" -gt 40 ] || fail "$changes damaged files, $refused refused"
