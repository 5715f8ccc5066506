# SPDX-License-Identifier: BSD-3-Clause
# A volume that was prepared is kept for the next command: other names, colours and opacities find it again; what changes a
# voxel or a surface does not. Whatever happens to the files, the pictures are those of a volume that was just prepared.
export SEGCAST_CACHE=$PWD/kept
printf 'volume: phantom:40x32x42\noutput: {size: [48, 32]}\n' >job.yaml
kept() { find kept -name '*.segc' 2>/dev/null | wc -l; }
# still NAME FILES [OPTION...]: the picture is that of a new preparation, and so many are kept then.
still() {
    local name=$1 files=$2
    shift 2
    "$SEGCAST" still job.yaml -o "$name.png" --overwrite "$@" >/dev/null 2>"$name.txt" || { cat "$name.txt" >&2; fail "$name: no picture"; }
    [ -e "$name-new.png" ] || SEGCAST_CACHE=off "$SEGCAST" still job.yaml -o "$name-new.png" "$@" -q >/dev/null || fail "$name: no picture without a cache"
    cmp "$name.png" "$name-new.png" || fail "$name: another picture than of a volume that is prepared anew"
    [ "$(kept)" = "$files" ] || fail "$name: $(kept) files are kept, expected $files"
}
found() { grep -q 'the volume was prepared before, and kept' "$1.txt"; }
still first 1
! found first || fail "something was found in an empty directory"
[ "$(stat -c %a kept)" = 700 ] || fail "others may look into what is kept: $(stat -c %a kept)"
still first 1
found first || { cat first.txt >&2; fail "what was kept is not found"; }
# It holds what pictures are drawn from, and is marked as used by the time of reading: by that of writing, those who have mapped it
# would know a change.
SEGCAST_CACHE=off "$SEGCAST" convert job.yaml -o bare.segc --set render.surface=voxel -q >/dev/null
[ "$(stat -c %s kept/*.segc)" -gt "$(stat -c %s bare.segc)" ] || fail "what is kept has to be derived each time: $(ls -l kept bare.segc)"
touch -d '2001-02-03 UTC' kept/*.segc
still first 1
case $(stat -c '%Y %X' kept/*.segc) in
981158400\ 981158400) fail "nobody can tell that it is used" ;;
981158400\ *) ;;
*) fail "to use it is to change it" ;;
esac
still colors 1 --set 'tissues={left ventricular myocardium: {color: "#123456", opacity: 0.4}}'
found colors || fail "another colour prepares the volume anew"
still cut 1 --set 'animation={clip: [{normal: posterior, at: 45%}]}'
found cut || fail "a cut prepares the volume anew"
still hidden 2 --set 'tissues={left ventricular myocardium: {visible: false}}'
! found hidden || fail "without a tissue the surfaces of all were found"
still smooth 3 --smooth 0.5
still first 3
found first || fail "what was kept first is not found any more"

# Light that was gathered in a volume is kept beside it, for the same colours; what is damaged is not believed.
# It has to take more than a third of a second to gather, and that of the user's cache, half a second to prepare.
lit=phantom:144x116x152 larger=phantom:224x180x240
case $BUILD in */asan) lit=phantom:72x58x76 larger=phantom:96x78x104 ;; esac
atlas=(--look atlas --set volume=$lit)
still lit 4 "${atlas[@]}"
[ "$(find kept -name '*.light' | wc -l)" = 1 ] || fail "the light of a picture is not kept: $(ls kept)"
for damage in 'true' 'printf X | dd of="$file" bs=1 seek=5000 conv=notrunc status=none' 'truncate -s 3000 "$file"'; do
    sampled || continue
    file=$(ls kept/*.light)
    eval "$damage"
    still lit 4 "${atlas[@]}"
done
still lit-red 4 "${atlas[@]}" --set 'tissues={left ventricular myocardium: {color: "#ff0000"}}'
[ "$(find kept -name '*.light' | wc -l)" = 2 ] || fail "another colour has the same light: $(ls kept)"

# What is said and removed; files of others stay.
echo mine >kept/notes.txt
expect 0 '' "$SEGCAST" help cache
grep -q 'kept holds 4 prepared volumes of' stdout.txt || { cat stdout.txt >&2; fail "what is kept is not told"; }
expect 0 '' "$SEGCAST" help cache --clear
[ "$(kept)" = 0 ] && [ -z "$(find kept -name '*.light')" ] && [ -e kept/notes.txt ] || fail "help cache --clear: $(ls kept)"
expect 64 'help cache' "$SEGCAST" help keys --clear

# Files that are damaged, cut off, empty, a link, or not ours are not believed.
still first 1
file=$(ls kept/*.segc)
bytes=$(stat -c %s "$file")
for damage in 'printf X | dd of="$file" bs=1 seek=$((bytes / 2)) conv=notrunc status=none' 'truncate -s 5000 "$file"' \
    'truncate -s 0 "$file"; rm -f "$file"' 'cp "$file" copy; rm "$file"; ln -s ../copy "$file"' 'rm "$file"; mkfifo "$file"'; do
    sampled || continue
    eval "$damage"
    if [ -p "$file" ] || [ -L "$file" ]; then
        "$SEGCAST" still job.yaml -o odd.png --overwrite -q >/dev/null || fail "$damage: no picture"
        cmp odd.png first-new.png || fail "$damage: another picture"
        rm -f "$file"
    else
        still first 1
        ! found first || fail "$damage: it was believed"
    fi
    still first 1
done
# A directory that cannot be made or written to costs nothing but the time.
echo file >no-directory
lost() { # lost DIRECTORY REASON COMMAND...: what is prepared is not kept there, which is told and no error; the picture is right
    local directory=$1 reason=$2
    shift 2
    (export SEGCAST_CACHE=$directory && "$@" "$SEGCAST" still job.yaml -o lost.png --overwrite) >/dev/null 2>lost.txt || { cat lost.txt >&2; fail "$reason: no picture"; }
    cmp lost.png first-new.png || fail "$reason: another picture"
    grep -q "is not kept for the next command, as $reason" lost.txt || { cat lost.txt >&2; fail "it is not told why nothing is kept: $reason"; }
    ! grep -q 'error:' lost.txt || { cat lost.txt >&2; fail "$reason: an error is told"; }
}
lost "$PWD/no-directory" 'its directory cannot be made' env
# shellcheck disable=SC2016 # for the other shell
lost "$PWD/full" 'it cannot be written' bash -c 'ulimit -f 100; exec "$@"' bash
[ -z "$(ls full)" ] || fail "a file that could not be written is left: $(ls full)"
mkdir -m 555 locked
[ "$(id -u)" != 0 ] || unprivileged=(setpriv --bounding-set=-dac_override,-dac_read_search)
if [ "$(id -u)" != 0 ] || "${unprivileged[@]}" true 2>/dev/null; then
    lost "$PWD/locked" 'it cannot be written' env "${unprivileged[@]}"
fi
# A directory that was there before keeps its modes.
mkdir -m 755 shared
SEGCAST_CACHE=$PWD/shared "$SEGCAST" still job.yaml -o shared.png -q >/dev/null || fail "no picture with a directory of the user"
[ "$(stat -c %a shared)" = 755 ] && [ -n "$(find shared -name '*.segc')" ] || fail "the modes of a directory of the user: $(stat -c %a shared)"
# In a batch job nothing is kept, unless a directory is named.
(unset SEGCAST_CACHE && SLURM_JOB_ID=1 "$SEGCAST" still job.yaml -o batch.png -q >/dev/null) || fail "no picture in a batch job"
[ ! -e .cache/segcast/prepared ] || fail "a batch job has kept something"
# In the user's cache directory only what takes more than half a second to prepare.
# Threads that wait for a core that others have taken count, too.
(unset SEGCAST_CACHE && "$SEGCAST" still phantom:8x8x8 --threads 1 -o home.png -q >/dev/null) || fail "no picture with the cache of the user"
case $BUILD in
*/asan) ;; # with sanitizers the smallest takes longer
*) [ ! -e .cache/segcast/prepared ] || fail "a small volume is kept in the user's cache directory" ;;
esac
(unset SEGCAST_CACHE && "$SEGCAST" still "$larger" --size 48x32 -o home.png --overwrite -q >/dev/null) || fail "no picture of a larger volume"
[ -n "$(find .cache/segcast/prepared -name '*.segc')" ] || fail "nothing is kept in the user's cache directory"
# Several at once.
rm -f kept/*.segc
many=20
case $BUILD in */asan) many=4 ;; esac
for i in $(seq $many); do "$SEGCAST" still job.yaml -o "many$i.png" -q --threads 1 >/dev/null & done
wait
for i in $(seq $many); do cmp "many$i.png" first-new.png || fail "one of several at once has drawn another picture"; done
[ "$(kept)" = 1 ] && [ "$(find kept | wc -l)" = 3 ] || fail "several at once have left $(ls -A kept)"
