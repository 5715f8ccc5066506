# SPDX-License-Identifier: BSD-3-Clause
# Outputs of a finished job that their user has changed are renamed, not lost, when segcast makes them again; and
# `segcast verify` sees a change in every file of a job, also in records of a slice that has no frames.
small_job job.yaml
sed -i 's/video: none/video: film.mp4, fps: 4, frames: png/' job.yaml
"$SEGCAST" render job.yaml -o first -q >/dev/null
cp job.yaml other.yaml

for name in stats.json report.html status.json trace.json frames.csv job.yaml film.mp4 frames/000001.png; do
    sampled || continue
    rm -rf out
    cp -r first out
    rounds=('')
    [ $name != film.mp4 ] || rounds=('' -2)
    for round in "${rounds[@]}"; do
        case $name in
        *.png) cp first/frames/000004.png out/$name ;; # a picture all the same: what is damaged is just made again
        *) echo "mine$round" >>"out/$name" ;;
        esac
        cp "out/$name" mine
        expect 0 "out/$name: was changed after segcast had made it; that file is now out/$name.changed$round" \
            "$SEGCAST" render other.yaml -o out --resume
        cmp mine "out/$name.changed$round" || fail "$name: what its user had written is lost"
        expect 0 '' "$SEGCAST" verify out
    done
    cmp first/film.mp4 out/film.mp4 || fail "$name: the film is another one after --resume"
done

# A job.yaml that is the very file that was given stays as it is, also in the directory of a finished job; with another
# job file it is kept aside, also while the job is not finished.
rm -rf out
cp -r first out
echo '# mine' >>out/job.yaml
cp out/job.yaml mine
expect 0 '' "$SEGCAST" render out/job.yaml -o out --resume
cmp mine out/job.yaml || fail "--resume has changed the job that was given"
[ ! -e out/job.yaml.changed ] || fail "the job that was given was renamed"
expect 0 '' "$SEGCAST" verify out
(ulimit -f 30; expect 74 '' "$SEGCAST" render job.yaml -o part)
expect 75 '' "$SEGCAST" status part
expect 74 '' bash -c 'ulimit -f 30; exec "$@"' bash "$SEGCAST" render other.yaml -o part --resume
[ ! -e part/job.yaml.changed ] || fail "a job.yaml that nobody has changed was renamed"
echo '# mine' >>part/job.yaml
cp part/job.yaml mine
expect 0 'part/job.yaml: was changed after segcast had made it; that file is now part/job.yaml.changed' \
    "$SEGCAST" render other.yaml -o part --resume
cmp mine part/job.yaml.changed || fail "what the user had written into the job of an unfinished run is lost"
expect 0 '' "$SEGCAST" verify part

# Slices write job.yaml in turn, each its own text; what its user has written between two of them is kept. One that is
# the job that was given stays, and is not proven.
"$SEGCAST" render job.yaml -o turns --slice 0/3 -q >/dev/null
expect 0 '' "$SEGCAST" render job.yaml -o turns --slice 1/3 --set render.skip=leap
[ ! -e turns/job.yaml.changed ] || fail "a slice has renamed the job.yaml of another"
cp -r turns given
echo '# mine' | tee -a turns/job.yaml >>given/job.yaml
cp turns/job.yaml mine
expect 0 'turns/job.yaml: was changed after segcast had made it; that file is now turns/job.yaml.changed' \
    "$SEGCAST" render other.yaml -o turns --slice 2/3
cmp mine turns/job.yaml.changed || fail "what the user had written into the job of slices is lost"
"$SEGCAST" verify turns | grep -q ', job.yaml' || fail "job.yaml of slices is not proven"
expect 0 '' "$SEGCAST" render given/job.yaml -o given --slice 2/3
cmp mine given/job.yaml || fail "a slice has changed the job that was given"
"$SEGCAST" verify given | grep -q 'all verified' || fail "slices of a job in their own directory"
! "$SEGCAST" verify given | grep -q 'job\.yaml' || fail "the job of the user is said to be that of segcast"

# So does `segcast report`; nothing is renamed that segcast has written itself.
cp -r first page
"$SEGCAST" report page -q >/dev/null
"$SEGCAST" report page -q >/dev/null
"$SEGCAST" render job.yaml -o page --resume -q >/dev/null
[ "$(ls page | grep -c changed)" = 0 ] || fail "files of segcast itself were renamed: $(ls page)"
echo mine >>page/report.html
cp page/report.html mine
expect 0 'page/report.html: was changed' "$SEGCAST" report page
cmp mine page/report.html.changed || fail "report: what the user had written is lost"
expect 0 '' "$SEGCAST" verify page

# --overwrite in the directory of the job that is given: the file is there at every moment, also when nothing more can
# be written after the earlier run was removed.
cp -r first again
cd again
expect 0 '' "$SEGCAST" render job.yaml -o . --overwrite
cmp ../first/job.yaml job.yaml || fail "--overwrite has changed the job that was given"
expect 74 '' bash -c 'ulimit -f 1; exec "$@"' bash "$SEGCAST" render job.yaml -o . --overwrite
[ ! -e film.mp4 ] || fail "the earlier run was not removed, so this shows nothing"
cmp ../first/job.yaml job.yaml || fail "the job that was given is lost"
cd ..

# Seven frames are one GOP: the first of two slices has none. Its records are proven like all others.
sed 's/fps: 4/fps: 24/' job.yaml >one_gop.yaml
"$SEGCAST" render one_gop.yaml -o slices --slice 0/2 -q >/dev/null
"$SEGCAST" render one_gop.yaml -o slices --slice 1/2 -q >/dev/null
expect 0 '' "$SEGCAST" verify slices
[ -e slices/stats.0of2.json ] || fail "the slice without frames has left no statistics: $(ls slices)"
for file in slices/*.*; do
    sampled || continue
    cp "$file" kept
    printf x >>"$file"
    expect 65 '' "$SEGCAST" verify slices
    cp kept "$file"
done
expect 0 '' "$SEGCAST" verify slices
