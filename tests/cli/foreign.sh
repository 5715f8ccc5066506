# SPDX-License-Identifier: BSD-3-Clause
# segcast changes and removes only what its own manifest says it made: whatever else is in its way is an
# error (73) before any work, with --resume and --overwrite, too, and stays as it is, byte for byte.
small_job job.yaml
echo broken >broken.nrrd # a volume that cannot be read: so nothing was read before the refusal
broken=$PWD/broken.nrrd
sed -i 's/size: \[96, 72\], video: none/size: [96, 72], fps: 4, frames: png, video: film.mp4/' job.yaml

# state DIR...: print the kind, hash and target of all files and folders
state() { find "$@" \( -type f -exec sha256sum {} + \) -o \( ! -type f -printf '%y %l %p\n' \) | sort; }
# refused WHAT PATTERN COMMAND...: the command exits with 73 and one message, before the volume is read, and
# changes nothing in this folder
refused() {
    local what=$1 pattern=$2 before
    shift 2
    before=$(state . | grep -v -e stdout.txt -e stderr.txt)
    expect 73 "$pattern" "$@" --set volume="$broken"
    one_error
    [ "$before" = "$(state . | grep -v -e stdout.txt -e stderr.txt)" ] || fail "$what: files were changed"
}
# each_way WHAT PATTERN DIR: a new run in DIR is refused, and with --resume, --overwrite and --slice
each_way() {
    for how in '' --resume --overwrite '--slice 0/2'; do
        # shellcheck disable=SC2086
        refused "$1 $how" "$2" "$SEGCAST" render job.yaml -o "$3" $how
    done
}

# Files under each name that the run would use, and anything in segments/.
for name in film.mp4 film.partial.mp4 job.yaml frames/000003.png segments/patient7.seg.nrrd \
    segments/000001.seg segments/000001.host.1.part segments/notes.txt; do
    rm -rf d
    mkdir -p "d/$(dirname $name)"
    echo mine >d/$name
    each_way $name "d/$name: is a file that was not made by segcast" d
done
for name in status.json stats.json frames.csv trace.json report.html; do # a slice has other names
    rm -rf d
    mkdir d
    echo mine >d/$name
    for how in '' --resume --overwrite; do
        # shellcheck disable=SC2086
        refused "$name $how" "d/$name: is a file" "$SEGCAST" render job.yaml -o d $how
    done
done
rm -rf d
mkdir d
echo mine >d/stats.0of2.json
refused slice 'd/stats.0of2.json: is a file' "$SEGCAST" render job.yaml -o d --slice 0/2
# Several are counted.
echo mine >d/film.mp4
mkdir d/frames
echo mine >d/frames/000001.png
echo mine >d/frames/000002.png
echo mine >d/job.yaml
each_way several 'd/film.mp4 \(and [23] more\): is a file' d

# A manifest that is none of segcast's.
rm -rf d
mkdir d
echo '{"path":"scan1.nrrd"}' >d/manifest.jsonl
for how in '' --resume --overwrite; do
    # shellcheck disable=SC2086
    refused "manifest $how" 'd/manifest.jsonl: its first line is' "$SEGCAST" render job.yaml -o d $how
done

# Folders and links of these names; what they point to is never touched.
mkdir elsewhere
echo mine >elsewhere/000001.seg
echo mine >elsewhere/000003.png
echo mine >elsewhere/patient7.seg.nrrd
for name in frames segments film.mp4 stats.json; do
    rm -rf d
    mkdir d
    ln -s ../elsewhere d/$name
    for how in '' --resume --overwrite; do
        # shellcheck disable=SC2086
        refused "a link $name $how" "d/$name: is a symbolic link" "$SEGCAST" render job.yaml -o d $how
    done
done
rm -rf d
mkdir -p d/film.mp4
each_way folder 'd/film.mp4: is a directory' d

# The user's own job.yaml stays, whatever is tried.
mkdir here
cp job.yaml here/job.yaml
for how in '' --resume --overwrite; do
    # shellcheck disable=SC2086
    (cd here && refused "job.yaml $how" './job.yaml: is a file that was not made by segcast.*choose another directory' \
        "$SEGCAST" render job.yaml -o . $how)
done
cmp job.yaml here/job.yaml || fail "the user's job.yaml was changed"

# In a run that has begun: links, and strangers in segments/, are refused when it goes on and when it begins
# anew; then it goes on, and nothing but segcast's own files was removed.
begin() { rm -rf out; "$SEGCAST" render job.yaml -o out -q --frames 0-5 >/dev/null; }
begin
echo mine >out/segments/patient7.seg.nrrd
refused "a stranger in segments/" 'out/segments/patient7.seg.nrrd: is a file' "$SEGCAST" render job.yaml -o out --resume
refused "a stranger in segments/" 'out/segments/patient7.seg.nrrd: is a file' "$SEGCAST" render job.yaml -o out --overwrite
expect 73 'out/segments/patient7.seg.nrrd: is a file' "$SEGCAST" join out; one_error
rm out/segments/patient7.seg.nrrd
for name in segments frames; do
    mv out/$name moved
    ln -s ../moved out/$name
    before=$(state moved)
    refused "a link $name" "out/$name: is a symbolic link" "$SEGCAST" render job.yaml -o out --resume
    refused "a link $name" "out/$name: is a symbolic link" "$SEGCAST" render job.yaml -o out --overwrite
    expect 73 "out/$name: is a symbolic link" "$SEGCAST" join out; one_error
    [ "$before" = "$(state moved)" ] || fail "$name: files behind a link were changed"
    rm out/$name
    mv moved out/$name
done
ln -sf ../elsewhere/000003.png out/frames/000003.png
refused "a link frames/000003.png" 'out/frames/000003.png: is a symbolic link' "$SEGCAST" render job.yaml -o out --resume
rm out/frames/000003.png
strangers() { # files of others that are in nobody's way
    echo mine >"$1/notes.txt"
    echo mine >"$1/manifest.train.jsonl"
    echo mine >"$1/frames/000007.png"
    echo mine >"$1/frames/cover.png"
    echo mine >"$1/.film.mp4.tmp"
}
strangers out
before=$(state out/notes.txt out/manifest.train.jsonl out/frames/000007.png out/frames/cover.png out/.film.mp4.tmp)
"$SEGCAST" render job.yaml -o out -q --resume >/dev/null
"$SEGCAST" verify out >/dev/null || fail "verify beside files of others"
[ ! -e out/segments ] || fail "segments/ was not removed"
"$SEGCAST" render job.yaml -o out -q --overwrite >/dev/null
"$SEGCAST" verify out >/dev/null || fail "verify after --overwrite"
[ "$before" = "$(state out/notes.txt out/manifest.train.jsonl out/frames/000007.png out/frames/cover.png out/.film.mp4.tmp)" ] ||
    fail "files of others were changed"
# In a finished directory a folder segments/ is the user's again.
mkdir out/segments
echo mine >out/segments/000000.seg
refused "segments/ of a finished run" 'out/segments/000000.seg: is a file' "$SEGCAST" render job.yaml -o out --overwrite
rm -r out/segments
# An empty folder that was there before stays.
rm -rf out
mkdir -p out/segments out/frames
"$SEGCAST" render job.yaml -o out -q >/dev/null
[ -d out/segments ] || fail "an empty folder of the user was removed"
