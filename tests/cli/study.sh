# SPDX-License-Identifier: BSD-3-Clause
# `segcast study`: what it measures, how it goes on after a stop, and what it refuses.
write_study() {
    cat >study.yaml <<EOF
title: "A small study"
set: {volume: "phantom:32x24x32", output: {size: 64x64}, animation: {frames: 8}}
sweep:
  render.skip: [none, leap]
  layers:
    opaque: {tissues: {"*": {opacity: 1}}, threads: 1}
    all: {threads: 1}
    four thousand: {threads: 4096}
least: 2
most: 2
budget: ${1:-20 min}
EOF
}
measurements() { cat "$1/measurements.jsonl" 2>/dev/null | grep -c '^{"measurement"' || true; }

# Every cell that can run here is measured; those that cannot are listed.
write_study
expect 0 '' "$SEGCAST" study study.yaml -o out -q
[ "$(measurements out)" = 8 ] || fail "$(measurements out) measurements, expected 8"
[ "$(tail -1 stdout.txt)" = out ] || fail "the path of the directory is not printed: $(cat stdout.txt)"
grep -qE '^render.skip  layers +CPU s/frame +\+- +s/frame +n  times as fast as opaque$' stdout.txt || fail "head: $(cat stdout.txt)"
[ "$(grep -cE '^(none|leap) +(opaque|all) +[0-9.e-]+ +[0-9.e-]+ +2' stdout.txt)" = 4 ] || fail "results: $(cat stdout.txt)"
[ "$(grep -c 'needs 4096 threads a rank' stdout.txt)" = 2 ] || fail "cells that cannot run: $(cat stdout.txt)"
[ "$(wc -l <out/cells.csv)" = 7 ] || fail "cells.csv: $(cat out/cells.csv)"
head -1 out/cells.csv | grep -q ',core_s,core_draw_s,.*,core_other_s' || fail "cells.csv has no core time: $(head -1 out/cells.csv)"
jq -e '.state == "complete" and .done == 8 and .total == 8' out/status.json >/dev/null || fail "$(cat out/status.json)"
jq -es 'length == 16 and all(.value > 0)' out/extrap.jsonl >/dev/null || fail "extrap.jsonl"
# Both methods draw the same pixels, and the layers others.
hashes=$(jq -r 'select(.measurement) | .measurement | "\(.cell % 3) \(.pixels_hash)"' out/measurements.jsonl | sort -u | wc -l)
[ "$hashes" = 2 ] || fail "$hashes different pictures, expected 2"
expect 0 '' "$SEGCAST" status out
grep -q 'out: a study, complete, 8 measurements of 6 cells, 2 of which cannot run here' stdout.txt || fail "status: $(cat stdout.txt)"
# The study as read can be measured again, as the same one.
expect 73 'already holds a study' "$SEGCAST" study study.yaml -o out -q; one_error
expect 0 '' "$SEGCAST" study out/study.yaml -o out --resume -q
[ "$(measurements out)" = 8 ] || fail "a complete study was measured again"

