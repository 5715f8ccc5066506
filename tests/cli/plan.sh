# SPDX-License-Identifier: BSD-3-Clause
# segcast plan counts drawing, encoding, preparing, disk and memory of a job, and writes nothing. What it says of
# disk and memory is compared with what the job then takes; times are not.
small_job job.yaml
sed -i 's/size: \[96, 72\], video: none/size: [160, 120], fps: 10, frames: png, video: film.mp4/; s/frames: 7/frames: 24/' job.yaml
"$SEGCAST" plan job.yaml -q --json >plan.json
jq -e '.schema == "segcast-plan-1" and .frames == 24 and .size == [160, 120] and .frames_measured > 0 and
    .frames_encoded >= 2 and .draw_cpu_s > 0 and .encode_cpu_s > 0 and .encode_cpu_s_per_frame > 0 and
    .prepare_cpu_s > 0 and .prepare_wall_s > 0 and
    ((.core_hours * 3600 - .draw_cpu_s - .encode_cpu_s - .prepare_cpu_s) | fabs) < 0.001 and
    (.memory | .prepared_bytes > 0 and .derived_bytes > 0 and .program_bytes > 0 and .renderer_bytes > 0) and
    ([.runs[].nodes] == [1, 4, 16]) and ([.runs[] | .ranks_per_node == 1 and .threads_per_rank >= 1 and
        .wall_s >= .prepare_s and .wall_s >= .root_encode_s and .wall_s >= .draw_s and
        (.limited_by | IN("drawing", "encoding", "encoding on rank 0", "preparing", "starting the ranks",
            "too few work units", "encoding on the ranks that gather", "sending the volume to all nodes", "joining the video")) and .efficiency > 0 and .efficiency <= 1 and .first_node_bytes > .other_node_bytes] | all)' \
    plan.json >/dev/null || fail "plan --json: $(cat plan.json)"
[ "$(ls)" = $'job.yaml\nplan.json' ] || fail "segcast plan has written files: $(ls)"

# Scaling: a row for 1, 2, 4, ... nodes, each with its best ranks x threads; core hours are those of all cores.
jq -e '.scaling | .costs_measured == false and ([.nodes[].nodes] == [1, 2, 4, 8, 16, 32, 64]) and
    (.pays_to_nodes as $n | [.nodes[].nodes] | index($n) != null) and
    ([.nodes[] | .ranks_per_node >= 1 and .threads_per_rank >= 1 and (.encode | IN("auto", "segments", "gather")) and .wall_s > 0 and
        .efficiency > 0 and .efficiency <= 1 and .core_hours * 3600 >= .wall_s * .nodes * 0.99 and
        (.limited_by | length > 3)] | all)' plan.json >/dev/null || fail "the scaling: $(cat plan.json)"

# near WHAT SAID IS PERCENT: what the plan said is as near to what is.
near() {
    [ $((100 * $2)) -ge $((($3) * (100 - $4))) ] && [ $((100 * $2)) -le $((($3) * (100 + $4))) ] ||
        fail "$1: the plan says $2, and it is $3 ($(cat plan.json))"
}
said() { jq ".$1 | floor" plan.json; }
bytes_of() { cat "$@" | wc -c; }
"$SEGCAST" render job.yaml -q >/dev/null
near 'bytes of the video' "$(said disk.video_bytes)" "$(bytes_of out/film.mp4)" 20
near 'bytes of the PNG files' "$(said disk.png_bytes)" "$(bytes_of out/frames/*)" 20
near 'bytes of the records' "$(said disk.records_bytes)" "$(bytes_of out/*.json* out/frames.csv out/job.yaml out/report.html)" 50
near 'bytes at the end' "$(said disk.end_bytes)" "$(find out -type f -exec cat {} + | wc -c)" 20
[ "$(said disk.peak_bytes)" -ge $(($(said disk.end_bytes) + 10 * 160 * 120 * 3 / 2)) ] ||
    fail "the pictures of a partial GOP are not counted: $(cat plan.json)"
# the sanitizers have a malloc of their own, of which nothing is known
if [ "$(said memory.encoder_bytes)" -gt 1000000 ]; then
    near 'memory' "$(said runs[0].first_node_bytes)" "$(jq '.memory.peak_rss_bytes[0]' out/stats.json)" 50
fi

# A longer job is not drawn whole: a few neighbours at a few places stand for all.
small_job long.yaml
sed -i 's/video: none/video: film.mp4, directory: long/; s/directory: out, //; s/frames: 7/frames: 250/' long.yaml
"$SEGCAST" plan long.yaml -q --json >plan.json
"$SEGCAST" render long.yaml -q >/dev/null
near 'bytes of a long video' "$(said disk.video_bytes)" "$(bytes_of long/film.mp4)" 40
near 'bytes of long records' "$(said disk.records_bytes)" "$(bytes_of long/*.json* long/frames.csv long/job.yaml long/report.html)" 50

# On other nodes; a job without video is not encoded, one without any output writes its records alone.
"$SEGCAST" plan job.yaml -q --nodes 5 --ranks 3 --threads 2 >plan.txt
[ "$(grep -cE '^wall time +[0-9]+ s on 5 nodes, 3 ranks of 2 threads each; limited by [a-z0 ]+$' plan.txt)" = 1 ] &&
    [ "$(grep -c '^wall time' plan.txt)" = 1 ] || fail "plan --nodes: $(cat plan.txt)"
for word in frames kernel volume measured preparing drawing encoding 'in all' disk scaling; do
    [ "$(grep -c "^$word  " plan.txt)" = 1 ] || fail "plan does not say $word: $(cat plan.txt)"
done
"$SEGCAST" plan job.yaml -q --json --nodes 6 --ranks 2 --threads 1 --set farm.encode=segments >plan.json
jq -e '(.runs | length) == 1 and (.runs[0] | .nodes == 6 and .ranks_per_node == 2 and .threads_per_rank == 1 and
    .gops_encoded_by_ranks == 0)' plan.json >/dev/null || fail "12 ranks for 3 GOPs: $(cat plan.json)"
"$SEGCAST" plan job.yaml -q --json --nodes 2 --set farm.encode=segments --set output.fps=4 >plan.json
jq -e '.runs[0].gops_encoded_by_ranks == 5' plan.json >/dev/null || fail "2 ranks for 6 GOPs: $(cat plan.json)"
"$SEGCAST" plan job.yaml -q --json --set output.video=none >plan.json
jq -e '.disk.video_bytes == 0 and .disk.png_bytes > 0 and .encode_cpu_s > 0 and .memory.encoder_bytes == 0 and
    .disk.peak_bytes == .disk.end_bytes' plan.json >/dev/null || fail "without video: $(cat plan.json)"
"$SEGCAST" plan job.yaml -q --json --set output.video=none --set output.frames=none >plan.json
jq -e '.disk.video_bytes == 0 and .disk.png_bytes == 0 and .encode_cpu_s == 0 and .frames_encoded == 0' plan.json \
    >/dev/null || fail "without outputs: $(cat plan.json)"

for value in 0 -1 x 1.5 '' 65537; do
    for option in nodes ranks; do
        expect 64 "--$option is \"$value\", expected a whole number from 1 to 65536" "$SEGCAST" plan job.yaml "--$option=$value"
        one_error
    done
done
expect 64 '4294967296 ranks in all, expected at most 65536; choose fewer' "$SEGCAST" plan job.yaml --nodes 65536 --ranks 65536
one_error
