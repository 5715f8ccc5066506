# SPDX-License-Identifier: BSD-3-Clause
# The page with which every run ends, and `segcast report`, which makes it anew or compares several runs.
command -v jq >/dev/null || skip "jq is not installed"

# Names that HTML would obey become data (page.pages shows that they stay text).
small_job job.yaml
film='a "b" <i>&c:d.mp4'
sed -i 's/video: none/fps: 4/' job.yaml
hostile=('--set' 'output.title="</title><script>alert(1)</script>"' '--set' "output.video='$film'")
mkdir '<b>'
cp job.yaml '<b>/job.yaml'
"$SEGCAST" render '<b>/job.yaml' -o '<b>/out' -q --threads 2 "${hostile[@]}" >/dev/null
page='<b>/out/report.html'
page_has "$page" '.kind == "run" and .title == $value' '</title><script>alert(1)</script>'
page_has "$page" '.video == $value and .frames == 7 and (.pictures | length) == 7 and .there == 7' "$film"
page_has "$page" '(.limit | length) > 10 and .run.frames == 7 and (.ranks | length) == 1 and (.runs | length) == 1 and .run_count == 1'
page_has "$page" '[.phases[] | .wall_s >= 0 and .cpu_s >= 0] | length == 8 and all'
page_has "$page" '(.cost.mean | length) == 7 and .cost.each == 1 and (.cost.slowest[0][1] == (.cost.mean | max)) and (.cost.least[1] == (.cost.mean | min))'
page_has "$page" '(.dots.points | length) == 7 and (.dots.correlation | . >= -1 and . <= 1)'
page_has "$page" '(.heat.kinds | map(.name)) == ["samples", "contributions"] and ([.heat.kinds[] | .low <= .median and .median <= .high and .none < 1] | all)'
page_has "$page" '(.activity.rows | map(.thread)) == [0, 1, null] and ([.activity.rows[0:2][] | .seconds.draw > 0 and (.strip | test("[dD]"))] | all)'
page_has "$page" '(.settings | test("frames: 7")) and .files == ["stats.json", "frames.csv", "trace.json", "manifest.jsonl", "job.yaml"]'
for at in '<b>/out/stats.json' "$page"; do
    { [ "$at" = "$page" ] && page_data "$page" || cat "$at"; } | jq -e '.core_time | (.core_s > 0) and (([.[]] | add) - .core_s) >= .core_s * 0.999' >/dev/null ||
        fail "$at: the causes do not add up to the time of cores"
done

# The page is made anew with the same bytes, whatever became of it, and stays proven.
mv '<b>/out' out
cp out/report.html page.html
cp out/manifest.jsonl manifest.jsonl
expect 0 '' "$SEGCAST" report out -q
[ "$(cat stdout.txt)" = out/report.html ] || fail "report does not print the path of the page: $(cat stdout.txt)"
cmp out/report.html page.html && cmp out/manifest.jsonl manifest.jsonl || fail "report made another page"
echo damaged >out/report.html
expect 65 'out/report.html: is missing, or is not the file' "$SEGCAST" verify out
expect 0 '' "$SEGCAST" report out
cmp out/report.html page.html || fail "report did not mend the page"
rm out/report.html
expect 0 '' "$SEGCAST" report out/
expect 0 '' "$SEGCAST" verify out
# If it becomes another page, the manifest gets its hash, and nothing else changes.
rm out/trace.json
expect 0 '' "$SEGCAST" report out
page_has out/report.html '.activity == "The trace is missing."'
expect 65 'out/trace.json: is missing' "$SEGCAST" verify out
"$SEGCAST" render job.yaml -o out "${hostile[@]}" --resume -q >/dev/null 2>&1
page_has out/report.html '.run.frames == 0 and (.heat.kinds | length) == 2'
expect 0 '' "$SEGCAST" verify out