# The study ends with its page, which is made anew with the same bytes; what is in its way is not touched.
page_has out/report.html '.kind == "study" and .title == "A small study" and .count == 8 and .measured == 4 and .cell_count == 6 and .complete and .missing == 0'
page_has out/report.html '(.axes | map(.name)) == ["render.skip", "layers"] and .series == 0 and .scale == -1 and .paper == null and .mismatch == null'
page_has out/report.html '[.cells[] | .n == 2 and (.times | length) == 2 and .cpu.low == null and .cpu.least <= .cpu.median and .cpu.median <= .cpu.most and .base == .cell] | length == 4 and all'
page_has out/report.html '[.cells[] | .limit as $l | ["draw", "cores", "start", "encode", "wait"] | index($l) != null] | all'
page_has out/report.html '[.cells[].core | .core_s > 0 and .draw_s > 0] | all'
page_has out/report.html '(.skipped | length) == 1 and .skipped[0].count == 2 and (.skipped[0].reason | test("needs 4096 threads a rank"))'
page_has out/report.html '(.runs | length) == 2 and (.settings | test("least: 2")) and .files == ["measurements.jsonl", "cells.csv", "extrap.jsonl", "study.yaml"]'
[ "$(jq -r 'select(.run).run.kernel' out/measurements.jsonl)" ] || fail "the kernel of the processor is not noted"
cp out/report.html page.html
echo damaged >out/report.html
expect 0 '' "$SEGCAST" report out
[ "$(cat stdout.txt)" = out/report.html ] || fail "report does not print the path of the page: $(cat stdout.txt)"
cmp out/report.html page.html || fail "report made another page"
rm out/report.html
ln -s ../page.html out/report.html
expect 73 'out/report.html: was not made by segcast' "$SEGCAST" report out; one_error
[ -L out/report.html ] || fail "a link was replaced"
rm out/report.html
expect 0 '' "$SEGCAST" report out/
expect 64 '-o names the page that compares several directories' "$SEGCAST" report out -o x.html; one_error
# As tables in Markdown, for documents: methods as columns, beside the times of the paper where both of its are there.
expect 0 '' "$SEGCAST" report out --markdown
grep -qxE '\| opaque \| [0-9.e-]+ \| [0-9.e-]+ \([0-9.]+\) \|' stdout.txt && grep -qx '|  | none | leap |' stdout.txt ||
    fail "the table of methods: $(cat stdout.txt)"
grep -q '^| all: samples per ray | [0-9.]* | [0-9.]* |$' stdout.txt && grep -q 'Medians of 2 measurements. Measured on' stdout.txt ||
    fail "the table of work: $(cat stdout.txt)"
! grep -q 'the paper' stdout.txt || fail "a study without the paper's methods shows its times"
sed '1s/"leap"/"interior"/' out/measurements.jsonl >tables.jsonl
mkdir tables
mv tables.jsonl tables/measurements.jsonl
expect 0 '' "$SEGCAST" report out tables --markdown
grep -qx '| the paper, its heart and computer | 3.3 | 2.1 (1.57) |' stdout.txt || fail "the times of the paper: $(cat stdout.txt)"
sed '1s/"layers"/"ranks"/' out/measurements.jsonl >tables/measurements.jsonl
expect 0 '' "$SEGCAST" report tables --markdown
grep -q '^| | seconds a frame | CPU seconds a frame | speed-up ' stdout.txt || fail "the table of scaling: $(cat stdout.txt)"
expect 64 'give either it or -o' "$SEGCAST" report out --markdown -o x.html; one_error
mkdir nothing
expect 66 'nothing: holds no timing study' "$SEGCAST" report nothing --markdown; one_error
# Of several, a comparison; with other pixels it says so. Of damaged ones and of mixtures, one message.
cp -r out other
sed '0,/"pixels_hash":"[0-9a-f]*"/s//"pixels_hash":"0123456789abcdef"/' out/measurements.jsonl >other/measurements.jsonl
[ "$(grep -c '"pixels_hash":"0123456789abcdef"' other/measurements.jsonl)" = 1 ] || fail "not one measurement was changed"
expect 0 '' "$SEGCAST" report other
page_has other/report.html '.mismatch | length == 2'
expect 0 '' "$SEGCAST" report out out -o same.html
page_has same.html '.kind == "studies" and .studies[1].beside == {"common": 4, "apart": 0, "other_pixels": 0, "mean": 1, "farthest": 1} and (.cells | length) == 4'
expect 0 '' "$SEGCAST" report out other -o same.html --overwrite
page_has same.html '.studies[1].beside.other_pixels == 1'
sed -i 's/"pixels_hash":"./"pixels_hash":"x/' other/measurements.jsonl
expect 65 'other/measurements.jsonl:[0-9]*: this is no line' "$SEGCAST" report other; one_error
expect 65 'other/measurements.jsonl:[0-9]*: this is no line' "$SEGCAST" report out other -o x.html; one_error
echo '{"schema":"another"}' >other/measurements.jsonl
expect 65 'other/measurements.jsonl:1: this is not the first line' "$SEGCAST" report other; one_error
small_job run.yaml
"$SEGCAST" render run.yaml -o run -q >/dev/null
expect 64 'out holds a timing study, and run does not' "$SEGCAST" report run out -o x.html; one_error
expect 64 'out holds a timing study, and nowhere does not' "$SEGCAST" report out nowhere -o x.html; one_error
[ ! -e x.html ] || fail "a page was left by a mistake"

