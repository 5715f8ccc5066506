# SPDX-License-Identifier: BSD-3-Clause
# The page with which every run ends, and `segcast report`, which makes it anew or compares several runs.
command -v python3 >/dev/null || skip "python3 is not installed"
check() { python3 "$SUPPORT/check_page.py" "$@" || fail "a page is wrong (above)"; }

# Names that HTML would obey are shown as they are.
small_job job.yaml
film='a "b" <i>&c:d.mp4'
sed -i 's/video: none/fps: 4/' job.yaml
hostile=('--set' 'output.title="</title><script>alert(1)</script>"' '--set' "output.video='$film'")
mkdir '<b>'
cp job.yaml '<b>/job.yaml'
"$SEGCAST" render '<b>/job.yaml' -o '<b>/out' -q "${hostile[@]}" >/dev/null
page='<b>/out/report.html'
check "$page"
grep -q '&lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt;' "$page" || fail "the title is not in the page"
grep -q '<video .*src="a%20%22b%22%20%3Ci%3E%26c%3Ad.mp4"' "$page" || fail "the film is not in the page"
[ "$(grep -o '<img alt="frame [0-9]*"' "$page" | wc -l)" = 7 ] || fail "the page does not show 7 frames"
[ "$(grep -oE '<img alt="Frame [0-9]+: (samples|contributions) per pixel, from [0-9]+ to [0-9]+' "$page" | wc -l)" = 2 ] ||
    fail "the page does not show the work of each pixel"
for words in 'Limited by' 'Where the time went' 'Time of all cores' 'threads waiting for each other' 'boundary voxels that its' 'Ranks and time' 'Cost along the film' 'The film' 'Runs on this job' \
    'Settings' 'stats.json' 'frames.csv' 'trace.json'; do
    grep -q "$words" "$page" || fail "the page does not hold: $words"
done

command -v jq >/dev/null && { jq -e '.core_time | (.core_s > 0) and (([.[]] | add) - .core_s) >= .core_s * 0.999' '<b>/out/stats.json' >/dev/null ||
    fail "the causes do not add up to the time of cores: $(jq -c .core_time '<b>/out/stats.json')"; }

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
grep -q 'The trace is missing' out/report.html || fail "the page does not say that the trace is missing"
expect 65 'out/trace.json: is missing' "$SEGCAST" verify out
"$SEGCAST" render job.yaml -o out "${hostile[@]}" --resume -q >/dev/null 2>&1
grep -q 'samples per pixel, from' out/report.html || fail "a run that drew nothing has lost the work of each pixel"
expect 0 '' "$SEGCAST" verify out
check out/report.html

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
expect 66 'nowhere: holds no run' "$SEGCAST" report nowhere; one_error
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
check slices/report.0of2.html
grep -q 'This is slice 0of2' slices/report.0of2.html || fail "the page of a slice does not say so"
rm slices/report.0of2.html
expect 0 '' "$SEGCAST" report slices
check slices/report.0of2.html
"$SEGCAST" render job.yaml -o slices --slice 1/2 -q >/dev/null
expect 0 '' "$SEGCAST" verify slices
expect 0 '' "$SEGCAST" report slices
[ "$(cat stdout.txt)" = $'slices/report.0of2.html\nslices/report.1of2.html' ] || fail "the pages of slices: $(cat stdout.txt)"
expect 0 '' "$SEGCAST" verify slices
check slices/report.0of2.html slices/report.1of2.html

# Several directories are compared.
"$SEGCAST" render job.yaml -o 'two <i>' -q --set output.video=none --set output.frames=png >/dev/null
check 'two <i>/report.html'
[ "$(grep -o '<img alt="frame [0-9]*"' 'two <i>/report.html' | wc -l)" = 7 ] || fail "no frames from PNG files"
"$SEGCAST" render job.yaml -o three -q --set output.video=none --set render.samples=1 >/dev/null
expect 0 '' "$SEGCAST" report out 'two <i>' -o compared.html
check compared.html
[ "$(cat stdout.txt)" = compared.html ] || fail "report does not print the path of the comparison: $(cat stdout.txt)"
grep -q 'two &lt;i&gt;' compared.html && grep -q 'All have drawn the same pictures' compared.html ||
    fail "the comparison does not name both, or finds other pictures"
expect 73 'compared.html: exists' "$SEGCAST" report out three -o compared.html; one_error
expect 0 '' "$SEGCAST" report out three -o compared.html --overwrite
grep -q 'frame 0 of three is another one than that of out' compared.html || fail "other pictures are not found"
expect 66 'nowhere: holds no run' "$SEGCAST" report out nowhere -o x.html; one_error
expect 75 'slices: has no stats.json to compare' "$SEGCAST" report out slices -o x.html; one_error
expect 64 'expected a name ending in .html' "$SEGCAST" report out three -o x.txt; one_error
[ ! -e x.html ] || fail "a page was left by a mistake"

# Ranks have a row each.
command -v mpirun >/dev/null || exit 0
mpi 2 "$SEGCAST" render job.yaml -o ranks -q --threads 2 >/dev/null
check ranks/report.html
grep -q 'rank 1, thread 1' ranks/report.html && grep -q '>rank 1</span>' ranks/report.html || fail "rank 1 is not in the page"
! grep -q 'rank 1, encoding' ranks/report.html || fail "there is a row for encoding on rank 1, which does not encode"
