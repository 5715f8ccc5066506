# SPDX-License-Identifier: BSD-3-Clause
# A prepared file that is cut off, or written into, while jobs have it mapped ends them with one message that names
# it, and with exit code 74. Frames that were drawn since are not accepted.
cat >job.yaml <<'YAML'
volume: heart.segc
output: {directory: out, size: [640, 480], video: none}
animation: {frames: 100000}
YAML
for way in alone mpi written; do
    "$SEGCAST" convert phantom:79x55x81 -o heart.nrrd --overwrite -q >/dev/null
    "$SEGCAST" convert heart.nrrd -o heart.segc --overwrite -q >/dev/null
    if [ $way != mpi ]; then
        "$SEGCAST" render job.yaml -o $way -q >/dev/null 2>stderr.txt &
    elif command -v mpirun >/dev/null && "$SEGCAST" --version | grep -qv 'MPI *none'; then
        mpi 2 "$SEGCAST" render job.yaml -o $way -q >/dev/null 2>stderr.txt &
    else
        continue
    fi
    id=$!
    wait_until '[ "$(frames $way)" -gt 0 ]'
    [ "$(frames $way)" -gt 0 ] || fail "$way: no frame was drawn in a minute: $(cat stderr.txt)"
    said='cannot be read any more'
    if [ $way = written ]; then
        said='(was written into while frames were drawn|cannot be read any more)' # if a number in it led too far
        kill -STOP $id
        before=$(stat -c %s $way/manifest.jsonl)
        head -c 200000 /dev/zero | tr '\0' '\377' | dd of=heart.segc bs=4096 seek=64 conv=notrunc status=none
        kill -CONT $id
    else
        truncate -s 4096 heart.segc
    fi
    code=0
    wait $id || code=$?
    [ $code = 74 ] || fail "$way: exit code $code, expected 74: $(cat stderr.txt)"
    grep -qE "segcast: error: .*heart.segc: $said" stderr.txt || fail "$way: $(cat stderr.txt)"
    [ $way = mpi ] || one_error
    [ $way != written ] || [ "$(stat -c %s $way/manifest.jsonl)" -le $((before + 200)) ] ||
        fail "frames of a changed volume were accepted"
done

# The same during a single picture, whose file then does not appear.
"$SEGCAST" convert heart.nrrd -o heart.segc --overwrite -q >/dev/null
"$SEGCAST" still job.yaml --set output.size=[4000,4000] --set render.quality=still -o big.png 2>stderr.txt >stdout.txt &
id=$!
wait_until 'grep -qs heart.segc /proc/$id/maps'
truncate -s 4096 heart.segc
code=0
wait $id || code=$?
[ $code = 74 ] && [ ! -e big.png ] && [ ! -s stdout.txt ] || fail "still: exit code $code: $(cat stderr.txt)"
one_error