# The document lists the keys that there are.
sed -n 's/^\([a-z]*\):.*/\1/p' out/study.yaml | sort >keys.txt
sed -n '/^| key |/,/^$/p' "$SOURCE/docs/studies.md" | cut -d'|' -f2 | grep -o '`[a-z]*`' | tr -d '`' | sort >documented.txt
diff keys.txt documented.txt || fail "docs/studies.md and the keys of a study differ (above)"

# A study that was stopped goes on; measurements that were there stay.
sed -i 's/most: 2/most: 6\nprecision: 0.1%/' study.yaml
"$SEGCAST" study study.yaml -o stopped -q >/dev/null 2>stderr.txt &
pid=$!
while [ "$(measurements stopped)" -lt 3 ]; do
    kill -0 $pid 2>/dev/null || fail "the study ended early: $(cat stderr.txt)"
    sleep 0.05
done
kill -USR1 $pid # TERM would end it at once while it prepares a volume
code=0
wait $pid || code=$?
[ "$code" = 75 ] || fail "exit $code of a study that was stopped, expected 75: $(cat stderr.txt)"
grep -q 'run again with --resume' stderr.txt || fail "a stop: $(cat stderr.txt)"
expect 75 '' "$SEGCAST" status stopped --json
jq -e '.condition == "incomplete" and .cells == 6' stdout.txt >/dev/null || fail "status --json: $(cat stdout.txt)"
page_has stopped/report.html '.complete == false'
jq -e '.state == "incomplete" and .total == 24 and .done < 24 and .done >= 3' stopped/status.json >/dev/null || fail "$(cat stopped/status.json)"
cp stopped/measurements.jsonl before.jsonl
printf '{"measurement":{"cell":0,"rou' >>stopped/measurements.jsonl # as after a power failure
expect 0 '' "$SEGCAST" study study.yaml -o stopped --resume -q
[ "$(measurements stopped)" = 24 ] || fail "$(measurements stopped) measurements after a stop, expected 24"
cmp -n "$(stat -c %s before.jsonl)" before.jsonl stopped/measurements.jsonl || fail "measurements were changed"

# Other settings are another study; --overwrite begins anew; a damaged file and a wrong pixel are told.
expect 73 'of another study' "$SEGCAST" study study.yaml -o stopped --resume -q --set output.size=72x64; one_error
sed 's/least: 2/least: 1/; s/most: 6/most: 1/' study.yaml >one.yaml
expect 0 '' "$SEGCAST" study one.yaml -o stopped --overwrite -q
[ "$(measurements stopped)" = 4 ] || fail "--overwrite kept measurements"
sed 's/"pixels_hash":"./"pixels_hash":"x/' stopped/measurements.jsonl >damaged.jsonl
cp -r stopped wrong
cp damaged.jsonl wrong/measurements.jsonl
expect 65 'measurements.jsonl:[0-9]*: this is no line' "$SEGCAST" study one.yaml -o wrong --resume -q; one_error
sed '0,/"pixels_hash":"[0-9a-f]*"/s//"pixels_hash":"0123456789abcdef"/' stopped/measurements.jsonl >wrong/measurements.jsonl
expect 70 'show the same picture, but their pixels differ' "$SEGCAST" study one.yaml -o wrong --resume -q; one_error

