# SPDX-License-Identifier: BSD-3-Clause
# segcast verify proves every byte of every file of a finished job: one bit changed anywhere is exit code 65.
# SC_TEST_ALL=1 changes every byte (20 minutes); otherwise about two hundred of them are tried.
cat >job.yaml <<'YAML'
volume: phantom:40x32x40
output: {directory: out, size: [32, 32], fps: 2, frames: png, video: v.mp4}
animation: {frames: 3}
YAML
step=67
[ -z "${SC_TEST_ALL:-}" ] || step=1
"$SEGCAST" render job.yaml -o out -q >/dev/null
"$SEGCAST" verify out >said.txt || fail "verify of an undamaged directory"
for file in $(find out -type f | sort); do
    case $file in */report.html) every=$((15 * step)) ;; *) every=$step ;; esac # it is many times larger than the others
    "$FLIP_BYTES" $every 65 "$file" "$SEGCAST" verify out -q || fail "a change in $file was not found"
done
"$SEGCAST" verify out >/dev/null || fail "the directory is not as it was"
# It says what it has proven, and that is every file.
for file in job.yaml manifest.jsonl status.json stats.json frames.csv trace.json report.html v.mp4 '3 PNG files'; do
    grep -q -- "[ :,]$file" said.txt || fail "verify does not say that it has proven $file: $(cat said.txt)"
done

# Files that are cut, longer or missing are damage, too; a manifest that is cut is that of an unfinished job.
for file in $(find out -type f | sort); do
    case $file in */manifest.jsonl) cut=75 gone=66 ;; *) cut=65 gone=65 ;; esac
    cp "$file" kept
    truncate -s -1 "$file"
    expect $cut '' "$SEGCAST" verify out; one_error
    cp kept "$file"
    echo >>"$file"
    expect 65 '' "$SEGCAST" verify out; one_error
    rm "$file"
    expect $gone '' "$SEGCAST" verify out; one_error
    cp kept "$file"
done
"$SEGCAST" verify out >/dev/null || fail "the directory is not as it was"

# The records of a job that was drawn in slices are proven, too.
for i in 0 1; do "$SEGCAST" render job.yaml -o sliced --slice $i/2 -q >/dev/null; done
for file in sliced/status.0of2.json sliced/stats.1of2.json sliced/frames.0of2.csv sliced/trace.1of2.json sliced/report.0of2.html sliced/job.yaml; do
    "$FLIP_BYTES" 401 65 "$file" "$SEGCAST" verify sliced -q || fail "a change in $file was not found"
done

# What was damaged is made again by --resume; then all is proven again.
for file in job.yaml stats.json report.html status.json v.mp4 frames/000001.png; do
    cp "out/$file" kept
    echo >>"out/$file"
    "$SEGCAST" render job.yaml -o out --resume -q >/dev/null 2>&1
    "$SEGCAST" verify out >/dev/null || fail "after --resume with a damaged $file"
    case $file in *.mp4 | *.png) cmp kept "out/$file" || fail "--resume makes another $file" ;; esac
done