# What is not segcast's is not touched; what is no run, damaged or not begun is told.
mkdir foreign
cp out/* foreign/
sed -i 's/"report.html",//' foreign/manifest.jsonl
expect 65 'foreign/manifest.jsonl: its first line is damaged' "$SEGCAST" report foreign; one_error
rm out/report.html
ln -s ../page.html out/report.html
expect 73 'out/report.html: was not made by segcast' "$SEGCAST" report out; one_error
rm out/report.html
mkdir out/report.html
expect 73 'out/report.html: was not made by segcast' "$SEGCAST" report out; one_error
rmdir out/report.html
expect 66 'nowhere: No such file' "$SEGCAST" report nowhere; one_error
mkdir empty
expect 66 'empty: holds no run' "$SEGCAST" report empty; one_error
expect 64 'takes the directory that a job has made' "$SEGCAST" report job.yaml; one_error
expect 64 'segcast report needs DIR' "$SEGCAST" report; one_error
expect 64 '-o names the page that compares several directories' "$SEGCAST" report out -o x.html; one_error
cp -r out other
for how in 'truncate -s 1000' 'truncate -s 0' 'sed -i s/per_rank/per_rang/' 'sed -i s/"frame":/"fame":/' 'sed -i s/\"samples\":.\[/\"sample\":[/' 'sed -i s/segcast-stats-1/segcast-stats-9/'; do
    cp out/stats.json kept
    $how out/stats.json
    expect 65 'out/stats.json: is ' "$SEGCAST" report out; one_error
    expect 65 'out/stats.json: is ' "$SEGCAST" report other out -o x.html; one_error
    cp kept out/stats.json
done
rm out/stats.json
expect 75 'out: has no stats.json' "$SEGCAST" report out; one_error
[ ! -e out/report.html ] || fail "a page was made without statistics"
cp kept out/stats.json

# A run that is stopped has a page, too, and so has each slice.
"$SEGCAST" render job.yaml -o slices --slice 0/2 -q >/dev/null
page_has slices/report.0of2.html '.slice == "0of2" and .files[0] == "stats.0of2.json"'
rm slices/report.0of2.html
expect 0 '' "$SEGCAST" report slices
page_has slices/report.0of2.html '.slice == "0of2"'
"$SEGCAST" render job.yaml -o slices --slice 1/2 -q >/dev/null
expect 0 '' "$SEGCAST" verify slices
expect 0 '' "$SEGCAST" report slices
[ "$(cat stdout.txt)" = $'slices/report.0of2.html\nslices/report.1of2.html' ] || fail "the pages of slices: $(cat stdout.txt)"
expect 0 '' "$SEGCAST" verify slices
page_has slices/report.1of2.html '.slice == "1of2"'

# Several directories are compared.
"$SEGCAST" render job.yaml -o 'two <i>' -q --set output.video=none --set output.frames=png >/dev/null
page_has 'two <i>/report.html' '.video == null and (.pictures | length) == 7'
"$SEGCAST" render job.yaml -o three -q --set output.video=none --set render.quality=draft >/dev/null
expect 0 '' "$SEGCAST" report out 'two <i>' -o compared.html
page_has compared.html '.kind == "runs" and .runs[1].name == "two <i>" and .differing == null and .common == 7 and (.runs | map(.drew)) == [false, true] and .runs[1].frames_per_s > 0'
[ "$(cat stdout.txt)" = compared.html ] || fail "report does not print the path of the comparison: $(cat stdout.txt)"
expect 73 'compared.html: exists' "$SEGCAST" report out three -o compared.html; one_error
expect 0 '' "$SEGCAST" report out three -o compared.html --overwrite
page_has compared.html '.differing == {"frame": 0, "name": "three"}'
expect 66 'nowhere: No such file' "$SEGCAST" report out nowhere -o x.html; one_error
expect 75 'slices: has no stats.json to compare' "$SEGCAST" report out slices -o x.html; one_error
expect 64 'expected a name ending in .html' "$SEGCAST" report out three -o x.txt; one_error
[ ! -e x.html ] || fail "a page was left by a mistake"

# Ranks have a row each.
command -v mpirun >/dev/null || exit 0
mpi 2 "$SEGCAST" render job.yaml -o ranks -q --threads 2 >/dev/null
page_has ranks/report.html '.run.ranks == 2 and (.ranks | map(.rank)) == [0, 1] and (.activity.rows | map([.rank, .thread])) == [[0, 0], [0, 1], [0, null], [1, 0], [1, 1]]'