# Skip methods are compared within one instruction set, also where leap has kernels for a better one than the others.
cat >rivals.yaml <<EOF
set: {volume: "phantom:32x24x32", output: {size: 64x64}, animation: {frames: 8}}
sweep: {render.skip: [octree, leap], render.cpu: [auto, sse4]}
least: 1
most: 1
EOF
expect 0 '' "$SEGCAST" study rivals.yaml -o rivals
mv stderr.txt rivals.txt
grep -qE '^octree +sse4 +this build has no such kernel' stdout.txt || fail "a kernel that is not built: $(cat stdout.txt)"
kernel=$(jq -r 'select(.run).run.kernel' rivals/measurements.jsonl)
small_job rival.yaml
expect 0 '' "$SEGCAST" render rival.yaml -o rival -q --set render.skip=octree
[ "$(jq -r .kernel rival/stats.json)" = "$kernel" ] || fail "the kernel of octree is $(jq .kernel rival/stats.json), that of the study $kernel"
if "$SEGCAST" check rival.yaml --cpu avx512 >/dev/null 2>&1; then
    grep -q "drawn by kernels for $kernel," rivals.txt || fail "the study does not say which kernels draw"
    expect 0 "kernel voxel/octree, $kernel|kernel smooth/octree, $kernel" "$SEGCAST" render rival.yaml -o rival --overwrite --set render.skip=octree --cpu avx512
fi

# Files of others stay.
mkdir foreign
echo mine >foreign/cells.csv
expect 73 'cells.csv: is in the way' "$SEGCAST" study one.yaml -o foreign -q; one_error
[ "$(cat foreign/cells.csv)" = mine ] || fail "a foreign file was changed"
expect 73 'cells.csv: is in the way' "$SEGCAST" study one.yaml -o foreign --overwrite -q; one_error

mkdir -p others/work links pages
echo mine >pages/report.html
expect 73 'pages/report.html: is in the way' "$SEGCAST" study one.yaml -o pages -q; one_error
[ "$(cat pages/report.html)" = mine ] || fail "a foreign page was changed"
expect 73 'others/work: is in the way' "$SEGCAST" study one.yaml -o others -q; one_error
ln -s nowhere links/cells.csv
expect 73 'links/cells.csv: is in the way' "$SEGCAST" study one.yaml -o links -q; one_error
mkdir empty
sed 's/budget:.*/budget: 1s/; s/64x64/4k/' one.yaml >long.yaml
expect 64 'the budget is 1 s' "$SEGCAST" study long.yaml -o empty -q; one_error
[ -d empty ] && [ -z "$(ls -A empty)" ] || fail "a study that was refused changed a directory of the user"

# A budget that cannot hold what is asked for: what it allows is measured.
sed 's/least: 1/least: 1000/; s/most: 1/most: 1000/; s/budget:.*/budget: 8s/' one.yaml >short.yaml
expect 0 'the budget of 8 s is used up: 4 of 4 cells were measured fewer than 1000 times, and 0 of them not at all' "$SEGCAST" study short.yaml -o short -q
grep -q 'the budget of 8 s lets each of 4 cells be measured about [0-9]* times\?, and not 1000' stderr.txt || fail "no plan: $(cat stderr.txt)"
page_has short/report.html '.complete and .measured == 4'
sed -i '/"measurement":{"cell":[13],/d; /"complete"/d' short/measurements.jsonl
sed -i 's/budget: 8s/budget: 1ms/' short.yaml
expect 75 'and 2 of them not at all' "$SEGCAST" study short.yaml -o short --resume -q
page_has short/report.html '.complete == false and .measured == 2 and .missing == 2'

