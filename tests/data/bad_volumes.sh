# Damaged volumes found in the wild: accepted or refused as EXPECT.tsv says, never a crash, a hang
# or a pile of memory. Where we judge otherwise, the reason stands here.
[ -d "$DATA/bad/made" ] || skip "no $DATA/bad"

judge() { # what we expect where the table leaves a choice or we differ
    case $1 in
    encoding_113.nrrd) echo accept ;; # says gzip, is plain: zlib reads it, the voxels are right
    kinds_139.nrrd) echo refuse ;;    # spacings beside directions: NRRD forbids it, Teem refuses
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
    path=$DATA/bad/made/$file
    case $file in
    *.txt | *.ctbl) arguments=("$DATA/bad/made/good.nrrd" --labels "$path") ;;
    *) arguments=("$path") ;;
    esac
    code=0
    timeout 300 "$SEGCAST" info "${arguments[@]}" >stdout.txt 2>stderr.txt || code=$?
    case $code in 0) got=accept ;; 64 | 65 | 66) got=refuse ;; *)
        cat stderr.txt; fail "$file: exit $code" ;;
    esac
    [ $code = 0 ] || one_error
    want=$(judge "$file" "$expected")
    [ "$want" = either ] || [ "$want" = "$got" ] ||
        { cat stderr.txt; fail "$file: we $got, expected: $expected"; }
done <"$DATA/bad/made/EXPECT.tsv"
[ "$count" -gt 150 ] || fail "only $count files"

while IFS= read -r -d '' path; do
    code=0
    timeout 300 "$SEGCAST" info "$path" >stdout.txt 2>stderr.txt || code=$?
    case $code in 0 | 65 | 66) ;; *) fail "$path: exit $code" ;; esac
done < <(find "$DATA/bad" -path '*/made' -prune -o -type f -print0)

# Equal contents are equal volumes, whatever the file; a doubled slope doubles the labels.
values() { "$SEGCAST" info "$1" --json 2>/dev/null | jq -c '[.labels[] | [.value, .voxels]]'; }
good=$(values "$DATA/bad/made/good.nii")
for file in good.nii.gz good_two_gzip_members.nii.gz big_endian.nii pair.hdr good.nrrd ascii_good.nrrd \
    good.mha good_compressed.mha; do
    [ "$(values "$DATA/bad/made/$file")" = "$good" ] || fail "$file differs from good.nii"
done
[ "$(values "$DATA/bad/made/slope2_inter1.nii")" != "$good" ] || fail "the slope is ignored"
