# SPDX-License-Identifier: BSD-3-Clause
# Damaged and unusual volumes, as other programs write them, are accepted or refused as EXPECT.tsv says;
# none makes segcast crash or hang. Where segcast differs from the table, judge() says why.
[ -d "$DATA/bad/made" ] || skip "there is no $DATA/bad/made (SC_TEST_DATA)"

judge() { # judge FILE EXPECTED: print accept, refuse or either
    case $1 in
    encoding_113.nrrd) echo accept ;; # declared as gzip, but not compressed: the voxels are right, and a warning says so
    table_utf16.txt) echo accept ;;   # it has a byte order mark, so that it is read as what it is
    *) case $2 in
       accept\ by\ content\ or\ refuse* | *"or refuse"* | "refuse or"* | *"or warn"* | *"documented"*) echo either ;;
       accept*) echo accept ;;
       refuse*) echo refuse ;;
       *) echo either ;;
       esac ;;
    esac
}

count=0
while IFS=$'\t' read -r file expected; do
    [ "$file" = file ] && continue
    count=$((count + 1))
    sampled || continue
    path=$DATA/bad/made/$file
    case $file in
    *.txt | *.ctbl) arguments=("$DATA/bad/made/good.nrrd" --labels "$path") ;;
    *) arguments=("$path") ;;
    esac
    code=0
    timeout 300 "$SEGCAST" info "${arguments[@]}" >stdout.txt 2>stderr.txt || code=$?
    case $code in 0) got=accept ;; 64 | 65 | 66) got=refuse ;; *)
        cat stderr.txt; fail "$file: exit code $code, expected 0, 64, 65 or 66" ;;
    esac
    [ $code = 0 ] || one_error
    want=$(judge "$file" "$expected")
    [ "$want" = either ] || [ "$want" = "$got" ] ||
        { cat stderr.txt; fail "$file: segcast info gives: $got, expected: $expected"; }
done <"$DATA/bad/made/EXPECT.tsv"
[ "$count" -gt 150 ] || fail "EXPECT.tsv names only $count files, expected more than 150"

# What is accepted although something is wrong with it is told, and a refusal names what was found.
while read -r file said; do
    "$SEGCAST" info "$DATA/bad/made/$file" >stdout.txt 2>stderr.txt || true
    grep -Eq -- "$said" stderr.txt || { cat stderr.txt; fail "$file: not told: $said"; }
done <<'TXT'
quatern_nan.nii warning: .*qform is not usable, its quaternion or offset is not a number; the voxel size alone is used
encoding_113.nrrd warning: .*says that its encoding is gzip, but its voxels are not compressed
gz_trailing_garbage.nii.gz warning: .*: 9 bytes behind the end of the compressed data are ignored
seg_layer_7.seg.nrrd warning: .*Segment0_Layer is "7", but the file has one layer
seg_value_huge.seg.nrrd warning: .*LabelValue of the segment .* is 99999999999999, which no voxel of this type can have, so that the segment has none; 1 segment is so
kinds_139.nrrd warning: .*has spacings beside space directions
sizes_101.nrrd error: .*sizes_101.nrrd:5: sizes is "7 5 -4", expected for each axis
sizes_105.nrrd error: .*sizes_105.nrrd:5: sizes is "a b c", expected for each axis
TXT
for file in good.nii good_two_gzip_members.nii.gz gzip_good.nrrd seg_ok.seg.nrrd trailing_garbage.nii good.nrrd; do
    "$SEGCAST" info "$DATA/bad/made/$file" 2>stderr.txt >/dev/null
    ! grep -q warning stderr.txt || { cat stderr.txt; fail "$file: a warning without a reason"; }
done

while IFS= read -r -d '' path; do
    code=0
    timeout 300 "$SEGCAST" info "$path" >stdout.txt 2>stderr.txt || code=$?
    case $code in 0 | 65 | 66) ;; *) fail "$path: exit code $code, expected 0, 65 or 66" ;; esac
done < <(find "$DATA/bad" -path '*/made' -prune -o -type f -print0)

# The same voxels in different formats give the same labels; a slope of 2 in the header changes them.
values() { "$SEGCAST" info "$1" --json 2>/dev/null | jq -c '[.labels[] | [.value, .voxels]]'; }
good=$(values "$DATA/bad/made/good.nii")
for file in good.nii.gz good_two_gzip_members.nii.gz big_endian.nii pair.hdr good.nrrd ascii_good.nrrd kinds_139.nrrd encoding_113.nrrd \
    good.mha good_compressed.mha; do
    [ "$(values "$DATA/bad/made/$file")" = "$good" ] || fail "$file differs from good.nii"
done
[ "$(values "$DATA/bad/made/slope2_inter1.nii")" != "$good" ] || fail "the slope in the header is ignored"