# Mistakes of the study, of the jobs of its cells, and a budget that cannot hold it.
refuse() { # CODE MESSAGE SED_COMMAND...
    local code=$1 message=$2
    shift 2
    sed "$@" one.yaml >bad.yaml
    expect "$code" "$message" "$SEGCAST" study bad.yaml -o bad -q
    [ ! -e bad ] || fail "a study that was refused left its directory: $(ls -a bad)"
}
refuse 65 'bad.yaml:4: unknown key "rende"; did you mean "render"' 's/render.skip:/rende.skip:/'; one_error
refuse 64 'bad.yaml:4: render.skp: .*did you mean "skip"' 's/render.skip:/render.skp:/'
refuse 64 'bad.yaml:4: render.skip: unknown skip "lep"; did you mean "leap"' 's/leap/lep/'
refuse 65 'bad.yaml:4: render.skip has no values' 's/\[none, leap\]/[]/'; one_error
refuse 64 'the budget is 1 s, and looking at [0-9] of 4 cells took longer' 's/budget:.*/budget: 1s/; s/64x64/4k/'; one_error
refuse 66 'nowhere.yaml: No such file' '1s/^/job: nowhere.yaml\n/'; one_error
expect 66 'absent.yaml' "$SEGCAST" study absent.yaml -q; one_error

# Whole jobs: from reading to the finished video, which stays.
cat >jobs.yaml <<EOF
set: {volume: "phantom:32x24x32", output: {size: 64x64, fps: 4}, animation: {frames: 8}}
sweep: {farm.encode: [rank0, segments]}
measure: job
least: 1
most: 1
budget: 20 min
EOF
expect 0 '' "$SEGCAST" study jobs.yaml -o jobs -q
[ "$(jq -r 'select(.measurement).measurement.frames' jobs/measurements.jsonl | sort -u)" = 8 ] || fail "frames of a job"
[ "$(jq -r 'select(.measurement).measurement.pixels_hash' jobs/measurements.jsonl | sort -u | wc -l)" = 1 ] || fail "pixels of a job"
"$SEGCAST" verify jobs/work >/dev/null || fail "the run that was measured last cannot be verified"

# The studies of weak scaling: as many pixels, or voxels and frames, for each rank in every cell. With a small phantom
# and small pictures all cells are accepted, and those that need more ranks than there are, listed.
for kind in pixels voxels; do
    study=$SOURCE/jobs/studies/weak-$kind.yaml
    sed -n 's/^ *"\([0-9]*\)": {ranks: \([0-9]*\), [a-z_.]*: \([0-9x]*\)\(, animation.frames: \([0-9]*\)\)\?}$/\1 \2 \3 \5/p' "$study" |
        awk -v kind=$kind '{
            n = split($3, sides, "x"); work = 1
            for (i = 1; i <= n; i++) work *= sides[i]
            if (NR == 1) { each = work; frames = $4 }
            if ($1 != $2 || work < 0.99 * each * $2 || work > 1.01 * each * $2 || $4 + 0 != frames * $2) { print; exit 1 }
        } END { if (NR < 6) exit 1 }' >wrong.txt || fail "$study: the work does not grow with the ranks: $(cat wrong.txt)"
    sed -e 's/volume: phantom/volume: "phantom:24x17x25"/; s/1080p/32x32/; s/least: 3/least: 1/; s/most: 10/most: 1/' \
        -e 's/output.size: [0-9x]*/output.size: 32x32/; s/volume.resample: [0-9x]*/volume.resample: 12x9x13/' "$study" >weak.yaml
    rm -rf weak
    "$SEGCAST" study weak.yaml -o weak -q >/dev/null 2>log.txt || fail "weak-$kind: $(cat log.txt)"
    [ "$(grep -c '"measured"' weak/cells.csv)" = 1 ] || fail "weak-$kind: $(cat weak/cells.csv)"
    [ "$(grep -c '"skipped":' weak/measurements.jsonl)" -ge 5 ] || fail "weak-$kind: $(cat weak/measurements.jsonl)"
done
